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
  std::vector<int> p(count), q, best_p, best_q;
  std::iota(p.begin(), p.end(), first);
  double least = -1;
  const double scale = center.segment(first, count).cwiseAbs().maxCoeff();
  do {
    q.resize(p.size());
    std::iota(q.begin(), q.end(), first);
    do {
      double bend = 0;
      for (int i = 0; i < count; ++i)
        bend += std::abs(plus[p[i]] - 2 * center[first + i] + minus[q[i]]);
      // The identity comes first; rounding alone does not displace it.
      if (least < 0 || bend < least - 1e-12 * scale) least = bend, best_p = p, best_q = q;
    } while (std::next_permutation(q.begin(), q.end()));
  } while (std::next_permutation(p.begin(), p.end()));
  const VectorXd plus_before = plus, minus_before = minus;
  for (int i = 0; i < count; ++i) {
    plus[first + i] = plus_before[best_p[i]];
    minus[first + i] = minus_before[best_q[i]];
  }
}

/// A neighbour of x along one of the variables.
struct Neighbour {
  double offset = 0;  ///< in steps
  std::optional<VectorXd> values;
};

using Pair = std::array<Neighbour, 2>;

/// Derivative at the middle of three points, by Newton's divided differences; by one side where
/// only that side has values, nothing where neither has.
// NOLINTNEXTLINE(performance-unnecessary-value-param): both may change places
std::optional<VectorXd> difference(Pair pair, const VectorXd& center,
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
  const auto inside = [&](Eigen::Index j, double offset) {
    const double moved = x[j] + offset * options.step;
    return moved >= 0 && moved <= 1;
  };
  std::vector<VectorXd> wanted;
  std::vector<Neighbour*> whose;
  const auto want = [&](Eigen::Index j, Neighbour& of, double offset) {
    of.offset = offset;
    whose.push_back(&of);
    wanted.push_back(x);
    wanted.back()[j] += offset * options.step;
  };
  const auto find_wanted = [&] {
    std::vector<std::optional<VectorXd>> found = evaluate(wanted);
    assert(found.size() == wanted.size());
    for (std::size_t k = 0; k < whose.size(); ++k) whose[k]->values = std::move(found[k]);
    wanted.clear();
    whose.clear();
  };
  std::vector<Pair> pairs(columns.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    want(columns[i], pairs[i][0], inside(columns[i], 1) ? 1 : -2);
    want(columns[i], pairs[i][1], inside(columns[i], -1) ? -1 : 2);
  }
  find_wanted();
  // a second round: the next but one where a neighbour has no values
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (std::size_t k = 0; k < 2; ++k) {
      const Neighbour& other = pairs[i][1 - k];
      if (!pairs[i][k].values && other.values && std::abs(other.offset) == 1 &&
          inside(columns[i], 2 * other.offset))
        want(columns[i], pairs[i][k], 2 * other.offset);
    }
  if (!wanted.empty()) find_wanted();
  MatrixXd derivative = MatrixXd::Zero(center.size(), x.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto column = difference(pairs[i], center, options);
    if (!column) return std::nullopt;
    derivative.col(columns[i]) = *column;
  }
  return derivative;
}

}  // namespace flexopt
