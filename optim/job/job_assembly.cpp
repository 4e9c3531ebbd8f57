#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
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

/// A step of the mounting.
struct MountingSpec {
  std::string name;
  std::vector<std::string> loads, springs;
  bool gravity = false, temperature = false, drives_free = false;
};

const RecordTable<MountingSpec>& mounting_table() {
  static const auto table =
      RecordTable<MountingSpec>()
          .optional("name", shape::text(100), &MountingSpec::name, "for messages")
          .other(shape::with_default("edges", shape::list(assembly_table().shape(), 0, 1000),
                                     json::array(),
                                     "that are moved or turned; of one edge in several steps moves "
                                     "and rotation vectors add up"))
          .optional("loads", shape::list(shape::text(100), 0, 100), &MountingSpec::loads,
                    "names of the loads that come")
          .optional("springs", shape::list(shape::text(100), 0, 1000), &MountingSpec::springs,
                    "names of the springs that get their preload")
          .with_default("gravity", shape::boolean(), &MountingSpec::gravity,
                        "whether gravity comes")
          .with_default("temperature", shape::boolean(), &MountingSpec::temperature,
                        "whether bodies and leaves get their temperature")
          .row(shape::optional("drive", shape::choice({"held", "free"}),
                               "whether the drives stay where they are (the default) or are free; "
                               "what was held is not freed by a later step"),
               [](const json& read, MountingSpec& step) { step.drives_free = read == "free"; })
          .other(shape::optional(
              "stroke", shape::one_of({shape::quantity(""), shape::map(shape::quantity(""))}),
              "where the drive goes first; of drives with names by these, others to zero"));
  return table;
}

/// The formula of a size of an edge. Throws SpecError.
EdgeSize edge_size(const AssemblyError& edge, int axis, const std::string& text,
                   const Family& family, const Pointer& edge_at) {
  const Pointer at = edge_at / (axis < 3 ? "move" : "turn") / (axis % 3) / "expression";
  const std::vector<FormulaName> names = formula_names(family.parameters);
  Formula formula(text, names, at.to_string(), BareNumbers::may_be_si);
  if (formula.slots().empty()) throw SpecError(at, text, uses_no_name(names));
  formula.check_unit(axis < 3 ? "m" : "rad");
  return {edge.leaf, edge.end, axis, std::move(formula)};
}

void read_edges(const json& read, const Pointer& list, int step, const Family& family,
                const Mechanism& mechanism, FaultList& faults, LoadCase& loads,
                std::vector<EdgeSize>& sizes) {
  std::set<std::pair<int, int>> edges;
  faults.each(read, list, [&](const json& item, const Pointer& at) {
    const AssemblySpec error = assembly_table().read(item);
    const int leaf = find_leaf(mechanism, error.leaf, at / "leaf", error.end);
    if (error.end == 1 && mechanism.leaves[static_cast<std::size_t>(leaf)].tip == free_edge)
      throw wrong(item, at, "end", "the tip of this leaf is free: no body holds it");
    if (!edges.insert({leaf, error.end}).second)
      throw wrong(item, at, "end", "one error for each edge: this one has another");
    if (!error.formulas.empty() && std::ranges::any_of(sizes, [&](const EdgeSize& size) {
          return size.leaf == leaf && size.end == error.end;
        }))
      throw SpecError(at, shown(item), "an earlier step has formulas for this edge: one step may");
    loads.assembly.push_back(
        {leaf, error.end, error.move, error.turn, step, !error.formulas.empty()});
    for (const auto& [axis, text] : error.formulas)
      sizes.push_back(edge_size(loads.assembly.back(), axis, text, family, at));
  });
}

VectorXd read_strokes(const json& read, const Mechanism& mechanism, const Pointer& at) {
  const std::vector<Drive>& drives = mechanism.drives;
  VectorXd strokes = VectorXd::Zero(static_cast<Eigen::Index>(drives.size()));
  const std::vector<std::string> known = names_in(drives);
  const bool named = known != std::vector<std::string>{""};
  if (named != read.is_object())
    throw SpecError(at, shown(read),
                    named ? "expected strokes by the names of the drives"
                          : "expected the stroke of the drive, which has no name");
  if (!named) {
    strokes[0] = read_quantity(stroke_place(drives[0].direction), read, at);
    return strokes;
  }
  for (const auto& [name, stroke] : read.items()) {
    const auto k = std::ranges::find(known, name) - known.begin();
    if (k == strokes.size())
      throw SpecError(at / name, shown(stroke),
                      "no drive has this name; " + known_names(name, known));
    strokes[k] = read_quantity(stroke_place(drives[static_cast<std::size_t>(k)].direction), stroke,
                               at / name);
  }
  return strokes;
}

