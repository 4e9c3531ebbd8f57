#include <cassert>

#include "core/response/quantities.hpp"
#include "results/files/result_parts.hpp"
#include "results/files/units.hpp"

namespace flexopt {
namespace {

using Json = OrderedJson;

Json errors_json(const std::vector<AssemblyError>& errors, const Mechanism& mechanism) {
  Json list = Json::array();
  for (const AssemblyError& e : errors)
    list.push_back({{"leaf", mechanism.leaves[static_cast<std::size_t>(e.leaf)].name},
                    {"end", e.end == 0 ? "base" : "tip"},
                    {"move", vector_json(e.move)},
                    {"turn", vector_json(e.turn)}});
  return list;
}

/// Adds the stroke of a place, and its load case, where there are several.
void add_place(const GoalPlace& place, const Job& job, Json& json) {
  const JobCase one = cases_of(job)[place.load_case];
  if (!one.name.empty()) json["case"] = one.name;
  json["stroke"] = one.request.points[place.point];
}

Json worst_json(const WorstAssembly& worst, const RunRecord& record, const DriveList& drives) {
  Json as_bad = Json::array();
  for (const std::vector<AssemblyError>& errors : worst.as_bad)
    as_bad.push_back(errors_json(errors, record.mechanism));
  Json json = {{"quantity", worst.of.quantity},
               {"over_stroke", name_of(worst.of.over_stroke)},
               {"unit", quantity_unit(worst.of.quantity, drives)},
               {"nominal", worst.nominal},
               {"corner", optional_json(worst.corner)},
               {"worst", optional_json(worst.worst)}};
  add_place(worst.place, record.job, json);
  json["misalignment"] = errors_json(worst.misalignment, record.mechanism);
  json["as_bad"] = std::move(as_bad);
  json["evaluations"] = worst.evaluations;
  json["reason"] = worst.reason;
  return json;
}

}  // namespace

OrderedJson make_assembly(const RunRecord& record) {
  assert(record.assembly);
  const AssemblyReport& report = *record.assembly;
  const DriveList drives(record.mechanism);
  Json worst = Json::array();
  for (const WorstAssembly& one : report.quantities)
    worst.push_back(worst_json(one, record, drives));
  Json json = {
      {"convention",
       "worst: found in the box of errors by local searches from its middle and from "
       "points of a Sobol sequence; as_bad: other places that were met and are no better but for "
       "rounding; corner: where the gradients in the middle point to; "
       "critical: the scale of the box up to which nothing critical was found in it"},
      {"message", report.message},
      {"worst_case", std::move(worst)},
      {"critical", nullptr}};
  if (const auto& critical = report.critical) {
    Json& own = json["critical"] = {
        {"scale", critical->scale}, {"limit", critical->limit}, {"reason", critical->text}};
    add_place(critical->place, record.job, own);
    own["misalignment"] = errors_json(critical->misalignment, record.mechanism);
    own["evaluations"] = critical->evaluations;
  }
  return json;
}

}  // namespace flexopt
