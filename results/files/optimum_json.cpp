// The part "optimum" of result.json.

#include <algorithm>
#include <cassert>
#include <cmath>

#include "optim/job/job_numbers.hpp"
#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

Json goal_json(const Constraint& goal, const DriveList& drives) {
  Json json = {{"name", extreme_name(goal, drives)}};
  json.update(measure_json(goal, drives));
  return json;
}

/// The bound that the margin is measured from.
Json nearest_bound(const ConstraintState& state) {
  if (!state.min) return optional_json(state.max);
  if (!state.max) return *state.min;
  return state.value - *state.min < *state.max - state.value ? *state.min : *state.max;
}

/// Adds the load case and point that decided a number; nothing for a job with one case.
void add_decisive(const Job& job, const Mechanism& mechanism,
                  const std::optional<GoalPlace>& decisive, Json& json) {
  if (job.cases.empty()) return;
  json["decisive"] = decisive ? place_json(job, mechanism, *decisive) : Json();
}

/// What a goal bears, as the job says it.
void add_margin(const Constraint& goal, Json& json) {
  if (!goal.margin && !goal.worst_assembly) return;
  json["under"] = goal.worst_assembly ? "assembly_tolerances" : "tolerances";
  json["as"] = goal.worst_assembly ? "worst" : goal.margin.text();
}

Json constraints_json(const Job& job, const Optimum& optimum, const Mechanism& mechanism) {
  const OptimiseSpec& spec = *job.optimise;
  const DriveList drives = drives_of(job, mechanism);
  assert(optimum.constraints.size() == spec.constraints.size() || optimum.constraints.empty());
  Json constraints = Json::array();
  for (std::size_t i = 0; i < optimum.constraints.size(); ++i) {
    const ConstraintState& state = optimum.constraints[i];
    const Constraint& asked = spec.constraints[i];
    Json json = {{"label", state.label}};
    json.update(goal_json(asked, drives));
    json.update({{"value", state.value},
                 {"bound", nearest_bound(state)},
                 {"min", optional_json(state.min)},
                 {"max", optional_json(state.max)},
                 {"margin", state.margin},
                 {"active", state.active},
                 {"multiplier", optional_json(state.multiplier)}});
    if (!asked.load_case.empty()) json["case"] = asked.load_case;
    add_margin(asked, json);
    add_decisive(job, mechanism, state.decisive, json);
    constraints.push_back(std::move(json));
  }
  return constraints;
}

Json variables_json(const Job& job, const Optimum& optimum, const Family& family) {
  Json variables = Json::array();
  for (const Variable& variable : job.optimise->variables) {
    const auto found = optimum.parameters.find(variable.parameter);
    const auto initial = job.design.parameters.find(variable.parameter);
    Json json = {{"parameter", variable.parameter},
                 {"unit", parameter_unit(family, variable.parameter)},
                 {"min", variable.min},
                 {"max", variable.max},
                 {"initial", nullptr},
                 {"optimum", nullptr},
                 {"at_bound", nullptr}};
    if (initial != job.design.parameters.end()) json["initial"] = initial->second;
    if (variable.start) json["initial"] = *variable.start;
    if (found != optimum.parameters.end()) {
      json["optimum"] = found->second;
      if (const char* bound = bound_at(variable, found->second)) json["at_bound"] = bound;
    }
    variables.push_back(std::move(json));
  }
  return variables;
}

Json start_json(const StartSummary& start) {
  return {{"start", start.index},
          {"from", start.from},
          {"to", start.to},
          {"objective", start.objective},
          {"violation", start.violation},
          {"feasible", start.feasible},
          {"agrees", start.agrees},
          {"status", start.status},
          {"stop_reason", start.stop_reason},
          {"kkt_residual", optional_json(start.kkt)},
          {"evaluations", start.evaluations},
          {"failed_evaluations", start.failed_evaluations}};
}

Json counts_json(const std::vector<ScreeningCount>& counts, const char* name) {
  return list_json(counts, [&](const ScreeningCount& count) -> Json {
    return {{name, count.what}, {"designs", count.designs}};
  });
}

Json screening_json(const Optimum& optimum) {
  if (!optimum.screening) return nullptr;
  const ScreeningReport& found = *optimum.screening;
  Json searched = Json::array();
  for (std::size_t k = 0; k < found.searched.size(); ++k) {
    const SearchedCluster& of = found.searched[k];
    searched.push_back({{"start", k},
                        {"from", of.from},
                        {"objective", of.objective},
                        {"violation", of.violation},
                        {"feasible", of.feasible},
                        {"designs", of.designs},
                        {"distance", known_json(!std::isinf(of.distance), of.distance)}});
  }
  return {{"designs", found.designs},
          {"evaluated", found.evaluated},
          {"ruled_out", found.ruled_out},
          {"failed", found.failed},
          {"feasible", found.feasible},
          {"nearly_feasible", found.nearly_feasible},
          {"atlas", found.looked_up},
          {"failures", counts_json(found.failures, "reason")},
          {"violated", counts_json(found.violated, "label")},
          {"clusters", found.clusters},
          {"searched", std::move(searched)}};
}

