#include "core/response/path/branch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <utility>

#include "core/equilibrium/edge_compliance.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/path/full_finish.hpp"

namespace flexopt {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// At how many of the points reduced leaves are asked for their dynamics. Modes that are drawn need
// the leaves' own motions, which condensing gives.
int points_with_dynamics(const ModelOptions& model, const StrokeRequest& request,
                         std::size_t points, bool differentiable) {
  const bool asked = request.frequencies_of(DriveState::free) > 0 ||
                     request.frequencies_of(DriveState::locked) > 0;
  const bool of_tables =
      model.mass == LeafMass::consistent &&
      (differentiable || (!request.outputs.has(Output::shapes) && model.leaf_modes > 0));
  return asked && of_tables ? static_cast<int>(points) : 0;
}

std::vector<std::unique_ptr<LeafElement>> make_leaves(const Mechanism& mechanism,
                                                      const ModelOptions& model,
                                                      const StrokeRequest& request,
                                                      std::size_t points, bool differentiable) {
  if (model.accuracy == Accuracy::full) return make_full_leaves(mechanism, model);
  double largest = 0;
  for (const double s : request.points) largest = std::max(largest, std::abs(s));
  std::vector<VectorXd> several;
  if (mechanism.drives.size() > 1)
    for (std::size_t k = 0; k < request.points.size(); ++k)
      several.push_back(request.strokes_at(k, mechanism.drives.size()));
  auto leaves = make_reduced_leaves(mechanism, model, largest, request.loads, several);
  const int dynamics = points_with_dynamics(model, request, points, differentiable);
  // derivatives of leaves that have none of their own are those of full ones
  const auto wants_tables = [&](LeafElement& leaf) {
    return !differentiable || leaf.interior_gap({}).empty();
  };
  if (dynamics > 0 && std::ranges::all_of(leaves, [&](const auto& l) { return wants_tables(*l); }))
    for (const auto& leaf : leaves) leaf->expect_dynamics(dynamics);
  return leaves;
}

constexpr const char* no_equilibrium = "no equilibrium with reduced leaves";

using Solve = std::function<Equilibrium()>;

// Where no equilibrium is found with reduced leaves, full ones take over.
Equilibrium solve_again_on_full_leaves(System& system, const Solve& solve,
                                       Equilibrium equilibrium) {
  bool replaced = false;
  for (int i = 0; i < system.leaves(); ++i)
    if (!system.leaf(i).is_full()) {
      system.replace_leaf(i, system.leaf(i).full_model(no_equilibrium));
      replaced = true;
    }
  if (replaced) equilibrium = solve();
  return equilibrium;
}

// Changes the models of leaves that are beyond their range. False where there are none.
bool refine(System& system) {
  bool changed = false;
  EdgeCompliance compliance(system);
  for (int i = 0; i < system.leaves(); ++i) {
    LeafElement::Refinement refinement = system.leaf(i).refine([&] { return compliance.of(i); });
    changed |= refinement.changed;
    if (refinement.replacement) system.replace_leaf(i, std::move(refinement.replacement));
  }
  if (changed) system.invalidate();  // a tube has grown or was replaced
  return changed;
}

// Solves, then again as long as a leaf of limited range wants its model changed: where there is an
// equilibrium, or where the way to it has ended.
Equilibrium solve_refined(System& system, const Solve& solve) {
  constexpr int most_rounds = 12;
  Equilibrium equilibrium = solve();
  for (int round = 0; round < most_rounds && refine(system); ++round) {
    const int before = equilibrium.iterations;
    equilibrium = solve();
    equilibrium.iterations += before;
  }
  if (!equilibrium.converged)
    equilibrium = solve_again_on_full_leaves(system, solve, std::move(equilibrium));
  return equilibrium;
}

// To the strokes of a point, or to its factor of the growing loads.
Equilibrium advance(System& system, const StrokeRequest& request, std::size_t k) {
  return solve_refined(system, [&] {
    return request.loads.driven()
               ? step_to(system, request.strokes_at(k, system.mechanism().drives.size()),
                         request.newton)
               : step_load(system, {1, request.points[k]}, request.newton);
  });
}

// Why a leaf cannot give the exact modes and derivatives that a point is asked for; empty where all
// can.
std::string interior_gap(System& system, const StrokeRequest& request) {
  InteriorUse use;
  use.mass = request.frequencies_of(DriveState::free) > 0 ||
             request.frequencies_of(DriveState::locked) > 0;
  use.stress = request.outputs.has(Output::stress);
  use.places = request.outputs.has_any({Output::moving_envelope, Output::clearance});
  for (int i = 0; i < system.leaves(); ++i)
    if (const std::string gap = system.leaf(i).interior_gap(use); !gap.empty())
      return fmt::format("leaf {}: {}", i, gap);
  return {};
}

bool has_full_leaves(const System& system) {
  for (int i = 0; i < system.leaves(); ++i)
    if (!system.leaf(i).is_full()) return false;
  return true;
}

// Evaluates point k. Where exact modes and derivatives are wanted that the leaves do not have, full
// ones take over, which are returned; the equilibrium is then theirs.
std::unique_ptr<System> evaluate_point(System& system, const ModelOptions& model,
                                       const StrokeRequest& request, std::size_t k,
                                       bool differentiable, PointOutputs& outputs,
                                       Equilibrium& equilibrium, PathPoint& point,
                                       PointGradients* gradients) {
  const PathPoint before = point;
  std::string gap = differentiable ? interior_gap(system, request) : std::string();
  if (gap.empty()) gap = outputs.evaluate(system, equilibrium, point, gradients);
  if (gap.empty()) return nullptr;
  point = before;
  auto full = finish_on_full_leaves(system, model, request, k, gap, equilibrium);
  if (equilibrium.converged) outputs.evaluate(*full, equilibrium, point, gradients);
  return full;
}

}  // namespace

