#pragma once
// What the first optimisation of a design looks for, and among what.
#include "results/start/start_design.hpp"

namespace flexopt {

/// "optimise" of a new job: the highest parasitic frequency over the stroke, at no more than the
/// allowable stress and in a tenth more room than the start takes. Sizes, angles and ratios vary
/// between half and twice the start (angles by 17°), or less, so that the design is sound at the
/// corners of their box; counts and masses do not.
OrderedJson first_goals(const StartDesign& start);

}  // namespace flexopt
