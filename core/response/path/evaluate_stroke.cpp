#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/elements/solid/elastic_model.hpp"
#include "core/math/work_limit.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/mechanism/joint.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/path/branch.hpp"
#include "core/response/path/frequency_derivatives.hpp"
#include "core/response/path/stroke_capacity.hpp"
#include "core/response/quantities.hpp"
#include "core/response/room_taken.hpp"
#include "core/response/solids.hpp"
#include "core/response/stress_safety.hpp"

namespace flexopt {
namespace {

// Cells that are integrated at fewer points than would see all of their motions need neighbours.
Check check_elastic(const ElasticBody& body) {
  Check sound = check_solid(body);
  if (sound && !condensed(body)->model.stiffness.allFinite())
    sound = Because(
        "its mesh has motions without stiffness: of hexahedra, two across a body are needed at "
        "least");
  if (!sound) return Because(body.name + ": " + sound.error());
  return {};
}

// The ways from rest to the points: those of one drive outward on either side, of several drives
// the straight lines on which points lie, or all points as they are listed.
std::vector<std::vector<int>> ways_to_points(const StrokeRequest& request) {
  const int count = static_cast<int>(request.points.size());
  std::vector<std::vector<int>> ways;
  if (request.in_order) {
    std::vector<int>& all = ways.emplace_back(count);
    std::iota(all.begin(), all.end(), 0);
    return ways;
  }
  std::vector<double> parts = request.points;  // of the way
  std::vector<int> of(request.points.size());
  const std::vector<VectorXd> lines = stroke_ways(request);
  for (int k = 0; k < count && !lines.empty(); ++k) {
    const VectorXd& strokes = request.strokes[k];
    std::optional<double> part;
    for (std::size_t line = 0; !part && line < lines.size(); ++line) {
      part = part_of_way(lines[line], {strokes.begin(), strokes.end()});
      of[k] = static_cast<int>(line);
    }
    parts[k] = part.value_or(1);
  }
  ways.resize(2 * std::max<std::size_t>(1, lines.size()));
  for (int k = 0; k < count; ++k) ways[2 * of[k] + (parts[k] < 0)].push_back(k);
  for (std::vector<int>& way : ways)
    std::ranges::stable_sort(way, {}, [&](int k) { return std::abs(parts[k]); });
  std::erase_if(ways, [](const auto& way) { return way.empty(); });
  return ways;
}

void add_screening(const StrokeRequest& request, DifferentiablePath* differentiable,
                   StrokeResponse& response) {
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    PathPoint& point = response.path[k];
    const auto to_point =
        modes_to_point(response, differentiable ? &differentiable->gradients : nullptr, point);
    if (!to_point) continue;
    const auto& [modes, gradients, at] = *to_point;
    const auto screening = screening_frequencies(*modes, request.parasitic, at);
    if (screening.empty()) continue;
    const auto& [mode, value] = screening.front();
    point.parasitic_frequency_screening = value;
    if (gradients)
      differentiable->gradients.path[k].parasitic_frequency_screening =
          screening_gradient((*modes)[mode], (*gradients)[mode], at);
  }
}

void miss_frequency_derivatives(const std::string& why, StrokeResponse& response) {
  response.no_frequency_derivatives = why;
  response.message = "no frequency derivatives: " + why;
}

void add_frequency_derivatives(const Mechanism& mechanism, const ModelOptions& model,
                               const StrokeRequest& request, DifferentiablePath* differentiable,
                               StrokeResponse& response) {
  const auto start = std::chrono::steady_clock::now();
  const ExactDerivatives exactly{differentiable ? &differentiable->design : nullptr, model};
  const bool loaded = !request.outputs.need_path() ||
                      std::ranges::any_of(response.path, [](const PathPoint& point) {
                        return point.status != PointStatus::not_reached;
                      });
  if (!loaded) {  // not the derivatives alone
    response.no_frequency_derivatives = response.message = response.path.front().message;
    return;
  }
  Answer<FrequencyDerivativesResult> found =
      differentiable && differentiable->along_stroke
          ? std::move(*differentiable->along_stroke)
          : frequency_derivatives(mechanism, model, request.loads, request.newton,
                                  request.frequencies, stroke_ways(request),
                                  differentiable ? &exactly : nullptr);
  response.seconds_derivatives =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (differentiable) {
    response.seconds_derivatives += differentiable->seconds_along_stroke;
    response.seconds_path -= differentiable->seconds_along_stroke;
  }
  if (!found) return miss_frequency_derivatives(found.error(), response);
  if (!found->note.empty()) response.message = found->note;
  response.frequency_derivatives = std::move(found->modes);
  response.frequency_ways = std::move(found->ways);
  set_validity(response.frequency_derivatives, response.path);
  for (FrequencyWay& way : response.frequency_ways) set_validity(way, response.path);
  if (StrokeGradients* gradients = gradients_of(differentiable)) {
    gradients->frequency_derivatives = std::move(found->gradients);
    gradients->frequency_ways = std::move(found->way_gradients);
  }
  add_screening(request, differentiable, response);
}

// Envelopes and mass of the leaves, once for all points.
void add_room_taken(const Mechanism& mechanism, const StrokeRequest& request,
                    DifferentiablePath* differentiable, StrokeResponse& response) {
  const bool still = request.outputs.has(Output::envelope),
             moving = request.outputs.has(Output::moving_envelope);
  if (!still && !moving) return;
  const Solids solids = Solids::undeflected(mechanism);
  if (solids.count() == 0) return;
  const Extents rest = extents_of(solids);
  StrokeGradients* gradients = gradients_of(differentiable);
  MatrixXd rest_rates;
  if (gradients)
    rest_rates =
        extent_rates(solids, rest, undeflected_rates(mechanism, differentiable->design.list));
  std::vector<const Extents*> states{&rest};
  std::vector<const MatrixXd*> state_rates{&rest_rates};
  bool whole = moving;
  for (std::size_t k = 0; k < response.path.size() && whole; ++k) {
    if (const auto& extents = response.path[k].extents)
      states.push_back(&*extents);
    else
      whole = false;
    if (gradients) state_rates.push_back(&gradients->path[k].extents);
  }
  PathPoint found;
  PointGradients rates;
  if (still) {
    found.envelope = envelope_of({&rest});
    found.leaf_mass = leaf_mass(mechanism);
    if (gradients) {
      rates.envelope = envelope_rates({&rest}, {&rest_rates});
      rates.leaf_mass = leaf_mass_rate(mechanism, differentiable->design.list);
    }
  }
  if (whole) {
    found.moving_envelope = envelope_of(states);
    if (gradients) rates.moving_envelope = envelope_rates(states, state_rates);
  }
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    PathPoint& point = response.path[k];
    point.envelope = found.envelope;
    point.moving_envelope = found.moving_envelope;
    point.leaf_mass = found.leaf_mass;
    if (!gradients) continue;
    PointGradients& of = gradients->path[k];
    of.envelope = rates.envelope;
    of.moving_envelope = rates.moving_envelope;
    of.leaf_mass = rates.leaf_mass;
  }
}

