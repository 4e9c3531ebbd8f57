#pragma once
// The share of a looked-up tube leaf in exact gradients: its internal unknowns are the three forces
// f over their scale, of which the mixed potential is stationary. Equations (T1) to (T3) of
// core/reduction/README.md.
#include <array>
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/reduction/frame/chord_gradient.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "core/reduction/tube/tube_rates.hpp"

namespace flexopt {

/// A tube leaf linearised. Of an evaluated leaf, which must outlive it.
class TubeLeafLinear final : public LeafLinear {
 public:
  explicit TubeLeafLinear(const TubeLeaf& leaf) : leaf_(&leaf) {}

  const LeafScale& scale() const override { return leaf_->scale(); }
  int unknowns() const override { return 3; }
  void solve(Eigen::Ref<MatrixXd> b) const override { b = (leaf_->mixed().F_inverse * b).eval(); }
  MatrixXd static_shapes(const std::vector<int>& columns) const override;
  MatrixXd mass_times(const MatrixXd& V) const override;
  MatrixXd station_motion(const MatrixXd& V) const override;
  Answer<LeafGradient<double>> gradient(LeafRates& rates, const LeafRows& rows) const override;

 private:
  const TubeLeaf* leaf_;
};

/// Of an evaluated leaf, which must outlive it.
class TubeLeafGradient final : public LeafGradient<double> {
 public:
  /// `rates`: of the leaf's model.
  TubeLeafGradient(const TubeLeaf& leaf, const TubeRates& rates, const LeafRows& rows);

  MatrixXd force_rates(const std::vector<LeafVariation<double>>& variations) const override {
    return chord_.force_rates(variations);
  }
  LeafQuadratic<double> quadratic(const MatrixXd& Y, const VectorXd& mu) const override;
  std::unique_ptr<LeafFields> fields(
      const MatrixXd& rows, const std::vector<LeafVariation<double>>& variations) const override;

 private:
  using Matrix9d = Eigen::Matrix<double, 9, 9>;  ///< over (e, f)
  ChordGradient chord_;
  Matrix9d tangent_;
  std::array<Matrix9d, 3> shape_tangent_;
  std::array<Matrix6d, 6> third_;  ///< of the potential
};

}  // namespace flexopt
