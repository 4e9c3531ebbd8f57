#include "optim/problem/goals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "core/response/path/frequency_derivatives.hpp"
#include "core/response/quantities.hpp"
#include "optim/job/job_numbers.hpp"

namespace flexopt {
namespace {

constexpr int stress_branches = 6;  // two ends of a leaf and its surfaces, of two kinds of leaves
constexpr int most_branches = 3;  // two modes cross at a point of the path; the third is a reserve

constexpr double clearance_without_pairs = 1;  // [m]: more than any bound asks for

constexpr double endless_bandwidth = 1e6;  // [Hz]: more than any bound asks for

// What a quantity counts as where there is nothing that it could be: no mode that the drive feels
// beside its own, no pair that can touch, no load, but for a reversed one, at which the tangent is
// singular (as far as it was followed, where that is known); no stress to speak of; no limit of a
// load, or end of a line, as far as it was followed, which counts as that.
std::optional<double> value_of_nothing(const PathPoint& point, const std::string& quantity) {
  if (quantity == "clearance")
    return point.clearance ? std::nullopt : std::optional(clearance_without_pairs);
  if (quantity == "yield_safety")
    return point.fillet_fault.empty() ? std::optional(no_critical_factor) : std::nullopt;
  if (quantity == "fatigue_safety" || quantity == "fatigue_life") {
    if (!point.fillet_fault.empty() || !point.fatigue_fault.empty() || point.fatigue_life)
      return std::nullopt;
    return quantity == "fatigue_life" ? longest_life : no_critical_factor;
  }
  if (const auto bound = at_least(point, quantity)) return bound;
  const bool of_drive = quantity == "bandwidth" || quantity.starts_with("bandwidth.");
  if (of_drive || quantity.starts_with("transfer_bandwidth.")) {
    const bool endless = of_drive ? !point.bandwidths.empty() : !point.transfers.empty();
    return endless && why_missing(point, quantity).empty() ? std::optional(endless_bandwidth)
                                                           : std::nullopt;
  }
  if (!point.buckling) return std::nullopt;
  const CriticalLoad& load =
      quantity == "buckling.drive_free" ? point.buckling->drive_free : point.buckling->drive_locked;
  const bool asked = quantity == "buckling_load_factor" || quantity.starts_with("buckling.");
  const bool never = load.none || load.factor.value_or(0) < 0;
  return asked && never ? std::optional(no_critical_factor) : std::nullopt;
}

// The quantities whose lowest over the stroke is that of several modes.
bool is_lowest_of_modes(const std::string& quantity) {
  return quantity == "parasitic_frequency" || quantity == "parasitic_frequency_screening";
}

/// Every load case, or the one that is named.
std::vector<GoalPart> parts_of(const Job& job, const std::string& load_case) {
  std::vector<GoalPart> parts;
  const std::vector<JobCase> cases = cases_of(job);
  for (std::size_t k = 0; k < cases.size(); ++k)
    if (load_case.empty() || cases[k].name == load_case)
      parts.push_back({k, cases[k].request.points.size()});
  return parts;
}

/// The goal of an objective or a constraint.
Goal make_goal(const Job& job, const std::string& label, const Constraint& asked, bool least,
               const std::string& pointer) {
  Goal goal{.label = label,
            .quantity = asked.quantity,
            .over_stroke = asked.over_stroke,
            .least = least,
            .margin = asked.margin,
            .worst_assembly = asked.worst_assembly};
  if (!asked.expression.empty()) goal.expression = goal_formula(job, asked.expression, pointer);
  if (!goal.of_parameters()) goal.parts = parts_of(job, asked.load_case);
  if (asked.of_design())
    goal.over_stroke = OverStroke::first;  // one number, one row
  else if (is_lowest_of_modes(goal.quantity) && goal.over_stroke == OverStroke::min)
    goal.branches = std::clamp(job.request.frequencies, 1, most_branches);
  return goal;
}

bool locked(const StrokeRequest& request) { return request.parasitic.drive == DriveState::locked; }

/// A value that counts at a point, and its derivatives where they are known.
struct PointValue {
  double value = 0;
  std::optional<VectorXd> gradient;
};

/// A row of derivatives; nothing where they are missing.
std::optional<VectorXd> row_of(const MatrixXd& rows, std::size_t index) {
  const auto row = static_cast<Eigen::Index>(index);
  return row < rows.rows() ? std::optional<VectorXd>(rows.row(row)) : std::nullopt;
}

/// The path that a goal is read from. `gradients`: null where derivatives are not wanted.
struct ReadPath {
  const StrokeResponse& response;
  const StrokeRequest& request;
  const StrokeGradients* gradients = nullptr;
};

/// Candidates of a quantity at a point that has a value, the worst first: as many as the goal
/// wants, or fewer.
std::vector<PointValue> candidates(const std::string& quantity, int branches, const ReadPath& path,
                                   const PathPoint& point, double value) {
  const StrokeRequest& request = path.request;
  const StrokeGradients* all = path.gradients;
  const std::ptrdiff_t index = &point - path.response.path.data();
  const PointGradients* gradients = all ? &all->path[index] : nullptr;
  std::vector<PointValue> found;
  const auto add = [&](double of, auto gradient) {
    if (found.size() == static_cast<std::size_t>(branches)) return;
    found.push_back({of, gradients ? gradient() : std::optional<VectorXd>()});
  };
  if (branches > 1 && quantity == "max_stress") {
    for (std::size_t k = 0; k < point.stress_peaks.size(); ++k)
      add(point.stress_peaks[k].value, [&] { return row_of(gradients->stress_peaks, k); });
  } else if (branches > 1 && quantity == "parasitic_frequency_screening") {
    const auto [modes, slopes, at] = modes_to_point(path.response, all, point).value();
    for (const ScreeningFrequency& f : screening_frequencies(*modes, request.parasitic, at))
      add(f.value, [&, modes = modes, slopes = slopes, at = at]() -> std::optional<VectorXd> {
        if (!slopes) return std::nullopt;
        return screening_gradient((*modes)[f.mode], (*slopes)[f.mode], at);
      });
  } else if (branches > 1 && quantity == "parasitic_frequency") {
    // it is the frequency of the first mode that counts
    const std::vector<Mode>& modes = locked(request) ? point.modes_locked : point.modes_free;
    for (std::size_t k = 0; k < modes.size(); ++k)
      if (request.parasitic.admits(modes[k].kind))
        add(modes[k].frequency, [&] {
          return row_of(
              locked(request) ? gradients->frequencies_locked : gradients->frequencies_free, k);
        });
  }
  if (found.empty()) add(value, [&] { return gradient_of(point, *gradients, quantity); });
  return found;
}

/// What counts of a quantity at a point.
Answer<std::vector<PointValue>, Why> values_at(const std::string& quantity, int branches,
                                               const ReadPath& path, const PathPoint& point) {
  const std::optional<double> value = value_of(point, quantity);
  const std::optional<double> nothing =
      value.value_or(-1) < 0 ? value_of_nothing(point, quantity) : std::nullopt;
  if (nothing) {
    PointValue counts{*nothing, {}};
    if (const StrokeGradients* all = path.gradients) {
      counts.gradient = VectorXd::Zero(std::ssize(all->parameters));
      // how far a search came moves with the design; the largest load that is looked at does not
      if (quantity.starts_with("load_capacity."))
        counts.gradient =
            gradient_of(point, all->path[&point - path.response.path.data()], quantity);
    }
    return std::vector{std::move(counts)};
  }
  if (value && std::isfinite(*value)) return candidates(quantity, branches, path, point, *value);
  const std::string reason = fmt::format("{} has no value", quantity);
  const std::string why = why_missing(point, quantity);
  return BecauseOf(
      {fmt::format("{} at stroke {:.6g}{}{}", reason, point.stroke, why.empty() ? "" : ": ", why),
       reason});
}

/// The derivatives of a formula by the chain rule; nothing where one of them is missing.
std::optional<VectorXd> chained(const Expression& formula, const ParameterValues& numbers,
                                const std::map<std::string, PointValue>& terms,
                                const std::vector<std::string>& parameters) {
  const std::optional<VectorXd> slopes = formula.gradient(numbers);
  if (!slopes) return std::nullopt;
  VectorXd sum = VectorXd::Zero(std::ssize(parameters));
  for (Eigen::Index i = 0; i < slopes->size(); ++i) {
    const std::string& name = formula.names()[static_cast<std::size_t>(i)];
    if (const auto term = terms.find(name); term != terms.end()) {
      if (!term->second.gradient) return std::nullopt;
      sum += (*slopes)[i] * *term->second.gradient;
    } else if (const auto at = std::ranges::find(parameters, name); at != parameters.end()) {
      sum[at - parameters.begin()] += (*slopes)[i];
    }
  }
  return sum;
}

/// Below these the values of a formula's quantities are rounding, beside others of the path.
std::vector<double> rounding_of_terms(const Expression& formula, const StrokeResponse& response) {
  std::vector<double> rounding;
  for (const std::string& quantity : formula.quantities()) {
    double largest = 0;
    for (const PathPoint& point : response.path)
      largest = std::max(largest, std::abs(value_of(point, quantity).value_or(0)));
    rounding.push_back(1e-12 * largest);
  }
  return rounding;
}

/// What counts of a formula at a point. `numbers`: the parameters, which get the quantities there;
/// one that is rounding counts as zero, so that nothing is divided by it.
Answer<std::vector<PointValue>, Why> values_at(const Expression& formula,
                                               const std::vector<double>& rounding,
                                               const ReadPath& path, const PathPoint& point,
                                               ParameterValues& numbers) {
  std::map<std::string, PointValue> terms;
  for (std::size_t k = 0; k < rounding.size(); ++k) {
    const std::string& quantity = formula.quantities()[k];
    auto found = values_at(quantity, 1, path, point);
    if (!found) return BecauseOf(found.error());
    const double value = found->front().value;
    numbers[quantity] = std::abs(value) < rounding[k] ? 0 : value;
    terms[quantity] = std::move(found->front());
  }
  const std::optional<double> value = formula.value(numbers);
  if (!value) {
    const std::string reason = fmt::format("{} is not finite", formula.text());
    return BecauseOf({fmt::format("{} at stroke {:.6g}", reason, point.stroke), reason});
  }
  PointValue one{*value, {}};
  if (path.gradients) one.gradient = chained(formula, numbers, terms, path.gradients->parameters);
  return std::vector{std::move(one)};
}

/// Whether a point has an equilibrium whose numbers count.
Answer<void, Why> check_point(const PathPoint& point, const StrokeResponse& response,
                              const StrokeRequest& request) {
  const bool path = request.outputs.need_path();
  if (path && point.status != PointStatus::converged) {
    const std::string& why = point.message.empty() ? response.message : point.message;
    if (response.status == Status::limit_reached)
      return BecauseOf({fmt::format("limit reached: {}", why), "limit reached"});
    return BecauseOf({fmt::format("no equilibrium at stroke {:.6g}{}{}", point.stroke,
                                  why.empty() ? "" : ": ", why),
                      "no equilibrium"});
  }
  if (response.status == Status::limit_reached && request.wants_stroke_capacity())
    return BecauseOf({fmt::format("limit reached: {}", response.message), "limit reached"});
  const bool unstable = path && !point.stable;
  if (!unstable && !(point.bifurcation_passed && request.branch == BranchChoice::primary))
    return {};
  const char* const beyond = "beyond a bifurcation";
  return BecauseOf({fmt::format("the equilibrium at stroke {:.6g} is {}", point.stroke,
                                unstable ? "unstable" : beyond),
                    unstable ? "unstable equilibrium" : beyond});
}

/// Extreme among the values first, first + 1, …, last − 1.
Extreme extreme_within(const Goal& goal, const GoalValues& values, std::size_t first,
                       std::size_t last) {
  const auto stride = static_cast<std::size_t>(goal.branches);
  Extreme best{first, 1};
  if (goal.over_stroke == OverStroke::last) best.entry = last - stride;
  const auto rank = [&](std::size_t i) {
    return goal.over_stroke == OverStroke::min       ? -values[i]
           : goal.over_stroke == OverStroke::max     ? values[i]
           : goal.over_stroke == OverStroke::max_abs ? std::abs(values[i])
                                                     : 0.0;
  };
  for (std::size_t i = first; i < last; i += stride)
    if (rank(i) > rank(best.entry)) best.entry = i;
  if (goal.over_stroke == OverStroke::max_abs && values[best.entry] < 0) best.sign = -1;
  return best;
}

}  // namespace

std::vector<Goal> make_goals(const Job& job) {
  assert(job.optimise);
  const OptimiseSpec& spec = *job.optimise;
  std::vector<Goal> goals{
      make_goal(job, "objective", spec.objective, spec.objective.maximise, "/optimise/objective")};
  for (std::size_t i = 0; i < spec.constraints.size(); ++i) {
    const Constraint& c = spec.constraints[i];
    const bool front = !c.min && !c.max && spec.pareto;  // the second objective of a front
    goals.push_back(make_goal(job, c.label, c, front ? spec.pareto->maximise : c.min.has_value(),
                              fmt::format("/optimise/constraints/{}", i)));
  }
  return goals;
}

void add_stress_branches(std::vector<Goal>& goals, StrokeRequest& request) {
  for (Goal& goal : goals)
    if (goal.quantity == "max_stress" && goal.over_stroke == OverStroke::max)
      goal.branches = request.stress_peaks = stress_branches;
}

StrokeRequest request_of_goals(const Job& job, const std::vector<Goal>& goals,
                               std::size_t load_case) {
  StrokeRequest request = job.cases.empty() ? job.request : job.cases[load_case].request;
  request.outputs = {};
  for (const Goal& goal : goals)
    if (std::ranges::find(goal.parts, load_case, &GoalPart::load_case) != goal.parts.end())
      for (const std::string& quantity : goal.quantities()) request.outputs.add(needs_of(quantity));
  return request;
}

int frequencies_needed(const std::vector<Goal>& goals, const StrokeRequest& request) {
  // with the drive held no mode is one of the drive's
  const bool lowest_count = locked(request) && request.parasitic.skipped.empty();
  for (const Goal& goal : goals)
    for (const std::string& quantity : goal.quantities()) {
      if (quantity == "parasitic_frequency" && lowest_count) continue;
      if (needs_of(quantity).need_frequencies()) return request.frequencies;
    }
  return std::min(request.frequencies, most_branches);
}

Eigen::Index DesignValues::first(std::size_t goal) const {
  Eigen::Index row = 0;
  for (std::size_t g = 0; g < goal; ++g) row += std::ssize(goals[g]);
  return row;
}

std::size_t Goal::points() const {
  if (of_parameters()) return 1;
  std::size_t count = 0;
  for (const GoalPart& part : parts) count += part.points;
  return count;
}

Answer<GoalReading, Why> read_goal(const Goal& goal, const StrokeResponse& response,
                                   const StrokeRequest& request, const StrokeGradients* gradients,
                                   const ParameterValues& parameters) {
  GoalReading reading;
  bool differentiated = gradients && gradients->path.size() == response.path.size();
  const ReadPath path{response, request, differentiated ? gradients : nullptr};
  if (differentiated) reading.parameters = gradients->parameters;
  ParameterValues numbers = goal.expression ? parameters : ParameterValues();
  std::vector<double> rounding;
  if (goal.expression) rounding = rounding_of_terms(*goal.expression, response);
  for (const PathPoint& point : response.path) {
    if (auto counts = check_point(point, response, request); !counts)
      return BecauseOf(counts.error());
    const auto found = goal.expression ? values_at(*goal.expression, rounding, path, point, numbers)
                                       : values_at(goal.quantity, goal.branches, path, point);
    if (!found) return BecauseOf(found.error());
    for (std::size_t k = 0; k < static_cast<std::size_t>(goal.branches); ++k) {
      const PointValue& one = (*found)[std::min(k, found->size() - 1)];  // the last one repeated
      reading.values.push_back(one.value);
      differentiated = differentiated && one.gradient;
      if (differentiated) append_rows(reading.gradient, one.gradient->transpose());
    }
  }
  if (!differentiated) reading.gradient.resize(0, 0);
  if (response.path.size() != request.points.size() || response.path.empty())
    return BecauseOf({fmt::format("{} of {} stroke points came back: {}", response.path.size(),
                                  request.points.size(), response.message),
                      "no equilibrium"});
  return reading;
}

void add_defined_quantities(const Job& job, ParameterValues numbers, StrokeResponse& response,
                            StrokeGradients* gradients) {
  const ReadPath path{response, job.request, gradients};
  for (const auto& [name, formula] : job.quantities) {
    const std::vector<double> rounding = rounding_of_terms(*formula, response);
    for (PathPoint& point : response.path) {
      const auto known = [&](const std::string& term) { return value_of(point, term).has_value(); };
      std::optional<PointValue> one;
      if (std::ranges::all_of(formula->quantities(), known))
        if (auto found = values_at(*formula, rounding, path, point, numbers)) one = found->front();
      point.named_quantities.push_back({name, one ? std::optional(one->value) : std::nullopt});
      if (gradients)
        gradients->path[static_cast<std::size_t>(&point - response.path.data())]
            .named_quantities.push_back(one ? one->gradient : std::nullopt);
    }
  }
}

Extreme extreme(const Goal& goal, const GoalValues& values, std::size_t part) {
  const auto stride = static_cast<std::size_t>(goal.branches);
  std::size_t first = 0;
  for (std::size_t k = 0; k < part; ++k) first += goal.parts[k].points * stride;
  return extreme_within(goal, values, first, first + goal.parts[part].points * stride);
}

Extreme extreme(const Goal& goal, const GoalValues& values) {
  assert(!values.empty() && values.size() % static_cast<std::size_t>(goal.branches) == 0);
  if (goal.parts.size() < 2) return extreme_within(goal, values, 0, values.size());
  const auto number = [&](const Extreme& e) { return e.sign * values[e.entry]; };
  Extreme worst = extreme(goal, values, 0);
  for (std::size_t k = 1; k < goal.parts.size(); ++k) {
    const Extreme here = extreme(goal, values, k);
    if (goal.least ? number(here) < number(worst) : number(here) > number(worst)) worst = here;
  }
  return worst;
}

GoalPlace place_of(const Goal& goal, std::size_t entry) {
  assert(!goal.of_parameters());
  std::size_t point = entry / static_cast<std::size_t>(goal.branches);
  for (const GoalPart& part : goal.parts) {
    if (point < part.points) return {part.load_case, point};
    point -= part.points;
  }
  return {0, point};
}

std::optional<double> stroke_reached(const StrokeResponse& response) {
  const auto failed = std::ranges::find_if(response.path, [](const PathPoint& point) {
    return point.status != PointStatus::converged && point.status != PointStatus::not_reached;
  });
  std::optional<double> nearest;
  if (failed == response.path.end()) return nearest;
  const auto distance = [&](double stroke) { return std::abs(stroke - failed->stroke); };
  for (const PathPoint& point : response.path)
    if (point.status == PointStatus::converged &&
        (!nearest || distance(point.stroke) < distance(*nearest)))
      nearest = point.stroke;
  return nearest;
}

double aggregate(const Goal& goal, const GoalValues& values) {
  const Extreme e = extreme(goal, values);
  return e.sign * values[e.entry];
}

}  // namespace flexopt
