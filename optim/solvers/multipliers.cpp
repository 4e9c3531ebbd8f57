#include "optim/solvers/multipliers.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

VectorXd solve_on(const MatrixXd& A, const VectorXd& b, const std::vector<Eigen::Index>& set) {
  VectorXd y = VectorXd::Zero(A.cols());
  if (set.empty()) return y;
  const VectorXd solution = least_squares(A(Eigen::all, set), b);
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
                                      const MatrixXd& dc) {
  constexpr double out_of_reach = 0.1;  // no multiplier that far inside a bound
  struct Column {
    VectorXd slope;
    double distance;
  };
  std::vector<Column> columns;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < c.size(); ++i)
    if (c[i] >= -out_of_reach) {
      rows.push_back(i);
      columns.push_back({dc.row(i).transpose(), c[i]});
    }
  // a bound of x is one more constraint: x_j - upper_j <= 0, lower_j - x_j <= 0
  for (Eigen::Index j = 0; j < x.size(); ++j)
    for (const double side : {1.0, -1.0}) {
      const double distance = side > 0 ? x[j] - upper[j] : lower[j] - x[j];
      if (distance >= -out_of_reach)
        columns.push_back({side * VectorXd::Unit(x.size(), j), distance});
    }
  const Eigen::Index n = x.size(), m = std::ssize(columns);
  MatrixXd A = MatrixXd::Zero(n + m, m);
  for (Eigen::Index k = 0; k < m; ++k) {
    A.col(k).head(n) = columns[k].slope;
    A(n + k, k) = columns[k].distance;
  }
  VectorXd b = VectorXd::Zero(n + m);
  b.head(n) = df;
  const VectorXd y = non_negative_least_squares(A, -b);
  Multipliers result;
  result.lambda = VectorXd::Zero(c.size());
  for (std::size_t k = 0; k < rows.size(); ++k) result.lambda[rows[k]] = y[k];
  result.residual = (b + A * y).lpNorm<Eigen::Infinity>();
  result.gap = result.lambda.dot(c.cwiseAbs());
  VectorXd slope = df;
  if (c.size() > 0) slope += dc.transpose() * result.lambda;
  for (Eigen::Index j = 0; j < n; ++j) {
    const double room = slope[j] > 0 ? x[j] - lower[j] : upper[j] - x[j];
    result.gap += std::abs(slope[j]) * (std::isfinite(room) ? room : 1.0);
  }
  return result;
}

}  // namespace flexopt
