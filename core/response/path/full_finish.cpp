#include "core/response/path/branch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/equilibrium/continuity.hpp"
#include "core/response/models/leaf_models.hpp"

namespace flexopt {

Equilibrium step_from_rest(System& system, const StrokeRequest& request, std::size_t point) {
  const bool driven = request.loads.driven();
  if (system.loaded_at_rest() && (driven || !request.loads.mounting.empty()))
    if (Equilibrium loaded = mount(system, request.newton); !loaded.converged) return loaded;
  if (!driven)
    return step_load(system, request.loads.mounted(request.points[point]), request.newton);
  Equilibrium reached;
  for (std::size_t k = request.in_order ? 0 : point; k <= point; ++k) {
    reached =
        step_to(system, request.strokes_at(k, system.mechanism().drives.size()), request.newton);
    if (!reached.converged) break;
  }
  return reached;
}

std::unique_ptr<System> finish_on_full_leaves(System& system, const ModelOptions& model,
                                              const StrokeRequest& request, std::size_t point,
                                              const Check& good, Equilibrium& equilibrium) {
  if (good) return nullptr;
  const std::string why = good.error().empty() ? "exact" : "exact: " + good.error();
  auto full = system.on_full_leaves(system.loads(), why);
  const bool driven = request.loads.driven();
  const int before = equilibrium.iterations, steps = equilibrium.sub_steps;
  std::optional<VectorXd> strokes;
  if (driven) strokes = request.strokes_at(point, system.mechanism().drives.size());
  const Place reduced = place_of(system);
  equilibrium = solve_equilibrium(*full, strokes, request.newton);
  if (!equilibrium.converged || full->strain() > largest_strain ||
      !is_near(*full, reduced, same_energy) ||
      negative_pivots(*full, driven) > negative_pivots(system, driven)) {
    full = std::make_unique<System>(
        system.mechanism(), make_full_leaves(system.mechanism(), model, why), system.loads());
    equilibrium = step_from_rest(*full, request, point);
  }
  equilibrium.iterations += before;
  equilibrium.sub_steps = std::max(equilibrium.sub_steps, steps);
  return full;
}

Check check_full(const System& system) {
  return system.all_full() ? Check() : Because(std::string());
}

Check check_interior(System& system, const StrokeRequest& request, std::size_t k,
                     bool differentiable) {
  InteriorUse use;
  use.mass = request.wants_frequencies() || request.wants_harmonic_answers() ||
             request.wants_state_space(k);
  const bool stress = request.outputs.has(Output::stress);
  use.stress = stress || request.wants_gauges();
  use.sections = (stress && request.stress.need_history()) || request.wants_gauges();
  use.places = request.outputs.has_any({Output::moving_envelope, Output::clearance}) ||
               request.wants_leaf_points(k, differentiable);
  for (int i = 0; i < system.leaves(); ++i)
    if (const Check has = system.leaf(i).check_interior(use); !has)
      return Because(fmt::format("leaf {}: {}", i, has.error()));
  return {};
}

Check check_reduced(const System& system, const PathPoint& point) {
  for (int i = 0; i < system.leaves(); ++i)
    if (const Check believed = system.leaf(i).check_rebuilt(); !believed)
      return Because(fmt::format("leaf {}: {}", i, believed.error()));
  constexpr double rounding = 1e-6;
  const std::vector<double>& f = point.frequencies_locked;
  const bool contradicts_itself = point.status == PointStatus::converged && point.stable &&
                                  !f.empty() && f.front() < -rounding * std::abs(f.back());
  if (contradicts_itself && !system.all_full())
    return Because("reduced leaves are stable with a negative frequency");
  return {};
}

}  // namespace flexopt