Json optima_json(const Optimum& optimum) {
  if (!optimum.screening) return nullptr;
  return list_json(optimum.optima, [&](const FoundOptimum& of) -> Json {
    const StartSummary& end = optimum.starts[of.start];
    return {
        {"start", of.start},
        {"starts", of.starts},
        {"variables", end.to},
        {"objective", end.objective},
        {"violation", end.violation},
        {"feasible", end.feasible},
        {"full", of.ok ? Json{{"objective", of.objective}, {"violation", of.violation}} : Json()}};
  });
}

Json stock_json(const Optimum& optimum) {
  if (!optimum.stock) return nullptr;
  const StockSearch& stock = *optimum.stock;
  const auto design_json = [](const StockDesign& d) -> Json {
    return {{"sizes", d.sizes},
            {"parameters", known_json(d.ok, d.parameters)},
            {"objective", known_json(d.ok, d.objective)},
            {"violation", known_json(d.ok, d.violation)},
            {"feasible", d.feasible},
            {"status", d.status},
            {"stop_reason", d.stop_reason},
            {"evaluations", d.evaluations}};
  };
  return {
      {"continuous", {{"parameters", stock.continuous}, {"objective", stock.continuous_objective}}},
      {"neighbours", stock.neighbours},
      {"tried", stock.tried},
      {"settled", stock.settled},
      {"designs", list_json(stock.designs, design_json)},
      {"chosen", known_json(stock.chosen >= 0, stock.chosen)}};
}

Json pareto_json(const OptimiseSpec& spec, const Optimum& optimum, const DriveList& drives) {
  if (!optimum.pareto) return nullptr;
  assert(spec.pareto);
  const ParetoSpec& asked = *spec.pareto;
  Json second = {{"label", asked.label}, {"sense", asked.maximise ? "maximise" : "minimise"}};
  second.update(goal_json(asked, drives));
  if (!asked.load_case.empty()) second["case"] = asked.load_case;
  const auto point_json = [](const ParetoPoint& p) -> Json {
    return {{"bound", optional_json(p.bound)},
            {"objective", known_json(p.ok, p.objective)},
            {"second", known_json(p.ok, p.second)},
            {"violation", known_json(p.ok, p.violation)},
            {"feasible", p.feasible},
            {"trade_off", optional_json(p.trade_off)},
            {"parameters", known_json(p.ok, p.parameters)},
            {"status", p.status},
            {"stop_reason", p.stop_reason},
            {"evaluations", p.evaluations}};
  };
  return {{"second", std::move(second)},
          {"message", optimum.pareto->message},
          {"points", list_json(optimum.pareto->points, point_json)}};
}

Json loop_json(const VerificationLoop& loop) {
  const auto step_json = [](const VerificationStep& s) -> Json {
    return {{"variables", s.variables},
            {"objective", known_json(s.ok, s.objective)},
            {"violation", known_json(s.ok, s.violation)},
            {"difference", known_json(s.ok, s.difference)},
            {"trust_region", s.trust_region},
            {"accepted", s.accepted}};
  };
  return {{"converged", loop.converged},
          {"message", loop.message},
          {"tolerance", loop.tolerance},
          {"iterations", loop.iterations},
          {"full_evaluations", loop.steps.size()},
          {"difference", loop.difference},
          {"kkt_residual", optional_json(loop.kkt)},
          {"steps", list_json(loop.steps, step_json)}};
}

Json verified_json(const Job& job, const Optimum& optimum, const Mechanism& mechanism) {
  if (!optimum.verified) return nullptr;
  const Verification& verified = *optimum.verified;
  assert(verified.constraints.size() == verified.constraint_differences.size());
  Json constraints = Json::array();
  for (std::size_t i = 0; i < verified.constraints.size(); ++i)
    constraints.push_back(
        {{"label", i < optimum.constraints.size() ? optimum.constraints[i].label : ""},
         {"value", verified.constraints[i]},
         {"difference", verified.constraint_differences[i]}});
  const bool found = verified.outcome().status == Status::ok;
  Json json = {{"accuracy", "full"},
               {"status", found ? "ok" : "no_equilibrium"},
               {"message", verified.outcome().message},
               {"objective", known_json(found, verified.objective)},
               {"objective_difference", known_json(found, verified.objective_difference)},
               {"constraints", std::move(constraints)},
               {"loop", verified.loop ? loop_json(*verified.loop) : Json()},
               {"path", path_json(verified.response, mechanism, job.request)}};
  for (std::size_t k = 0; k < verified.cases.size(); ++k)
    json["cases"][job.cases[k].name] = {
        {"path", path_json(verified.cases[k], mechanism, job.cases[k].request)}};
  return json;
}

