#include "results/files/assembly.hpp"

#include <cassert>

#include "core/response/quantities.hpp"
#include "results/files/units.hpp"

namespace flexopt {
namespace {

using Json = OrderedJson;

Json errors_json(const std::vector<AssemblyError>& errors, const Mechanism& mechanism) {
  Json list = Json::array();
  for (const AssemblyError& e : errors)
    list.push_back({{"leaf", mechanism.leaves[static_cast<std::size_t>(e.leaf)].name},
                    {"end", e.end == 0 ? "base" : "tip"},
                    {"move", {e.move[0], e.move[1], e.move[2]}},
                    {"turn", {e.turn[0], e.turn[1], e.turn[2]}}});
  return list;
}

Json worst_json(const WorstAssembly& worst, const RunRecord& record, const DriveList& drives) {
  Json as_bad = Json::array();
  for (const std::vector<AssemblyError>& errors : worst.as_bad)
    as_bad.push_back(errors_json(errors, record.mechanism));
  return {{"quantity", worst.of.quantity},
          {"over_stroke", name_of(worst.of.over_stroke)},
          {"unit", quantity_unit(worst.of.quantity, drives)},
          {"nominal", worst.nominal},
          {"corner", worst.corner ? Json(*worst.corner) : Json()},
          {"worst", worst.worst ? Json(*worst.worst) : Json()},
          {"stroke", record.job.request.points[worst.point]},
          {"misalignment", errors_json(worst.misalignment, record.mechanism)},
          {"as_bad", std::move(as_bad)},
          {"evaluations", worst.evaluations},
          {"reason", worst.reason}};
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
  if (const auto& critical = report.critical)
    json["critical"] = {{"scale", critical->scale},
                        {"limit", critical->limit},
                        {"reason", critical->text},
                        {"stroke", record.job.request.points[critical->point]},
                        {"misalignment", errors_json(critical->misalignment, record.mechanism)},
                        {"evaluations", critical->evaluations}};
  return json;
}

}  // namespace flexopt
