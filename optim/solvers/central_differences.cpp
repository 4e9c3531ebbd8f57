#include "optim/solvers/central_differences.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>

namespace flexopt {
namespace {

/// Reorders `plus` and `minus` so that every branch bends least: Σ |v₊ − 2v + v₋| is the smallest
/// over all permutations of both. Sorted values of crossing curves have kinks, the curves have not.
void follow_branches(const VectorXd& center, VectorXd& plus, VectorXd& minus, int first,
                     int count) {
  std::vector<int> p(static_cast<std::size_t>(count)), q, best_p, best_q;
  std::iota(p.begin(), p.end(), first);
  double least = -1;
  const double scale = center.segment(first, count).cwiseAbs().maxCoeff();
  do {
    q.resize(p.size());
    std::iota(q.begin(), q.end(), first);
    do {
      double bend = 0;
      for (int i = 0; i < count; ++i)
        bend += std::abs(plus[p[static_cast<std::size_t>(i)]] - 2 * center[first + i] +
                         minus[q[static_cast<std::size_t>(i)]]);
      // The identity comes first; rounding alone does not displace it.
      if (least < 0 || bend < least - 1e-12 * scale) least = bend, best_p = p, best_q = q;
    } while (std::next_permutation(q.begin(), q.end()));
  } while (std::next_permutation(p.begin(), p.end()));
  const VectorXd plus_before = plus, minus_before = minus;
  for (int i = 0; i < count; ++i) {
    plus[first + i] = plus_before[best_p[static_cast<std::size_t>(i)]];
    minus[first + i] = minus_before[best_q[static_cast<std::size_t>(i)]];
  }
}

struct Neighbour {
  double offset = 0;  ///< in steps
  std::optional<VectorXd> values;
};

/// The neighbours of x along some of the variables.
class Neighbours {
 public:
  Neighbours(const ValuesAtMany& evaluate, const VectorXd& x, std::vector<Eigen::Index> columns,
             double step)
      : evaluate_(evaluate),
        x_(x),
        columns_(std::move(columns)),
        step_(step),
        pairs_(columns_.size()) {}
  using Pair = std::array<Neighbour, 2>;

  /// Finds the two neighbours of each variable that its place in the box allows, all at once.
  void find();
  /// A second round: the next but one where a neighbour has no values.
  void find_lost();
  const std::vector<Pair>& pairs() const { return pairs_; }

 private:
  bool inside(Eigen::Index j, double offset) const {
    const double moved = x_[j] + offset * step_;
    return moved >= 0 && moved <= 1;
  }
  VectorXd moved(Eigen::Index j, double offset) const {
    VectorXd y = x_;
    y[j] += offset * step_;
    return y;
  }

  const ValuesAtMany& evaluate_;
  const VectorXd& x_;
  std::vector<Eigen::Index> columns_;
  double step_;
  std::vector<Pair> pairs_;
};

void Neighbours::find() {
  std::vector<VectorXd> wanted;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const Eigen::Index j = columns_[i];
    pairs_[i][0].offset = inside(j, 1) ? 1 : -2;
    pairs_[i][1].offset = inside(j, -1) ? -1 : 2;
    for (const Neighbour& p : pairs_[i]) wanted.push_back(moved(j, p.offset));
  }
  std::vector<std::optional<VectorXd>> found = evaluate_(wanted);
  assert(found.size() == wanted.size());
  for (std::size_t i = 0; i < pairs_.size(); ++i)
    for (std::size_t k = 0; k < 2; ++k) pairs_[i][k].values = std::move(found[2 * i + k]);
}

void Neighbours::find_lost() {
  std::vector<VectorXd> wanted;
  std::vector<std::pair<std::size_t, std::size_t>> lost;  // variable, which of its two
  for (std::size_t i = 0; i < pairs_.size(); ++i)
    for (std::size_t k = 0; k < 2; ++k) {
      const Neighbour& other = pairs_[i][1 - k];
      if (pairs_[i][k].values || !other.values || std::abs(other.offset) != 1) continue;
      if (!inside(columns_[i], 2 * other.offset)) continue;
      lost.emplace_back(i, k);
      wanted.push_back(moved(columns_[i], 2 * other.offset));
    }
  if (wanted.empty()) return;
  std::vector<std::optional<VectorXd>> found = evaluate_(wanted);
  for (std::size_t n = 0; n < lost.size(); ++n) {
    const auto [i, k] = lost[n];
    pairs_[i][k] = {2 * pairs_[i][1 - k].offset, std::move(found[n])};
  }
}

/// Derivative at the middle of three points, by Newton's divided differences; by one side where
/// only that side has values, nothing where neither has.
// NOLINTNEXTLINE(performance-unnecessary-value-param): both may change places
std::optional<VectorXd> difference(Neighbours::Pair pair, const VectorXd& center,
                                   const DifferenceOptions& options) {
  auto& [a, b] = pair;
  const double h = options.step;
  if (!a.values) std::swap(a, b);
  if (!a.values) return std::nullopt;
  if (!b.values) return (*a.values - center) / (a.offset * h);
  if (a.offset == -b.offset)
    for (const auto& [first, count] : options.branches)
      follow_branches(center, *a.values, *b.values, first, count);
  const VectorXd da = (*a.values - center) / (a.offset * h),
                 db = (*b.values - center) / (b.offset * h);
  return (a.offset * db - b.offset * da) / (a.offset - b.offset);
}

}  // namespace

std::optional<MatrixXd> central_differences(const ValuesAtMany& evaluate, const VectorXd& x,
                                            const VectorXd& center,
                                            const DifferenceOptions& options) {
  std::vector<Eigen::Index> columns = options.columns;
  for (Eigen::Index j = 0; options.columns.empty() && j < x.size(); ++j) columns.push_back(j);
  Neighbours neighbours(evaluate, x, columns, options.step);
  neighbours.find();
  neighbours.find_lost();
  MatrixXd derivative = MatrixXd::Zero(center.size(), x.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto column = difference(neighbours.pairs()[i], center, options);
    if (!column) return std::nullopt;
    derivative.col(columns[i]) = *column;
  }
  return derivative;
}

}  // namespace flexopt
