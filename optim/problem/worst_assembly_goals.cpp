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
    }
    candidates_.push_back(goals[g].branches);
  }
}

StrokeRequest WorstAssemblyGoals::request(const Job& job, std::size_t load_case) const {
  std::vector<Goal> asked;
  for (const std::size_t g : which_) asked.push_back(plain_[g]);
  return request_of_goals(job, asked, load_case);
}

std::vector<WorstAssemblyGoals::Number> WorstAssemblyGoals::numbers() const {
  std::vector<Number> all;
  for (const std::size_t g : which_)
    for (const GoalPart& part : plain_[g].parts)
      for (const std::size_t point : points_of(plain_[g], part.points))
        all.push_back({g, part.load_case, point});
  return all;
}

std::string WorstAssemblyGoals::said(const std::string& message, std::size_t load_case) const {
  if (cases_[load_case].empty()) return message;
  return fmt::format("{} (load case {})", message, cases_[load_case]);
}

std::vector<StrokeSensitivity> WorstAssemblyGoals::paths_at(
    const Design& design, const VectorXd& z,
    const std::function<StrokeSensitivity(const StrokeRequest&)>& evaluate) const {
  std::vector<StrokeSensitivity> found(design.requests.size());
  for (std::size_t k = 0; k < found.size(); ++k)
    if (!design.requests[k].outputs.empty())
      found[k] = evaluate(box_.with_errors(design.requests[k], z));
  return found;
}

Answer<BoxLook, Why> WorstAssemblyGoals::values_at(const std::vector<StrokeSensitivity>& found,
                                                   const Design& design,
                                                   const std::vector<Number>& numbers,
                                                   const VectorXd& z) const {
  BoxLook look;
  look.values.resize(static_cast<Eigen::Index>(numbers.size()));
  bool differentiated = true;
  for (const Number& number : numbers)
    differentiated = differentiated && found[number.load_case].gradients.has_value();
  if (differentiated) look.rates.resize(look.values.size(), z.size());
  std::pair last{plain_.size(), std::size_t{0}};
  Answer<GoalReading, Why> reading;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const auto& [g, load_case, point] = numbers[k];
    if (std::pair now{g, load_case}; now != last) {
      Goal one = plain_[g];
      one.branches = 1;
      const StrokeSensitivity& of = found[load_case];
      reading = read_goal(one, of.response, design.requests[load_case],
                          differentiated ? &*of.gradients : nullptr);
      last = now;
    }
    if (!reading) {
      std::vector<std::string> where;
      for (const double x : z) where.push_back(fmt::format("{:.3g}", x));
      return BecauseOf({said(fmt::format("{} (errors of assembly at {} of their box)",
                                         reading.error().message, fmt::join(where, ", ")),
                             load_case),
                        reading.error().reason});
    }
    const double value = reading->values[point], side = side_of(plain_[g], value);
    const auto row = static_cast<Eigen::Index>(k);
    look.values[row] = side * value;
    differentiated = differentiated && reading->differentiated();
    if (differentiated)
      look.rates.row(row) = side * reading->gradient.row(static_cast<Eigen::Index>(point));
  }
  if (!differentiated) look.rates.resize(0, 0);
  return look;
}

Answer<BoxLook, Why> WorstAssemblyGoals::look(const Design& design, const Evaluate& evaluate,
                                              const std::vector<Number>& numbers,
                                              const VectorXd& z) const {
  const auto plain_look = [&](const VectorXd& at) {
    const auto plain = [&](const StrokeRequest& request) { return evaluate(request, false); };
    return values_at(paths_at(design, at, plain), design, numbers, at);
  };
  Answer<BoxLook, Why> here;
  if (design.exact) {
    const std::vector<MechanismDirection> along = box_.directions(design.mechanism);
    const auto differentiated = [&](const StrokeRequest& request) {
      return evaluate_stroke_gradients(design.mechanism, along, design.model, request);
    };
    here = values_at(paths_at(design, z, differentiated), design, numbers, z);
    if (!here || here->rates.rows() > 0) return here;
  } else {
    here = plain_look(z);
    if (!here) return here;
  }
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
    if (one.of->gradient.rows() == 0) continue;
    append_rows(whole.gradient, one.of->gradient.row(static_cast<Eigen::Index>(one.entry)));
  }
}

Answer<WorstAssemblyGoals::Found, Why> WorstAssemblyGoals::read(const Design& design,
                                                                const Evaluate& evaluate,
                                                                bool gradient) const {
  const std::vector<Number> asked = numbers();
  std::vector<std::size_t> kinds;
  for (const Number& number : asked) kinds.push_back(number.goal);
  const auto worst = worst_places(
      search_, kinds, [&](const VectorXd& z) { return look(design, evaluate, asked, z); });
  if (!worst) return BecauseOf(worst.error());
  // the paths at these places, each once in each load case
  std::vector<std::pair<VectorXd, std::size_t>> places;
  std::vector<StrokeSensitivity> paths;
  const auto path_at = [&](const VectorXd& z, std::size_t load_case) {
    const auto known = std::ranges::find_if(
        places, [&](const auto& p) { return p.second == load_case && p.first == z; });
    if (known != places.end()) return static_cast<std::size_t>(known - places.begin());
    places.emplace_back(z, load_case);
    paths.push_back(evaluate(box_.with_errors(design.requests[load_case], z), gradient));
    return paths.size() - 1;
  };
  std::vector<std::vector<std::size_t>> at(asked.size());
  for (std::size_t k = 0; k < asked.size(); ++k)
    for (const VectorXd& z : worst->places[k]) at[k].push_back(path_at(z, asked[k].load_case));

  Found found{.goals = std::vector<GoalReading>(plain_.size())};
  for (const StrokeSensitivity& path : paths)
    if (path.gradients) found.parameters = path.gradients->parameters;
  std::size_t first = 0;
  for (const std::size_t g : which_) {
    GoalReading& whole = found.goals[g];
    for (const GoalPart& part : plain_[g].parts) {
      std::vector<GoalReading> readings(paths.size());
      for (std::size_t p = 0; p < paths.size(); ++p) {
        if (places[p].second != part.load_case) continue;
        auto reading = read_goal(plain_[g], paths[p].response, design.requests[part.load_case],
                                 paths[p].gradients ? &*paths[p].gradients : nullptr);
        if (!reading)
          return BecauseOf({said(reading.error().message, part.load_case), reading.error().reason});
        readings[p] = std::move(*reading);
      }
      const std::size_t count = points_of(plain_[g], part.points).size();
      for (std::size_t point = 0; point < part.points; ++point) {
        std::size_t k = first;  // a goal of one point has its place for all
        for (std::size_t j = first; j < first + count; ++j)
          if (asked[j].point == point) k = j;
        std::vector<const GoalReading*> here;
        for (const std::size_t p : at[k]) here.push_back(&readings[p]);
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
    (e.turn ? own->turn : own->move)[e.axis] += e.size * z[static_cast<Eigen::Index>(k)];
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
