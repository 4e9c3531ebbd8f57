#pragma once
// Symmetric block-tridiagonal factorisation K = L Σ Lᵀ with the inertia of K.
#include <Eigen/Dense>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// Diagonal blocks D_i and blocks O_i below them (row i + 1, column i). Positive definite pivots
/// take the Cholesky way; an indefinite pivot is eliminated with pivots of its own, so that buckled
/// leaves are solved too and counted. Storage is kept between factorisations of the same sizes.
class BlockTridiagonal {
 public:
  /// Sets the sizes of the blocks.
  void resize(const std::vector<int>& sizes);

  int blocks() const { return static_cast<int>(diagonal.size()); }
  int size() const { return offset.back(); }

  std::vector<MatrixXd> diagonal;  ///< only the lower triangle is read; overwritten by factorise()
  std::vector<MatrixXd> below;     ///< overwritten by factorise()
  std::vector<int> offset;         ///< start of each block, and the size at the end

  void factorise();
  /// Makes solving faster by inverting the pivots once: pays from some twenty columns on.
  void invert_pivots();
  /// K b; before factorise().
  MatrixXd times(const MatrixXd& b) const;

  /// Negative eigenvalues of the factorised matrix.
  int negative_pivots() const { return negative_; }

  /// L⁻¹ b in place, blocks before `first` of b being zero.
  void solve_lower(Eigen::Ref<MatrixXd> b, int first = 0) const;
  /// Σ y in place.
  void apply_signs(Eigen::Ref<MatrixXd> y) const;
  /// L⁻ᵀ b in place.
  void solve_upper(Eigen::Ref<MatrixXd> b) const;
  /// K⁻¹ b in place.
  void solve(Eigen::Ref<MatrixXd> b) const {
    solve_lower(b);
    apply_signs(b);
    solve_upper(b);
  }

 private:
  template <class Derived>
  void lower(Eigen::MatrixBase<Derived>& b, int first) const;
  template <class Derived>
  void upper(Eigen::MatrixBase<Derived>& b) const;

  struct Indefinite {
    MatrixXd inverse_root;  ///< R of R⁻¹ Σ R⁻ᵀ; after invert_pivots() that of a positive pivot too
    VectorXd signs;
  };
  std::vector<Indefinite> indefinite_;  ///< empty matrices where the pivot is positive definite
  int negative_ = 0;
  bool inverted_ = false;
};

}  // namespace flexopt
