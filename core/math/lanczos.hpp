#pragma once
// Lowest eigenpairs of K x = λ M x by inverse Lanczos with full reorthogonalisation. Written here
// because every step needs one K⁻¹ and one M only when M V is kept beside V; general packages ask
// for several products with M a step, which is what a leaf's frequencies cost.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/math/decompositions.hpp"
#include "core/math/types.hpp"

namespace flexopt {

struct LowestPairs {
  bool converged = false;
  VectorXd values;   ///< ascending; of smallest magnitude, a negative one where K has one
  MatrixXd vectors;  ///< M-orthonormal columns
};

/// `solve(x)` → K⁻¹ x, `mass(x)` → M x, M positive definite, n unknowns. Converged when every Ritz
/// value's residual is below `tolerance` relative to it (its error is the square of that).
template <class Solve, class Mass>
LowestPairs lowest_pairs(int n, int count, const Solve& solve, const Mass& mass,
                         double tolerance = 1e-7) {
  LowestPairs pairs;
  count = std::min(count, n);
  const int most = std::min(n, 6 * count + 60);
  MatrixXd V(n, most), MV(n, most);
  VectorXd alpha(most), beta = VectorXd::Zero(most);

  // reproducible and without symmetry: no mode is orthogonal to it
  auto start = [n](int seed) {
    VectorXd v(n);
    for (int i = 0; i < n; ++i) v[i] = std::sin(1.0 + 1.7 * seed + 12.9898 * i);
    return v;
  };
  auto orthogonalise = [&](VectorXd& w, int k) {
    VectorXd sum = VectorXd::Zero(k);
    for (int pass = 0; pass < 2; ++pass) {
      const VectorXd h = MV.leftCols(k).transpose() * w;
      w.noalias() -= V.leftCols(k) * h;
      sum += h;
    }
    return sum;
  };

  VectorXd w = start(0), Mw = mass(w);
  double norm = std::sqrt(w.dot(Mw));
  for (int j = 0; j < most; ++j) {
    V.col(j) = w / norm;
    MV.col(j) = Mw / norm;
    w = solve(VectorXd(MV.col(j)));
    alpha[j] = orthogonalise(w, j + 1)[j];
    Mw = mass(w);
    norm = std::sqrt(std::max(0.0, w.dot(Mw)));
    const bool exhausted = norm <= 1e-13 * std::abs(alpha[0]);

    const int k = j + 1;
    if (k >= count && (k % 4 == 0 || k == most)) {
      const auto ritz = SymmetricEigen::of_tridiagonal(alpha.head(k), beta.head(k - 1));
      std::vector<int> order(k);
      std::iota(order.begin(), order.end(), 0);
      const VectorXd& theta = ritz.eigenvalues();
      std::stable_sort(order.begin(), order.end(),
                       [&](int a, int b) { return std::abs(theta[a]) > std::abs(theta[b]); });
      order.resize(count);
      const bool done = std::all_of(order.begin(), order.end(), [&](int i) {
        return norm * std::abs(ritz.eigenvectors()(k - 1, i)) <= tolerance * std::abs(theta[i]);
      });
      if (done || k == most) {
        std::sort(order.begin(), order.end(),
                  [&](int a, int b) { return 1 / theta[a] < 1 / theta[b]; });
        pairs.converged = done || k == n;
        pairs.values.resize(count);
        pairs.vectors.resize(n, count);
        for (int i = 0; i < count; ++i) {
          pairs.values[i] = 1 / theta[order[i]];
          pairs.vectors.col(i).noalias() = V.leftCols(k) * ritz.eigenvectors().col(order[i]);
        }
        return pairs;
      }
    }
    beta[j] = exhausted ? 0 : norm;
    if (exhausted) {  // an invariant subspace: go on beside it
      w = start(j + 1);
      orthogonalise(w, k);
      Mw = mass(w);
      norm = std::sqrt(w.dot(Mw));
    }
  }
  return pairs;
}

}  // namespace flexopt
