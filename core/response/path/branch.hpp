#pragma once
// The branch of equilibria that leads from rest to the points of a path.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/equilibrium/stroke_path.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/response/path/point_outputs.hpp"
#include "core/response/request.hpp"
#include "core/response/response.hpp"

namespace flexopt {

/// Changes the models of leaves that are beyond their range at the present state: they get further
/// bent states, or others take their place. False where there are none.
bool refine_leaves(System& system);

/// Follows each of the ways, which begin at rest under the constant loads, through its points of
/// the response, and evaluates each. `differentiable`: null for points as they are modelled. After
/// a point that is not reached the rest of its way is not either. Where the limits of this thread's
/// work are used up (LimitedWork), the point has the status limit_reached, or where only critical
/// loads and load capacities are left of it keeps what it has, with the reason in them; all points
/// behind are not reached. Returns whether the limits were used up.
bool follow_ways(const Mechanism& mechanism, const ModelOptions& model,
                 const StrokeRequest& request, const std::vector<std::vector<int>>& ways,
                 DifferentiablePath* differentiable, StrokeResponse& response);

// Points of the path on full leaves, to which reduced ones only lead.

/// From rest to one point of the path.
Equilibrium step_from_rest(System& system, const StrokeRequest& request, std::size_t point);

/// Full leaves take over where reduced ones are not `good`, for its reason, if there is more to say
/// than that full ones are exact; else null. The system on full leaves at this point of the request
/// comes by Newton's method from the state of the reduced ones; where that leads astray (to no
/// equilibrium, to one that is far from it or less stable, or to one that is stretched too far),
/// along the way from rest. `equilibrium`: that of the reduced leaves, replaced by the one of the
/// full leaves.
std::unique_ptr<System> finish_on_full_leaves(System& system, const ModelOptions& model,
                                              const StrokeRequest& request, std::size_t point,
                                              const Check& good, Equilibrium& equilibrium);

/// Whether all leaves are full, without a reason.
Check check_full(const System& system);

/// Whether all leaves can give the exact modes and derivatives that a point is asked for.
Check check_interior(System& system, const StrokeRequest& request, std::size_t point,
                     bool differentiable);

/// Whether reduced leaves are believed: beside what they rebuilt, and unless their frequencies and
/// equilibrium contradict each other (then they are expanded about a state that is none of the full
/// leaves').
Check check_reduced(const System& system, const PathPoint& point);

// From an unstable equilibrium to the stable one on the branch that meets its own: (Q9) of
// README.md of core/equilibrium.

/// What leads around a bifurcation: extra loads, which are then taken away.
struct Push {
  /// (displacement, spin) of the bodies along which loads push; zero where bodies are not pushed.
  VectorXd motion;
  /// The weight of the leaves that pushes them between their edges: the acceleration that would
  /// bend a leaf that buckles by its length [m/s²]; zero where bodies are pushed.
  Vector3d acceleration = Vector3d::Zero();
};

struct StableBranch {
  std::unique_ptr<System> system;  ///< of full leaves, assembled at the stable equilibrium
  Equilibrium equilibrium;
  Push push;  ///< that leads there
};

/// `unstable`: assembled at the unstable equilibrium of a point of the path, its leaves full. The
/// bodies are led to the side on which the largest motion of the mode is positive, a leaf that
/// buckles between its edges to the side of its normal.
Answer<StableBranch> find_stable_branch(System& unstable, const ModelOptions& model,
                                        const StrokeRequest& request, std::size_t point);
/// Leads to the stable branch at another point by a push that led there before. `system`: with the
/// loads.
Answer<StableBranch> lead_to_stable_branch(System& system, const Push& push,
                                           const ModelOptions& model, const StrokeRequest& request,
                                           std::size_t point);

/// The stable equilibria of a point, lowest first: that of `system`, assembled there, if it is
/// stable, and those to either side of it where it is not; with `push`, by which it has come from
/// an unstable branch, that on the other side. Each is listed once. Of leaves that are full.
std::vector<StableState> stable_states(System& system, const std::optional<Push>& push,
                                       const ModelOptions& model, const StrokeRequest& request,
                                       std::size_t point);

/// Onto the stable branch at a point that is unstable, of another system, `away`.
Check leave_branch(System& system, std::unique_ptr<System>& away, const ModelOptions& model,
                   const StrokeRequest& request, std::size_t point, Equilibrium& equilibrium,
                   std::optional<Push>& push);

}  // namespace flexopt
