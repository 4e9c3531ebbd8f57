#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/response/gradients/point_gradients.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/modes/state_space.hpp"
#include "core/response/path/frequency_derivatives.hpp"
#include "core/response/path/point_outputs.hpp"

namespace flexopt {
namespace {

void refuse(PathPoint& point, const std::string& reason) {
  point.status = PointStatus::no_equilibrium;
  point.message = reason;
}

void miss_frequencies(int unknowns, PathPoint& point) {
  refuse(point, fmt::format("the lowest frequencies of {} unknowns were not found", unknowns));
}

void set_measures(const DynamicsMeasures& measures, PathPoint& point) {
  point.bandwidths.clear();
  for (const std::optional<DynamicsMeasure>& bandwidth : measures.bandwidths) {
    point.bandwidths.emplace_back();
    if (bandwidth) point.bandwidths.back() = bandwidth->value;
  }
  point.no_bandwidth = measures.no_bandwidth;
  point.transmissibility.reset();
  if (const auto& gain = measures.transmissibility)
    point.transmissibility = {gain->value, gain->frequency};
  point.no_transmissibility = measures.no_transmissibility;
}

// So many frequencies, or as many as elastic bodies need for fixed-interface modes that carry
// motions up to `band` [Hz]. Where the most do not suffice, the motions are left out.
int frequencies_to(double band, const ElasticBodies& bodies, int count) {
  constexpr int most = 100;  // frequencies of a job
  while (count < most && mode_limit(bodies, count).frequency < band)
    count = std::min(most, 2 * count);
  return count;
}

// Modes are told apart where they are drawn and where they are followed along the stroke.
bool wants_mode_motions(const StrokeRequest& request) {
  return request.outputs.has(Output::shapes) || request.wants_frequency_derivatives();
}

bool is_at_rest(const PathPoint& point) {
  return point.stroke == 0 &&
         std::ranges::all_of(point.strokes, [](double stroke) { return stroke == 0; });
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

// Up to where measures are read off [Hz].
double highest_of(const DynamicsMeasures& measures, const DynamicsRule* rule) {
  double highest = measures.transmissibility ? rule->transmissibility->to : 0;
  for (const std::optional<DynamicsMeasure>& bandwidth : measures.bandwidths)
    if (bandwidth) highest = std::max(highest, bandwidth->frequency);
  for (const TransferMeasure& transfer : measures.transfers)
    highest = std::max(highest, transfer.bandwidth.value_or(0));
  return highest;
}

// Whether the tables of reduced leaves have all modes up to somewhat more than the highest
// frequency. `all`: whether none of the modes is missing that are asked for.
Check check_tables(const MechanismFactor& factor, double highest, bool all) {
  const double cutoff = FrequencyOptions{}.cutoff_ratio * highest;
  for (std::size_t i = 0; i < factor.leaves().size(); ++i) {
    const std::optional<double> top = factor.leaves()[i].linear->highest_mode();
    if (top && !all)
      return Because(fmt::format("leaf {}: its tables have fewer modes than are asked for", i));
    if (top && *top < cutoff)
      return Because(fmt::format("leaf {}: its tables have modes up to {:.4g} Hz, not to {:.4g} Hz",
                                 i, *top, cutoff));
  }
  return {};
}

// Whether a motion grows where loads follow their bodies: with the drives held as for stability.
void add_growth(const StrokeRequest& request, const Frequencies& found, PathPoint& point) {
  const bool locked = request.loads.stable_with_all_held();
  for (const Mode& mode : locked ? found.locked : found.free) {
    point.stable = point.stable && mode.frequency >= 0;
    if (mode.growth_rate > (point.flutter ? point.flutter->growth_rate : 0)) point.flutter = mode;
  }
  if (point.flutter)
    point.message = fmt::format("flutter at {:.4g} Hz grows by {:.4g} 1/s",
                                -point.flutter->frequency, point.flutter->growth_rate);
}

}  // namespace

// Frequencies of the condensed mechanism.
void PointOutputs::add_ritz_frequencies(System& system, PathPoint& point) {
  const bool follows = system.follows();  // growing motions are looked for whatever is asked for
  const auto found = natural_frequencies(
      system, {.count = std::max(request_->frequencies, follows ? 1 : 0),
               .free = follows || request_->frequencies_of(DriveState::free) > 0,
               .leaf_modes = model_->leaf_modes,
               .constant_mass = constant_mass_ ? &*constant_mass_ : nullptr,
               .motions = wants_mode_motions(*request_),
               .shapes = request_->outputs.has(Output::shapes)});
  if (!found) return miss_frequencies(system.size(), point);
  add_modes(*request_, found->free, found->locked, point);
  add_reports(system, point);
  if (follows) add_growth(*request_, *found, point);
}

// Frequencies of the whole mechanism, to rounding. False where they are not found.
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
      const ExactDerivatives derivatives{&differentiable_->design, *model_};
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
      to[k].elastic_motion = from[k].elastic_motion;
    }
  };
  take(drawn->free, point.modes_free);
  take(drawn->locked, point.modes_locked);
}

