#include <nlohmann/json.hpp>

#include "core/response/quantities.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {
namespace {

using Json = OrderedJson;

Json largest_json(const LargestError& largest, const Job& job) {
  Json json = {{"quantity", largest.name}, {"point", largest.point}};
  if (!job.cases.empty()) json["case"] = job.cases[largest.path].name;
  json["relative"] = largest.relative;
  json["of_it"] = {{"elements_along", largest.along},
                   {"elements_across", largest.across},
                   {"reduction", largest.reduction},
                   {"theory", largest.theory}};
  return json;
}

}  // namespace

Json point_errors_json(const std::vector<EstimatedError>& errors) {
  Json relative = Json::object(), absolute = Json::object();
  for (const QuantityRow& row : quantity_rows())
    if (row.error == ErrorKind::none) {
      const std::string key = row.name.substr(0, row.name.find('.'));
      relative[key] = absolute[key] = nullptr;
    }
  for (const EstimatedError& error : errors) {
    relative[Json::json_pointer(error.pointer)] = error.scale > 0 ? Json(error.relative()) : Json();
    absolute[Json::json_pointer(error.pointer)] = error.absolute();
  }
  return {{"relative", std::move(relative)}, {"absolute", std::move(absolute)}};
}

Json accuracy_json(const RunRecord& record) {
  const ModelOptions& model = record.job.model;
  Json json = {{"accuracy", name_of(model.accuracy)}, {"mesh", model.mesh}};
  for (const bool stresses : {false, true}) {
    const auto largest = largest_error(record.errors, stresses);
    json[stresses ? "largest_of_stresses" : "largest"] =
        largest ? largest_json(*largest, record.job) : Json();
  }
  if (!record.chosen) return json;
  json["tolerance"] = record.job.accuracy.tolerance;
  json["met"] = meets_tolerance(record);
  json["beyond"] = Json::array();
  for (const LargestError& error : errors_beyond(record.errors, record.job.accuracy.tolerance))
    json["beyond"].push_back(largest_json(error, record.job));
  json["message"] = record.chosen->message;
  json["tried"] = Json::array();
  for (const TriedModel& tried : record.chosen->tried)
    json["tried"].push_back(
        {{"accuracy", name_of(tried.accuracy)},
         {"mesh", tried.mesh},
         {"largest", tried.message.empty() ? largest_json(tried.largest, record.job) : Json()},
         {"message", tried.message}});
  return json;
}

}  // namespace flexopt
