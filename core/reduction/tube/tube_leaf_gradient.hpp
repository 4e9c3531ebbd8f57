#pragma once
// The share of a looked-up tube leaf in exact gradients: its internal unknowns are the three forces
// f over their scale, of which the mixed potential is stationary, and where it has tables of its
// dynamics their amplitudes. Equations (G1) to (G3), (D8) and (D9) of core/reduction/README.md.
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/elements/leaf/chord_gradient.hpp"
#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/reduction/tube/dynamics_form.hpp"
#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {

/// Linearisation of an evaluated tube leaf. The leaf must outlive it.
class TubeLeafLinear final : public LeafLinear {
 public:
  static constexpr int P = TubeDynamics::amplitudes;

  /// `internal`: what its tables say here; null where no mass is wanted.
  TubeLeafLinear(const TubeLeaf& leaf, const TubeDynamics::Answer* internal);

  const LeafScale& scale() const override { return leaf_->scale(); }
  int unknowns() const override { return 3 + (internal_ ? P : 0); }
  void solve(Eigen::Ref<MatrixXd> b) const override;
  MatrixXd static_shapes(const std::vector<int>& columns) const override;
  MatrixXd mass_times(const MatrixXd& V) const override;
  std::optional<InternalMotions> internal_motions() const override;
  std::optional<double> highest_mode() const override;
  MatrixXd station_motion(const MatrixXd& V) const override;
  Answer<std::unique_ptr<LeafGradient<double>>> gradient(LeafRates& rates,
                                                         const LeafRows& rows) const override;

 private:
  const TubeLeaf* leaf_;
  const TubeDynamics::Answer* internal_;
  Matrix12d edge_rates_;
  Eigen::Matrix<double, P, P> stiffness_factor_;
};

/// Gradients of an evaluated leaf, which must outlive this.
class TubeLeafGradient final : public LeafGradient<double> {
 public:
  static constexpr int P = TubeDynamics::amplitudes;

  /// `rates`, `dynamics`: of the leaf's model; null where no mass is wanted.
  TubeLeafGradient(const TubeLeaf& leaf, const TubeRates& rates, const DynamicsRates* dynamics,
                   const LeafRows& rows);

  MatrixXd force_rates(const std::vector<LeafVariation<double>>& variations) const override {
    return chord_.force_rates(variations);
  }
  LeafQuadratic<double> quadratic(const MatrixXd& Y, const VectorXd& mu) const override;
  std::unique_ptr<LeafFields> fields(
      const MatrixXd& rows, const std::vector<LeafVariation<double>>& variations) const override;

 private:
  using Vector9d = Eigen::Matrix<double, 9, 1>;  ///< over (e, f)
  using Matrix9d = Eigen::Matrix<double, 9, 9>;
  struct Covectors;
  void add_internal(const ChordGradient::Column& column, const VectorXd& amplitudes, double mu,
                    LeafQuadratic<double>& q, int k, Covectors& of) const;
  Vector9d third_of(const Vector9d& a, const Vector9d& b) const;

  const TubeLeaf* leaf_;
  ChordGradient chord_;
  Matrix9d tangent_;
  std::array<Matrix9d, 3> shape_tangent_;
  std::array<Matrix6d, 6> third_;  ///< of the potential
  std::shared_ptr<const DynamicsForm> internal_;
};

}  // namespace flexopt
