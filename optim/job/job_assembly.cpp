#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

/// Ways to take the worst value over the stroke; a single value has no worse side of its own.
const EnumNames<OverStroke> worse_names{
    {"min", OverStroke::min}, {"max", OverStroke::max}, {"max_abs", OverStroke::max_abs}};

const RecordTable<Constraint>& worst_table() {
  static const auto table =
      RecordTable<Constraint>()
          .optional("quantity", shape::text(100), &Constraint::quantity,
                    "whose worst value is looked for")
          .optional("expression", shape::text(), &Constraint::expression,
                    "or a formula of quantities and parameters")
          .choice<OverStroke>("over_stroke", worse_names, &Constraint::over_stroke,
                              "its worse side, and which value over the stroke: the least, the "
                              "largest, or the largest in size")
          .optional("case", shape::text(100), &Constraint::load_case,
                    "the load case that counts; default: the worst of all");
  return table;
}

const RecordTable<AssemblyTolerances>& box_table() {
  static const auto table =
      RecordTable<AssemblyTolerances>()
          .optional("stiffness_share", shape::quantity("1", 0, 1, true, true),
                    &AssemblyTolerances::stiffness_share,
                    "critical is what leaves a support so much of its stiffness")
          .optional("drive_load_change", shape::quantity("1", 0, 1e6, true),
                    &AssemblyTolerances::drive_load_change,
                    "critical is what changes the drive load by so much of its largest value")
          .with_default("largest_scale", shape::quantity("1", 0, 1e6, true),
                        &AssemblyTolerances::largest_scale,
                        "of the box, up to which a critical one is looked for")
          .with_default("starts", shape::integer(2, 1000), &AssemblyTolerances::starts,
                        "of each search, the middle of the box among them")
          .with_default("seed", shape::integer(0, 4294967295.0), &AssemblyTolerances::seed,
                        "of the starts")
          .optional("max_paths", shape::integer(1, 1e9), &AssemblyTolerances::max_paths,
                    "after so many the study ends with the worst that it has found; default: "
                    "none ends it");
  return table;
}

Shape edge_shape() {
  std::vector<Field> fields = assembly_table().fields();
  for (Field& field : fields) {
    if (field.name == "move") field.meaning = "largest to either side, of the edge's middle";
    if (field.name == "turn") field.meaning = "largest to either side, about each axis";
  }
  return shape::record(std::move(fields));
}

EdgeTolerance read_edge(const json& read, const Mechanism& mechanism, const Pointer& at) {
  const AssemblySpec spec = assembly_table().read(read);
  const int leaf = find_leaf(mechanism, spec.leaf, at / "leaf", spec.end);
  if (spec.end == 1 && mechanism.leaves[static_cast<std::size_t>(leaf)].tip == free_edge)
    throw wrong(read, at, "end", "the tip of this leaf is free: no body holds it");
  for (const auto& [key, sizes] : {std::pair{"move", spec.move}, {"turn", spec.turn}})
    for (int i = 0; i < 3; ++i)
      if (sizes[i] < 0)
        throw SpecError(at / key / i, fmt::format("{:g}", sizes[i]),
                        "it is a size to either side: expected 0 or more");
  if (spec.move.isZero(0) && spec.turn.isZero(0))
    throw SpecError(at, shown(read), "this edge has neither move nor turn");
  return {leaf, spec.end, spec.move, spec.turn};
}

}  // namespace

bool read_worst_assembly(json& goal, const GoalContext& context, const Constraint& read,
                         const Pointer& at) {
  if (!goal.contains("under") || goal["under"] != "assembly_tolerances") return false;
  const std::string place = (at / "under").to_string(), shown_under = shown(goal["under"]);
  if (!context.borne.assembly_tolerances)
    throw SpecError(place, shown_under, "the job has no \"assembly_tolerances\"");
  if (const std::string as = goal.value("as", "worst"); as != "worst")
    throw wrong(goal, at, "as",
                "of errors of assembly in a box the \"worst\" counts: no other distribution of "
                "them is known");
  if (read.of_parameters())
    throw SpecError(place, shown_under,
                    "a formula of the parameters is the same however the mechanism is assembled");
  if (read.of_design())
    throw SpecError(place, shown_under,
                    read.name() + " is the same however the mechanism is assembled");
  if (read.min && read.max)
    throw SpecError(place, shown_under,
                    "under errors of assembly each bound has a number of its own: give min and max "
                    "in two constraints");
  const bool least = read.min.has_value();
  const OverStroke over = read.over_stroke;
  if ((least && (over == OverStroke::max || over == OverStroke::max_abs)) ||
      (!least && over == OverStroke::min))
    throw SpecError(
        at / "over_stroke", '"' + name_of(over) + '"',
        fmt::format("the worst of the box is the {} here, and so must be that over the stroke: {}",
                    least ? "least" : "largest",
                    least ? "min, first, last" : "max, max_abs, first, last"));
  goal["as"] = "worst";
  return true;
}

