#include "core/math/dense_pencil.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/math/decompositions.hpp"

namespace flexopt {

namespace {

// Pairs of K x = λ M x by the Cholesky factor of K − σ M: λ = σ + 1/θ with the largest θ. Nothing
// where that is not positive definite.
std::optional<EigenPairs> pairs_above(double sigma, const MatrixXd& K, const MatrixXd& M,
                                      int count) {
  const Cholesky factor(K - sigma * M);
  if (!factor.positive_definite()) return std::nullopt;
  MatrixXd A = factor.solve_lower(M);
  A = factor.solve_lower(A.transpose());
  const SymmetricEigen eigen(0.5 * (A + A.transpose()));
  const VectorXd distance =
      eigen.eigenvalues().tail(count).reverse().cwiseMax(1e-300).cwiseInverse();
  return EigenPairs{sigma + distance.array(),
                    factor.solve_upper(eigen.eigenvectors().rightCols(count).rowwise().reverse()) *
                        distance.cwiseSqrt().asDiagonal()};
}

}  // namespace

// Uses the Cholesky factor of K or, where K is not positive definite, of K − σ M below all values:
// that of M alone loses them where some motions have (nearly) no mass.
EigenPairs lowest_dense_pairs(const MatrixXd& K, const MatrixXd& M, int count) {
  const int n = static_cast<int>(K.rows());
  count = std::min(count, n);
  if (n == 0) return {VectorXd(0), MatrixXd(0, 0)};
  const VectorXd s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd Ks = s.asDiagonal() * K * s.asDiagonal(), Ms = s.asDiagonal() * M * s.asDiagonal();
  std::optional<EigenPairs> pairs = pairs_above(0, Ks, Ms, count);
  constexpr double first = 1e-4, last = 1e12;  // times unit stiffness over the largest mass
  const double unit = 1 / std::max(Ms.diagonal().cwiseAbs().maxCoeff(), 1e-300);
  for (double below = first; !pairs && below <= last; below *= 10)
    pairs = pairs_above(-below * unit, Ks, Ms, count);
  if (!pairs) {
    const SymmetricEigen eigen(Ks, Ms);
    pairs = EigenPairs{eigen.eigenvalues().head(count), eigen.eigenvectors().leftCols(count)};
  }
  pairs->vectors = (s.asDiagonal() * pairs->vectors).eval();
  return *std::move(pairs);
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
