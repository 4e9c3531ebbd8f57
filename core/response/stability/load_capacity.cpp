#include "core/response/stability/load_capacity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/equilibrium/free_motions.hpp"
#include "core/mechanism/drive.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/stability/capacity_limits.hpp"

namespace flexopt {
namespace {

// Bound from which motions of the bodies count as large; lengths over the longest leaf.
constexpr double large_motion = 0.01;

DeadLoad load_along(int direction, double size) {
  Vector6d load = Vector6d::Zero();
  load[direction % 6] = direction < 6 ? size : -size;
  DeadLoad along = load_at_O(load);
  along.name = (direction < 6 ? "" : "-") + std::string(direction_names[direction % 6]);
  return along;
}

std::vector<Mechanism> with_load(const Mechanism& mechanism, std::vector<Mechanism> directions) {
  directions.push_back(zero_rate(mechanism));
  return directions;
}

// About how large the load gets: to a singular tangent as the state foretells it, with its mode, or
// to large motions. None where the load does neither.
struct Outlook {
  double size = 0;
  VectorXd mode;
};
Answer<Outlook> outlook_of(LoadBranch& branch, int direction, const ModelOptions& model) {
  const System& system = branch.system();
  BranchTracer tracer(branch, model);
  const BranchTracer::Look here = tracer.look(1, {});
  Outlook outlook{std::numeric_limits<double>::infinity(), {}};
  if (!FreeMotions(system, branch.locked()).still(system.mechanism().end_effector)[direction % 6])
    outlook.size = large_motion * std::abs(here.along.factor) /
                   here.along.bodies.cwiseQuotient(system.units()).cwiseAbs().maxCoeff();
  if (here.ahead)
    outlook = {std::min(outlook.size, std::abs(here.estimate(0, *here.ahead))), here.ahead->mode};
  if (!std::isfinite(outlook.size))
    return Because("the end-effector cannot move in this direction: the load moves nothing");
  return outlook;
}

LoadCapacity none_left(const CapacityLimits& limits) {
  LoadCapacity capacity = limits.reached();
  capacity.value = 0;
  capacity.reason = "the state without the load is at the limit: " + capacity.reason;
  return capacity;
}

}  // namespace

CapacityDirections::CapacityDirections(const Mechanism& mechanism, DesignDirections& directions)
    : design(directions), with_load(mechanism, flexopt::with_load(mechanism, directions.list)) {}

LoadCapacityResult find_load_capacity(System& system, int direction, double growing,
                                      const VectorXd& drive_loads, const StrokeRequest& request,
                                      const ModelOptions& model, CapacityDirections* design) {
  const DriveState drive = request.capacity.drive;
  LoadCapacityResult result;
  LoadCapacity& capacity = result.capacity;
  const auto count = design ? static_cast<Eigen::Index>(design->design.list.size()) : 0;
  const auto without_load = [&](LoadCapacity found) {
    if (design) result.gradient = VectorXd(VectorXd::Zero(count));
    capacity = std::move(found);
    return result;
  };
  LoadBranch unit(system, load_along(direction, 1), growing, drive, drive_loads, request.newton);
  if (unit.negative_pivots() > 0)
    return without_load(
        {.limit = CapacityLimit::instability, .reason = "the state without the load is unstable"});
  CapacityLimits limits(unit.system(), request);
  if (limits.beyond(unit.system()) >= 0) return without_load(none_left(limits));
  const bool driven = request.loads.driven();
  UnloadedStiffness unloaded;
  MatrixXd of_drives;
  if (design) {
    unloaded = limits.unloaded(unit.system(), *design, model, driven);
    of_drives = drive_load_rates(unit, model, design->design, driven);
  }
  const Answer<Outlook> outlook = outlook_of(unit, direction, model);
  if (!outlook) {
    capacity.reason = outlook.error();
    return result;
  }
  const double size = outlook->size;
  LoadBranch branch(system, load_along(direction, size), growing, drive, drive_loads,
                    request.newton);
  const LoadBranch::State begin = branch.save();
  BranchTracer tracer(
      branch, model, [&](System& at) { return limits.beyond(at); }, size);
  const std::optional<double>& largest =
      direction % 6 < 3 ? request.capacity.largest_force : request.capacity.largest_moment;
  const double bound = largest ? *largest / size : std::numeric_limits<double>::infinity();
  CriticalLoad end = tracer.follow(1, tracer.look(1, outlook->mode), bound);
  const double reached = end.factor.value_or(branch.factor());
  if (reached > bound || (!end.factor && !tracer.at_limit())) {
    if (design && reached > bound) result.gradient = VectorXd(VectorXd::Zero(count));
    capacity.limit = CapacityLimit::none;
    capacity.value = std::min(reached * size, largest.value_or(reached * size));
    capacity.reason = reached > bound ? "no limit up to the largest load that is looked at"
                                      : std::move(end.reason);
    return result;
  }
  if (tracer.at_limit()) {
    limits.beyond(branch.system());
    capacity = limits.reached();
    if (design) result.gradient = limits.gradient(branch, *design, model, of_drives, unloaded);
    if (result.gradient) *result.gradient *= size;
  } else if (const Check held = tracer.check_bodies(); !held) {
    capacity.reason = held.error();
    return result;
  } else {
    capacity.limit = CapacityLimit::instability;
    capacity.fold = end.fold;
    capacity.reason = fmt::format(
        "the tangent becomes singular ({})",
        end.fold ? "the load is the largest of its branch" : "branches of equilibria meet");
    if (design) result.gradient = size * tracer.gradient(design->design, of_drives);
  }
  capacity.value = reached * size;
  if (const BranchTracer::Trial trial = tracer.put_on(begin, reached); !trial.doubt.empty()) {
    capacity = {};
    capacity.value = trial.stable_to * size;
    capacity.reason = "a limit is not confirmed: " + trial.doubt;
    result.gradient.reset();
  }
  return result;
}

}  // namespace flexopt
