#pragma once
// How force, tangent and mass of a superelement change with the places of its nodes and with its
// data. Its energy is the stationary value, over the frame and the forces λ that hold it, of
//
//     E = ½ qᵀ K q − λᵀ Φ q, (18)
//
// so that yᵀ K_T y is the second variation of (18) along y and the frame's first-order answer ψ to
// it, and the derivative of that the third variation, which takes first-order answers only:
//
//     yᵀ K_T y = q1ᵀ K q1 + r·q2,     r = K q − Φᵀ λ,   Φ q1 = 0 (19) (yᵀ K_T y)˙ = 2 (K q1 − Φᵀ
//     λ1)·q̇1 + r·q̇2 + (K q2)·q̇ − λ̇ᵀ Φ q2
//                   + q1ᵀ K̇ q1 + (K̇ q − Φ̇ᵀ λ)·q2 − 2 λ1ᵀ Φ̇ q1                                  (20)
//
// q1, q2: derivatives of the local coordinates where nodes move as p + ε u, exp(ε hat ω) R and the
// frame as x + ε F ξ, F exp(ε hat ψ).
#include <Eigen/LU>
#include <span>

#include "core/reduction/superelement.hpp"

namespace flexopt {

/// Vectors have (displacement, spin) or (force, moment) per node, then the amplitudes of the
/// vibration modes; axes of the nodes' places.
class SuperelementGradient {
 public:
  static constexpr int most_nodes = 4;

  /// `element` evaluated at its present stresses; `rates`: derivatives of its model, whose modes'
  /// block of K may be full. Both must outlive this.
  SuperelementGradient(const Superelement& element, std::span<const SuperelementModel> rates);

  int coordinates() const { return n_; }  ///< of the nodes
  int amplitudes() const { return static_cast<int>(model_->stiffness.rows()) - n_; }

  /// ∂force/∂model, one column for each rate.
  const MatrixXd& force_rates() const { return force_rates_; }
  /// ∂q/∂model, the nodes held.
  const MatrixXd& local_rates() const { return local_rates_; }
  /// Change of the force while the nodes move by the columns of Z.
  MatrixXd force_rates(const MatrixXd& Z) const;

  /// q = yᵀ(K − μ M) y and its derivatives. Those in the state vary the moved R as exp(hat δ) R,
  /// y and μ are constant.
  struct Quadratic {
    double stiffness = 0, mass = 0;  ///< yᵀ K y, yᵀ M y
    VectorXd increment;              ///< ∂q/∂y
    VectorXd state;                  ///< ∂q/∂(places of the nodes)
    VectorXd model;                  ///< along each rate
  };
  /// Sizes of `q` are kept from call to call.
  void quadratic(const VectorXd& y, double mu, Quadratic& q) const;

 private:
  using NodeVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6 * most_nodes, 1>;

  const Superelement* element_;
  const SuperelementModel* model_;
  std::span<const SuperelementModel> rates_;
  int n_, nodes_;
  Eigen::PartialPivLU<Matrix6d> A_;    ///< Φ D Φ_rig
  Eigen::PartialPivLU<Matrix6d> A_t_;  ///< its transpose
  Vector6d lambda_;
  std::vector<Matrix3d> moment_slope_;  ///< ∂(J⁻ᵀ r)/∂θ
  std::vector<Vector6d> frame_rates_;   ///< motion of the frame by the model
  MatrixXd work_rates_;                 ///< K̇ q − Φ̇ᵀ λ
  MatrixXd force_rates_, local_rates_;
};

}  // namespace flexopt
