#pragma once
// Bandwidth and transmissibility of a mechanism about an equilibrium, straight from K and M of all
// its unknowns: no modes are left out. Equations (H4) to (H10) of README.md.
#include <optional>
#include <vector>

#include "core/elements/leaf/leaf_rates.hpp"
#include "core/response/modes/mechanism_factor.hpp"
#include "core/response/response.hpp"

namespace flexopt {

/// weight · d[yᵀ(K − λM)y]: a share of a derivative, y held.
struct QuadraticTerm {
  double weight = 0, lambda = 0;
  VectorXd y;                          ///< relative to the ground
  Vector3d ground = Vector3d::Zero();  ///< translation of the ground, and of everything with it
};

/// weight · d(lever): what a measure changes by with the lever of a named point on its body.
struct LeverTerm {
  NamedPoint point;
  Vector3d weight;
};

struct DynamicsMeasure {
  double value = 0;
  double frequency = 0;              ///< [Hz]
  std::vector<QuadraticTerm> terms;  ///< derivative of the value: their sum, and
  std::optional<LeverTerm> lever;
};

struct DynamicsMeasures {
  std::vector<std::optional<DynamicsMeasure>> bandwidths;  ///< of each drive [Hz]
  std::optional<DynamicsMeasure> transmissibility;
  MatrixXd carried;  ///< motion of all unknowns with translations of the ground: rows × 3
};

/// `driven`: whether the drives hold the strokes of the state; else there is no bandwidth. `terms`:
/// whether derivatives are wanted. `points`: those that the rule may name.
DynamicsMeasures dynamics_measures(const MechanismFactor& factor, const DynamicsRule& rule,
                                   bool driven, bool terms,
                                   const std::vector<NamedPoint>& points = {});

/// Equation (H10). None where a leaf with a point does not know how its inside moves.
Answer<std::vector<Transfer>> transfers(const MechanismFactor& factor, const DynamicsRule& rule,
                                        const std::vector<NamedPoint>& points, LeafRates& rates);

}  // namespace flexopt
