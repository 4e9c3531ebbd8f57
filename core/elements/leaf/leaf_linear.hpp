#pragma once
// A leaf linearised about its present state, all its interior unknowns kept: what a mechanism needs
// of it for K⁻¹ B and M B. Leaf axes and units as in LeafRows.
#include <vector>

#include "core/elements/leaf/leaf_scale.hpp"

namespace flexopt {

class LeafLinear {
 public:
  virtual ~LeafLinear() = default;

  virtual const LeafScale& scale() const = 0;
  virtual int unknowns() const = 0;
  /// K_ff⁻¹ b, edges and material point held.
  virtual void solve(Eigen::Ref<MatrixXd> b) const = 0;
  /// Static shapes dx/d(edges, point), all other coordinates held: unknowns × columns of 12 or 15.
  virtual MatrixXd static_shapes(const std::vector<int>& columns) const = 0;
  /// M V for rates V of the unknowns and the edges (+ 12 rows).
  virtual MatrixXd mass_times(const MatrixXd& V) const = 0;
  /// Motion of stations for such rates, times the root of their mass: LeafDynamics::stations.
  virtual MatrixXd station_motion(const MatrixXd& V) const = 0;
};

}  // namespace flexopt
