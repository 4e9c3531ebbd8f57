#pragma once
// How force, tangent and mass of a superelement change with the places of its nodes and with its
// data: equations (R16), (R17) of core/reduction/README.md. Its energy is the stationary value of ½
// qᵀKq − λᵀΦq over the frame and the forces λ that hold it, so that yᵀ K_T y is its second
// variation along y and the frame's first-order answer, and the derivative of that the third
// variation with first-order answers only.
#include <span>

#include "core/math/small_lu.hpp"
#include "core/reduction/superelement/superelement.hpp"

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
  /// Motion of the frame (displacement, spin; in its axes) by the model, the nodes held, and by
  /// nodes that move by the columns of Z.
  const Vector6d& frame_rate(int model) const { return frame_rates_[model]; }
  MatrixXd frame_rates(const MatrixXd& Z) const;
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

  struct Motion;

  void add_rate(int model);
  Vector6d turned_back(const NodeVector& v) const;  ///< Φ_rigᵀ Dᵀ v
  void add_mass(const VectorXd& y, double mu, Motion& motion, Quadratic& form) const;
  /// The motion along the increments; its share of yᵀ K y.
  double move(Motion& motion) const;
  void add_derivatives(const Motion& motion, double mu, Quadratic& form) const;

  const Superelement* element_;
  const SuperelementModel* model_;
  std::span<const SuperelementModel> rates_;
  int n_, nodes_;
  SmallLu<6> A_;    ///< Φ D Φ_rig
  SmallLu<6> A_t_;  ///< its transpose
  Vector6d lambda_;
  std::vector<Matrix3d> moment_slope_;  ///< ∂(J⁻ᵀ r)/∂θ
  std::vector<Vector6d> frame_rates_;   ///< motion of the frame by the model
  MatrixXd work_rates_;                 ///< K̇ q − Φ̇ᵀ λ
  MatrixXd force_rates_, local_rates_;
};

}  // namespace flexopt