// How many points converged, why others did not, and what the response says so far.
void summarise(StrokeResponse& response) {
  const std::string remark = std::move(response.message);
  const auto converged = static_cast<std::size_t>(
      std::ranges::count(response.path, PointStatus::converged, &PathPoint::status));
  if (converged == response.path.size()) {
    response.message = fmt::format("all {} stroke points converged", converged);
  } else {
    response.status = Status::no_equilibrium;
    response.message =
        fmt::format("{} of {} stroke points converged", converged, response.path.size());
    for (const PathPoint& p : response.path)
      if (p.status != PointStatus::converged && p.status != PointStatus::not_reached)
        response.message += "; " + p.message;
    const auto any = [&](PointStatus status) {
      return std::ranges::find(response.path, status, &PathPoint::status) != response.path.end();
    };
    if (any(PointStatus::left_branch) && !any(PointStatus::no_equilibrium))
      response.status = Status::left_branch;
    if (any(PointStatus::limit_reached)) response.status = Status::limit_reached;
  }
  const auto unstable =
      std::ranges::count_if(response.path, [](const PathPoint& p) { return !p.stable; });
  if (unstable > 0)
    response.message +=
        fmt::format("; {} of them {} unstable", unstable, unstable == 1 ? "is" : "are");
  const auto flutters =
      std::ranges::find_if(response.path, [](const PathPoint& p) { return p.flutter.has_value(); });
  if (flutters != response.path.end())
    response.message += fmt::format("; at {:.6g} {}", flutters->stroke, flutters->message);
  const auto passed = std::ranges::find(response.path, true, &PathPoint::bifurcation_passed);
  if (passed != response.path.end() && unstable == 0 && !passed->other_branch)
    response.message += "; " + passed->message;
  if (!remark.empty()) response.message += "; " + remark;
}

// Each critical load and each load capacity of a point is counted as one unit of work, as the point
// itself is.
StrokeProgress progress_of(const StrokeRequest& request, const StrokeResponse& response,
                           int iterations) {
  StrokeProgress progress{.iterations = iterations};
  const auto capacities = std::ranges::count(request.capacity.directions, true);
  const int each = 1 + (request.growing_load() ? 2 : 0) +
                   (request.wants_capacity() ? static_cast<int>(capacities) : 0);
  progress.total = each * static_cast<int>(response.path.size());
  for (const PathPoint& point : response.path) {
    progress.done += point.status != PointStatus::not_reached;
    if (const auto& buckling = point.buckling)
      for (const CriticalLoad* load : {&buckling->drive_locked, &buckling->drive_free})
        progress.done += load->factor || !load->reason.empty();
    for (const auto& capacity : point.load_capacity) progress.done += capacity.has_value();
  }
  return progress;
}

