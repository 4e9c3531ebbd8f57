#include "core/math/dense_pencil.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/math/decompositions.hpp"

namespace flexopt {

// Uses the Cholesky factor of K, or that of M where K is not positive definite.
EigenPairs lowest_dense_pairs(const MatrixXd& K, const MatrixXd& M, int count) {
  const int n = static_cast<int>(K.rows());
  count = std::min(count, n);
  EigenPairs pairs{VectorXd(count), MatrixXd(n, count)};
  const VectorXd s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd Ks = s.asDiagonal() * K * s.asDiagonal(), Ms = s.asDiagonal() * M * s.asDiagonal();
  const Cholesky factor(Ks);
  if (factor.positive_definite()) {
    MatrixXd A = factor.solve_lower(Ms);
    A = factor.solve_lower(A.transpose());
    const SymmetricEigen eigen(0.5 * (A + A.transpose()));
    pairs.values = eigen.eigenvalues().tail(count).reverse().cwiseMax(1e-300).cwiseInverse();
    pairs.vectors = s.asDiagonal() *
                    factor.solve_upper(eigen.eigenvectors().rightCols(count).rowwise().reverse()) *
                    pairs.values.cwiseSqrt().asDiagonal();
  } else {
    const SymmetricEigen eigen(Ks, Ms);
    pairs.values = eigen.eigenvalues().head(count);
    pairs.vectors = s.asDiagonal() * eigen.eigenvectors().leftCols(count);
  }
  return pairs;
}

EigenPairs held_pairs(const EigenPairs& free, Eigen::Index r, int count) {
  constexpr double nothing = 1e-12;
  constexpr int bisections = 20;
  const VectorXd v = free.vectors.row(r).transpose().normalized();
  const VectorXd squares = v.cwiseAbs2();
  const Eigen::Index n = v.size();
  EigenPairs held{VectorXd(n), MatrixXd(free.vectors.rows(), n)};
  Eigen::Index found = 0, before = -1;  // the last λ that takes part
  const auto add = [&](double value, const VectorXd& x) {
    held.values[found] = value;
    held.vectors.col(found++) = free.vectors * x.normalized();
  };
  for (Eigen::Index k = 0; k < n && found < count; ++k) {
    if (squares[k] < nothing) {  // it moves nothing
      add(free.values[k], VectorXd::Unit(n, k));
      continue;
    }
    const Eigen::Index a = std::exchange(before, k);
    if (a < 0) continue;
    const double gap = free.values[k] - free.values[a];
    if (!(gap > 1e-10 * std::abs(free.values[k]))) {
      add(free.values[k], v[k] * VectorXd::Unit(n, a) - v[a] * VectorXd::Unit(n, k));
      continue;
    }
    double low = free.values[a], high = free.values[k];
    for (int step = 0; step < bisections; ++step) {
      const double middle = 0.5 * (low + high);
      const bool above = (squares.array() / (free.values.array() - middle)).sum() > 0;
      (above ? high : low) = middle;
    }
    const double mu = 0.5 * (low + high);
    add(mu, v.cwiseQuotient((free.values.array() - mu).matrix()));
  }
  held.values.conservativeResize(found);
  held.vectors.conservativeResize(Eigen::NoChange, found);
  return held;
}

}  // namespace flexopt
