#include <fmt/format.h>

#include <cassert>
#include <nlohmann/json.hpp>

#include "core/response/quantities.hpp"
#include "results/files/csv_text.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"
#include "results/files/units.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

/// A row of values for each value of the first parameter.
Json rows_json(const MapValues& values, std::size_t columns) {
  Json rows = Json::array();
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (k % columns == 0) rows.push_back(Json::array());
    rows.back().push_back(optional_json(values[k]));
  }
  return rows;
}

Json parameters_json(const RunRecord& record, const MapSpec& map, const ResponseMap& found) {
  const Family& family = resolve(record.job.design)->family();
  Json parameters = Json::array();
  for (std::size_t k = 0; k < 2; ++k) {
    const Variable& axis = map.parameters[k];
    Json start = found.held[k];
    if (record.optimum)
      for (const Variable& v : record.job.optimise->variables)
        if (v.parameter == axis.parameter && v.start) start = *v.start;
    parameters.push_back({{"parameter", axis.parameter},
                          {"unit", parameter_unit(family, axis.parameter)},
                          {"values", found.parameters[k]},
                          {"start", std::move(start)},
                          {"held", found.held[k]}});
  }
  return parameters;
}

Json map_json(const RunRecord& record, const MapSpec& map, const ResponseMap& found) {
  const DriveList drives(record.mechanism);
  const std::size_t columns = found.parameters[1].size();
  Json quantities = Json::array();
  for (std::size_t q = 0; q < map.quantities.size(); ++q) {
    const Constraint& of = map.quantities[q];
    Json json = {{"label", of.label}};
    if (of.expression.empty())
      json.update({{"quantity", of.quantity}, {"over_stroke", name_of(of.over_stroke)}});
    else
      json["expression"] = of.expression;
    json["unit"] = goal_unit(of.quantity, drives);
    json["values"] = rows_json(found.quantities[q], columns);
    quantities.push_back(std::move(json));
  }
  return {{"parameters", parameters_json(record, map, found)},
          {"model", {{"accuracy", "reduced"}, {"atlas", found.looked_up}}},
          {"quantities", std::move(quantities)},
          {"margin", found.margin.empty() ? Json() : rows_json(found.margin, columns)},
          {"failed", found.failed},
          {"first_failure", found.first_failure}};
}

/// A row for each design of each map and each of its quantities.
std::string maps_csv(const RunRecord& record) {
  std::string text = csv::row({"map", "first parameter", "value [SI]", "second parameter",
                               "value [SI]", "quantity", "unit", "value", "margin [1]"});
  const DriveList drives(record.mechanism);
  for (std::size_t m = 0; m < record.maps.size(); ++m) {
    const MapSpec& map = record.job.maps[m];
    const ResponseMap& found = record.maps[m];
    const std::size_t columns = found.parameters[1].size();
    for (std::size_t q = 0; q < map.quantities.size(); ++q)
      for (std::size_t k = 0; k < found.quantities[q].size(); ++k)
        text += csv::row({fmt::format("{}", m), csv::text_cell(map.parameters[0].parameter),
                          csv::number_cell(found.parameters[0][k / columns]),
                          csv::text_cell(map.parameters[1].parameter),
                          csv::number_cell(found.parameters[1][k % columns]),
                          csv::text_cell(map.quantities[q].label),
                          csv::text_cell(goal_unit(map.quantities[q].quantity, drives)),
                          csv::number_cell(found.quantities[q][k]),
                          found.margin.empty() ? "" : csv::number_cell(found.margin[k])});
  }
  return text;
}

}  // namespace

OrderedJson make_maps(const RunRecord& record) {
  assert(record.maps.size() == record.job.maps.size());
  Json maps = Json::array();
  for (std::size_t k = 0; k < record.maps.size(); ++k)
    maps.push_back(map_json(record, record.job.maps[k], record.maps[k]));
  return maps;
}

void write_maps_csv(const std::filesystem::path& folder, const RunRecord& record) {
  write_or_remove(folder / "maps.csv", record.maps.empty() ? "" : maps_csv(record));
}

}  // namespace flexopt
