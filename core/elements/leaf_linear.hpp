#pragma once
// A leaf linearised about its present state, all its interior unknowns kept: what a mechanism needs
// of it for K⁻¹ B and M B. Leaf axes and units as in LeafRows.
#include <vector>

#include "core/elements/full_leaf.hpp"

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

/// Of an assembled full leaf, which must outlive it.
class FullLeafLinear final : public LeafLinear {
 public:
  explicit FullLeafLinear(FullLeaf& leaf) : leaf_(&leaf) { leaf.plate().invert_pivots(); }

  const LeafScale& scale() const override { return leaf_->scale(); }
  int unknowns() const override { return leaf_->plate().unknowns(); }
  void solve(Eigen::Ref<MatrixXd> b) const override { leaf_->plate().solve(b); }
  MatrixXd static_shapes(const std::vector<int>& columns) const override {
    return leaf_->plate().static_shapes(columns);
  }
  MatrixXd mass_times(const MatrixXd& V) const override { return leaf_->plate().mass_times(V); }
  MatrixXd station_motion(const MatrixXd& V) const override {
    return leaf_station_motion(leaf_->plate(), leaf_->scale(), V);
  }

 private:
  const FullLeaf* leaf_;
};

}  // namespace flexopt
