#pragma once
// Points of the path on full leaves, to which reduced ones only lead.
#include <memory>
#include <string>

#include "core/equilibrium/stroke_path.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/response/request.hpp"
#include "core/response/response.hpp"

namespace flexopt {

/// From rest to one point of the path.
Equilibrium step_from_rest(System& system, const StrokeRequest& request, std::size_t point);

/// The system on full leaves at this point of the request, by Newton's method from the state of
/// the reduced ones; where that leads astray (to no equilibrium, to one that is far from it or less
/// stable, or to one that is stretched too far), along the way from rest. `reason`: why, if there
/// is more to say than that they are exact. `equilibrium`: that of the reduced leaves, replaced by
/// the one of the full leaves.
std::unique_ptr<System> finish_on_full_leaves(System& system, const ModelOptions& model,
                                              const StrokeRequest& request, std::size_t point,
                                              const std::string& reason, Equilibrium& equilibrium);

/// Whether all leaves can give the exact modes and derivatives that a point is asked for.
Check check_interior(System& system, const StrokeRequest& request, std::size_t point);

/// Whether reduced leaves are believed: beside what they rebuilt, and unless their frequencies and
/// equilibrium contradict each other (then they are expanded about a state that is none of the full
/// leaves').
Check check_reduced(const System& system, const PathPoint& point);

}  // namespace flexopt
