#pragma once
// P A Pᵀ = L D Lᵀ of a small symmetric matrix that need not be definite, with Bunch and Kaufman's
// pivots of one or two rows: stable, and D tells how many eigenvalues are negative.
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

class SymmetricFactor {
 public:
  /// Factorises the lower triangle of A. A pivot that is negligible beside A is replaced by a very
  /// small positive one.
  void compute(const MatrixXd& A);

  /// Number of eigenvalues of A below zero.
  int negative() const { return negative_; }
  /// Replaces b by A⁻¹ b.
  void solve(VectorXd& b) const;

 private:
  struct Pivot {
    Eigen::Index row, swapped;  ///< the last row of the pivot, exchanged for this one
    int size;
  };
  Eigen::Index choose(Eigen::Index k, int& size) const;
  void exchange(Eigen::Index a, Eigen::Index b);
  void eliminate_one(Eigen::Index k);
  void eliminate_two(Eigen::Index k);

  MatrixXd L_;  ///< below the pivots; these in its diagonal blocks
  std::vector<Pivot> pivots_;
  double smallest_ = 0;  ///< pivot
  int negative_ = 0;
};

}  // namespace flexopt
