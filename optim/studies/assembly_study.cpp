#include "optim/studies/assembly_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/response/quantities.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/problem/worst_assembly_goals.hpp"
#include "optim/solvers/central_differences.hpp"
#include "optim/solvers/problem.hpp"
#include "optim/solvers/unit_points.hpp"

namespace flexopt {
namespace {

// A box of so many errors has few corners: all are looked at.
constexpr int few_sides = 4;
constexpr int most_steps = 40;  // of the search from one start

// Places of the box that far apart are two, and two values that near are the same.
constexpr double same_place = 1e-2, as_bad_as = 1e-7;

// Search for a critical scale: the number of rounds that look for the pattern anew, the relative
// difference of scales that count as equal, and the accuracy of the scale.
constexpr int most_rounds = 4;
constexpr double same_scale = 1e-3, scale_accuracy = 1e-7;
// Far beyond a bifurcation Newton's method may find a branch that is stable again.
constexpr double growth = 1.2;

/// A number that is worse the larger it is.
struct Reading {
  bool ok = false;
  bool unstable = false;  ///< or without equilibrium: beyond everything
  double value = 0;
  GoalPlace place;
  std::string what;  ///< which number it is, of several
};
/// Paths of all load cases; empty for those that were not asked for.
using Paths = std::vector<StrokeResponse>;
struct Read {
  std::function<Reading(const Paths&)> of;
  std::vector<std::size_t> cases;  ///< which it needs
};

class Box {
 public:
  Box(const Job& job, const ParameterValues& parameters, const ModelOptions& model,
      const PathsSoFar& progress);

  int size() const { return box_.size(); }
  int evaluations() const { return evaluations_; }
  bool spent() const { return evaluations_ >= spec_.max_paths.value_or(evaluations_ + 1); }
  std::string limit() const {
    return fmt::format("ended by its limit of {} paths", spec_.max_paths.value_or(0));
  }
  std::vector<AssemblyError> errors(const VectorXd& z) const { return box_.errors(z); }
  /// Index of the named load case; of all where there is no name.
  std::vector<std::size_t> cases_named(const std::string& name = "") const;
  Paths evaluate(const VectorXd& z, const std::vector<std::size_t>& cases);
  /// Reading at the errors z, each −1 … 1, of the box times `scale`.
  Reading read(const VectorXd& z, double scale, const Read& of);
  /// Derivatives of the reading along z, by central differences; nothing where one of these has no
  /// value.
  std::optional<VectorXd> gradient(const VectorXd& z, const Reading& here, double scale,
                                   const Read& of);
  /// The largest value that is found, from the gradients' corner and the starts; with `corner`, of
  /// a box of few sides, all its corners too.
  std::pair<VectorXd, Reading> worst(double scale, const Read& of, const VectorXd& start,
                                     std::optional<double>* corner,
                                     std::vector<VectorXd>* as_bad = nullptr);