/// SI unit of the goal with this label; that of the objective where no constraint has it.
std::string goal_unit(const OptimiseSpec& spec, const std::string& label, const DriveList& drives) {
  const auto found = std::ranges::find(spec.constraints, label, &Constraint::label);
  return found == spec.constraints.end() ? goal_unit(spec.objective, drives)
                                         : goal_unit(*found, drives);
}

Json sensitivities_json(const OptimiseSpec& spec, const Optimum& optimum, const Family& family,
                        const DriveList& drives) {
  return list_json(optimum.sensitivities, [&](const Sensitivity& s) -> Json {
    return {{"of", s.of},
            {"unit", goal_unit(spec, s.of, drives)},
            {"parameter", s.parameter},
            {"per", parameter_unit(family, s.parameter)},
            {"value", s.value}};
  });
}

/// Convergence history as columns: the starts without designs and without the neighbours for
/// differences; history.csv has all.
Json history_json(const Optimum& optimum) {
  Json start = Json::array(), number = Json::array(), objective = Json::array(),
       violation = Json::array();
  for (const EvaluationRecord& record : optimum.history) {
    if (record.difference || record.stage != Stage::search) continue;
    start.push_back(record.start);
    number.push_back(record.number);
    objective.push_back(known_json(record.ok, record.objective));
    violation.push_back(known_json(record.ok, record.violation));
  }
  return {{"start", start}, {"number", number}, {"objective", objective}, {"violation", violation}};
}

/// What the least violated design cannot meet together; null where nothing is known of it.
Json conflict_json(const Optimum& optimum) {
  if (!optimum.conflict) return nullptr;
  Json json = {{"constraints", Json::array()}, {"variables", Json::array()}};
  for (const std::size_t i : optimum.conflict->constraints)
    json["constraints"].push_back(optimum.constraints[i].label);
  for (const auto& [parameter, bound] : optimum.conflict->variables)
    json["variables"].push_back({{"parameter", parameter}, {"at_bound", bound}});
  return json;
}

}  // namespace

OrderedJson make_optimum(const Job& job, const Optimum& optimum, const Mechanism& mechanism) {
  assert(job.optimise);
  const OptimiseSpec& spec = *job.optimise;
  const Family& family = resolve(job.design)->family();
  Json goal = {{"sense", spec.objective.maximise ? "maximise" : "minimise"}};
  goal.update(goal_json(spec.objective, drives_of(job, mechanism)));
  if (!spec.objective.load_case.empty()) goal["case"] = spec.objective.load_case;
  add_margin(spec.objective, goal);
  if (optimum.status != OptimumStatus::failed) add_decisive(job, mechanism, optimum.decisive, goal);
  return {
      {"status", name_of(optimum.status)},
      {"stop_reason", optimum.stop_reason},
      {"conflict", conflict_json(optimum)},
      {"kkt_residual", optional_json(optimum.kkt)},
      {"parameters", optimum.parameters},
      {"objective", known_json(optimum.status != OptimumStatus::failed, optimum.objective)},
      {"goal", std::move(goal)},
      {"constraints", constraints_json(job, optimum, mechanism)},
      {"variables", variables_json(job, optimum, family)},
      {"accuracy",
       optimum.at_full_accuracy || job.model.accuracy == Accuracy::full ? "full" : "reduced"},
      {"algorithm",
       {{"library", spec.algorithm.library},
        {"name", spec.algorithm.name},
        {"local", known_json(!spec.algorithm.local.empty(), spec.algorithm.local)}}},
      {"gradients", optimum.gradients},
      {"gradients_of", optimum.gradients != "exact" ? Json()
                       : optimum.of_reduced_leaves  ? Json("reduced")
                                                    : Json("full")},
      {"gradients_message", optimum.gradients_message},
      // the leaves of the search, where these are not those of the job's model
      {"searched_on",
       job.search_model ? Json{{"accuracy", "reduced"}, {"mesh", job.search_model->mesh}} : Json()},
      {"evaluations", optimum.evaluations},
      {"failed_evaluations", optimum.failed_evaluations},
      {"best_start", optimum.best_start},
      {"agreeing_starts", optimum.agreeing_starts},
      {"starts", list_json(optimum.starts, start_json)},
      {"screening", screening_json(optimum)},
      {"optima", optima_json(optimum)},
      {"stock", stock_json(optimum)},
      {"pareto", pareto_json(spec, optimum, drives_of(job, mechanism))},
      {"verified", verified_json(job, optimum, mechanism)},
      {"sensitivities", sensitivities_json(spec, optimum, family, drives_of(job, mechanism))},
      {"history", history_json(optimum)}};
}

}  // namespace flexopt
