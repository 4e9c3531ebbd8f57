#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/equilibrium/stroke_path.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/joint.hpp"
#include "core/response/gradients/point_gradients.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/path/stiffness.hpp"
#include "core/response/response.hpp"
#include "core/response/stroke_series/frequency_derivatives.hpp"

namespace flexopt {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<std::unique_ptr<LeafElement>> make_leaves(const Mechanism& mechanism,
                                                      const ModelOptions& model,
                                                      const StrokeRequest& request) {
  if (model.accuracy == Accuracy::full) return make_full_leaves(mechanism, model);
  double largest = 0;
  for (const double s : request.points) largest = std::max(largest, std::abs(s));
  if (request.load_path)
    return make_reduced_leaves(mechanism, model, std::nullopt,
                               request.load + largest * *request.load_path);
  return make_reduced_leaves(mechanism, model, largest, request.load);
}

// Solves by `solve`, then again as long as a leaf of limited range wants its model changed. Where
// no equilibrium is found with reduced leaves, full ones take over.
template <class Solve>
Equilibrium solve_refined(System& system, const Solve& solve) {
  Equilibrium equilibrium = solve();
  if (!equilibrium.converged) {
    bool replaced = false;
    for (int i = 0; i < system.leaves(); ++i) {
      if (system.leaf(i).is_full()) continue;
      system.replace_leaf(i, system.leaf(i).full_model("no equilibrium with reduced leaves"));
      replaced = true;
    }
    if (replaced) equilibrium = solve();
  }
  for (int round = 0; equilibrium.converged && round < 8; ++round) {
    bool changed = false;
    for (int i = 0; i < system.leaves(); ++i) {
      LeafElement::Refinement refinement = system.leaf(i).refine();
      changed |= refinement.changed;
      if (refinement.replacement) system.replace_leaf(i, std::move(refinement.replacement));
    }
    if (!changed) break;
    system.invalidate();  // a tube has grown or was replaced
    const int before = equilibrium.iterations;
    equilibrium = solve();
    equilibrium.iterations += before;
  }
  return equilibrium;
}

std::optional<double> parasitic_frequency(const PathPoint& point, const StrokeRequest& request) {
  const auto& modes = request.parasitic_with_drive_locked ? point.modes_locked : point.modes_free;
  for (const Mode& mode : modes)
    if (is_parasitic(mode, request)) return mode.frequency;
  return std::nullopt;
}

// What exact points need beside the request.
struct Exact {
  std::vector<Mechanism> directions;  ///< of the gradients; may be empty
  StrokeGradients gradients;
  LeafRates rates;
  /// Where the path has a point at rest: the modes along the stroke from it, and what they took.
  std::optional<FrequencyDerivativesResult> along_stroke;
  double seconds_along_stroke = 0;
};

ExactDerivatives exact_derivatives(Exact& exact, const ModelOptions& model) {
  return {&exact.rates, &exact.directions, model};
}

// Largest first, the one that is named max_stress at their head.
void add_stress_peaks(System& system, const StrokeRequest& request, PathPoint& point) {
  constexpr double share = 0.8;  // smaller ones are far from any bound
  const StressPeak& largest = *point.max_stress;
  std::vector<StressPeak> others;
  for (int i = 0; i < system.leaves(); ++i)
    for (const StressPeak& p : system.leaf(i).stress_peaks()) {
      const bool same = p.leaf == largest.leaf && p.along == largest.along &&
                        p.across == largest.across &&
                        p.on_positive_normal == largest.on_positive_normal;
      if (!same && p.value >= share * largest.value) others.push_back(p);
    }
  std::stable_sort(others.begin(), others.end(),
                   [](const StressPeak& a, const StressPeak& b) { return a.value > b.value; });
  point.stress_peaks.push_back(largest);
  for (const StressPeak& p : others)
    if (static_cast<int>(point.stress_peaks.size()) < request.stress_peaks)
      point.stress_peaks.push_back(p);
}

// Frequencies of the whole mechanism to rounding. False where they are not found.
bool add_exact_modes(const MechanismFactor& factor, const ModelOptions& model,
                     const StrokeRequest& request, Exact& exact, ExactModeLists& lists,
                     PathPoint& point) {
  const auto wanted = [&](std::optional<int> count) {
    return std::min(request.frequencies, count.value_or(request.frequencies));
  };
  const int free = wanted(request.frequencies_free), locked = wanted(request.frequencies_locked);
  if (model.leaf_modes == 0) {
    lists = static_modes(factor, free, locked);
  } else {
    const bool at_rest = request.frequency_derivatives && !request.load_path && point.stroke == 0 &&
                         std::all_of(factor.leaves().begin(), factor.leaves().end(),
                                     [](const MechanismFactor::Leaf& leaf) { return leaf.full; });
    const int needed = at_rest ? std::min(modes_needed(request.frequencies), factor.size()) : 0;
    auto modes = exact_modes(factor, std::max(free, needed), locked);
    if (!modes) {
      point.status = PointStatus::no_equilibrium;
      point.message =
          fmt::format("the lowest frequencies of {} unknowns were not found", factor.size());
      return false;
    }
    lists = std::move(*modes);
    if (at_rest) {
      const auto start = Clock::now();
      const ExactDerivatives derivatives = exact_derivatives(exact, model);
      exact.along_stroke =
          frequency_derivatives(factor, request.frequencies, &derivatives, &lists.free);
      exact.seconds_along_stroke = seconds_since(start);
      lists.free.modes.resize(
          std::min(lists.free.modes.size(), static_cast<std::size_t>(free)));  // those listed
    }
  }
  point.modes_free = lists.free.modes;
  point.modes_locked = lists.locked.modes;
  for (const Mode& m : point.modes_free) point.frequencies_free.push_back(m.frequency);
  for (const Mode& m : point.modes_locked) point.frequencies_locked.push_back(m.frequency);
  point.parasitic_frequency = parasitic_frequency(point, request);
  return true;
}

// What exact points have beside others; derivatives of everything, if asked for. Frequencies by a
// constant mass have none.
void evaluate_exactly(System& system, const ModelOptions& model, const StrokeRequest& request,
                      Exact& exact, PathPoint& point, PointGradients* gradients) {
  const auto refuse = [&](const std::string& reason) {
    point.status = PointStatus::no_equilibrium;
    point.message = reason;
  };
  const Answer<MechanismFactor> linear = MechanismFactor::of(system);
  if (!linear.value) return refuse(linear.reason);
  const MechanismFactor& factor = *linear.value;
  ExactModeLists modes;
  if (model.mass == LeafMass::consistent &&
      !add_exact_modes(factor, model, request, exact, modes, point))
    return;
  if (point.max_stress && request.stress_peaks > 0) add_stress_peaks(system, request, point);
  if (!gradients) return;
  Answer<LeafGradients<double>> leaves = leaf_gradients(factor, exact.rates);
  if (!leaves.value) return refuse(leaves.reason);
  *gradients = point_gradients(factor, std::move(*leaves.value), exact.directions, model, request,
                               point, modes);
}

void evaluate_point(System& system, const Equilibrium& equilibrium, const ModelOptions& model,
                    const StrokeRequest& request, ConstantMass* constant_mass,
                    std::vector<int>& leaf_modes, Exact* exact, PathPoint& point,
                    PointGradients* gradients) {
  const Mechanism& mechanism = system.mechanism();
  point.status = PointStatus::converged;
  point.newton_iterations = equilibrium.iterations;
  point.sub_steps = equilibrium.sub_steps;
  point.drive_load = equilibrium.drive_load;
  const BodyPose& pose = system.pose(mechanism.end_effector);
  const RigidBody& body = mechanism.bodies[mechanism.end_effector];
  point.displacement = pose.position - body.reference;
  point.rotation = rotation_log(pose.rotation);
  for (int i = 0; i < system.leaves(); ++i) {
    const auto& follows = mechanism.leaves[i].point;
    if (follows && follows->body == mechanism.end_effector && follows->spread_over_tip)
      point.displacement =
          system.leaf(i).material_point(follows->along, follows->across) - body.reference;
  }
  for (const Probe& probe : request.probes) {
    const LeafSpring& leaf = mechanism.leaves[probe.leaf];
    const Vector3d place = leaf.origin + leaf.axes.col(0) * (probe.along * leaf.length) +
                           leaf.axes.col(1) * ((probe.across - 0.5) * leaf.width);
    point.probes.push_back(system.leaf(probe.leaf).material_point(probe.along, probe.across) -
                           place);
  }

  const EndEffectorCompliance c = end_effector_compliance(system);
  point.compliance_free = c.drive_free;
  point.compliance_locked = c.drive_locked;
  for (int d = 0; d < 6; ++d)
    if (!c.still[d]) point.support_stiffness[d] = 1 / c.drive_locked(d, d);
  const int d = index(mechanism.drive);
  point.drive_stiffness = 1 / c.drive_free(d, d);
  point.negative_pivots = request.load_path ? negative_pivots(system, false) : c.negative_pivots;
  point.stable = point.negative_pivots == 0;

  for (int i = 0; i < system.leaves(); ++i) point.leaves.push_back(system.leaf(i).report());
  if (request.frequencies > 0 && (!exact || model.mass == LeafMass::constant)) {
    const Frequencies f = natural_frequencies(system,
                                              {.count = request.frequencies,
                                               .leaf_modes = model.leaf_modes,
                                               .constant_mass = constant_mass},
                                              leaf_modes);
    point.modes_free = f.free;
    point.modes_locked = f.locked;
    for (const Mode& m : f.free) point.frequencies_free.push_back(m.frequency);
    for (const Mode& m : f.locked) point.frequencies_locked.push_back(m.frequency);
    point.parasitic_frequency = parasitic_frequency(point, request);
    for (int i = 0; i < system.leaves(); ++i) point.leaves[i] = system.leaf(i).report();
  }
  if (request.stress)
    for (int i = 0; i < system.leaves(); ++i) {
      const StressPeak peak = system.leaf(i).max_stress();
      // equal leaves carry equal stress but for rounding: the first one is named
      if (!point.max_stress || peak.value > point.max_stress->value * (1 + 1e-9))
        point.max_stress = peak;
    }
  if (request.shapes)
    for (int i = 0; i < system.leaves(); ++i) point.shapes.push_back(system.leaf(i).shape());
  if (exact) evaluate_exactly(system, model, request, *exact, point, gradients);
}

// The system at its present state with full leaves in the reduced ones' place.
std::unique_ptr<System> with_full_leaves(System& system) {
  std::vector<std::unique_ptr<LeafElement>> leaves;
  System::Snapshot state = system.save();
  state.leaves.clear();
  for (int i = 0; i < system.leaves(); ++i) {
    leaves.push_back(system.leaf(i).full_model("exact"));
    state.leaves.push_back(leaves.back()->save());
  }
  auto full = std::make_unique<System>(system.mechanism(), std::move(leaves));
  full->restore(state);
  return full;
}

// The path of full leaves from rest to one point.
Equilibrium step_from_rest(System& system, const StrokeRequest& request, double stroke) {
  if (request.load_path)
    return step_free_load(system, Vector6d::Zero(), request.load + stroke * *request.load_path,
                          request.newton);
  if (!request.load.isZero())
    if (Equilibrium loaded = step_load(system, request.load, request.newton); !loaded.converged)
      return loaded;
  return step_to(system, stroke, request.load, request.newton);
}

// The system on full leaves: Newton from the state of the reduced ones; where that leads astray (to
// none, or to one that is less stable or stretched too far), along the path from rest.
std::unique_ptr<System> finish_on_full_leaves(System& system, const ModelOptions& model,
                                              const StrokeRequest& request, double stroke,
                                              Equilibrium& equilibrium) {
  auto full = with_full_leaves(system);
  const bool driven = !request.load_path;
  const int before = equilibrium.iterations, steps = equilibrium.sub_steps;
  equilibrium = driven
                    ? solve_equilibrium(*full, stroke, request.load, request.newton)
                    : solve_equilibrium(*full, std::nullopt,
                                        request.load + stroke * *request.load_path, request.newton);
  if (!equilibrium.converged || full->strain() > largest_strain ||
      negative_pivots(*full, driven) > negative_pivots(system, driven)) {
    full =
        std::make_unique<System>(system.mechanism(), make_full_leaves(system.mechanism(), model));
    equilibrium = step_from_rest(*full, request, stroke);
  }
  equilibrium.iterations += before;
  equilibrium.sub_steps = std::max(equilibrium.sub_steps, steps);
  return full;
}

// From the undeflected state through the points in `order` (all of one sign, outward).
void follow_branch(const Mechanism& mechanism, const ModelOptions& model,
                   const StrokeRequest& request, const std::vector<int>& order, Exact* exact,
                   StrokeResponse& response) {
  auto start = Clock::now();
  System system(mechanism, make_leaves(mechanism, model, request));
  response.seconds_coefficients += seconds_since(start);
  start = Clock::now();

  bool lost = false;
  std::string reason;
  std::vector<int> leaf_modes;
  std::optional<ConstantMass> constant_mass;
  if (request.frequencies > 0 && model.mass == LeafMass::constant)
    constant_mass.emplace(mechanism, model);
  Vector6d present = Vector6d::Zero();  // dead load reached, where nothing is driven
  const auto follow_load = [&](const Vector6d& load) {
    const Equilibrium reached = step_free_load(system, present, load, request.newton);
    if (reached.converged) present = load;
    return reached;
  };
  if (!request.load.isZero()) {
    const Equilibrium loaded = solve_refined(system, [&] {
      return request.load_path ? follow_load(request.load)
                               : step_load(system, request.load, request.newton);
    });
    lost = !loaded.converged;
    reason = loaded.message;
  }
  for (const int k : order) {
    PathPoint& point = response.path[k];
    if (lost) {
      point.message = reason;
      continue;
    }
    Equilibrium equilibrium = solve_refined(system, [&] {
      return request.load_path ? follow_load(request.load + point.stroke * *request.load_path)
                               : step_to(system, point.stroke, request.load, request.newton);
    });
    std::unique_ptr<System> full;
    if (exact && equilibrium.converged && model.accuracy == Accuracy::reduced &&
        model.method == Reduction::mixed_potential)
      full = finish_on_full_leaves(system, model, request, point.stroke, equilibrium);
    if (!equilibrium.converged) {
      point.status = PointStatus::no_equilibrium;
      point.message = equilibrium.message;
      point.newton_iterations = equilibrium.iterations;
      lost = true;
      reason = fmt::format("the path ended before: {}", equilibrium.message);
      continue;
    }
    evaluate_point(full ? *full : system, equilibrium, model, request,
                   constant_mass ? &*constant_mass : nullptr, leaf_modes, exact, point,
                   exact && !exact->directions.empty() ? &exact->gradients.path[k] : nullptr);
  }
  response.seconds_path += seconds_since(start);
}

void add_frequency_derivatives(const Mechanism& mechanism, const ModelOptions& model,
                               const StrokeRequest& request, Exact* exact,
                               StrokeResponse& response) {
  const auto start = Clock::now();
  std::optional<ExactDerivatives> exactly;
  if (exact) exactly = exact_derivatives(*exact, model);
  FrequencyDerivativesResult found =
      exact && exact->along_stroke
          ? std::move(*exact->along_stroke)
          : frequency_derivatives(mechanism, model, request.load, request.newton,
                                  request.frequencies, exactly ? &*exactly : nullptr);
  response.seconds_derivatives = seconds_since(start);
  if (exact) {
    response.seconds_derivatives += exact->seconds_along_stroke;
    response.seconds_path -= exact->seconds_along_stroke;
  }
  if (!found.ok) {
    response.message = "no frequency derivatives: " + found.message;
    return;
  }
  response.frequency_derivatives = std::move(found.modes);
  set_validity(response.frequency_derivatives, response.path);
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    PathPoint& point = response.path[k];
    const auto screening =
        screening_frequencies(response.frequency_derivatives, request, point.stroke);
    if (screening.empty()) continue;
    const auto& [mode, value] = screening.front();
    point.parasitic_frequency_screening = value;
    if (!found.gradients.empty())
      exact->gradients.path[k].parasitic_frequency_screening = screening_gradient(
          response.frequency_derivatives[mode], found.gradients[mode], point.stroke);
  }
  if (exact) exact->gradients.frequency_derivatives = std::move(found.gradients);
}