 private:
  AssemblyBox box_;
  AssemblyTolerances spec_;
  ModelOptions model_;
  Mechanism mechanism_;
  std::vector<JobCase> cases_;
  PathsSoFar progress_;
  int evaluations_ = 0;
};

Box::Box(const Job& job, const ParameterValues& parameters, const ModelOptions& model,
         const PathsSoFar& progress)
    : box_(*job.assembly_tolerances),
      spec_(*job.assembly_tolerances),
      model_(model),
      mechanism_(make_mechanism(job, parameters)),
      cases_(cases_of(job)),
      progress_(progress) {
  for (JobCase& one : cases_) {
    one.request.outputs = {Output::equilibrium};
    for (const Constraint& c : spec_.quantities)
      for (const std::string& name : c.quantities()) one.request.outputs.add(needs_of(name));
    if (spec_.wants_critical()) one.request.outputs.add(Output::stiffness);
  }
}

std::vector<std::size_t> Box::cases_named(const std::string& name) const {
  std::vector<std::size_t> named;
  for (std::size_t k = 0; k < cases_.size(); ++k)
    if (name.empty() || cases_[k].name == name) named.push_back(k);
  return named;
}

Paths Box::evaluate(const VectorXd& z, const std::vector<std::size_t>& cases) {
  Paths found(cases_.size());
  for (const std::size_t k : cases) {
    if (progress_) progress_(evaluations_);
    ++evaluations_;
    found[k] = evaluate_stroke(mechanism_, model_, box_.with_errors(cases_[k].request, z));
  }
  return found;
}

Reading Box::read(const VectorXd& z, double scale, const Read& of) {
  if (spent()) return {.what = limit()};
  const Paths found = evaluate(scale * z, of.cases);
  for (const std::size_t k : of.cases)
    for (const PathPoint& point : found[k].path)
      if (point.status != PointStatus::converged || !point.stable || point.bifurcation_passed) {
        Reading reading;
        reading.unstable = true;
        reading.place = {k, static_cast<std::size_t>(&point - found[k].path.data())};
        reading.what = point.status != PointStatus::converged || point.stable
                           ? point.message
                           : "the mechanism is unstable";
        return reading;
      }
  return of.of(found);
}

std::optional<VectorXd> Box::gradient(const VectorXd& z, const Reading& here, double scale,
                                      const Read& of) {
  const auto values = [&](const std::vector<VectorXd>& x) {
    std::vector<std::optional<VectorXd>> answers;
    for (const VectorXd& one : x) {
      const Reading r = read((2 * one.array() - 1).matrix(), scale, of);
      answers.push_back(r.ok ? std::optional(VectorXd(VectorXd::Constant(1, r.value)))
                             : std::nullopt);
    }
    return answers;
  };
  const auto rates = central_differences(values, (0.5 * (z.array() + 1)).matrix(),
                                         VectorXd::Constant(1, here.value));
  if (!rates) return std::nullopt;
  return VectorXd(0.5 * rates->row(0).transpose());
}

std::pair<VectorXd, Reading> Box::worst(double scale, const Read& of, const VectorXd& start,
                                        std::optional<double>* corner,
                                        std::vector<VectorXd>* as_bad) {
  std::pair<VectorXd, Reading> best{start, {}};
  std::vector<std::pair<VectorXd, double>> all;
  const auto keep = [&](const VectorXd& z, const Reading& r) {
    if (as_bad && r.ok) all.emplace_back(z, r.value);
    const bool better = r.unstable ? !best.second.unstable
                                   : r.ok && !best.second.unstable &&
                                         (!best.second.ok || r.value > best.second.value);
    if (better) best = {z, r};
  };
  Problem problem;
  problem.lower = VectorXd::Constant(size(), -1);
  problem.upper = VectorXd::Constant(size(), 1);
  double unit = 1;
  problem.evaluate = [&](const VectorXd& z, bool differentiated) {
    const Reading r = read(z, scale, of);
    keep(z, r);
    Problem::Value value;
    value.ok = r.ok;
    value.enough = r.unstable || spent();
    value.f = -r.value / unit;
    if (!r.ok || !differentiated) return value;
    const auto rates = gradient(z, r, scale, of);
    value.ok = rates.has_value();
    if (rates) value.df = -*rates / unit;
    return value;
  };
  const std::vector<VectorXd> spread = sobol_points(size(), spec_.starts, spec_.seed);
  for (int k = 0; k < spec_.starts && !best.second.unstable && !spent(); ++k) {
    // the first start is the middle, or what is known
    VectorXd from = start;
    if (k > 0) from = (2 * spread[k].array() - 1).matrix();
    const Reading here = read(from, scale, of);
    keep(from, here);
    if (!here.ok) continue;
    unit = std::max(std::abs(here.value), 1e-300);
    const auto rates = gradient(from, here, scale, of);
    if (!rates) continue;
    VectorXd to = from;
    for (Eigen::Index i = 0; i < to.size(); ++i)
      if ((*rates)[i] != 0) to[i] = (*rates)[i] > 0 ? 1 : -1;
    const Reading there = read(to, scale, of);
    keep(to, there);
    if (k == 0 && corner && there.ok) *corner = there.value;
    OptimiserOptions options;
    options.name = "LD_SLSQP";
    options.max_evaluations = most_steps;
    options.tolerance = 1e-6;
    if (!best.second.unstable && !spent())
      minimise(problem, there.ok && there.value > here.value ? to : from, options);
  }
  // where several ends are as bad but for little, a search may take any of them
  if (corner && size() <= few_sides)
    for (int k = 0; k < 1 << size() && !best.second.unstable && !spent(); ++k) {
      VectorXd z(size());
      for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = k >> i & 1 ? 1 : -1;
      keep(z, read(z, scale, of));
    }
  for (const auto& [z, value] : all) {
    const auto elsewhere = [&, &z = z](const VectorXd& known) {
      return (known - z).cwiseAbs().maxCoeff() > same_place;
    };
    if (value >= best.second.value - as_bad_as * std::abs(best.second.value) &&
        elsewhere(best.first) && std::ranges::all_of(*as_bad, elsewhere))
      as_bad->push_back(z);
  }
  return best;
}

/// Which side of a quantity is the worse one.
double side_of(const Constraint& of) { return of.min ? -1 : 1; }

/// The number of a quantity or a formula at a point of a path.
using NumberAt = std::function<std::optional<double>(const PathPoint&)>;

/// The worst over the stroke of a quantity, and over these load cases, its worse side up.
Reading read_worst(const Paths& found, const Constraint& of, const NumberAt& number,
                   const std::vector<std::size_t>& cases) {
  Reading reading;
  for (const std::size_t k : cases) {
    const std::vector<PathPoint>& path = found[k].path;
    for (std::size_t i = 0; i < path.size(); ++i) {
      if ((of.over_stroke == OverStroke::first && i > 0) ||
          (of.over_stroke == OverStroke::last && i + 1 < path.size()))
        continue;
      const auto value = number(path[i]);
      if (!value) return {.what = fmt::format("{} has no value at point {}", of.name(), i)};
      double side = side_of(of);
      if (of.over_stroke == OverStroke::max_abs && *value < 0) side = -1;
      if (reading.ok && side * *value <= reading.value) continue;
      reading = {true, false, side * *value, {k, i}, {}};
    }
  }
  return reading;
}

/// How far beyond what is critical, in any load case: above zero beyond it.
Reading read_critical(const Paths& found, const Paths& nominal, const AssemblyTolerances& spec) {
  Reading reading;
  const auto take = [&](double value, GoalPlace place, std::string what) {
    if (!reading.ok || value > reading.value)
      reading = {true, false, value, place, std::move(what)};
  };
  for (std::size_t c = 0; c < found.size(); ++c) {
    double largest = 0;
    for (const PathPoint& p : nominal[c].path) largest = std::max(largest, std::abs(p.drive_load));
    for (std::size_t k = 0; k < found[c].path.size(); ++k) {
      const PathPoint &now = found[c].path[k], &then = nominal[c].path[k];
      for (std::size_t d = 0; spec.stiffness_share && d < 6; ++d)
        if (now.support_stiffness[d] && then.support_stiffness[d])
          take(*spec.stiffness_share * *then.support_stiffness[d] / *now.support_stiffness[d] - 1,
               {c, k},
               fmt::format("support_stiffness.{} falls to {:g} of its value", direction_names[d],
                           *spec.stiffness_share));
      if (!spec.drive_load_change || largest == 0) continue;
      take(std::abs(now.drive_load - then.drive_load) / (*spec.drive_load_change * largest) - 1,
           {c, k},
           fmt::format("drive_load changes by {:g} of its largest value", *spec.drive_load_change));
    }
  }
  return reading;
}

WorstAssembly worst_of(Box& box, const Constraint& of, const NumberAt& number,
                       const Paths& nominal) {
  WorstAssembly result;
  result.of = of;
  const int before = box.evaluations();
  const std::vector<std::size_t> cases = box.cases_named(of.load_case);
  const Reading plain = read_worst(nominal, of, number, cases);
  const double side = side_of(of);
  if (!plain.ok) {
    result.reason = plain.what;
    return result;
  }
  result.nominal = side * plain.value;
  const Read read{[&](const Paths& found) { return read_worst(found, of, number, cases); }, cases};
  std::vector<VectorXd> as_bad;
  const auto [z, reading] = box.worst(1, read, VectorXd::Zero(box.size()), &result.corner, &as_bad);
  if (result.corner) *result.corner *= side;
  result.evaluations = box.evaluations() - before;
  result.misalignment = box.errors(z);
  for (const VectorXd& other : as_bad) result.as_bad.push_back(box.errors(other));
  result.place = reading.place;
  if (reading.ok) result.worst = side * reading.value;
  result.reason = box.spent() ? box.limit() : reading.ok ? "" : reading.what;
  return result;
}

/// Largest part of a scale, from 0, that is within along a pattern; where it ends, what was read.
std::pair<double, Reading> end_along(Box& box, const Read& of, const VectorXd& z, double from,
                                     double largest) {
  const auto beyond = [](const Reading& r) { return r.unstable || (r.ok && r.value > 0); };
  double low = 0, high = std::min(from, largest);
  Reading at_low = box.read(z, 0, of), at_high = box.read(z, high, of);
  while (!beyond(at_high) && high < largest && !box.spent()) {
    low = high;
    at_low = at_high;
    high = std::min(growth * high, largest);
    at_high = box.read(z, high, of);
  }
  if (!beyond(at_high))
    return {box.spent() ? low : largest, {.what = box.spent() ? box.limit() : ""}};
  double below = at_low.ok ? at_low.value : 0;
  double above = at_high.ok ? at_high.value : 0;
  int last = 0;
  while (high - low > scale_accuracy * high && !box.spent()) {
    // regula falsi in the Illinois way; halves where one end is unstable
    double middle = 0.5 * (low + high);
    if (at_high.ok && below < 0 && above > 0)
      middle = (low * above - high * below) / (above - below);
    const Reading here = box.read(z, middle, of);
    if (here.ok && std::abs(here.value) < scale_accuracy) return {middle, here};
    const int side = beyond(here) ? 1 : -1;
    (side > 0 ? high : low) = middle;
    if (side > 0) at_high = here;
    (side > 0 ? above : below) = here.ok ? here.value : 0;
    if (side == last) (side > 0 ? below : above) *= 0.5;
    last = side;
  }
  return {high, at_high};
}

CriticalAssembly critical_of(Box& box, const AssemblyTolerances& spec, const Paths& nominal) {
  CriticalAssembly result;
  const int before = box.evaluations();
  const Read of{[&](const Paths& found) { return read_critical(found, nominal, spec); },
                box.cases_named()};
  result.scale = spec.largest_scale;
  result.limit = "none";
  VectorXd pattern = VectorXd::Zero(box.size());
  double scale = std::min(1.0, spec.largest_scale), within = 0;
  for (int round = 0; round < most_rounds; ++round) {
    const auto [z, reading] = box.worst(scale, of, pattern, nullptr);
    if (!reading.ok && !reading.unstable) {
      if (!box.spent()) result.text = reading.what;
      break;
    }
    const auto [end, there] = end_along(box, of, z, scale, spec.largest_scale);
    within = end;
    if (box.spent() && !there.ok && !there.unstable) break;
    const bool smaller = end < result.scale;
    const bool same = std::abs(end - result.scale) < same_scale * end;
    if (smaller) {
      result.scale = end;
      result.misalignment = box.errors(end * z);
      result.place = there.place;
      result.text = there.what;
      result.limit = there.unstable                         ? "instability"
                     : there.what.starts_with("drive_load") ? "drive_load"
                                                            : "stiffness";
    }
    if (same || (!smaller && round > 0)) break;
    pattern = z;
    scale = end;
  }
  if (box.spent() && result.limit == "none") result.scale = within;
  if (result.text.empty())
    result.text = fmt::format("nothing critical up to {:g} times the box", result.scale);
  if (box.spent()) result.text += "; " + box.limit();
  result.evaluations = box.evaluations() - before;
  return result;
}

}  // namespace

int most_paths(const Job& job) {
  const AssemblyTolerances& spec = *job.assembly_tolerances;
  const int sides = AssemblyBox(spec).size(), cases = static_cast<int>(cases_of(job).size());
  const int start = 2 + 2 * sides + most_steps * (1 + 2 * sides);
  const int searches =
      static_cast<int>(spec.quantities.size()) + (spec.wants_critical() ? most_rounds : 0);
  const double paths =
      cases * (1 + searches * (1.0 * spec.starts * start + (sides <= few_sides ? 1 << sides : 0)));
  constexpr int countable = 1'000'000'000;
  return static_cast<int>(std::min<double>(paths, spec.max_paths.value_or(countable)));
}

AssemblyReport study_assembly(const Job& job, const ParameterValues& parameters,
                              const ModelOptions& model, const PathsSoFar& progress) {
  AssemblyReport report;
  const AssemblyTolerances& spec = *job.assembly_tolerances;
  Box box(job, parameters, model, progress);
  const Paths nominal = box.evaluate(VectorXd::Zero(box.size()), box.cases_named());
  for (const StrokeResponse& one : nominal)
    if (one.status != Status::ok) {
      report.message = one.message;
      return report;
    }
  const ParameterValues numbers = complete_numbers(job, parameters);
  for (const Constraint& of : spec.quantities) {
    NumberAt number = [&](const PathPoint& point) { return value_of(point, of.quantity); };
    if (!of.expression.empty())
      number = [&, formula = goal_formula(job, of.expression)](const PathPoint& point) {
        return formula.value(point, numbers);
      };
    report.quantities.push_back(worst_of(box, of, number, nominal));
  }
  if (spec.wants_critical()) report.critical = critical_of(box, spec, nominal);
  return report;
}

}  // namespace flexopt
