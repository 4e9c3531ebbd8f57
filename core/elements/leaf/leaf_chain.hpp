#pragma once
// A leaf cut at rigid lines into segments, each of them a leaf element of its own: the lines
// between are internal unknowns, eliminated, so that the mechanism sees the edges only. Any
// elements do.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/elements/leaf/condensed_interior.hpp"
#include "core/elements/leaf/leaf_element.hpp"
#include "core/math/block_tridiagonal.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Segment i of n equal ones along a leaf: both its edges are held.
LeafSpring leaf_segment(const LeafSpring& leaf, int i, int n);

class LeafChain final : public LeafElement {
 public:
  /// Makes the whole leaf at full accuracy, in one piece, where its chain stands; `reason`: for its
  /// report.
  using FullModel = std::function<std::unique_ptr<LeafElement>(
      LeafElement& chain, const EdgePoses& edges, const std::string& reason)>;

  /// `segments`: at least two, in order along the leaf, made for its `leaf_segment`s at rest.
  LeafChain(const LeafSpring& leaf, std::vector<std::unique_ptr<LeafElement>> segments,
            FullModel full_model);

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
  Check check_rebuilt() const override;

 private:
  int segments() const { return static_cast<int>(segments_.size()); }
  int unknowns() const { return K_.size(); }
  /// Rows of segment i's two edges among those of T: inner lines, then the 12 of the edges.
  MatrixXd edge_rows(int i, const MatrixXd& T) const;
  MatrixXd shape_motion(const std::vector<LeafDynamics>& parts, const MatrixXd& lines);

  LeafSpring leaf_;
  std::vector<std::unique_ptr<LeafElement>> segments_;
  FullModel full_model_;
  std::vector<EdgePose> lines_;  ///< all of them, edges included
  double unit_energy_;           ///< D, for the size of the correction
  BlockTridiagonal K_;           ///< of the inner lines
  VectorXd g_;                   ///< residual
  MatrixXd coupling_;            ///< K_fb
  CondensedInterior interior_;
  bool condensed_ = false;  ///< it is that of the present state
  int points_across_ = 0;   ///< of shape(), once known
};

}  // namespace flexopt
