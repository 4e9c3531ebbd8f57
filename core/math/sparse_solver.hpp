#pragma once
// Linear equations: dense by LU where there are few unknowns, else by the sparse factorisations of
// SuiteSparse that are not under the GPL (KLU, LDL, AMD). sparse_definite.hpp: definite ones.
#include <memory>
#include <optional>

#include "core/math/decompositions.hpp"
#include "core/math/sparse_matrix.hpp"

namespace flexopt {

/// Number of unknowns from which the equations of a mechanism are solved sparse. Measured:
/// `./flexopt bench many_leaves`.
inline constexpr int sparse_from = 200;

/// Orders of elimination that were found for patterns, so that a matrix that is assembled again
/// costs its numbers only. Keeps the latest few. Not for several threads at once.
class SparseAnalyses {
 public:
  SparseAnalyses();
  ~SparseAnalyses();
  SparseAnalyses(const SparseAnalyses&) = delete;
  SparseAnalyses& operator=(const SparseAnalyses&) = delete;

  struct Kept;
  Kept& kept() { return *kept_; }

 private:
  std::unique_ptr<Kept> kept_;
};

/// A x = b with pivoting: KLU and one step of refinement, or dense. Not for several threads at
/// once.
class LinearSolver {
 public:
  LinearSolver() = default;
  /// `analyses`: null for dense. Throws std::bad_alloc. Where A is singular the answers are not
  /// finite.
  LinearSolver(const SparseMatrix& A, const std::shared_ptr<SparseAnalyses>& analyses);

  MatrixXd solve(const Eigen::Ref<const MatrixXd>& B) const;

 private:
  struct Factor;  ///< of KLU
  Lu dense_;
  std::shared_ptr<const Factor> sparse_;
};

/// How many eigenvalues of a symmetric matrix are negative: of L D Lᵀ without pivoting (LDL).
/// `order`: of elimination; empty for a good one. None where a pivot vanishes.
std::optional<int> negative_eigenvalues(const SparseMatrix& A, const std::vector<int>& order,
                                        SparseAnalyses& analyses);

/// Bodies in an order of elimination that keeps the factors of a matrix of this pattern sparse
/// (approximate minimum degree); `ties`: further pairs of bodies. Throws std::bad_alloc.
std::vector<int> elimination_order(const BlockMatrix& A,
                                   const std::vector<std::pair<int, int>>& ties);

}  // namespace flexopt
