#pragma once
// A leaf, or a segment of one, whose full model is projected on its Craig–Bampton modes and their
// modal derivatives, in the chord frame. Equations (23)–(27) of modal_derivatives.md.
#include <memory>

#include "core/elements/full_leaf.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/reduction/chord_edges.hpp"
#include "core/reduction/chord_frame.hpp"

namespace flexopt {

/// The fields of all leaves of one shape: x = x0 + X e + Ψ a (modal_derivatives) or
/// x = x0 + X e + ½ Σ θij ei ej (quadratic_manifold), the edges exactly where e puts them.
class ModalModel {
 public:
  ModalModel(std::shared_ptr<const PlateMesh> mesh, Reduction method, ModalDerivativeSet set);

  const std::shared_ptr<const PlateMesh>& mesh() const { return mesh_; }
  bool slaved() const { return slaved_; }
  int amplitudes() const { return static_cast<int>(fields_.cols()); }  ///< none where slaved

  const VectorXd& rest() const { return rest_; }          ///< x0
  const MatrixXd& modes() const { return modes_; }        ///< X, unknowns × 6
  const MatrixXd& derivatives() const { return theta_; }  ///< θij, unknowns × 21 (pair_index)
  const MatrixXd& fields() const { return fields_; }      ///< Ψ, orthonormal in energy at rest
  /// θ·e: Σ_j θij ej, unknowns × 6.
  MatrixXd derivatives_times(const Vector6d& e) const;

 private:
  std::shared_ptr<const PlateMesh> mesh_;
  bool slaved_;
  VectorXd rest_;
  MatrixXd modes_, theta_, fields_;
};

class ModalLeaf final : public LeafElement {
 public:
  /// The model must have been made for such a leaf. `index`: of the leaf in its mechanism.
  ModalLeaf(const LeafSpring& leaf, std::shared_ptr<const ModalModel> model, int index);

  void move(const EdgePoses& edges, const Vector12d& dq) override;
  const LeafEvaluation& evaluate() override;
  const LeafEvaluation& evaluation() const override { return evaluation_; }
  std::unique_ptr<LeafState> save() const override;
  void restore(const LeafState& state) override;
  LeafDynamics dynamics(int modes) override;
  StressPeak max_stress() override;
  LeafShape shape() override;
  Vector3d material_point(double along, double across) override;
  LeafReport report() const override;

  const ModalModel& model() const { return *model_; }
  const VectorXd& amplitudes() const { return a_; }

 private:
  /// Puts the plate into the state of the present edges and amplitudes.
  bool place();
  /// d(unknowns)/de: X, or X + θ e.
  MatrixXd rates() const;
  /// Nodal values in the leaf's axes, from the base's undeflected place.
  std::vector<MatrixXd> nodal();

  LeafSpring leaf_;
  int index_;
  LeafScale scale_;
  std::shared_ptr<const ModalModel> model_;
  PlateLeaf plate_;  ///< in the chord frame
  EdgePoses edges_;  ///< scaled
  VectorXd a_;
  ChordFrame frame_;
  bool placed_ = false;     ///< plate_ and frame_ are those of edges_ and a_
  bool evaluated_ = false;  ///< and so are the linear model and the evaluation
  bool moved_ = false;      ///< the last move left a linearised step
  VectorXd dx_;
  Vector12d dq_;

  VectorXd g_;         ///< of e and a
  MatrixXd H_;         ///< tangent of e and a
  MatrixXd inverse_;   ///< of its block of a
  MatrixXd static_;    ///< da/de
  Rows12x6 edge_map_;  ///< G
  LeafEvaluation evaluation_;
};

}  // namespace flexopt
