#pragma once
// The reduced leaf: a tube potential with the fields to rebuild the full leaf from.
#include <memory>
#include <string>
#include <vector>

#include "core/elements/full_leaf.hpp"
#include "core/reduction/mixed_condensation.hpp"
#include "core/reduction/tube_expansion.hpp"

namespace flexopt {

/// What a tube is built for.
struct TubeRange {
  Eigen::Vector2d ray{1, 1};  ///< (θ1y, θ2y) of the drive, the larger one 1
  double sigma_max = 0.3;     ///< along the ray [rad]
  double force_centre = 0;    ///< N about which to expand, over the force scale
  int order = 2;              ///< of the fields: potential of degree 2 order + 1
};

/// How far off the expansion a state may lie: beyond these the support stiffness may be off by more
/// than about 0.3 % (degree 5, measured on leaves with w²/(Lt) from 18 to 240).
struct ValidityBox {
  double tau_ratio, tau;  ///< |τ| ≤ max(tau_ratio |σ|, tau) [rad]
  double twist;           ///< |φ| [rad]
  double axial;           ///< |N − centre| over the buckling load 4π² E I / (1 − ν²) L²
  double lateral;         ///< |M1|, |M2| times 2/L over the same
};
ValidityBox validity_box(const TubeRange& range);

/// Potential and fields of all leaves of one shape and range. Grows when a leaf bends further.
class TubeModel {
 public:
  /// Solves and expands the bent states; `built()` tells whether all were found.
  TubeModel(std::shared_ptr<const PlateMesh> mesh, const TubeRange& range);

  bool built() const { return potential_ != nullptr; }
  const TubePotential& potential() const { return *potential_; }
  const TubeRange& range() const { return range_; }
  const std::shared_ptr<const PlateMesh>& mesh() const { return mesh_; }

  /// Adds a bent state at sigma, beyond the last. False if none was found.
  bool extend(double sigma);

  /// Unknowns of the leaf in its chord frame (ChordLeaf::unknowns) at s, f (over their scale):
  /// second-order fields, every coefficient joined by two-point Hermite interpolation.
  VectorXd fields(const Vector3d& s, const Vector3d& f) const;

 private:
  bool add(double sigma);

  std::shared_ptr<const PlateMesh> mesh_;
  TubeRange range_;
  Eigen::Matrix2d directions_;
  ChordLeaf leaf_;
  std::vector<TubeExpansion> expansions_;
  std::unique_ptr<TubePotential> potential_;
};

class TubeLeaf final : public LeafElement {
 public:
  TubeLeaf(const LeafSpring& leaf, std::shared_ptr<TubeModel> model, int index);

  void move(const EdgePoses& edges, const Vector12d& dq) override;
  const LeafEvaluation& evaluate() override;
  const LeafEvaluation& evaluation() const override { return evaluation_; }
  Refinement refine() override;
  std::unique_ptr<LeafElement> full_model(const std::string& reason) override;
  std::unique_ptr<LeafState> save() const override;
  void restore(const LeafState& state) override;
  LeafDynamics dynamics(int modes) override;
  StressPeak max_stress() override;
  LeafShape shape() override;
  Vector3d material_point(double along, double across) override;
  LeafReport report() const override { return {"tube", {}, check_}; }

 private:
  /// State of the full leaf rebuilt from the fields, edges at their present poses.
  PlateLeaf::State rebuilt() const;
  /// The full leaf at that state after one Newton step with the edges held.
  PlateLeaf& condensed();
  std::vector<MatrixXd> rebuilt_nodal();

  LeafSpring leaf_;
  int index_;
  LeafScale scale_;
  std::shared_ptr<TubeModel> model_;
  EdgePoses edges_;  ///< scaled
  ReducedState state_;
  ReducedResponse response_;
  LeafEvaluation evaluation_;
  double check_ = 0;
  std::unique_ptr<PlateLeaf> plate_;
  bool plate_is_current_ = false;
};

}  // namespace flexopt
