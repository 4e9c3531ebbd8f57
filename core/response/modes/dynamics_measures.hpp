#pragma once
// Bandwidth, transmissibility and transfers of a mechanism about an equilibrium, straight from K
// and M of all its unknowns. Equations (H4) to (H12) of README.md.
#include <optional>
#include <vector>

#include "core/elements/leaf/leaf_rates.hpp"
#include "core/response/modes/harmonic_terms.hpp"
#include "core/response/response.hpp"

namespace flexopt {

struct DynamicsMeasure {
  double value = 0;
  double frequency = 0;             ///< [Hz]
  std::optional<MeasureRate> rate;  ///< of the value; nothing where it was not found
};

struct TransferMeasure : Transfer {
  MeasureRate at_rest;
  std::optional<MeasureRate> of_bandwidth;  ///< nothing where it was not found
};

struct DynamicsMeasures {
  std::vector<std::optional<DynamicsMeasure>> bandwidths;  ///< of each drive [Hz]
  std::vector<NoBandwidth> no_bandwidth;                   ///< likewise, where it is missing
  std::optional<DynamicsMeasure> transmissibility;
  std::string no_transmissibility;  ///< why it is missing
  std::vector<TransferMeasure> transfers;
};

/// `driven`: whether the drives hold the strokes of the state; else there is no bandwidth. `terms`:
/// whether derivatives are wanted. `points`: those that the rule may name.
DynamicsMeasures dynamics_measures(const MechanismFactor& factor, const DynamicsRule& rule,
                                   bool driven, bool terms,
                                   const std::vector<NamedPoint>& points = {});

/// Equations (H10) to (H12). `terms`: whether derivatives are wanted. None where a leaf with a
/// point does not know how its inside moves.
Answer<std::vector<TransferMeasure>> transfers(const MechanismFactor& factor,
                                               const DynamicsRule& rule,
                                               const std::vector<NamedPoint>& points, bool terms,
                                               LeafRates& rates);

}  // namespace flexopt
