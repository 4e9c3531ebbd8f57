#pragma once
// How the tangent of a mechanism changes along a branch of equilibria, and where it would become
// singular if it went on changing so: equations (S22) and (S23) of core/response/README.md.
#include <memory>
#include <optional>
#include <vector>

#include "core/equilibrium/dead_loads.hpp"
#include "core/response/gradients/design_rates.hpp"

namespace flexopt {

/// dK/dσ while the state moves by `state` per σ and the load grows by `load` per σ.
class StiffnessRate {
 public:
  /// Factor and `still`, a design that does not change, must outlive it. `named`: the load for a
  /// factor of 1.
  StiffnessRate(const MechanismFactor& factor, DesignDirections& still, const ModelOptions& model,
                const BodyLoad& named);

  /// Per σ, rows of the factor.
  void set_direction(const VectorXd& state, double load);

  /// Yᵀ dK/dσ Y, exact.
  MatrixXd forms(const MatrixXd& Y) const;
  /// dK/dσ y of the leaves and the loads, up to terms by which spins do not commute: what a Krylov
  /// space is built with.
  VectorXd times(const VectorXd& y) const;

 private:
  MatrixXd leaf_gradients_of(const MatrixXd& Y) const;

  const MechanismFactor* factor_;
  DesignRates<double> design_;
  BodyLoad named_;
  VectorXd state_, scaled_state_, of_state_;
  double load_ = 0, size_ = 0;
};

/// A root of (K + μ dK/dσ) φ = 0.
struct SoftMode {
  double step = 0;  ///< μ, per unit of σ
  VectorXd mode;    ///< rows of the factor
};

/// The smallest root of either sign, of a K that is positive definite on the motions that are left.
struct Softening {
  std::optional<SoftMode> ahead, behind;  ///< μ > 0, μ < 0
};
/// A force on every row that has no symmetry.
VectorXd any_force(const MechanismFactor& factor);
/// `start`: near the mode ahead; empty where nothing is known. `behind`: whether the root behind is
/// wanted, too.
Softening soften(const MechanismFactor& factor, const StiffnessRate& rate, bool drives_locked,
                 const VectorXd& start, bool behind);

}  // namespace flexopt
