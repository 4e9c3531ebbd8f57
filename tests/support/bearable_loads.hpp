#pragma once
// How far, and under what, random mechanisms are moved when laws are checked.
#include "core/mechanism/load_case.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"

namespace flexopt::laws {

struct AtRest {
  double stroke;    ///< that neither buckles nor tears: of 1 N or 20 mN m, 1 mm or 0.02 rad
  double rounding;  ///< of answers to forces, relative
};
AtRest at_rest(const Mechanism& mechanism, const ModelOptions& model);

/// A small dead load on every body, or half of those at which the mechanism has a limit point: its
/// tangent becomes singular there, and no equilibrium is behind it. Throws where a step fails
/// elsewhere: a fault.
LoadCase bearable_loads(const Mechanism& mechanism, const ModelOptions& model);

}  // namespace flexopt::laws