// Whether modes of reduced leaves, which were found or not, are believed.
Check PointOutputs::check_modes(const MechanismFactor& factor, const FullModeLists& lists,
                                bool found, const DynamicsMeasures& dynamics) const {
  if (model_->leaf_modes == 0) return {};
  double highest = highest_of(dynamics, request_->dynamics ? &*request_->dynamics : nullptr);
  for (const FullModes* list : {&lists.free, &lists.locked})
    for (const Mode& mode : list->modes) highest = std::max(highest, mode.frequency);
  const auto wanted = [&](DriveState drive) {
    return static_cast<std::size_t>(request_->frequencies_of(drive));
  };
  const bool all = found && lists.free.modes.size() >= wanted(DriveState::free) &&
                   lists.locked.modes.size() >= wanted(DriveState::locked);
  return check_tables(factor, highest, all);
}

// False where a named point has no motion; the point then says why.
bool PointOutputs::add_measures(const MechanismFactor& factor, bool terms,
                                DynamicsMeasures& measures, PathPoint& point) {
  if (request_->wants_dynamics()) {
    measures = dynamics_measures(factor, *request_->dynamics, request_->loads.driven(), terms,
                                 request_->named_points);
    set_measures(measures, point);
  }
  if (!request_->wants_transfers()) return true;
  LeafRates own;
  LeafRates& rates = differentiable_ ? differentiable_->design.rates : own;
  auto found = transfers(factor, *request_->dynamics, request_->named_points, terms, rates);
  if (!found) {
    refuse(point, found.error());
    return false;
  }
  point.transfers.assign(found->begin(), found->end());
  measures.transfers = std::move(*found);
  return true;
}

bool PointOutputs::add_state_space(const MechanismFactor& factor, const FullModes& free,
                                   std::size_t index, PathPoint& point) {
  if (!request_->wants_state_space(index)) return true;
  LeafRates own;
  LeafRates& rates = differentiable_ ? differentiable_->design.rates : own;
  Answer<StateSpace> model =
      state_space(factor, *request_->state_space, request_->named_points, free, rates);
  if (model)
    point.state_space = std::move(*model);
  else
    refuse(point, model.error());
  return model.has_value();
}

int PointOutputs::vibrations(const System& system, std::size_t index) const {
  constexpr int of_dynamics = 6;  // of a band whose frequencies nobody has asked for
  int count = request_->wants_frequencies() || request_->wants_frequency_derivatives()
                  ? request_->frequencies
                  : 0;
  if (request_->wants_harmonic_answers()) count = std::max(count, of_dynamics);
  if (request_->wants_state_space(index)) count = std::max(count, request_->state_space->modes);
  if (request_->wants_dynamics() && request_->dynamics->transmissibility)
    count =
        frequencies_to(request_->dynamics->transmissibility->to, system.elastic_bodies(), count);
  return count;
}

Check PointOutputs::add_dynamics(System& system, std::size_t index, PathPoint& point) {
  const Answer<MechanismFactor> linear = MechanismFactor::of(system, vibrations(system, index));
  if (!linear) {
    refuse(point, linear.error());
    return {};
  }
  const MechanismFactor& factor = *linear;
  DynamicsMeasures measures;
  if (!add_measures(factor, false, measures, point)) return {};
  if (request_->wants_harmonic_answers() && model_->leaf_modes > 0)
    if (Check believed = check_tables(factor, highest_of(measures, &*request_->dynamics), true);
        !believed)
      return believed;
  if (!request_->wants_state_space(index)) return {};
  const auto modes =
      full_modes(factor, std::min(request_->state_space->modes, factor.size()), 0, ModeMotions::no);
  if (modes)
    add_state_space(factor, modes->free, index, point);
  else
    miss_frequencies(factor.size(), point);
  return {};
}

// What differentiable points have beside others; derivatives of everything, if asked for.
// Frequencies by a constant mass have none.
Check PointOutputs::evaluate_differentiable(System& system, const Solids* solids, std::size_t index,
                                            PathPoint& point, PointGradients* gradients) {
  const auto refused = [&](const std::string& reason) {
    refuse(point, reason);
    return Check();
  };
  const Answer<MechanismFactor> linear = MechanismFactor::of(system, vibrations(system, index));
  if (!linear) return refused(linear.error());
  const MechanismFactor& factor = *linear;
  DynamicsMeasures dynamics;
  if (!add_measures(factor, gradients != nullptr, dynamics, point)) return {};
  FullModeLists modes;
  if (model_->mass == LeafMass::consistent) {
    const bool found = add_full_frequencies(factor, index, modes, point);
    if (Check believed = check_modes(factor, modes, found, dynamics); !believed) return believed;
    if (!found || !add_state_space(factor, modes.free, index, point)) return {};
    add_mode_shapes(system, point);
  }
  if (point.max_stress && request_->stress_peaks > 0)
    add_stress_peaks(system, request_->stress_peaks, point);
  if (!gradients) return {};
  const auto design = design_rates(factor, differentiable_->design, *model_);
  if (!design) return refused(design.error());
  *gradients = point_gradients(factor, *design, *request_, point, modes, solids,
                               request_->wants_harmonic_answers() ? &dynamics : nullptr,
                               *stress_places_, differentiable_->design.strokes);
  return {};
}

}  // namespace flexopt