StrokeResponse evaluate(const Mechanism& mechanism, const ModelOptions& model,
                        const StrokeRequest& request, Exact* exact) {
  StrokeResponse response;
  if (const auto rule = dependent_joints(mechanism)) {
    response.status = Status::no_equilibrium;
    response.message = *rule;
  }
  std::vector<int> outward, backward;
  for (int k = 0; k < static_cast<int>(request.points.size()); ++k) {
    PathPoint point;
    point.stroke = request.points[k];
    response.path.push_back(point);
    (request.points[k] < 0 ? backward : outward).push_back(k);
  }
  if (response.status != Status::ok) {
    for (PathPoint& point : response.path) point.message = response.message;
    return response;
  }
  auto by_distance = [&](int a, int b) {
    return std::abs(request.points[a]) < std::abs(request.points[b]);
  };
  std::stable_sort(outward.begin(), outward.end(), by_distance);
  std::stable_sort(backward.begin(), backward.end(), by_distance);
  for (const auto& branch : {outward, backward})
    if (!branch.empty() && request.path)
      follow_branch(mechanism, model, request, branch, exact, response);

  if (request.frequencies > 0 && request.frequency_derivatives && !request.load_path)
    add_frequency_derivatives(mechanism, model, request, exact, response);
  if (!request.path) {
    if (response.frequency_derivatives.empty()) response.status = Status::no_equilibrium;
    return response;
  }
  const std::string remark = std::move(response.message);

  int converged = 0;
  for (const PathPoint& p : response.path) converged += p.status == PointStatus::converged;
  if (converged == static_cast<int>(response.path.size())) {
    response.message = fmt::format("all {} stroke points converged", converged);
  } else {
    response.status = Status::no_equilibrium;
    response.message =
        fmt::format("{} of {} stroke points converged", converged, response.path.size());
    for (const PathPoint& p : response.path)
      if (p.status == PointStatus::no_equilibrium) response.message += "; " + p.message;
  }
  if (!remark.empty()) response.message += "; " + remark;
  return response;
}

