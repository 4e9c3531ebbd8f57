#pragma once
// A linear superelement: any linear body reduced to the six coordinates of its interface nodes,
// placed by a floating frame that takes up its rigid motion. Equations (R6)–(R10) of
// core/reduction/README.md.
#include <span>
#include <vector>

#include "core/math/floating_frame.hpp"

namespace flexopt {

/// What a superelement is: plain data, in the axes of the undeformed body. Coordinates of a node
/// are its displacement [m] and rotation [rad]. Rows and columns of K and M: the m nodes, six each,
/// then the amplitudes of the fixed-interface vibration modes.
struct SuperelementModel {
  std::vector<Vector3d> nodes;  ///< undeformed interface nodes, seen from the frame's point [m]
  MatrixXd stiffness;           ///< K_CB; boundary and vibration modes do not mix
  MatrixXd mass;                ///< M_CB
  /// Φ_CB, 6 × 6m: displacement and rotation of the frame's material point by the boundary modes.
  MatrixXd frame_modes;
  /// Optional: displacements of the FE body, one column a boundary mode, for stresses and shapes.
  MatrixXd recovery;

  int coordinates() const { return 6 * static_cast<int>(nodes.size()); }
  double size() const;  ///< largest distance of two nodes [m]
};

using NodePose = FramePose;  ///< of an interface node

/// A superelement at given places of its nodes. Vectors have (force, moment) or (displacement,
/// spin) per node, global axes.
class Superelement {
 public:
  /// The model must outlive the superelement.
  explicit Superelement(const SuperelementModel& model);

  /// Frame, energy, force and tangent. `stress_coordinates`: local coordinates whose forces the
  /// geometric stiffness takes instead of the present ones (Newton's linearised last step; equal at
  /// equilibrium). Returns false when no frame was found; the results do not hold then.
  bool evaluate(std::span<const NodePose> nodes, const VectorXd* stress_coordinates = nullptr);

  const SuperelementModel& model() const { return *model_; }
  /// The floating frame places the undeformed body where it fits the deformed one: Φ_CB q = 0.
  const NodePose& frame() const { return floating_.pose; }
  /// Local coordinates q = (u, θ) of the nodes in the frame: u = Fᵀ(p − x) − X, θ = log(Fᵀ R).
  const VectorXd& local() const { return q_; }
  const MatrixXd& local_rate() const { return B_; }  ///< dq = B · (displacement, spin) of the nodes
  double energy() const { return energy_; }
  const VectorXd& force() const { return force_; }      ///< ∂energy/∂nodes
  const MatrixXd& tangent() const { return tangent_; }  ///< R varied as exp(hat δ) R, 2nd order
  /// Largest stretch of the lines between the nodes.
  double strain() const;
  /// M_CB turned into global axes; the vibration modes keep their amplitudes.
  MatrixXd mass() const;

 private:
  const SuperelementModel* model_;
  FloatingFrame<double> floating_;
  VectorXd q_, s_, force_;
  MatrixXd B_, tangent_;
  double energy_ = 0;
};

}  // namespace flexopt
