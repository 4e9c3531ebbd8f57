#include "optim/numerics/central_differences.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

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

}  // namespace

std::optional<MatrixXd> central_differences(const ValuesAtMany& evaluate, const VectorXd& x,
                                            const VectorXd& center,
                                            const DifferenceOptions& options) {
  const double h = options.step;
  std::vector<Eigen::Index> columns = options.columns;
  for (Eigen::Index j = 0; options.columns.empty() && j < x.size(); ++j) columns.push_back(j);
  const std::size_t n = columns.size();
  const auto inside = [&](Eigen::Index j, double offset) {
    const double moved = x[j] + offset * h;
    return moved >= 0 && moved <= 1;
  };
  const auto moved = [&](Eigen::Index j, double offset) {
    VectorXd y = x;
    y[j] += offset * h;
    return y;
  };

  // First the two neighbours that each variable's place in the box allows, all at once; then a
  // second round for those whose neighbour failed.
  std::vector<std::array<Neighbour, 2>> pairs(n);
  std::vector<VectorXd> wanted;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Index j = columns[i];
    auto& pair = pairs[i];
    pair[0].offset = inside(j, 1) ? 1 : -2;
    pair[1].offset = inside(j, -1) ? -1 : 2;
    for (const Neighbour& p : pair) wanted.push_back(moved(j, p.offset));
  }
  std::vector<std::optional<VectorXd>> found = evaluate(wanted);
  assert(found.size() == wanted.size());
  std::vector<std::pair<std::size_t, int>> again;
  wanted.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Index j = columns[i];
    auto& pair = pairs[i];
    for (std::size_t k = 0; k < 2; ++k) pair[k].values = std::move(found[2 * i + k]);
    for (int k = 0; k < 2; ++k) {
      const Neighbour& lost = pair[static_cast<std::size_t>(k)];
      Neighbour& other = pair[static_cast<std::size_t>(1 - k)];
      if (lost.values || !other.values || std::abs(other.offset) != 1) continue;
      if (!inside(j, 2 * other.offset)) continue;
      again.emplace_back(i, k);
      wanted.push_back(moved(j, 2 * other.offset));
    }
  }
  found = wanted.empty() ? std::vector<std::optional<VectorXd>>{} : evaluate(wanted);
  for (std::size_t i = 0; i < again.size(); ++i) {
    auto& pair = pairs[again[i].first];
    const auto k = static_cast<std::size_t>(again[i].second);
    pair[k] = {2 * pair[1 - k].offset, std::move(found[i])};
  }

  MatrixXd derivative = MatrixXd::Zero(center.size(), x.size());
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Index j = columns[i];
    auto [a, b] = pairs[i];
    if (!a.values) std::swap(a, b);
    if (!a.values) return std::nullopt;
    if (!b.values) {
      derivative.col(j) = (*a.values - center) / (a.offset * h);
      continue;
    }
    if (a.offset == -b.offset)
      for (const auto& [first, count] : options.branches)
        follow_branches(center, *a.values, *b.values, first, count);
    // Newton's divided differences through the three points, differentiated at the middle one.
    const VectorXd da = (*a.values - center) / (a.offset * h),
                   db = (*b.values - center) / (b.offset * h);
    derivative.col(j) = (a.offset * db - b.offset * da) / (a.offset - b.offset);
  }
  return derivative;
}

}  // namespace flexopt
