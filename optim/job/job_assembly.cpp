#include "optim/job/job_assembly.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

/// One value over the stroke has no worse side of its own.
const EnumNames<OverStroke> worse_names{
    {"min", OverStroke::min}, {"max", OverStroke::max}, {"max_abs", OverStroke::max_abs}};

const RecordTable<Constraint>& worst_table() {
  static const auto table =
      RecordTable<Constraint>()
          .required("quantity", shape::text(100), &Constraint::quantity,
                    "whose worst value is looked for")
          .choice<OverStroke>("over_stroke", worse_names, &Constraint::over_stroke,
                              "its worse side, and which value over the stroke: the least, the "
                              "largest, or the largest in size");
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
                        "of the starts");
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
  const auto found = std::ranges::find(mechanism.leaves, spec.leaf, &LeafSpring::name);
  std::vector<std::string> known;
  for (const LeafSpring& leaf : mechanism.leaves) known.push_back(leaf.name);
  if (found == mechanism.leaves.end())
    throw SpecError((at / "leaf").to_string(), shown(spec.leaf),
                    "no leaf has this name; " + known_names(spec.leaf, known));
  if (spec.end == 1 && found->tip == free_edge)
    throw SpecError((at / "end").to_string(), shown(read["end"]),
                    "the tip of this leaf is free: no body holds it");
  for (const auto& [key, sizes] : {std::pair{"move", spec.move}, {"turn", spec.turn}})
    for (int i = 0; i < 3; ++i)
      if (sizes[i] < 0)
        throw SpecError((at / key / i).to_string(), fmt::format("{:g}", sizes[i]),
                        "it is a size to either side: expected 0 or more");
  if (spec.move.isZero(0) && spec.turn.isZero(0))
    throw SpecError(at.to_string(), shown(read), "this edge has neither move nor turn");
  return {static_cast<int>(found - mechanism.leaves.begin()), spec.end, spec.move, spec.turn};
}

}  // namespace

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

AssemblyTolerances read_assembly_tolerances(json& read, const Mechanism& mechanism,
                                            const GoalContext& context) {
  const Pointer at("/assembly_tolerances");
  FaultList& faults = context.faults;
  AssemblyTolerances spec = box_table().read(read);
  if (!context.cases.all.empty())
    faults.add(at.to_string(), fmt::format("{} load cases", context.cases.all.size()),
               "it is looked at in a job without cases");
  std::set<std::pair<int, int>> edges;
  for (std::size_t i = 0; i < read["edges"].size(); ++i)
    faults.attempt([&] {
      const Pointer here = at / "edges" / i;
      const EdgeTolerance edge = read_edge(read["edges"][i], mechanism, here);
      if (!edges.insert({edge.leaf, edge.end}).second)
        throw SpecError((here / "end").to_string(), shown(read["edges"][i]["end"]),
                        "one box for each edge: this one has another");
      spec.edges.push_back(edge);
    });
  for (std::size_t i = 0; i < read["quantities"].size(); ++i)
    faults.attempt([&] {
      Constraint one = worst_table().read(read["quantities"][i]);
      one.quantity = context.quantity(one.quantity, "", at / "quantities" / i / "quantity").name;
      if (is_of_design(one.quantity))
        throw SpecError((at / "quantities" / i / "quantity").to_string(), shown(one.quantity),
                        "it is the same however the mechanism is assembled");
      one.label = goal_label(one);
      spec.quantities.push_back(std::move(one));
    });
  const bool drives = !mechanism.drives.empty() && context.request.loads.driven();
  if (spec.drive_load_change && !drives)
    faults.add((at / "drive_load_change").to_string(), shown(read["drive_load_change"]),
               "nothing is driven here");
  if (read["quantities"].empty() && !spec.stiffness_share && !spec.drive_load_change)
    faults.add((at / "quantities").to_string(), shown(read["quantities"]),
               "name quantities, or give stiffness_share or drive_load_change");
  return spec;
}

}  // namespace flexopt
