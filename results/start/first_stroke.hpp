#pragma once
// Stroke of a design in its first job.
#include "results/start/start_design.hpp"

namespace flexopt {

/// "stroke" of a new job: from rest to the largest of 1, 2, 5, 10 … mm or deg, of all drives alike,
/// up to which the path is stable and the stress stays below `allowed` [Pa], on a coarse mesh by
/// this model. Throws SpecError where not even a thousandth can be followed.
OrderedJson first_stroke(const StartDesign& start, const ModelOptions& model, double allowed);

}  // namespace flexopt
