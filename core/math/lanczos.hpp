#pragma once
// Lowest eigenpairs of K x = λ M x by inverse block Lanczos with full reorthogonalisation. Blocks
// find repeated eigenvalues, up to their width, and several right sides cost a solve little more
// than one. Written here because every step needs one K⁻¹ and one M only when M V is kept beside V;
// general packages ask for several products with M a step.
#include <functional>

#include "core/math/types.hpp"

namespace flexopt {

/// B → A B for a matrix of columns, n × any number.
using LinearMap = std::function<MatrixXd(const MatrixXd&)>;

struct LowestPairs {
  bool converged = false;
  VectorXd values;   ///< ascending; of smallest magnitude, a negative one where K has one
  MatrixXd vectors;  ///< M-orthonormal columns
};

/// The lowest `count` pairs of n unknowns: `solve(B)` → K⁻¹ B, `mass(B)` → M B, M positive
/// definite. Converged when every Ritz value's residual is below `tolerance` relative to it; its
/// error is the square of that. Blocks then end with an inverse iteration on the found space, which
/// makes the vectors better; for single vectors, where it would cost half of the whole, it is left
/// out.
LowestPairs lowest_pairs(int n, int count, int width, const LinearMap& solve, const LinearMap& mass,
                         double tolerance = 1e-7);

/// What is wanted of a body's modes.
struct ModesWanted {
  int count = 0;     ///< stable ones, the lowest
  int negative = 0;  ///< eigenvalues of K below zero, by its inertia: those are found, all of them
  bool in_pairs = false;  ///< equal values come in pairs: both are found, and none stands alone
  /// Whether there may be motions without mass, which are no modes. Where fewer modes exist than
  /// are sought, such motions spoil those found: not usable with pairs, and negative values of
  /// large magnitude are not sought.
  bool massless = false;
  double tolerance = 1e-7;
};

/// The negative eigenvalues and the lowest `count` others; one more where the last is one of a
/// pair. solve and mass as above; no values where it did not converge.
LowestPairs lowest_modes(int n, const ModesWanted& wanted, const LinearMap& solve,
                         const LinearMap& mass);

/// Columns to start from, n × width: reproducible and without symmetry, no mode is orthogonal to
/// them. Those of another seed are others.
MatrixXd start_columns(int n, int width, int seed = 0);

/// Krylov space of K⁻¹M, block by block: V M-orthonormal, K⁻¹M V = V T + (next block) rest() on the
/// last block's columns. Where the space is full, rest() has a row for each column that found no
/// room: its size.
class BlockKrylov {
 public:
  /// `most`: columns of V at the end.
  BlockKrylov(const MatrixXd& start, int most, LinearMap solve, LinearMap mass);

  /// Adds a block; false where the space is invariant or full.
  bool extend();
  /// Goes on with these columns as the next block, where the space is invariant.
  void go_on(const MatrixXd& columns);

  int columns() const { return columns_; }  ///< of V with their T; the next block is not counted
  /// Whether the space is invariant, so that it contains the whole answer.
  bool invariant() const { return block_ == 0 && (columns_ < most_ || most_ == V_.rows()); }
  auto V() const { return V_.leftCols(columns_); }
  auto MV() const { return MV_.leftCols(columns_); }
  MatrixXd T() const;
  const MatrixXd& rest() const { return rest_; }

 private:
  MatrixXd append(MatrixXd W);
  void orthonormalise(MatrixXd& W, const VectorXd& removed);

  LinearMap solve_, mass_;
  int width_, most_, columns_ = 0, block_ = 0;
  MatrixXd V_, MV_, T_, rest_;
};

/// The `count` eigenvalues of largest magnitude of a symmetric matrix, in that order, and their
/// vectors.
struct LargestPairs {
  VectorXd values;
  MatrixXd vectors;
};
LargestPairs largest_pairs(const MatrixXd& A, int count);

}  // namespace flexopt
