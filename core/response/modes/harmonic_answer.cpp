#include "core/response/modes/harmonic_answer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/decompositions.hpp"

namespace flexopt {

Complex PoleSum::at(Complex sigma) const {
  Complex sum = 0;
  for (Eigen::Index j = 0; j < theta.size(); ++j) sum += weight[j] / (1.0 - sigma * theta[j]);
  return sum;
}

Complex PoleSum::slope(Complex sigma) const {
  Complex sum = 0;
  for (Eigen::Index j = 0; j < theta.size(); ++j) {
    const Complex one = 1.0 - sigma * theta[j];
    sum += weight[j] * theta[j] / (one * one);
  }
  return sum;
}

std::vector<double> PoleSum::frequencies() const {
  constexpr double rounding = 1e-12;  // of the largest: bodies that nothing moves
  std::vector<double> list;
  const double largest = theta.size() > 0 ? theta.maxCoeff() : 0;
  for (const double t : theta)
    if (t > rounding * largest) list.push_back(1 / (2 * std::numbers::pi * std::sqrt(t)));
  std::ranges::sort(list);
  return list;
}

HarmonicAnswer::HarmonicAnswer(const VectorXd& start, int most, const LinearMap& solve,
                               const LinearMap& mass)
    : solve_(solve), mass_(mass), start_(start), krylov_(start, most, solve, mass) {
  size_ = std::sqrt(std::max(0.0, start.dot(mass(start).col(0))));
}

bool HarmonicAnswer::extend() {
  constexpr int columns_at_once = 8;
  bool more = true;
  for (int k = 0; k < columns_at_once && more; ++k) more = krylov_.extend();
  decompose();
  return more;
}

void HarmonicAnswer::decompose() {
  const MatrixXd T = krylov_.T();
  if (T.rows() == 0) return;
  const SymmetricEigen eigen = T.rows() > 1
                                   ? SymmetricEigen::of_tridiagonal(T.diagonal(), T.diagonal(-1))
                                   : SymmetricEigen(T);
  theta_ = eigen.eigenvalues();
  Q_ = eigen.eigenvectors();
}

PoleSum HarmonicAnswer::along(const VectorXd& a) const {
  if (still()) return {VectorXd::Zero(1), VectorXd::Constant(1, a.dot(start_))};
  return {theta_, size_ * Q_.row(0).transpose().cwiseProduct(Q_.transpose() *
                                                             (krylov_.V().transpose() * a))};
}

PoleSum HarmonicAnswer::mass() const {
  if (still()) return {VectorXd::Zero(1), VectorXd::Zero(1)};
  return {theta_, size_ * size_ * Q_.row(0).transpose().cwiseAbs2()};
}

VectorXcd HarmonicAnswer::coefficients(Complex sigma) const {
  const VectorXcd of_poles =
      (size_ * Q_.row(0).transpose().cast<Complex>())
          .cwiseQuotient((1.0 - sigma * theta_.cast<Complex>().array()).matrix());
  VectorXcd g(Q_.rows());
  g.real() = Q_ * of_poles.real();
  g.imag() = Q_ * of_poles.imag();
  return g;
}

double HarmonicAnswer::residual(Complex sigma) const {
  if (still() || exact()) return 0;
  const VectorXcd g = coefficients(sigma);
  return std::abs(sigma * g[g.size() - 1]) * krylov_.rest().norm() / g.norm();
}

VectorXcd HarmonicAnswer::vector(Complex sigma) const {
  VectorXcd y = start_.cast<Complex>();
  if (still()) return y;
  const VectorXcd g = coefficients(sigma);
  MatrixXd parts(g.size(), 2);
  parts.col(0) = g.real();
  parts.col(1) = g.imag();
  const MatrixXd next = solve_(MatrixXd(krylov_.MV() * parts));
  VectorXcd answer(y.size());
  answer.real() = next.col(0);
  answer.imag() = next.col(1);
  y += sigma * answer;
  return y;
}

}  // namespace flexopt