StrokeResponse evaluate(const Mechanism& mechanism, const ModelOptions& model,
                        const StrokeRequest& request, DifferentiablePath* differentiable) {
  StrokeResponse response;
  const std::vector<NamedNumber> numbers = named_numbers(request);
  for (std::size_t k = 0; k < request.points.size(); ++k) {
    PathPoint& point = response.path.emplace_back();
    point.stroke = request.points[k];
    point.numbers = numbers;
    if (mechanism.drives.size() > 1 ||
        (!mechanism.drives.empty() && !mechanism.drives[0].name.empty()))
      for (const Drive& drive : mechanism.drives) point.drive_names.push_back(drive.name);
    if (!request.loads.driven()) continue;
    const VectorXd strokes = request.strokes_at(k, mechanism.drives.size());
    point.strokes.assign(strokes.begin(), strokes.end());
  }
  Check kept = check_joints(mechanism);
  if (kept) kept = check_rules(request.loads, mechanism);
  for (const ElasticBody& body : mechanism.elastic_bodies) {
    if (kept) kept = check_rules(body, static_cast<int>(mechanism.bodies.size()));
    if (kept) kept = check_elastic(body);
  }
  if (kept && mechanism.drives.empty() && request.loads.driven() &&
      std::ranges::any_of(request.points, [](double stroke) { return stroke != 0; }))
    kept = Because("the mechanism has no drive that a stroke could prescribe");
  if (!kept) {
    response.status = Status::no_equilibrium;
    response.message = kept.error();
    for (PathPoint& point : response.path) point.message = response.message;
    return response;
  }
  std::function<void(int)> told;
  if (request.progress)
    told = [&](int iterations) { request.progress(progress_of(request, response, iterations)); };
  const LimitedWork limits(request.limits, told);
  bool cut_short = false;
  const bool path = request.outputs.need_path();
  if (path)
    cut_short =
        follow_ways(mechanism, model, request, ways_to_points(request), differentiable, response);
  if (path && request.outputs.has(Output::stress) && request.stress.need_history()) {
    StrokeGradients* gradients = gradients_of(differentiable);
    add_fatigue(mechanism, request.stress, gradients ? &differentiable->design.list : nullptr,
                response, gradients);
  }
  if (request.wants_frequency_derivatives()) try {
      add_frequency_derivatives(mechanism, model, request, differentiable, response);
    } catch (const WorkLimitReached& reached) {
      cut_short = true;
      miss_frequency_derivatives(reached.what(), response);
    }
  add_room_taken(mechanism, request, differentiable, response);
  if (request.wants_stroke_capacity() &&
      add_stroke_capacities(mechanism, model, request, differentiable, response)) {
    cut_short = true;
    response.message += response.message.empty() ? "" : "; ";
    response.message += "a limit of work ended the search for stroke capacities";
  }
  if (path)
    summarise(response);
  else if (request.outputs.has(Output::frequency_derivatives) &&
           response.frequency_derivatives.empty())
    response.status = Status::no_equilibrium;
  if (cut_short) response.status = Status::limit_reached;
  return response;
}

}  // namespace

Check has_derivatives(const ModelOptions& model, const LoadCase& loads) {
  if (loads.follow())
    return Because("loads that follow their bodies have no potential, and no exact derivatives");
  if (model.accuracy == Accuracy::full || model.method == Reduction::mixed_potential) return {};
  return Because("this method of reduction has no exact derivatives");
}

StrokeResponse evaluate_stroke(const Mechanism& mechanism, const ModelOptions& model,
                               const StrokeRequest& request) {
  DifferentiablePath shared;
  const bool differentiable =
      request.values == PathValues::differentiable && has_derivatives(model, request.loads);
  return evaluate(warmed(mechanism, request.loads), model, request,
                  differentiable ? &shared : nullptr);
}

MechanismDirection assembly_direction(std::string parameter, const Mechanism& mechanism,
                                      const AssemblyError& rate) {
  MechanismDirection direction{std::move(parameter), zero_rate(mechanism)};
  LeafSpring& leaf = direction.rate.leaves[rate.leaf];
  leaf.assembly_move[rate.end] = rate.move;
  leaf.assembly_turn[rate.end] = rate.turn;
  return direction;
}

StrokeSensitivity evaluate_stroke_gradients(const Mechanism& mechanism,
                                            const std::vector<MechanismDirection>& directions,
                                            const ModelOptions& model,
                                            const StrokeRequest& request) {
  StrokeSensitivity result;
  Mechanism own = warmed(mechanism, request.loads);
  // drives whose axes a parameter turns are conditions
  for (const MechanismDirection& d : directions)
    for (std::size_t k = 0; k < own.drives.size(); ++k)
      own.drives[k].axes_change |= !d.rate.drives[k].axes.isZero(0);
  if (Check has = has_derivatives(model, request.loads); !has) {
    result.response = evaluate_stroke(own, model, request);
    result.message = std::move(has.error());
    return result;
  }
  DifferentiablePath shared;
  std::vector<Mechanism> rates;
  for (const MechanismDirection& d : directions) {
    shared.gradients.parameters.push_back(d.parameter);
    rates.push_back(d.rate);
  }
  shared.design = DesignDirections(mechanism, std::move(rates));
  shared.gradients.path.resize(request.points.size());
  result.response = evaluate(own, model, request, &shared);
  result.gradients = std::move(shared.gradients);
  return result;
}

}  // namespace flexopt
