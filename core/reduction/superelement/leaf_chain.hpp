#pragma once
// A leaf cut at rigid lines into segments, each of them a leaf element of its own: the lines
// between are internal unknowns, eliminated, so that the mechanism sees the edges only. Any
// elements do.
#include <memory>
#include <string>
#include <vector>

#include "core/elements/leaf/condensed_interior.hpp"
#include "core/elements/leaf/leaf_element.hpp"
#include "core/elements/plate/plate_mesh.hpp"
#include "core/math/block_tridiagonal.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Segment i of n equal ones along a leaf: both its edges are held.
LeafSpring leaf_segment(const LeafSpring& leaf, int i, int n);

class LeafChain final : public LeafElement {
 public:
  /// `segments`: at least two, in order along the leaf, made for its `leaf_segment`s at rest.
  /// `shape`, `index`: of the leaf in one piece, and in its mechanism.
  LeafChain(const LeafSpring& leaf, std::vector<std::unique_ptr<LeafElement>> segments,
            PlateShape shape, int index);

  void move(const EdgePoses& edges, const Vector12d& dq) override;
  const LeafEvaluation& evaluate() override;
  std::unique_ptr<LeafState> save() const override;
  void restore(const LeafState& state) override;
  LeafDynamics dynamics(DynamicsRequest request) override;
  LeafStress stress() override;
  LeafShape shape() override;
  std::vector<Vector3d> material_points(const std::vector<std::array<double, 2>>& places) override;
  LeafReport report() const override { return segments_.front()->report(); }
  std::unique_ptr<LeafElement> full_model(const std::string& reason) override;

 private:
  int segments() const { return static_cast<int>(segments_.size()); }
  int unknowns() const { return K_.size(); }
  /// Rows of segment i's two edges among those of T: inner lines, then the 12 of the edges.
  MatrixXd edge_rows(int i, const MatrixXd& T) const;

  LeafSpring leaf_;
  std::vector<std::unique_ptr<LeafElement>> segments_;
  PlateShape shape_;
  int index_;
  std::vector<EdgePose> lines_;  ///< all of them, edges included
  double unit_energy_;           ///< D, for the size of the correction
  BlockTridiagonal K_;           ///< of the inner lines
  VectorXd g_;                   ///< residual
  MatrixXd coupling_;            ///< K_fb
  CondensedInterior interior_;
  bool condensed_ = false;  ///< it is that of the present state
};

}  // namespace flexopt
