#pragma once
// The largest strokes of drives: README.md of core/response, (S37) and (S38).
#include "core/response/path/point_outputs.hpp"

namespace flexopt {

/// Fills the stroke capacities of every point of the response, the same in all, by the rules of the
/// request. `differentiable`: null for capacities of leaves as they are modelled; it gets their
/// derivatives, where it has directions. Where the limits of this thread's work are used up
/// (LimitedWork), capacities are what is reached so far, with the reason. Returns whether they
/// were.
bool add_stroke_capacities(const Mechanism& mechanism, const ModelOptions& model,
                           const StrokeRequest& request, DifferentiablePath* differentiable,
                           StrokeResponse& response);

}  // namespace flexopt
