#include "core/response/path/point_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/equilibrium/end_effector_compliance.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/profile.hpp"
#include "core/response/gradients/point_gradients.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/modes/state_space.hpp"
#include "core/response/path/low_modes.hpp"
#include "core/response/path/stroke_ways.hpp"
#include "core/response/room_taken.hpp"
#include "core/response/stability/critical_load.hpp"
#include "core/response/stress_safety.hpp"

namespace flexopt {
namespace {

void add_motion(System& system, const StrokeRequest& request, PathPoint& point) {
  const Mechanism& mechanism = system.mechanism();
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
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const BodyPose& at = system.pose(static_cast<int>(b));
    point.bodies.push_back(
        {at.position - mechanism.bodies[b].reference, rotation_log(at.rotation)});
  }
  point.bodies[mechanism.end_effector].displacement = point.displacement;
  for (const Probe& probe : request.probes) {
    const LeafSpring& leaf = mechanism.leaves[probe.leaf];
    const ArcPoint<double> middle = leaf.middle(probe.along);
    const double beside =
        (probe.across - 0.5) * leaf.width * profile_at(leaf.width_profile, probe.along);
    const Vector3d place =
        leaf.origin + leaf.axes * Vector3d(middle.x * leaf.length, beside, middle.z * leaf.length);
    point.probes.push_back(system.leaf(probe.leaf).material_point(probe.along, probe.across) -
                           place);
  }
}

void add_stiffness(const System& system, const StrokeRequest& request, PathPoint& point) {
  const EndEffectorCompliance c = end_effector_compliance(system);
  point.compliance_free = c.drive_free;
  point.compliance_locked = c.drive_locked;
  point.support_stiffness = c.support_stiffness();
  point.drive_stiffnesses.assign(c.drive_stiffness.begin(), c.drive_stiffness.end());
  if (!point.drive_stiffnesses.empty()) point.drive_stiffness = point.drive_stiffnesses.front();
  point.negative_pivots =
      request.loads.driven() ? c.negative_pivots : negative_pivots(system, false);
  point.stable = point.negative_pivots == 0;
}

// Modes are told apart where they are drawn and where they are followed along the stroke.
bool wants_mode_motions(const StrokeRequest& request) {
  return request.outputs.has(Output::shapes) || request.wants_frequency_derivatives();
}

bool is_at_rest(const PathPoint& point) {
  return point.stroke == 0 &&
         std::ranges::all_of(point.strokes, [](double stroke) { return stroke == 0; });
}

void add_reports(System& system, PathPoint& point) {
  point.leaves.clear();
  for (int i = 0; i < system.leaves(); ++i) point.leaves.push_back(system.leaf(i).report());
}

void add_modes(const StrokeRequest& request, const std::vector<Mode>& free,
               const std::vector<Mode>& locked, PathPoint& point) {
  if (request.frequencies_of(DriveState::free) > 0) point.modes_free = free;
  if (request.frequencies_of(DriveState::locked) > 0) point.modes_locked = locked;
  for (const Mode& m : point.modes_free) point.frequencies_free.push_back(m.frequency);
  for (const Mode& m : point.modes_locked) point.frequencies_locked.push_back(m.frequency);
  const ParasiticRule& rule = request.parasitic;
  const auto& modes = rule.drive == DriveState::locked ? point.modes_locked : point.modes_free;
  const auto lowest =
      std::ranges::find_if(modes, [&](const Mode& mode) { return rule.admits(mode.kind); });
  if (lowest != modes.end()) point.parasitic_frequency = lowest->frequency;
}

/// Of every leaf.
std::vector<StressPeak> largest_stresses(System& system) {
  std::vector<StressPeak> peaks;
  for (int i = 0; i < system.leaves(); ++i) peaks.push_back(system.leaf(i).max_stress());
  return peaks;
}

void add_max_stress(const std::vector<StressPeak>& leaves, PathPoint& point) {
  for (const StressPeak& peak : leaves) {
    // equal leaves carry equal stress but for rounding: the first one is named
    if (!point.max_stress || peak.value > point.max_stress->value * (1 + 1e-9))
      point.max_stress = peak;
  }
}

void add_safety(System& system, const StressRules& rules, std::vector<StressPeak> leaves,
                PathPoint& point) {
  if (!rules.fillet && !rules.yield && !rules.fatigue && !rules.life) return;
  const Mechanism& mechanism = system.mechanism();
  if (rules.fillet) point.fillet_fault = fillet_fault(mechanism, *rules.fillet);
  if (!point.fillet_fault.empty()) return;
  if (rules.fillet)
    for (int i = 0; i < system.leaves(); ++i) {
      StressPeak& largest = leaves[i];
      largest = with_fillets(largest, system.leaf(i), mechanism, *rules.fillet);
    }
  add_stress_safety(leaves, mechanism, rules, point);
}

// The places are those of the first point that is evaluated.
void add_sections(System& system, std::vector<std::vector<StressPlace>>& places, PathPoint& point) {
  if (places.empty())
    for (int i = 0; i < system.leaves(); ++i) places.push_back(system.leaf(i).stress_places());
  point.sections.clear();
  for (int i = 0; i < system.leaves(); ++i)
    point.sections.push_back(system.leaf(i).section_stresses(places[i]));
}

// Largest first, the one that is named max_stress at their head.
void add_stress_peaks(System& system, int wanted, PathPoint& point) {
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
    if (static_cast<int>(point.stress_peaks.size()) < wanted) point.stress_peaks.push_back(p);
}

Solids solids_of(System& system) {
  const Mechanism& mechanism = system.mechanism();
  std::vector<BodyPlace> bodies;
  for (int b = 0; b < static_cast<int>(mechanism.bodies.size()); ++b)
    bodies.push_back({system.pose(b).position, system.pose(b).rotation});
  return {mechanism,
          [&](int leaf, const std::vector<std::array<double, 2>>& points) {
            return system.leaf(leaf).material_points(points);
          },
          bodies};
}

}  // namespace