Field assembly_tolerances_field() {
  std::vector<Field> fields{
      shape::required("edges", shape::list(edge_shape(), 1, 100),
                      "how far each may sit other than designed, to either side, beside assembly"),
      shape::with_default("quantities", shape::list(worst_table().shape(), 0, 50), json::array(),
                          "of which the worst value in the box is looked for")};
  for (const Field& field : box_table().fields()) fields.push_back(field);
  return shape::optional("assembly_tolerances", shape::record(std::move(fields)),
                         "a box of errors of assembly: the worst of them, and the critical size");
}

bool names_the_box(const json& job) {
  if (!job.contains("optimise") || !job["optimise"].is_object()) return false;
  const auto names = [](const json& goal) {
    return goal.is_object() && goal.contains("under") && goal["under"] == "assembly_tolerances";
  };
  const json& goals = job["optimise"];
  return (goals.contains("objective") && names(goals["objective"])) ||
         (goals.contains("pareto") && names(goals["pareto"])) ||
         (goals.contains("constraints") && goals["constraints"].is_array() &&
          std::ranges::any_of(goals["constraints"], names));
}

void look_at_goals(const OptimiseSpec& goals, AssemblyTolerances& spec) {
  const auto look_at = [&](const Constraint& goal, bool least) {
    const auto same = [&](const Constraint& c) {
      return c.name() == goal.name() && c.over_stroke == goal.over_stroke &&
             c.load_case == goal.load_case && c.min.has_value() == least;
    };
    if (!goal.worst_assembly || std::ranges::any_of(spec.quantities, same)) return;
    Constraint one{.quantity = goal.quantity,
                   .expression = goal.expression,
                   .over_stroke = goal.over_stroke,
                   .load_case = goal.load_case,
                   .unit = goal.unit,
                   .terms = goal.terms};
    if (least) one.min = 0;  // the least is the worst
    one.label = goal_label(one);
    spec.quantities.push_back(std::move(one));
  };
  look_at(goals.objective, goals.objective.maximise);
  for (const Constraint& c : goals.constraints) look_at(c, c.min.has_value());
  if (goals.pareto) look_at(*goals.pareto, goals.pareto->maximise);
}

AssemblyTolerances read_assembly_tolerances(json& read, const Mechanism& mechanism, bool in_goals,
                                            const GoalContext& context) {
  const Pointer at("/assembly_tolerances");
  FaultList& faults = context.faults;
  AssemblyTolerances spec = box_table().read(read);
  std::set<std::pair<int, int>> edges;
  for (std::size_t i = 0; i < read["edges"].size(); ++i)
    faults.attempt([&] {
      const Pointer here = at / "edges" / i;
      const EdgeTolerance edge = read_edge(read["edges"][i], mechanism, here);
      if (!edges.insert({edge.leaf, edge.end}).second)
        throw SpecError(here / "end", shown(read["edges"][i]["end"]),
                        "one box for each edge: this one has another");
      spec.edges.push_back(edge);
    });
  for (std::size_t i = 0; i < read["quantities"].size(); ++i)
    faults.attempt([&] {
      Constraint one = worst_table().read(read["quantities"][i]);
      const Pointer here = at / "quantities" / i;
      const char* const key = context.take(read["quantities"][i], here, one);
      if (one.of_design())
        throw SpecError(here / key, shown(one.name()),
                        "it is the same however the mechanism is assembled");
      if (one.over_stroke == OverStroke::min) one.min = 0;  // the least is the worst
      one.label = goal_label(one);
      spec.quantities.push_back(std::move(one));
    });
  const bool drives =
      !mechanism.drives.empty() && (context.request.loads.driven() || !context.cases.all.empty());
  if (spec.drive_load_change && !drives)
    faults.add(at / "drive_load_change", shown(read["drive_load_change"]),
               "nothing is driven here");
  if (read["quantities"].empty() && !spec.wants_critical() && !in_goals)
    faults.add(at / "quantities", shown(read["quantities"]),
               "name quantities, give stiffness_share or drive_load_change, or let a goal of "
               "optimise count \"under\": \"assembly_tolerances\"");
  return spec;
}

}  // namespace flexopt