// A material point that is a node of superelements cannot leave it.
std::optional<std::string> leaves_a_node(const Mechanism& mechanism,
                                         const std::vector<MechanismDirection>& directions,
                                         const ModelOptions& model) {
  for (const MechanismDirection& d : directions)
    for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
      if (leaves_a_node(mechanism.leaves[i], d.rate.leaves[i], model))
        return fmt::format(
            "along {} a material point leaves its node of superelements: no exact derivatives",
            d.parameter);
  return std::nullopt;
}

}  // namespace

StrokeResponse evaluate_stroke(const Mechanism& mechanism, const ModelOptions& model,
                               const StrokeRequest& request) {
  Exact exact;
  return evaluate(mechanism, model, request, request.exact ? &exact : nullptr);
}

StrokeSensitivity evaluate_stroke_gradients(const Mechanism& mechanism,
                                            const std::vector<MechanismDirection>& directions,
                                            const ModelOptions& model,
                                            const StrokeRequest& request) {
  StrokeSensitivity result;
  if (auto reason = leaves_a_node(mechanism, directions, model)) {
    result.response = evaluate_stroke(mechanism, model, request);
    result.message = std::move(*reason);
    return result;
  }
  Exact exact;
  for (const MechanismDirection& d : directions) {
    exact.gradients.parameters.push_back(d.parameter);
    exact.directions.push_back(d.rate);
  }
  exact.gradients.path.resize(request.points.size());
  result.response = evaluate(mechanism, model, request, &exact);
  result.gradients = std::move(exact.gradients);
  return result;
}

}  // namespace flexopt
