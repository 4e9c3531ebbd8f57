#pragma once
// Stress with the fillets at the clamps, and how far it is from yield and from fatigue: equations
// (Y1) to (Y3) of README.md.
#include <optional>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

class LeafElement;

/// Whether every leaf's material has what the safety needs.
bool knows_yield(const Mechanism& mechanism);
bool knows_fatigue(const Mechanism& mechanism, const FatigueRule& rule);

/// Why a fillet of this radius [m] has no tabulated factor at some clamped edge; empty where all
/// have one.
std::string fillet_fault(const Mechanism& mechanism, double radius);

/// Largest stress of a cycle with the rule's stress ratio that the material endures [Pa]; nothing
/// where the material lacks a number.
std::optional<double> fatigue_strength(const Material& material, const FatigueRule& rule);

/// The largest stress of a leaf, from that without fillets: (Y1). The fillet has no fault.
StressPeak with_fillets(StressPeak largest, LeafElement& leaf, const Mechanism& mechanism,
                        double fillet);

/// Fills `notch_stress`, `yield_safety` and `fatigue_safety` of a point, of those that the request
/// asks for, from the largest stresses of all leaves, with fillets where
/// there are some.
void add_stress_safety(const std::vector<StressPeak>& leaves, const Mechanism& mechanism,
                       const StressRules& rules, PathPoint& point);

/// Derivative of a notched stress, from that with constant factors, along the directions.
VectorXd with_fillet_rates(VectorXd stress_rates, const StressPeak& peak,
                           const Mechanism& mechanism, const std::vector<Mechanism>& directions,
                           double fillet);

/// Derivative of a safety from that of the stress behind it; the strengths are constants.
VectorXd safety_rates(const StressSafety& safety, const VectorXd& stress_rates);

}  // namespace flexopt
