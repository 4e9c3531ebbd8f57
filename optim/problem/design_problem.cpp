#include "optim/problem/design_problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/problem/posing.hpp"

namespace flexopt {

namespace {

/// The job with the second objective of a front among its constraints, and with the numbers of
/// material and end-effector that are variables or stand in formulas among its parameters.
Job prepared(Job job) {
  OptimiseSpec& spec = *job.optimise;
  if (spec.pareto) spec.constraints.push_back(*spec.pareto);
  const ParameterValues numbers = numbers_of(job.design.material, job.end_effector);
  job.design.resolved = resolve(job.design);
  std::vector<std::string> wanted;
  for (const Variable& v : spec.variables) wanted.push_back(v.parameter);
  const auto add = [&](const std::string& formula, const std::string& pointer) {
    if (formula.empty()) return;
    const std::vector<std::string> names = goal_formula(job, formula, pointer).names();
    wanted.insert(wanted.end(), names.begin(), names.end());
  };
  add(spec.objective.expression, "/optimise/objective");
  for (std::size_t i = 0; i < spec.constraints.size(); ++i)
    add(spec.constraints[i].expression, fmt::format("/optimise/constraints/{}", i));
  if (job.tolerances)
    for (const Tolerance& entry : job.tolerances->entries)
      for (const ToleranceTerm& term : entry.terms)
        wanted.push_back(parts_of_name(term.parameter).parameter);
  for (const std::string& name : wanted)
    if (const auto number = numbers.find(name); number != numbers.end())
      job.design.parameters.insert(*number);
  return job;
}

/// Names of the parameters that change when a variable does, or with a tolerance if `robust`.
std::vector<std::string> moving_parameters(const Job& job, bool robust) {
  const ParametricDesign& design = *job.design.resolved;
  const auto varies = [&](const std::string& name) {
    return std::ranges::find(job.optimise->variables, name, &Variable::parameter) !=
           job.optimise->variables.end();
  };
  const auto deviates = [&](const std::string& name) {
    return robust && std::ranges::any_of(job.tolerances->entries, [&](const Tolerance& entry) {
             return std::ranges::find(entry.terms, name, &ToleranceTerm::parameter) !=
                    entry.terms.end();
           });
  };
  std::vector<std::string> moving;
  for (const auto& [name, value] : job.design.parameters) {
    bool moves = varies(name);
    for (const DependentParameter& d : design.dependents())
      if (d.slot == design.slot(name))
        moves = std::ranges::any_of(d.formula.slots(), [&](int slot) {
          return varies(design.family().parameters[slot].name);
        });
    if (moves || deviates(name)) moving.push_back(name);
  }
  if (robust)
    for (const Tolerance& entry : job.tolerances->entries)
      for (const ToleranceTerm& term : entry.terms)
        if (!parts_of_name(term.parameter).leaf.empty() &&
            std::ranges::find(moving, term.parameter) == moving.end())
          moving.push_back(term.parameter);
  return moving;
}

/// Whether a differentiable path was not finished on full leaves.
bool of_reduced_leaves(const StrokeResponse& response, const StrokeRequest& request) {
  return request.values == PathValues::differentiable &&
         std::ranges::any_of(response.path, [](const PathPoint& point) {
           return std::ranges::find(point.leaves, "tube", &LeafReport::model) != point.leaves.end();
         });
}

}  // namespace

// How many places of the box are kept for each value of a goal that counts assembly errors.
constexpr int places_in_box = 3;

DesignProblem::DesignProblem(const Job& job, Evaluators evaluators)
    : job_(prepared(job)), evaluators_(std::move(evaluators)), goals_(make_goals(job_)) {
  std::vector<Goal> assembled = goals_;
  std::erase_if(assembled, [](const Goal& goal) { return goal.worst_assembly; });
  for (std::size_t k = 0; k < cases_of(job_).size(); ++k)
    requests_.push_back(request_of_goals(job_, assembled, k));
  for (const Goal& g : goals_) needs_mechanics_ = needs_mechanics_ || !g.of_parameters();
  // values with and without derivatives must be those of one function
  const bool searched = algorithm_of(optimiser_options(*job_.optimise)).gradients;
  if (evaluators_.gradients && (searched || robust())) {
    for (StrokeRequest& request : requests_) {
      request.values = PathValues::differentiable;
      request.frequencies = frequencies_needed(goals_, request);
      if (searched && algorithm_of(optimiser_options(*job_.optimise)).bears_repetition())
        add_stress_branches(goals_, request);
    }
  }
  if (assembled.size() < goals_.size()) {
    // values at nearly as bad places are candidates where repeated rows do no harm
    const bool many =
        searched && algorithm_of(optimiser_options(*job_.optimise)).bears_repetition();
    worst_assembly_.emplace(job_, goals_, many ? places_in_box : 1);
    for (std::size_t k = 0; k < requests_.size(); ++k) {
      StrokeRequest& request = box_requests_.emplace_back(worst_assembly_->request(job_, k));
      request.values = requests_[k].values;
      request.stress_peaks = requests_[k].stress_peaks;
    }
  }
  names_ = moving_parameters(job_, robust());
}

bool DesignProblem::robust() const {
  return std::ranges::any_of(goals_, [](const Goal& goal) { return bool(goal.margin); });
}

Variables DesignProblem::variables(const VectorXd& x) const {
  assert(x.size() == size());
  constexpr double rounding = 1e-14;
  Variables v;
  for (int j = 0; j < size(); ++j) {
    const Variable& of = spec().variables[j];
    double value = x[j] <= 0   ? of.min
                   : x[j] >= 1 ? of.max
                               : std::clamp(of.min + x[j] * (of.max - of.min), of.min, of.max);
    for (const double size : of.stock)  // a size is hit to the bit
      if (std::abs(value - size) <= rounding * (of.max - of.min)) value = size;
    v.push_back(value);
  }
  return v;
}

VectorXd DesignProblem::scaled(const Variables& variables) const {
  VectorXd x(size());
  const auto back = [&](int j) { return this->variables(x)[j]; };
  for (int j = 0; j < size(); ++j) {
    const Variable& of = spec().variables[j];
    x[j] = std::clamp((variables[j] - of.min) / (of.max - of.min), 0.0, 1.0);
  }
  // Adjusts x so that it leads back to the same bits; rounding is off by a few units of x at most.
  for (int j = 0; j < size(); ++j) {
    const double wanted = variables[j];
    for (int i = 0; i < 8 && back(j) != wanted; ++i)
      x[j] = std::nextafter(x[j], back(j) < wanted ? 1.0 : 0.0);
  }
  return x;
}

ParameterValues DesignProblem::named(const Variables& variables) const {
  ParameterValues values;
  for (std::size_t j = 0; j < variables.size(); ++j)
    values[spec().variables[j].parameter] = variables[j];
  return values;
}

ParameterValues DesignProblem::parameters(const Variables& variables) const {
  ParameterValues values = job_.design.parameters;
  for (const auto& [name, value] : named(variables)) values[name] = value;
  return complete_parameters(job_.design, std::move(values));
}

Mechanism DesignProblem::mechanism(const Variables& variables) const {
  return make_mechanism(job_, parameters(variables));
}

StrokeResponse DesignProblem::respond(const Variables& variables, const ModelOptions& model,
                                      const StrokeRequest& request) const {
  return evaluators_.values(mechanism(variables), model, request);
}

Answer<std::vector<GoalReading>, Why> DesignProblem::look_in_box(const ParameterValues& parameters,
                                                                 bool gradient,
                                                                 const ModelOptions& model,
                                                                 bool& reduced) const {
  const Mechanism mechanism = make_mechanism(job_, parameters);
  const bool exact = evaluators_.gradients != nullptr &&
                     box_requests_.front().values == PathValues::differentiable;
  const auto evaluate = [&](const StrokeRequest& request, bool differentiated) {
    StrokeSensitivity found;
    if (differentiated && evaluators_.gradients)
      found = evaluators_.gradients(job_, parameters, names_, model, request);
    else
      found.response = evaluators_.values(mechanism, model, request);
    reduced |= of_reduced_leaves(found.response, request);
    return found;
  };
  return worst_assembly_->read({mechanism, model, box_requests_, parameters, exact}, evaluate,
                               gradient);
}

DesignValues DesignProblem::look(const ParameterValues& parameters, bool gradient,
                                 const ModelOptions& model) const {
  std::vector<StrokeSensitivity> found(requests_.size());
  for (std::size_t k = 0; k < requests_.size(); ++k) {
    if (requests_[k].outputs.empty()) continue;  // no goal is about this load case
    if (gradient && evaluators_.gradients)
      found[k] = evaluators_.gradients(job_, parameters, names_, model, requests_[k]);
    else
      found[k].response = evaluators_.values(make_mechanism(job_, parameters), model, requests_[k]);
  }
  std::optional<Answer<std::vector<GoalReading>, Why>> worst;
  bool reduced = false;
  if (worst_assembly_) worst = look_in_box(parameters, gradient, model, reduced);
  DesignValues slopes = read_goals(parameters, found, requests_, worst ? &*worst : nullptr);
  slopes.of_reduced_leaves = reduced;
  for (const StrokeSensitivity& of : found)
    if (!slopes.ok && !slopes.reached) slopes.reached = stroke_reached(of.response);
  for (std::size_t k = 0; k < found.size(); ++k)
    slopes.of_reduced_leaves |= of_reduced_leaves(found[k].response, requests_[k]);
  for (const StrokeSensitivity& of : found)
    if (slopes.ok && !of.gradients && !of.message.empty()) slopes.no_gradient = of.message;
  return slopes;
}

DesignValues DesignProblem::evaluate(const Variables& variables, bool gradient,
                                     std::optional<Accuracy> accuracy) const {
  try {
    ModelOptions model = !accuracy && job_.search_model ? *job_.search_model : job_.model;
    if (accuracy) model.accuracy = *accuracy;
    const ParameterValues all = parameters(variables);
    DesignValues values = look(all, gradient || robust(), model);
    if (robust())
      RobustGoals{goals_, job_.tolerances->entries, names_}.add_margins(
          all, gradient,
          [&](const ParameterValues& beside) {
            try {
              return look(beside, true, model);
            } catch (const SpecError& error) {
              return DesignValues{.message = error.what(), .reason = error.rule()};
            }
          },
          values);
    values = chained(std::move(values), all);
    const bool offered = evaluators_.gradients || !needs_mechanics_;
    if (!gradient || !offered) {
      values.no_gradient.clear();
      values.gradient.resize(0, 0);
    }
    return values;
  } catch (const SpecError& error) {
    return {.message = error.what(), .reason = error.rule()};
  }
}

}  // namespace flexopt
