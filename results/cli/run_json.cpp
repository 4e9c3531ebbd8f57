#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "results/cli/printed.hpp"
#include "results/files/result_json.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

/// An object with these members of another, null where it has none.
Json picked(const Json& from, std::initializer_list<const char*> keys) {
  Json some = Json::object();
  for (const char* key : keys) some[key] = from.contains(key) ? from.at(key) : Json();
  return some;
}

Json table_json(const StrokeResponse& response, const DriveList& drives,
                const StrokeRequest& request) {
  Json table = Json::array();
  for (const StrokeRow& row : stroke_table(response, drives, request)) {
    Json json = {{"quantity", row.quantity}, {"label", row.label}, {"unit", row.unit}};
    Json values = Json::array(), directions = Json::array(), at_least = Json::array();
    bool directed = false, bound = false;
    for (const StrokeCell& cell : row.cells) {
      values.push_back(optional_json(cell.value));
      directions.push_back(cell.direction.empty() ? Json() : Json(cell.direction));
      at_least.push_back(cell.at_least);
      bound = bound || cell.at_least;
      directed = directed || !cell.direction.empty();
    }
    json["values"] = std::move(values);
    if (directed) json["directions"] = std::move(directions);
    if (bound) json["at_least"] = std::move(at_least);
    table.push_back(std::move(json));
  }
  return table;
}

Json optimum_json(const Json& optimum) {
  Json json = picked(optimum, {"status", "stop_reason", "objective", "goal", "parameters"});
  json["constraints"] = Json::array();
  for (const Json& constraint : optimum.at("constraints"))
    json["constraints"].push_back(
        picked(constraint, {"label", "unit", "value", "min", "max", "margin", "active"}));
  json["verified"] = nullptr;
  if (const Json& verified = optimum.at("verified"); verified.is_object())
    json["verified"] =
        picked(verified, {"status", "objective", "objective_difference", "constraints"});
  json.update(picked(optimum, {"evaluations", "failed_evaluations"}));
  return json;
}

Json comparison_json(const Json& comparison) {
  Json json = picked(comparison, {"designs", "failed_designs"});
  json["models"] = Json::array();
  for (const Json& model : comparison.at("models")) {
    Json shown = picked(model, {"name", "failures", "fallbacks", "speed_up"});
    for (const auto& [quantity, figures] : model.at("errors").items())
      if (figures.at("count") != 0)
        shown["errors"][quantity] = picked(figures, {"worst", "p99", "median", "worst_at"});
    json["models"].push_back(std::move(shown));
  }
  return json;
}

/// Listed designs without their whole results.
Json list_json(const Json& list) {
  Json entries = Json::array();
  for (const Json& entry : list) {
    Json shown = entry;
    shown.erase("result");
    entries.push_back(std::move(shown));
  }
  return entries;
}

void add_tables(const RunRecord& record, Json& json) {
  const DriveList drives(record.mechanism);
  if (record.job.cases.empty()) {
    json["table"] = table_json(response_of(record), drives, record.job.request);
    return;
  }
  const auto responses = responses_of(record);
  for (std::size_t k = 0; k < responses.size(); ++k)
    json["cases"][record.job.cases[k].name]["table"] =
        table_json(*responses[k], drives, record.job.cases[k].request);
}

Json error_json(const Fault& fault) {
  Json json = {{"pointer", fault.pointer},
               {"value", fault.value},
               {"rule", fault.rule},
               {"message", fault.text()}};
  if (!fault.source.empty()) json["source"] = fault.source;
  if (fault.line > 0) json.update({{"line", fault.line}, {"column", fault.column}});
  return json;
}

Json failure_json(const std::string& status, const std::string& message) {
  return {{"flexopt", version()},
          {"status", status},
          {"usable", false},
          {"error", {{"pointer", ""}, {"value", ""}, {"rule", ""}, {"message", message}}}};
}

/// Prints a document on one line.
void print(Json document) {
  remove_non_finite(document);
  fmt::print("{}\n", compact_text(document));
}

}  // namespace

void print_run(const WrittenRun& written, const std::string& folder, const RunRecord* record) {
  const Json& result = *written.result;
  Json json = {{"flexopt", version()}};
  json.update(picked(result, {"status", "message"}));
  json["usable"] = usable(result);
  json["folder"] = folder;
  json.update(picked(result.at("job"), {"name", "job"}));
  json["failed_expectations"] = written.failed_expectations;
  for (const char* list : {"ranking", "designs"})
    if (result.contains(list)) json[list] = list_json(result.at(list));
  if (!record) return print(std::move(json));
  if (record->comparison) {
    json["comparison"] = comparison_json(result.at("comparison"));
    return print(std::move(json));
  }
  if (record->optimum) json["optimum"] = optimum_json(result.at("optimum"));
  if (record->tolerances)
    json["tolerances"] = picked(result.at("tolerances"), {"goals", "room", "yield"});
  if (record->assembly)
    json["assembly_tolerances"] =
        picked(result.at("assembly_tolerances"), {"message", "worst_case", "critical"});
  add_tables(*record, json);
  print(std::move(json));
}

void print_shard(const Shard& shard, const std::vector<SharedLoop>& loops,
                 const std::string& folder) {
  Json json = {{"flexopt", version()},  {"status", "shard"},     {"usable", true},
               {"folder", folder},      {"shard", shard.number}, {"of", shard.of},
               {"loops", Json::array()}};
  for (const SharedLoop& loop : loops)
    json["loops"].push_back({{"what", loop.what}, {"here", loop.here}, {"all", loop.all}});
  print(std::move(json));
}

void print_wrong_input(const SpecError& error) {
  Json json = failure_json("wrong_input", error.what());
  json["error"] = error_json(error.faults().front());
  json["errors"] = Json::array();
  for (const Fault& fault : error.faults()) json["errors"].push_back(error_json(fault));
  print(std::move(json));
}

void print_failure(const std::string& status, const std::string& message) {
  print(failure_json(status, message));
}

}  // namespace flexopt
