#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

constexpr int most_map_designs = 10000;

/// The bounds of the variable of that name, where the axis gives none.
void take_bounds(json& axis, const Job& job, const Pointer& at) {
  const Variable* variable = nullptr;
  if (job.optimise) {
    const auto found = std::ranges::find(
        job.optimise->variables, axis["parameter"].get<std::string>(), &Variable::parameter);
    if (found != job.optimise->variables.end()) variable = &*found;
  }
  for (const auto& [key, bound] : {std::pair{"min", &Variable::min}, {"max", &Variable::max}}) {
    if (axis.contains(key)) continue;
    if (!variable)
      throw SpecError(at / key, "nothing",
                      "it is required: the parameter is no variable of \"optimise\"");
    axis[key] = variable->*bound;
  }
}

/// Objective and constraints, without bounds and tolerances, each once.
std::vector<Constraint> measures_of(const OptimiseSpec& goals) {
  std::vector<Constraint> all{goals.objective};
  all.insert(all.end(), goals.constraints.begin(), goals.constraints.end());
  std::vector<Constraint> measures;
  for (Constraint& c : all) {
    c.min.reset();
    c.max.reset();
    c.margin = {};
    c.worst_assembly = false;
    c.label = goal_label(c);
    if (std::ranges::find(measures, c.label, &Constraint::label) == measures.end())
      measures.push_back(std::move(c));
  }
  return measures;
}

MapSpec read_map(json& read, const GoalContext& context, const Job& job, const Pointer& at) {
  FaultList& faults = context.faults;
  MapSpec map = map_table().read(read);
  if (map.points[0] * map.points[1] > most_map_designs)
    throw wrong(read, at, "points",
                fmt::format("expected at most {} points together", most_map_designs));
  for (std::size_t k = 0; k < 2; ++k)
    faults.attempt([&] {
      json& axis = read["parameters"][k];
      take_bounds(axis, job, at / "parameters" / k);
      map.parameters[k] = read_range(axis, context, at / "parameters" / k);
    });
  if (map.parameters[0].parameter == map.parameters[1].parameter &&
      !map.parameters[0].parameter.empty())
    throw SpecError(at / "parameters" / 1 / "parameter", shown(map.parameters[1].parameter),
                    "it is the first parameter already");
  if (!read.contains("quantities") && !job.optimise)
    throw SpecError(at / "quantities", "nothing",
                    "it is required: the job has no \"optimise\" whose goals could be drawn");
  for (std::size_t k = 0; read.contains("quantities") && k < read["quantities"].size(); ++k)
    faults.attempt([&] {
      map.quantities.push_back(
          read_measure(read["quantities"][k], context, at / "quantities" / k, std::nullopt));
    });
  if (!read.contains("quantities")) map.quantities = measures_of(*job.optimise);
  return map;
}

}  // namespace

std::vector<MapSpec> read_maps(json& read, const Family& family, const Job& job,
                               const CaseNames& cases, FaultList& faults) {
  const GoalContext context(family, job, cases, {}, faults);
  std::vector<MapSpec> maps;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Pointer at = Pointer("/maps") / i;
    if (faults.sound(at))
      faults.attempt([&] { maps.push_back(read_map(read[i], context, job, at)); });
  }
  return maps;
}

}  // namespace flexopt
