#include "optim/multipliers.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <vector>

namespace flexopt {
namespace {

VectorXd solve_on(const MatrixXd& A, const VectorXd& b, const std::vector<Eigen::Index>& set) {
  VectorXd y = VectorXd::Zero(A.cols());
  if (set.empty()) return y;
  const VectorXd solution = A(Eigen::all, set).completeOrthogonalDecomposition().solve(b);
  y(set) = solution;
  return y;
}

}  // namespace

VectorXd non_negative_least_squares(const MatrixXd& A, const VectorXd& b) {
  const Eigen::Index n = A.cols();
  VectorXd y = VectorXd::Zero(n);
  if (n == 0 || A.rows() == 0) return y;
  const double tiny = 1e-12 * (1.0 + A.cwiseAbs().maxCoeff() * b.cwiseAbs().maxCoeff());
  std::vector<Eigen::Index> passive;
  for (Eigen::Index round = 0; round < 3 * n + 3; ++round) {
    const VectorXd w = A.transpose() * (b - A * y);  // descent direction of each y_i
    Eigen::Index entering = -1;
    for (Eigen::Index i = 0; i < n; ++i)
      if (std::find(passive.begin(), passive.end(), i) == passive.end() && w[i] > tiny &&
          (entering < 0 || w[i] > w[entering]))
        entering = i;
    if (entering < 0) break;
    passive.push_back(entering);
    VectorXd z = solve_on(A, b, passive);
    while (true) {  // step back to the first y_i that would turn negative, and let it go
      double step = 1;
      Eigen::Index leaving = -1;
      for (const Eigen::Index i : passive) {
        const double reach = z[i] > 0 ? 1.0 : y[i] / std::max(y[i] - z[i], 1e-300);
        if (reach < step || (z[i] <= 0 && leaving < 0)) step = reach, leaving = i;
      }
      if (leaving < 0) break;
      y += step * (z - y);
      y[leaving] = 0;
      std::erase(passive, leaving);
      z = solve_on(A, b, passive);
    }
    y = z.cwiseMax(0.0);
  }
  return y;
}

Multipliers least_squares_multipliers(const VectorXd& x, const VectorXd& lower,
                                      const VectorXd& upper, const VectorXd& c, const VectorXd& df,
                                      const MatrixXd& dc, double active_within) {
  std::vector<Eigen::Index> active, free;
  for (Eigen::Index i = 0; i < c.size(); ++i)
    if (c[i] >= -active_within) active.push_back(i);
  // A held variable feels its bound's multiplier: one more column, +e_j at the upper bound
  // (x_j − upper_j ≤ 0), −e_j at the lower.
  std::vector<std::pair<Eigen::Index, double>> held;
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    if (x[j] >= upper[j] - active_within) held.emplace_back(j, 1.0);
    if (x[j] <= lower[j] + active_within) held.emplace_back(j, -1.0);
  }
  const auto m = static_cast<Eigen::Index>(active.size());
  MatrixXd A = MatrixXd::Zero(x.size(), m + static_cast<Eigen::Index>(held.size()));
  if (m > 0) A.leftCols(m) = dc(active, Eigen::all).transpose();
  for (std::size_t k = 0; k < held.size(); ++k)
    A(held[k].first, m + static_cast<Eigen::Index>(k)) = held[k].second;
  const VectorXd y = non_negative_least_squares(A, -df);
  Multipliers result;
  result.lambda = VectorXd::Zero(c.size());
  for (Eigen::Index i = 0; i < m; ++i) result.lambda[active[static_cast<std::size_t>(i)]] = y[i];
  const VectorXd rest = A.cols() > 0 ? VectorXd(df + A * y) : df;
  result.residual = rest.size() ? rest.cwiseAbs().maxCoeff() : 0.0;
  return result;
}

}  // namespace flexopt