PointOutputs::PointOutputs(const Mechanism& mechanism, const ModelOptions& model,
                           const StrokeRequest& request,
                           std::vector<std::vector<StressPlace>>& stress_places,
                           DifferentiablePath* differentiable)
    : model_(&model),
      request_(&request),
      differentiable_(differentiable),
      stress_places_(&stress_places) {
  if (request.frequencies > 0 && model.mass == LeafMass::constant)
    constant_mass_.emplace(mechanism, model);
  if (request.outputs.has(Output::clearance)) clearance_pairs_ = clearance_pairs(mechanism);
}

namespace {
void miss_frequencies(int unknowns, PathPoint& point) {
  point.status = PointStatus::no_equilibrium;
  point.message = fmt::format("the lowest frequencies of {} unknowns were not found", unknowns);
}
}  // namespace

// Of the condensed mechanism.
void PointOutputs::add_ritz_frequencies(System& system, PathPoint& point) {
  const auto found =
      natural_frequencies(system, {.count = request_->frequencies,
                                   .free = request_->frequencies_of(DriveState::free) > 0,
                                   .leaf_modes = model_->leaf_modes,
                                   .constant_mass = constant_mass_ ? &*constant_mass_ : nullptr,
                                   .motions = wants_mode_motions(*request_),
                                   .shapes = request_->outputs.has(Output::shapes)});
  if (!found) return miss_frequencies(system.size(), point);
  add_modes(*request_, found->free, found->locked, point);
  add_reports(system, point);
}

