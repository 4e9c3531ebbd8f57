#pragma once
// Values of polynomials, with powers from std::pow.
#include <Eigen/Core>
#include <cmath>
#include <span>

#include "core/math/matrix_polynomial.hpp"
#include "core/math/polynomial.hpp"

namespace flexopt::test {

/// Values of all monomials at x.
inline Eigen::VectorXd monomial_values(const MonomialTable& table, std::span<const double> x) {
  Eigen::VectorXd values = Eigen::VectorXd::Ones(table.size());
  for (int i = 0; i < table.size(); ++i)
    for (int v = 0; v < table.variables(); ++v)
      values[i] *= std::pow(x[static_cast<std::size_t>(v)], table.exponents(i)[v]);
  return values;
}

/// Σ c_i x^i.
inline double polynomial_value(const MonomialTable& table, std::span<const double> c,
                               std::span<const double> x) {
  return Eigen::Map<const Eigen::VectorXd>(c.data(), table.size()).dot(monomial_values(table, x));
}

/// The same with matrices as coefficients.
inline Eigen::MatrixXd polynomial_value(const MatrixPolynomial& A, std::span<const double> x) {
  const Eigen::VectorXd values = monomial_values(A.table(), x);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(A.rows(), A.cols());
  for (int i = 0; i < A.size(); ++i) sum += values[i] * A[i];
  return sum;
}

}  // namespace flexopt::test
