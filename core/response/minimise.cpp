#include "core/response/solid_search.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

using Indices = std::vector<Eigen::Index>;

// Coordinates that may move downhill: not at a bound beyond which it goes on.
Indices free_coordinates(const VectorXd& u, const VectorXd& direction, const VectorXd& lower,
                         const VectorXd& upper) {
  Indices free;
  for (Eigen::Index k = 0; k < u.size(); ++k)
    if (lower[k] < upper[k] && !(u[k] <= lower[k] && direction[k] <= 0) &&
        !(u[k] >= upper[k] && direction[k] >= 0))
      free.push_back(k);
  return free;
}

double downhill_slope(const LocalValue& at, const Indices& free) {
  double largest = 0;
  for (const Eigen::Index k : free) largest = std::max(largest, std::abs(at.gradient[k]));
  return largest;
}

// −H⁻¹ g of the free coordinates, with as much added to the diagonal as makes H positive definite.
VectorXd newton_step(const LocalValue& at, const Indices& free) {
  const MatrixXd H = at.curvature(free, free);
  const MatrixXd g = at.gradient(free);
  const double size = std::max(H.cwiseAbs().maxCoeff(), 1e-30);
  for (double lift = 1e-13 * size;; lift *= 30) {
    const Cholesky factor(H + lift * MatrixXd::Identity(H.rows(), H.cols()));
    if (factor.positive_definite()) return -factor.solve_upper(factor.solve_lower(g)).col(0);
  }
}

// How much of a step leads to the first bound; 1 where none is met.
double reach_of(const VectorXd& u, const VectorXd& step, const VectorXd& lower,
                const VectorXd& upper) {
  double reach = 1;
  for (Eigen::Index k = 0; k < u.size(); ++k)
    if (step[k] != 0) reach = std::min(reach, ((step[k] > 0 ? upper : lower)[k] - u[k]) / step[k]);
  return std::max(reach, 0.0);
}

// The end of a part of a step, on the bounds that it meets.
VectorXd end_of(const VectorXd& u, const VectorXd& step, double by, const VectorXd& lower,
                const VectorXd& upper) {
  VectorXd end = (u + by * step).cwiseMax(lower).cwiseMin(upper);
  for (Eigen::Index k = 0; k < u.size(); ++k)
    for (const double bound : {lower[k], upper[k]})
      if (step[k] != 0 && std::abs(end[k] - bound) < 1e-14 * (upper[k] - lower[k])) end[k] = bound;
  return end;
}

}  // namespace

VectorXd local_minimum(const std::function<LocalValue(const VectorXd&)>& f, const VectorXd& lower,
                       const VectorXd& upper, const VectorXd& start) {
  constexpr int most = 100;
  constexpr double flat = 1e-15;  // of the largest slope
  VectorXd u = start.cwiseMax(lower).cwiseMin(upper);
  LocalValue at = f(u);
  const double steepest = std::max(at.gradient.cwiseAbs().maxCoeff(), 1e-300);
  for (int k = 0; k < most; ++k) {
    Indices free = free_coordinates(u, -at.gradient, lower, upper);
    const double slope = downhill_slope(at, free);
    if (free.empty() || slope <= flat * steepest) break;
    VectorXd step = VectorXd::Zero(u.size());
    for (;;) {  // a coordinate at its bound that the step would push out is held too
      step.setZero();
      step(free) = newton_step(at, free);
      const Indices inside = free_coordinates(u, step, lower, upper);
      Indices kept;
      std::ranges::set_intersection(free, inside, std::back_inserter(kept));
      if (kept.size() == free.size() || kept.empty()) break;
      free = std::move(kept);
    }
    bool moved = false;
    // not beyond the first bound: coordinates that move together would no longer
    const double reach = reach_of(u, step, lower, upper);
    for (double by = reach; by > 1e-10 * reach && !moved; by /= 4) {
      const VectorXd next = end_of(u, step, by, lower, upper);
      if (next == u) break;
      LocalValue there = f(next);
      // where the value has no digits left the slope decides
      const bool lower_value = there.value < at.value,
                 equal_value = there.value <= at.value + 1e-13 * std::abs(at.value);
      moved =
          (lower_value && !equal_value) ||
          ((lower_value || equal_value) &&
           downhill_slope(there, free_coordinates(next, -there.gradient, lower, upper)) < slope);
      if (!moved && lower_value) moved = true;
      if (moved) {
        u = next;
        at = std::move(there);
      }
    }
    if (!moved) break;
  }
  return u;
}

}  // namespace flexopt
