#pragma once
// A leaf, or a segment of one, whose full model is projected on its Craig–Bampton modes and their
// modal derivatives, in the chord frame. Equations (M6)–(M9) of
// core/reduction/superelement/README.md.
#include <memory>

#include "core/elements/plate/full_leaf.hpp"
#include "core/reduction/superelement/modal_derivatives.hpp"

namespace flexopt {

class ModalLeaf final : public LeafElement {
 public:
  /// The model must have been made for such a leaf. `index`: of the leaf in its mechanism.
  ModalLeaf(const LeafSpring& leaf, std::shared_ptr<const ModalModel> model, int index);

  void move(const EdgePoses& edges, const Vector12d& dq) override;
  const LeafEvaluation& evaluate() override;
  std::unique_ptr<LeafState> save() const override;
  void restore(const LeafState& state) override;
  LeafDynamics dynamics(DynamicsRequest request) override;
  LeafStress stress() override;
  LeafShape shape() override;
  std::vector<Vector3d> material_points(const std::vector<std::array<double, 2>>& places) override;
  LeafReport report() const override;
  std::unique_ptr<LeafElement> full_model(const std::string& reason) override;

  const ModalModel& model() const { return *model_; }

 private:
  /// Rates of the plate's unknowns and edges by (edges, a), seen in the axes of the chord frame
  /// from axes that stand still: unknowns + 12 rows.
  MatrixXd rates() const;
  /// Nodal values in the leaf's axes, from the base's undeflected place.
  std::vector<MatrixXd> nodal() const;
  /// Puts the plate into the state of the present edges and amplitudes.
  bool place();
  /// Sets V_, g_ and H_ there.
  void linearise_chart();

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
  double step_size_ = 0;  ///< of the last step of a slaved leaf, in energy

  MatrixXd V_;         ///< d(unknowns)/d(e, a)
  VectorXd g_;         ///< of e and a
  MatrixXd H_;         ///< tangent of e and a
  MatrixXd inverse_;   ///< of its block of a
  MatrixXd static_;    ///< da/de
  Rows12x6 edge_map_;  ///< G
};

}  // namespace flexopt
