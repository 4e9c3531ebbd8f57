#pragma once
// Bandwidth and transmissibility of a mechanism about an equilibrium, straight from K and M of all
// its unknowns: no modes are left out. Equations (H4) to (H9) of README.md.
#include <optional>
#include <vector>

#include "core/response/modes/mechanism_factor.hpp"
#include "core/response/request.hpp"

namespace flexopt {

/// weight · d[yᵀ(K − λM)y]: a share of a derivative, y held.
struct QuadraticTerm {
  double weight = 0, lambda = 0;
  VectorXd y;                          ///< relative to the ground
  Vector3d ground = Vector3d::Zero();  ///< translation of the ground, and of everything with it
};

struct DynamicsMeasure {
  double value = 0;
  double frequency = 0;              ///< [Hz]
  std::vector<QuadraticTerm> terms;  ///< derivative of the value: their sum
};

struct DynamicsMeasures {
  std::vector<std::optional<DynamicsMeasure>> bandwidths;  ///< of each drive [Hz]
  std::optional<DynamicsMeasure> transmissibility;
  MatrixXd carried;  ///< motion of all unknowns with translations of the ground: rows × 3
};

/// `driven`: whether the drives hold the strokes of the state; else there is no bandwidth. `terms`:
/// whether derivatives are wanted.
DynamicsMeasures dynamics_measures(const MechanismFactor& factor, const DynamicsRule& rule,
                                   bool driven, bool terms);

}  // namespace flexopt
