#pragma once
// Harmonic answers of a linearised mechanism at all frequencies up to some, from one Krylov space.
#include <complex>
#include <vector>

#include "core/math/lanczos.hpp"

namespace flexopt {

using Complex = std::complex<double>;
using VectorXcd = Eigen::VectorXcd;

/// Σ_j weight_j / (1 − σ θ_j)
struct PoleSum {
  VectorXd theta, weight;

  Complex at(Complex sigma) const;
  /// Derivative along σ.
  Complex slope(Complex sigma) const;
  /// Frequencies of the poles, ascending [Hz].
  std::vector<double> frequencies() const;
};

/// y(σ) = (1 − σ K⁻¹M)⁻¹ y(0) for a static answer y(0) = K⁻¹ f, or for a motion that K⁻¹ does not
/// make: equation (H5) of README.md. In the Krylov space V of K⁻¹M, begun with y(0),
///     y(σ) ≈ V (1 − σ T)⁻¹ Vᵀ M y(0)
/// for every σ at once.
class HarmonicAnswer {
 public:
  /// `most`: columns of V at the end.
  HarmonicAnswer(const VectorXd& start, int most, const LinearMap& solve, const LinearMap& mass);

  /// Adds some columns; false where there are no more.
  bool extend();
  /// Whether the answer is exact, because the Krylov space is invariant.
  bool exact() const { return krylov_.invariant(); }
  /// Whether y(0) has no mass that moves, so that y(σ) = y(0).
  bool still() const { return krylov_.columns() == 0; }

  /// aᵀ y(σ).
  PoleSum along(const VectorXd& a) const;
  /// y(0)ᵀ M y(σ).
  PoleSum mass() const;
  /// What is left of (1 − σ K⁻¹M) y(σ) = y(0), over y(σ), both by their mass.
  double residual(Complex sigma) const;
  /// The motion y(σ), improved by one solve more: its error is of the order of the square of the
  /// residual.
  VectorXcd vector(Complex sigma) const;

 private:
  void decompose();
  VectorXcd coefficients(Complex sigma) const;

  LinearMap solve_, mass_;
  VectorXd start_;
  BlockKrylov krylov_;
  double size_ = 0;  ///< of y(0), by its mass
  VectorXd theta_;   ///< T = Q θ Qᵀ
  MatrixXd Q_;
};

}  // namespace flexopt
