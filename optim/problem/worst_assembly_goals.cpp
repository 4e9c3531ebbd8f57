#include "optim/problem/worst_assembly_goals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "optim/solvers/central_differences.hpp"

namespace flexopt {

namespace {

/// A value with the sign with which it is worse the larger it is.
double side_of(const Goal& goal, double value) {
  const double sign = goal.over_stroke == OverStroke::max_abs && value < 0 ? -1 : 1;
  return goal.least ? -sign : sign;
}

/// Which points of a path the goal looks at.
std::vector<std::size_t> points_of(const Goal& goal, std::size_t count) {
  if (goal.over_stroke == OverStroke::first) return {0};
  if (goal.over_stroke == OverStroke::last) return {count - 1};
  std::vector<std::size_t> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// Why a goal has no value, with the load case where there are several.
BecauseOf said(const Why& why, const std::string& load_case, const std::string& where = "") {
  return BecauseOf({fmt::format("{}{}{}", why.message, where,
                                load_case.empty() ? "" : fmt::format(" (load case {})", load_case)),
                    why.reason});
}

}  // namespace

WorstAssemblyGoals::WorstAssemblyGoals(const Job& job, std::vector<Goal>& goals, int places)
    : box_(*job.assembly_tolerances), plain_(goals) {
  const AssemblyTolerances& spec = *job.assembly_tolerances;
  search_ = {box_.size(), spec.starts, spec.seed, places};
  for (const JobCase& one : cases_of(job)) cases_.push_back(one.name);
  for (std::size_t g = 0; g < goals.size(); ++g) {
    if (goals[g].worst_assembly) {
      which_.push_back(g);
      goals[g].branches = std::max(goals[g].branches, places);
      for (const GoalPart& part : goals[g].parts)
        for (const std::size_t point : points_of(goals[g], part.points))
          numbers_.push_back({g, part.load_case, point});
    }
    candidates_.push_back(goals[g].branches);
  }
}

StrokeRequest WorstAssemblyGoals::request(const Job& job, std::size_t load_case) const {
  std::vector<Goal> asked;
  for (const std::size_t g : which_) asked.push_back(plain_[g]);
  return request_of_goals(job, asked, load_case);
}

Answer<BoxLook, Why> WorstAssemblyGoals::values_at(
    const Design& design, const VectorXd& z,
    const std::function<StrokeSensitivity(const StrokeRequest&)>& evaluate) const {
  std::vector<StrokeSensitivity> found(design.requests.size());
  for (std::size_t k = 0; k < found.size(); ++k)
    if (!design.requests[k].outputs.empty())
      found[k] = evaluate(box_.with_errors(design.requests[k], z));
  BoxLook look;
  look.values.resize(std::ssize(numbers_));
  Eigen::Index row = 0;
  bool differentiated = true;
  for (const std::size_t g : which_) {
    Goal one = plain_[g];
    one.branches = 1;
    for (const GoalPart& part : one.parts) {
      const StrokeSensitivity& of = found[part.load_case];
      const auto reading = read_goal(one, of.response, design.requests[part.load_case],
                                     of.gradients ? &*of.gradients : nullptr, design.parameters);
      if (!reading)
        return said(reading.error(), cases_[part.load_case],
                    fmt::format(" (errors of assembly at {:.3g} of their box)",
                                fmt::join(z.begin(), z.end(), ", ")));
      differentiated = differentiated && reading->differentiated();
      for (const std::size_t point : points_of(one, part.points)) {
        const double value = reading->values[point], side = side_of(one, value);
        look.values[row++] = side * value;
        if (differentiated) append_rows(look.rates, side * reading->gradient.row(point));
      }
    }
  }
  if (!differentiated) look.rates.resize(0, 0);
  return look;
}

Answer<BoxLook, Why> WorstAssemblyGoals::look(const Design& design, const Evaluate& evaluate,
                                              const VectorXd& z) const {
  const auto plain_look = [&](const VectorXd& at) {
    return values_at(design, at,
                     [&](const StrokeRequest& request) { return evaluate(request, false); });
  };
  Answer<BoxLook, Why> here;
  if (design.exact) {
    const std::vector<MechanismDirection> along = box_.directions(design.mechanism);
    here = values_at(design, z, [&](const StrokeRequest& request) {
      return evaluate_stroke_gradients(design.mechanism, along, design.model, request);
    });
  } else {
    here = plain_look(z);
  }
  if (!here || (design.exact && here->rates.rows() > 0)) return here;
  const auto values = [&](const std::vector<VectorXd>& x) {
    std::vector<std::optional<VectorXd>> answers;
    for (const VectorXd& one : x) {
      const auto beside = plain_look((2 * one.array() - 1).matrix());
      answers.push_back(beside ? std::optional(beside->values) : std::nullopt);
    }
    return answers;
  };
  const auto rates = central_differences(values, (0.5 * (z.array() + 1)).matrix(), here->values);
  const char* const none = "no value beside errors of assembly in their box";
  if (!rates) return BecauseOf({none, none});
  here->rates = 0.5 * *rates;
  return here;
}

void WorstAssemblyGoals::add_candidates(std::size_t goal,
                                        const std::vector<const GoalReading*>& readings,
                                        std::size_t point, GoalReading& whole) const {
  const auto own = static_cast<std::size_t>(plain_[goal].branches);
  struct Candidate {
    const GoalReading* of;
    std::size_t entry;
    double worse;
  };
  std::vector<Candidate> all;
  for (const GoalReading* reading : readings)
    for (std::size_t b = 0; b < own; ++b) {
      const std::size_t entry = point * own + b;
      const double value = reading->values[entry];
      all.push_back({reading, entry, side_of(plain_[goal], value) * value});
    }
  std::stable_sort(all.begin(), all.end(),
                   [](const Candidate& a, const Candidate& b) { return a.worse > b.worse; });
  const auto count = static_cast<std::size_t>(candidates_[goal]);
  for (std::size_t k = 0; k < count; ++k) {
    const Candidate& one = all[std::min(k, all.size() - 1)];
    whole.values.push_back(one.of->values[one.entry]);
    if (!one.of->parameters.empty()) whole.parameters = one.of->parameters;
    if (one.of->gradient.rows() == 0) continue;
    append_rows(whole.gradient, one.of->gradient.row(one.entry));
  }
}

Answer<std::vector<GoalReading>, Why> WorstAssemblyGoals::read(const Design& design,
                                                               const Evaluate& evaluate,
                                                               bool gradient) const {
  std::vector<std::size_t> kinds;
  for (const Number& number : numbers_) kinds.push_back(number.goal);
  const auto worst =
      worst_places(search_, kinds, [&](const VectorXd& z) { return look(design, evaluate, z); });
  if (!worst) return BecauseOf(worst.error());
  // the paths at these places, each once in each load case
  std::vector<std::pair<VectorXd, std::size_t>> places;
  std::vector<StrokeSensitivity> paths;
  std::vector<std::vector<std::size_t>> at(numbers_.size());
  for (std::size_t k = 0; k < numbers_.size(); ++k)
    for (const VectorXd& z : worst->places[k]) {
      const std::pair place{z, numbers_[k].load_case};
      const auto known = std::ranges::find(places, place);
      at[k].push_back(static_cast<std::size_t>(known - places.begin()));
      if (known != places.end()) continue;
      places.push_back(place);
      paths.push_back(evaluate(box_.with_errors(design.requests[place.second], z), gradient));
    }

  std::vector<GoalReading> found(plain_.size());
  std::size_t first = 0;
  for (const std::size_t g : which_) {
    GoalReading& whole = found[g];
    for (const GoalPart& part : plain_[g].parts) {
      std::vector<GoalReading> readings(paths.size());
      for (std::size_t p = 0; p < paths.size(); ++p) {
        if (places[p].second != part.load_case) continue;
        auto reading =
            read_goal(plain_[g], paths[p].response, design.requests[part.load_case],
                      paths[p].gradients ? &*paths[p].gradients : nullptr, design.parameters);
        if (!reading) return said(reading.error(), cases_[part.load_case]);
        readings[p] = std::move(*reading);
      }
      const std::size_t count = points_of(plain_[g], part.points).size();
      for (std::size_t point = 0; point < part.points; ++point) {
        // a goal of one point has its place for all
        std::vector<const GoalReading*> here;
        for (const std::size_t p : at[first + (count > 1 ? point : 0)])
          here.push_back(&readings[p]);
        add_candidates(g, here, point, whole);
      }
      first += count;
    }
    if (!whole.differentiated()) whole.gradient.resize(0, 0);
  }
  return found;
}

AssemblyBox::AssemblyBox(const AssemblyTolerances& spec) {
  for (const EdgeTolerance& edge : spec.edges)
    for (int k = 0; k < 6; ++k) {
      const double size = k < 3 ? edge.move[k] : edge.turn[k - 3];
      if (size == 0) continue;
      entries_.push_back({edge.leaf, edge.end, k % 3, k >= 3, size});
    }
}

std::vector<AssemblyError> AssemblyBox::errors(const VectorXd& z) const {
  std::vector<AssemblyError> errors;
  for (std::size_t k = 0; k < entries_.size(); ++k) {
    const Entry& e = entries_[k];
    auto own = std::ranges::find_if(
        errors, [&](const AssemblyError& a) { return a.leaf == e.leaf && a.end == e.end; });
    if (own == errors.end()) own = errors.insert(errors.end(), {e.leaf, e.end});
    (e.turn ? own->turn : own->move)[e.axis] += e.size * z[k];
  }
  return errors;
}

StrokeRequest AssemblyBox::with_errors(StrokeRequest request, const VectorXd& z) const {
  for (const AssemblyError& error : errors(z)) {
    auto own = std::ranges::find_if(request.loads.assembly, [&](const AssemblyError& a) {
      return a.leaf == error.leaf && a.end == error.end;
    });
    if (own == request.loads.assembly.end()) {
      request.loads.assembly.push_back(error);
    } else {
      own->move += error.move;
      own->turn += error.turn;
    }
  }
  return request;
}

std::vector<MechanismDirection> AssemblyBox::directions(const Mechanism& mechanism) const {
  std::vector<MechanismDirection> all;
  for (const Entry& e : entries_) {
    AssemblyError rate{e.leaf, e.end};
    (e.turn ? rate.turn : rate.move)[e.axis] = e.size;
    all.push_back(
        assembly_direction(fmt::format("error of assembly {}", all.size()), mechanism, rate));
  }
  return all;
}

}  // namespace flexopt