// Of the whole mechanism, to rounding. False where they are not found.
bool PointOutputs::add_full_frequencies(const MechanismFactor& factor, std::size_t index,
                                        FullModeLists& lists, PathPoint& point) {
  const int free = request_->frequencies_of(DriveState::free),
            locked = request_->frequencies_of(DriveState::locked);
  if (model_->leaf_modes == 0) {
    lists = static_modes(factor, free, locked);
  } else {
    const bool at_rest = request_->wants_frequency_derivatives() && is_at_rest(point) &&
                         std::all_of(factor.leaves().begin(), factor.leaves().end(),
                                     [](const MechanismFactor::Leaf& leaf) { return leaf.full; });
    int needed = at_rest ? std::min(modes_needed(request_->frequencies), factor.size()) : 0;
    if (request_->wants_state_space(index))
      needed = std::max(needed, std::min(request_->state_space->modes, factor.size()));
    auto modes = full_modes(factor, std::max(free, needed), locked,
                            wants_mode_motions(*request_) ? ModeMotions::yes : ModeMotions::no);
    if (!modes) {
      miss_frequencies(factor.size(), point);
      return false;
    }
    lists = std::move(*modes);
    if (at_rest) {
      const auto start = std::chrono::steady_clock::now();
      const ExactDerivatives derivatives = differentiable_->exact_derivatives(*model_);
      differentiable_->along_stroke = frequency_derivatives(
          factor, request_->frequencies, stroke_ways(*request_), &derivatives, &lists.free);
      differentiable_->seconds_along_stroke =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    lists.free.modes.resize(
        std::min(lists.free.modes.size(), static_cast<std::size_t>(free)));  // those listed
  }
  add_modes(*request_, lists.free.modes, lists.locked.modes, point);
  return true;
}

// The modes of the whole mechanism are those of the condensed one, in the same order, but for a
// few 1e-5 of their frequencies: that knows how they look.
void PointOutputs::add_mode_shapes(System& system, PathPoint& point) {
  if (!request_->outputs.has(Output::shapes) ||
      (point.modes_free.empty() && point.modes_locked.empty()))
    return;
  const auto drawn = natural_frequencies(
      system, {.count = request_->frequencies, .leaf_modes = model_->leaf_modes, .shapes = true});
  if (!drawn) return miss_frequencies(system.size(), point);
  const auto take = [](const std::vector<Mode>& from, std::vector<Mode>& to) {
    for (std::size_t k = 0; k < std::min(from.size(), to.size()); ++k) {
      to[k].body_motion = from[k].body_motion;
      to[k].leaf_motion = from[k].leaf_motion;
    }
  };
  take(drawn->free, point.modes_free);
  take(drawn->locked, point.modes_locked);
}

// Why modes of reduced leaves, which were found or not, are not believed; empty where they are.
// Those up to the highest frequency are made of all modes of the leaves up to somewhat more.
std::string PointOutputs::modes_gap(const MechanismFactor& factor, const FullModeLists& lists,
                                    bool found, const DynamicsMeasures& dynamics) const {
  if (model_->leaf_modes == 0) return {};
  double highest = dynamics.transmissibility ? request_->dynamics->transmissibility->to : 0;
  for (const std::optional<DynamicsMeasure>& bandwidth : dynamics.bandwidths)
    if (bandwidth) highest = std::max(highest, bandwidth->frequency);
  for (const FullModes* list : {&lists.free, &lists.locked})
    for (const Mode& mode : list->modes) highest = std::max(highest, mode.frequency);
  const auto wanted = [&](DriveState drive) {
    return static_cast<std::size_t>(request_->frequencies_of(drive));
  };
  const bool all = found && lists.free.modes.size() >= wanted(DriveState::free) &&
                   lists.locked.modes.size() >= wanted(DriveState::locked);
  const double cutoff = FrequencyOptions{}.cutoff_ratio * highest;
  for (std::size_t i = 0; i < factor.leaves().size(); ++i) {
    const std::optional<double> top = factor.leaves()[i].linear->highest_mode();
    if (top && !all)
      return fmt::format("leaf {}: its tables have fewer modes than are asked for", i);
    if (top && *top < cutoff)
      return fmt::format("leaf {}: its tables have modes up to {:.4g} Hz, not to {:.4g} Hz", i,
                         *top, cutoff);
  }
  return {};
}

namespace {

void set_measures(const DynamicsMeasures& measures, PathPoint& point) {
  point.bandwidths.clear();
  for (const std::optional<DynamicsMeasure>& bandwidth : measures.bandwidths) {
    point.bandwidths.emplace_back();
    if (bandwidth) point.bandwidths.back() = bandwidth->value;
  }
  if (const auto& gain = measures.transmissibility)
    point.transmissibility = {gain->value, gain->frequency};
}

}  // namespace

// False where a probe has no motion; the point then says why.
bool PointOutputs::add_state_space(const MechanismFactor& factor, const FullModes& free,
                                   std::size_t index, PathPoint& point) {
  if (!request_->wants_state_space(index)) return true;
  LeafRates own;
  LeafRates& rates = differentiable_ ? differentiable_->rates : own;
  Answer<StateSpace> model =
      state_space(factor, *request_->state_space, request_->probes, free, rates);
  if (model.value) {
    point.state_space = std::move(*model.value);
    return true;
  }
  point.status = PointStatus::no_equilibrium;
  point.message = model.reason;
  return false;
}

void PointOutputs::add_dynamics(System& system, std::size_t index, PathPoint& point) {
  const auto refuse = [&](const std::string& reason) {
    point.status = PointStatus::no_equilibrium;
    point.message = reason;
  };
  const Answer<MechanismFactor> linear = MechanismFactor::of(system);
  if (!linear.value) return refuse(linear.reason);
  const MechanismFactor& factor = *linear.value;
  if (request_->wants_dynamics())
    set_measures(dynamics_measures(factor, *request_->dynamics, request_->loads.driven(), false),
                 point);
  if (!request_->wants_state_space(index)) return;
  const auto modes =
      full_modes(factor, std::min(request_->state_space->modes, factor.size()), 0, ModeMotions::no);
  if (!modes) return miss_frequencies(factor.size(), point);
  add_state_space(factor, modes->free, index, point);
}

// What differentiable points have beside others; derivatives of everything, if asked for.
// Frequencies by a constant mass have none.
std::string PointOutputs::evaluate_differentiable(System& system, const Solids* solids,
                                                  std::size_t index, PathPoint& point,
                                                  PointGradients* gradients) {
  const auto refuse = [&](const std::string& reason) {
    point.status = PointStatus::no_equilibrium;
    point.message = reason;
    return std::string();
  };
  const Answer<MechanismFactor> linear = MechanismFactor::of(system);
  if (!linear.value) return refuse(linear.reason);
  const MechanismFactor& factor = *linear.value;
  DynamicsMeasures dynamics;
  if (request_->wants_dynamics()) {
    dynamics = dynamics_measures(factor, *request_->dynamics, request_->loads.driven(),
                                 gradients != nullptr);
    set_measures(dynamics, point);
  }
  FullModeLists modes;
  if (model_->mass == LeafMass::consistent) {
    const bool found = add_full_frequencies(factor, index, modes, point);
    if (std::string gap = modes_gap(factor, modes, found, dynamics); !gap.empty()) return gap;
    if (!found || !add_state_space(factor, modes.free, index, point)) return {};
    add_mode_shapes(system, point);
  }
  if (point.max_stress && request_->stress_peaks > 0)
    add_stress_peaks(system, request_->stress_peaks, point);
  if (!gradients) return {};
  Answer<LeafGradients<double>> leaves = leaf_gradients(factor, differentiable_->rates);
  if (!leaves.value) return refuse(leaves.reason);
  *gradients = point_gradients(factor, std::move(*leaves.value), differentiable_->directions,
                               *model_, *request_, point, modes, solids,
                               request_->wants_dynamics() ? &dynamics : nullptr, *stress_places_);
  return {};
}

void PointOutputs::add_buckling(System& system, const Equilibrium& equilibrium, std::size_t index,
                                PathPoint& point, PointGradients* gradients) {
  const double growing = request_->loads.driven() ? 0 : request_->points[index];
  std::optional<DesignDirections> design;
  if (gradients)
    design = {&differentiable_->directions, &differentiable_->rates, request_->loads.driven()};
  Buckling& buckling = point.buckling.emplace();
  for (const DriveState drive : {DriveState::locked, DriveState::free}) {
    if (drive == DriveState::free && system.drives().empty()) {
      buckling.drive_free = buckling.drive_locked;
      if (gradients) gradients->buckling_free = gradients->buckling_locked;
      continue;
    }
    LoadBranch branch(system, *request_->growing_load(), growing, drive, equilibrium.drive_loads,
                      request_->newton);
    CriticalLoadResult found = find_critical_load(branch, *model_, design ? &*design : nullptr);
    const bool locked = drive == DriveState::locked;
    (locked ? buckling.drive_locked : buckling.drive_free) = std::move(found.load);
    if (gradients)
      (locked ? gradients->buckling_locked : gradients->buckling_free) = std::move(found.gradient);
  }
}

void PointOutputs::add_load_capacity(System& system, std::size_t index, PathPoint& point,
                                     PointGradients* gradients) {
  const double growing = request_->loads.driven() ? 0 : request_->points[index];
  if (gradients && !capacity_)
    capacity_.emplace(system.mechanism(), differentiable_->directions, differentiable_->rates);
  for (std::size_t k = 0; k < request_->capacity.directions.size(); ++k) {
    if (!request_->capacity.directions[k]) continue;
    LoadCapacityResult found = find_load_capacity(system, static_cast<int>(k), growing, *request_,
                                                  *model_, gradients ? &*capacity_ : nullptr);
    point.load_capacity[k] = std::move(found.capacity);
    if (gradients) gradients->load_capacity[k] = std::move(found.gradient);
  }
}

std::string PointOutputs::evaluate(System& system, const Equilibrium& equilibrium,
                                   std::size_t index, PathPoint& point, PointGradients* gradients) {
  point.status = PointStatus::converged;
  point.newton_iterations = equilibrium.iterations;
  point.sub_steps = equilibrium.sub_steps;
  point.drive_load = equilibrium.drive_load;
  point.drive_loads.assign(equilibrium.drive_loads.begin(), equilibrium.drive_loads.end());
  add_motion(system, *request_, point);
  add_stiffness(system, *request_, point);
  add_reports(system, point);
  const bool frequencies = request_->frequencies_of(DriveState::free) > 0 ||
                           request_->frequencies_of(DriveState::locked) > 0;
  if (frequencies && (!differentiable_ || model_->mass == LeafMass::constant))
    add_ritz_frequencies(system, point);
  if (request_->outputs.has(Output::stress)) {
    std::vector<StressPeak> leaves = largest_stresses(system);
    add_max_stress(leaves, point);
    add_safety(system, request_->stress, std::move(leaves), point);
    if (request_->stress.need_history()) add_sections(system, *stress_places_, point);
  }
  if (request_->outputs.has(Output::shapes))
    for (int i = 0; i < system.leaves(); ++i) point.shapes.push_back(system.leaf(i).shape());
  std::optional<Solids> solids;
  if (request_->outputs.has(Output::moving_envelope) || !clearance_pairs_.empty())
    solids = solids_of(system);
  if (request_->outputs.has(Output::moving_envelope)) point.extents = extents_of(*solids);
  if (!clearance_pairs_.empty()) point.clearance = clearance_of(*solids, clearance_pairs_);
  if (!differentiable_) return {};
  return evaluate_differentiable(system, solids ? &*solids : nullptr, index, point, gradients);
}

}  // namespace flexopt
