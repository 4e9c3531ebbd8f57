#pragma once
// A leaf spring of a mechanism at full accuracy: PlateLeaf in SI units and global axes.
#include <memory>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/elements/leaf/leaf_scale.hpp"
#include "core/elements/plate/plate_leaf.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

PlateShape plate_shape(const LeafSpring& leaf, const std::array<int, 2>& mesh,
                       bool free_edge_torsion);
/// What a leaf is modelled as.
PlateShape leaf_shape(const LeafSpring& leaf, const ModelOptions& model);

PlateSupport plate_support(const LeafSpring& leaf, const PlateMesh& mesh);

class FullLeaf final : public LeafElement {
 public:
  /// `mesh` must have the shape of the leaf. `index`: of the leaf in its mechanism.
  /// `reason`: why the leaf is not what was asked for; empty if it is.
  FullLeaf(const LeafSpring& leaf, std::shared_ptr<const PlateMesh> mesh, int index,
           std::string reason = {});

  /// An undeflected leaf shares the assembly and factors of an equal undeflected one, which are
  /// made if need be, until one of both moves. False if the two are not equal.
  bool start_as(FullLeaf& equal);

  void move(const EdgePoses& edges, const Vector12d& dq) override;
  void displace_point(const Vector3d& displacement, const Vector3d& du) override;
  /// With a load that acts inside, the energy contains that of the weight, zero when undeflected.
  void act(const LeafLoad& load) override;
  const LeafEvaluation& evaluate() override;
  LeafInterior interior(const Vector12d& dq) const override;
  std::unique_ptr<LeafState> save() const override;
  void restore(const LeafState& state) override;
  LeafDynamics dynamics(DynamicsRequest request) override;
  LeafStress stress() override;
  LeafShape shape() override;
  std::vector<Vector3d> material_points(const std::vector<std::array<double, 2>>& places) override;
  LeafReport report() const override {
    return {.model = "full", .reason = reason_, .check = 0, .replaced = !reason_.empty()};
  }
  bool is_full() const override { return true; }
  std::unique_ptr<LeafElement> full_model(const std::string& reason) override;
  Answer<std::unique_ptr<LeafLinear>> linearise() override;
  Check check_interior(InteriorUse) override { return {}; }

  /// The plate for changes: from now on it is not shared with other leaves.
  PlateLeaf& plate();
  const PlateLeaf& plate() const { return *plate_; }
  /// PlateLeaf::invert_pivots(), for all leaves that share the plate.
  void invert_pivots() { plate_->invert_pivots(); }
  const LeafScale& scale() const { return scale_; }

 private:
  LeafSpring leaf_;
  int index_;
  std::string reason_;
  LeafScale scale_;
  std::shared_ptr<PlateLeaf> plate_;  ///< of equal undeflected leaves one
  bool assembled_ = false;            ///< the plate is, at the present state
  Vector3d point_ = Vector3d::Zero(), point_increment_ = Vector3d::Zero();  ///< scaled
};

/// Motion of the leaf's stations for the columns of T (unknowns, then edge increments, all scaled),
/// times the root of their mass: LeafDynamics::stations.
MatrixXd leaf_station_motion(const PlateLeaf& plate, const LeafScale& scale, const MatrixXd& T);

/// Motion of the points of shape() for such columns: LeafDynamics::shape_motion.
MatrixXd leaf_shape_motion(const PlateLeaf& plate, const LeafScale& scale, const MatrixXd& T);

/// Craig–Bampton dynamics of an assembled plate, SI and global axes.
LeafDynamics plate_dynamics(const PlateLeaf& plate, const LeafSpring& leaf, const LeafScale& scale,
                            DynamicsRequest request);

}  // namespace flexopt