/// How the drives are held in a step behind others.
MountingStep read_drives(const json& read, const MountingSpec& spec, const Mechanism& mechanism,
                         const LoadCase& loads, const Pointer& at) {
  MountingStep step{.name = spec.name, .drives_free = spec.drives_free};
  for (const char* key : {"drive", "stroke"})
    if (read.contains(key) && (mechanism.drives.empty() || !loads.driven()))
      throw SpecError(at / key, shown(read[key]), "nothing is driven here");
  if (spec.drives_free && read.contains("stroke"))
    throw SpecError(at / "stroke", shown(read["stroke"]), "the drive is free in this step");
  if (spec.drives_free && !loads.mounting.empty() && !loads.mounting.back().drives_free)
    throw SpecError(at / "drive", shown(read["drive"]),
                    "the step before holds the drives, and what was held is not freed: free them "
                    "from the first step on");
  if (read.contains("stroke"))
    step.strokes = read_strokes(read["stroke"], mechanism, at / "stroke");
  return step;
}

/// The step in which each item of a kind comes, none of them at first.
class StepsOf {
 public:
  StepsOf(std::string what, std::vector<std::string> names)
      : what_(std::move(what)), names_(std::move(names)), steps_(names_.size()) {}

  /// Throws SpecError where no item has this name, or it comes before.
  void put_on(const std::string& name, int step, const Pointer& at) {
    const auto found = std::ranges::find(names_, name);
    if (found == names_.end() || name.empty())
      throw SpecError(at, shown(name),
                      fmt::format("no {} has this name; {}", what_, known_names(name, names_)));
    std::optional<int>& own = steps_[static_cast<std::size_t>(found - names_.begin())];
    if (own)
      throw SpecError(at, shown(name),
                      fmt::format("it comes in step {} of the mounting already", *own + 1));
    own = step;
  }
  /// Of an item; where no step names it, `last`.
  int of(std::size_t item, int last) const { return steps_[item].value_or(last); }

 private:
  std::string what_;
  std::vector<std::string> names_;
  std::vector<std::optional<int>> steps_;
};

Shape edge_shape() {
  std::vector<Field> fields = assembly_table().fields();
  for (Field& field : fields) {
    if (field.name == "move") {
      field.shape = vector3("m", largest_edge_size);
      field.meaning = "largest to either side, of the edge's middle";
    }
    if (field.name == "turn") {
      field.shape = vector3("rad", largest_edge_size);
      field.meaning = "largest to either side, about each axis";
    }
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

Shape mounting_shape() {
  return shape::one_of({shape::list(assembly_table().shape(), 0, 1000),
                        shape::record({shape::required(
                            "steps", shape::list(mounting_table().shape(), 1, 100),
                            "of the mounting, before the stroke, one after the other")})});
}

std::vector<EdgeSize> read_mounting(const json& read, const Family& family,
                                    const Mechanism& mechanism, FaultList& faults,
                                    LoadCase& loads) {
  std::vector<EdgeSize> sizes;
  if (read.is_array())
    read_edges(read, Pointer("/assembly"), 0, family, mechanism, faults, loads, sizes);
  if (!read.contains("steps")) return sizes;
  StepsOf dead("load", names_in(loads.constant)), springs("spring", names_in(mechanism.springs)),
      around("kind", {"gravity", "temperature"});
  int k = 0;
  faults.each(read["steps"], Pointer("/assembly/steps"), [&](const json& item, const Pointer& at) {
    const MountingSpec spec = mounting_table().read(item);
    read_edges(item["edges"], at / "edges", k, family, mechanism, faults, loads, sizes);
    loads.mounting.push_back(read_drives(item, spec, mechanism, loads, at));
    for (std::size_t i = 0; faults.sound("/loads") && i < spec.loads.size(); ++i)
      dead.put_on(spec.loads[i], k, at / "loads" / i);
    for (std::size_t i = 0; i < spec.springs.size(); ++i)
      springs.put_on(spec.springs[i], k, at / "springs" / i);
    for (const auto& [kind, comes] :
         {std::pair{"gravity", spec.gravity}, {"temperature", spec.temperature}})
      if (comes) around.put_on(kind, k, at / kind);
    ++k;
  });
  bool rest = false;  // that no step names
  const auto step_of = [&](const StepsOf& steps, std::size_t item, bool acts) {
    const int step = steps.of(item, acts ? k : 0);
    rest = rest || step == k;
    return step;
  };
  for (std::size_t i = 0; i < loads.constant.size(); ++i)
    loads.constant[i].step = step_of(dead, i, true);
  for (std::size_t i = 0; i < mechanism.springs.size(); ++i)
    loads.spring_steps.push_back(step_of(springs, i, !mechanism.springs[i].matrix));
  loads.gravity_step = step_of(around, 0, !loads.gravity.isZero(0));
  loads.temperature_step =
      step_of(around, 1, !loads.temperature.empty() || !loads.body_expansion.empty());
  if (rest) loads.mounting.push_back({.name = "the rest"});
  return sizes;
}

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
