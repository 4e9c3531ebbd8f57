#pragma once
// Stress with the fillets at the clamps, and how far it is from yield and from fatigue: equations
// (Y1) to (Y3) of README.md.
#include <vector>

#include "core/response/response.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

class LeafElement;

/// Whether every leaf's material has what the safety, or the life, needs.
bool knows_yield(const Mechanism& mechanism);
bool knows_fatigue(const Mechanism& mechanism, const FatigueRule& rule);
bool knows_life(const Mechanism& mechanism, const FatigueRule& rule);

/// Whether a fillet of this radius [m] has a tabulated factor at every clamped edge.
Check check_fillet(const Mechanism& mechanism, double radius);

/// clamp_factors(): notch factors of the edges of a leaf that bodies hold. clamp_factor_rates():
/// their derivatives for one edge, along a direction in which the leaf changes by `rate`.
ClampFactors clamp_factors(const LeafSpring& leaf, double fillet);
NotchFactors clamp_factor_rates(const LeafSpring& leaf, const LeafSpring& rate, int end,
                                double fillet);

/// The largest stress of a leaf, from that without fillets: (Y1). The fillet has no fault.
StressPeak with_fillets(StressPeak largest, LeafElement& leaf, const Mechanism& mechanism,
                        double fillet);

/// Fills `notch_stress`, `yield_safety`, and fatigue by a stress ratio, of those that the request
/// asks for, from the largest stresses of all leaves, with fillets where there are some.
void add_stress_safety(const std::vector<StressPeak>& leaves, const Mechanism& mechanism,
                       const StressRules& rules, PathPoint& point);

/// Derivative of a notched stress, from that with constant factors, along the directions.
VectorXd with_fillet_rates(VectorXd stress_rates, const StressPeak& peak,
                           const Mechanism& mechanism, const std::vector<Mechanism>& directions,
                           double fillet);

/// Derivative of a safety, against fatigue by a stress ratio, from that of the stress behind it; the
/// strengths are constants.
VectorXd safety_rates(double safety, double stress, const VectorXd& stress_rates);
/// Derivative of a life by a stress ratio from that of the stress.
VectorXd ratio_life_rates(const FatigueCycle& life, const Material& material,
                          const FatigueRule& rule, const VectorXd& stress_rates);

}  // namespace flexopt
