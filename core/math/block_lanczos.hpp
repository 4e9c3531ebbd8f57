#pragma once
// Lowest eigenpairs of K x = λ M x by inverse block Lanczos with full reorthogonalisation. Blocks
// find repeated eigenvalues, up to their width, which a single vector cannot.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/math/lanczos.hpp"
#include "core/math/types.hpp"

namespace flexopt {

/// `solve(B)` → K⁻¹ B, `mass(B)` → M B for matrices of columns, n rows. Values ascending, those of
/// smallest magnitude. Converged when every Ritz value's residual is below `tolerance` relative to
/// it, the last `guards` aside; a last inverse iteration on the found space then squares the error
/// of the values.
template <class Solve, class Mass>
LowestPairs lowest_pairs_of_blocks(int n, int count, int width, const Solve& solve,
                                   const Mass& mass, double tolerance = 1e-7, int guards = 0) {
  LowestPairs pairs;
  const int most = std::min(n, 6 * count + 20 * width + 40);
  MatrixXd V(n, most), MV(n, most), T = MatrixXd::Zero(most, most);
  int k = 0;  // columns of V

  // W ← W − V Vᵀ M W, M-orthonormal: appended to V. The factors go to (the coefficients, the rest).
  const auto append = [&](MatrixXd W, MatrixXd& H, MatrixXd& B) {
    H = MatrixXd::Zero(k, W.cols());
    // the last two blocks carry the coefficients; all others only rounding, removed in one pass
    for (const int first : {std::max(0, k - 3 * width), 0}) {
      const int columns = k - first;
      const MatrixXd h = MV.middleCols(first, columns).transpose() * W;
      W.noalias() -= V.middleCols(first, columns) * h;
      H.bottomRows(columns) += h;
    }
    MatrixXd MW = mass(W);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(MatrixXd(W.transpose() * MW));
    const VectorXd& g = gram.eigenvalues();
    const double floor = 1e-24 * H.colwise().squaredNorm().maxCoeff();
    int kept = 0;
    for (int i = 0; i < g.size(); ++i) kept += g[i] > floor && g[i] > 1e-14 * g[g.size() - 1];
    kept = std::min(kept, most - k);
    const MatrixXd U = gram.eigenvectors().rightCols(kept);
    const VectorXd root = g.tail(kept).cwiseSqrt();
    V.middleCols(k, kept).noalias() = W * (U * root.cwiseInverse().asDiagonal());
    MV.middleCols(k, kept).noalias() = MW * (U * root.cwiseInverse().asDiagonal());
    B = root.asDiagonal() * U.transpose();
    k += kept;
    return kept;
  };

  MatrixXd start(n, width), H, B;  // reproducible and without symmetry
  for (int c = 0; c < width; ++c)
    for (int i = 0; i < n; ++i) start(i, c) = std::sin(1.0 + 1.7 * c + 12.9898 * i + 0.3 * c * i);
  start = solve(mass(start));
  // columns of unit size, for the scale of the first Gram matrix
  for (int c = 0; c < width; ++c) start.col(c) /= start.col(c).norm();
  int block = append(start, H, B), step = 0;

  while (block > 0) {
    const int first = k - block;
    const MatrixXd W = solve(MatrixXd(MV.middleCols(first, block)));
    const int before = k;
    const int next = append(W, H, B);
    T.block(0, first, before, block) = H;
    T.block(first, 0, block, before) = H.transpose();
    const MatrixXd A = T.topLeftCorner(before, before);
    ++step;
    // a decomposition costs about a solve: not at every step
    if (before >= 3 * count && (step % 2 == 0 || next == 0 || k == most)) {
      const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz(0.5 * (A + A.transpose()));
      const VectorXd& theta = ritz.eigenvalues();
      std::vector<int> order(before);
      std::iota(order.begin(), order.end(), 0);
      std::stable_sort(order.begin(), order.end(),
                       [&](int a, int b) { return std::abs(theta[a]) > std::abs(theta[b]); });
      order.resize(count);
      const auto& S = ritz.eigenvectors();
      pairs.converged =
          next == 0 || std::all_of(order.begin(), order.end() - guards, [&](int i) {
            return (B * S.col(i).tail(block)).norm() <= tolerance * std::abs(theta[i]);
          });
      if (pairs.converged || (k == most && most < n)) {
        const MatrixXd MX = MV.leftCols(before) * S(Eigen::all, order);
        // Rayleigh–Ritz on Y = K⁻¹ M X:  (Yᵀ M X) z = λ⁻¹… with Yᵀ K Y = Yᵀ M X
        const MatrixXd Y = solve(MX), MY = mass(Y);
        const MatrixXd KY = Y.transpose() * MX, G = Y.transpose() * MY;
        const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> last(0.5 * (KY + KY.transpose()),
                                                                      0.5 * (G + G.transpose()));
        pairs.values = last.eigenvalues();
        pairs.vectors = Y * last.eigenvectors();
        return pairs;
      }
    }
    block = next;
  }
  return pairs;
}

}  // namespace flexopt