void follow_branch(const Mechanism& mechanism, const ModelOptions& model,
                   const StrokeRequest& request, const std::vector<int>& order,
                   DifferentiablePath* differentiable, StrokeResponse& response) {
  auto start = Clock::now();
  const auto make_system = [&] {
    return std::make_unique<System>(
        mechanism, make_leaves(mechanism, model, request, order.size(), differentiable != nullptr),
        request.loads);
  };
  auto system = make_system();
  response.seconds_coefficients += seconds_since(start);
  start = Clock::now();

  PointOutputs outputs(mechanism, model, request, differentiable);
  const bool several = !request.strokes.empty();
  std::optional<std::string> lost;  // why the path has ended
  const auto load = [&] {
    if (!system->loaded_at_rest()) return;
    const auto apply = [&] { return step_load(*system, {.constant = 1}, request.newton); };
    Equilibrium loaded = solve_refined(*system, apply);
    if (!loaded.converged && model.accuracy != Accuracy::full) {
      // a reduced leaf that is far off at rest leaves no state to go on from
      system = std::make_unique<System>(
          mechanism, make_full_leaves(mechanism, model, no_equilibrium), request.loads);
      loaded = apply();
    }
    if (!loaded.converged) lost = loaded.message;
  };
  load();
  bool from_rest = true;
  for (const int k : order) {
    PathPoint& point = response.path[k];
    if (lost) {
      point.message = *lost;
      continue;
    }
    Equilibrium equilibrium = advance(*system, request, static_cast<std::size_t>(k));
    if (several && !equilibrium.converged && !from_rest) {
      system = make_system();
      load();
      equilibrium = advance(*system, request, static_cast<std::size_t>(k));
    }
    from_rest = false;
    const bool gradients = differentiable && !differentiable->directions.empty();
    PointGradients* own = gradients ? &differentiable->gradients.path[k] : nullptr;
    std::unique_ptr<System> full;
    if (equilibrium.converged)
      full = evaluate_point(*system, model, request, static_cast<std::size_t>(k),
                            differentiable != nullptr, outputs, equilibrium, point, own);
    if (!equilibrium.converged) {
      point.status = PointStatus::no_equilibrium;
      point.message = equilibrium.message;
      point.newton_iterations = equilibrium.iterations;
      if (!several) lost = fmt::format("the path ended before: {}", equilibrium.message);
      continue;
    }
    if (request.growing_load() && point.status == PointStatus::converged) {
      System& whole = full ? *full : *system;
      std::unique_ptr<System> buckling;  // is that of full leaves: reduced ones do not reach so far
      if (!has_full_leaves(whole))
        buckling = finish_on_full_leaves(whole, model, request, static_cast<std::size_t>(k), {},
                                         equilibrium);
      outputs.add_buckling(buckling ? *buckling : whole, equilibrium, static_cast<std::size_t>(k),
                           point, own);
    }
  }
  response.seconds_path += seconds_since(start);
}

}  // namespace flexopt
