#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "results/files/folder.hpp"
#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

std::string name_of(ToleranceSpread spread) {
  return spread == ToleranceSpread::uniform ? "uniform" : "normal";
}

Json entries_json(const std::vector<Tolerance>& entries, const Family& family) {
  Json list = Json::array();
  for (const Tolerance& entry : entries) {
    Json changes = Json::object(), deviations = Json::object(), units = Json::object();
    for (const ToleranceTerm& term : entry.terms) {
      changes[term.parameter] = term.change;
      units[term.parameter] = parameter_unit(family, term.parameter);
      deviations[term.parameter] = std::abs(term.change) * entry.standard_deviation();
    }
    list.push_back({{"name", entry.name},
                    {"entry", entry.entry},
                    {"distribution", name_of(entry.spread)},
                    {"units", std::move(units)},
                    {"at_upper_limit", std::move(changes)},
                    {"standard_deviation", std::move(deviations)}});
  }
  return list;
}

Json sampled_json(const std::optional<SampledNumber>& sampled) {
  if (!sampled) return nullptr;
  return {{"count", sampled->count},
          {"mean", sampled->mean},
          {"standard_deviation", sampled->standard_deviation},
          {"low", sampled->low},
          {"high", sampled->high}};
}

Json number_json(const ToleratedNumber& number, const std::vector<Tolerance>& entries) {
  Json json = {{"value", number.value},
               {"worst", nullptr},
               {"standard_deviation", nullptr},
               {"shares", nullptr}};
  if (number.slopes) {
    json["worst"] = farthest(*number.slopes);
    json["standard_deviation"] = standard_deviation(entries, *number.slopes);
    json["shares"] = Json::object();
    const VectorXd shares = variance_shares(entries, *number.slopes);
    for (std::size_t e = 0; e < entries.size(); ++e) json["shares"][entries[e].name] = shares[e];
  }
  json["sampled"] = sampled_json(number.sampled);
  return json;
}

double spread_of(const ToleratedNumber& number, const std::vector<Tolerance>& entries) {
  if (number.slopes) return standard_deviation(entries, *number.slopes);
  return number.sampled ? number.sampled->standard_deviation : 0;
}

Json widest_json(const RunRecord& record, const DriveList& drives) {
  Json list = Json::array();
  for (const ToleratedQuantity* q : widest_spreads(record)) {
    const JobCase one = cases_of(record.job)[q->load_case];
    Json& json = list.emplace_back(Json::object());
    if (!one.name.empty()) json["case"] = one.name;
    json.update({{"stroke", one.request.points[q->point]},
                 {"point", q->point},
                 {"quantity", q->name},
                 {"unit", quantity_unit(q->name, drives)}});
    json.update(number_json(q->number, record.job.tolerances->entries));
  }
  return list;
}

/// Point by point the quantities of a load case.
Json path_json(const RunRecord& record, std::size_t load_case) {
  const JobCase one = cases_of(record.job)[load_case];
  Json path = Json::array();
  for (const double stroke : one.request.points)
    path.push_back({{"stroke", stroke}, {"quantities", Json::object()}});
  for (const ToleratedQuantity& q : record.tolerances->quantities)
    if (q.load_case == load_case)
      path[q.point]["quantities"][q.name] = number_json(q.number, record.job.tolerances->entries);
  return path;
}

Json goal_json(const RunRecord& record, const ToleratedGoal& goal, const DriveList& drives) {
  const bool formula = !goal.expression.empty();
  Json json = {{"label", goal.label},
               {formula ? "expression" : "quantity", formula ? goal.expression : goal.quantity},
               {"unit", formula ? goal.unit : quantity_unit(goal.quantity, drives)}};
  json.update(number_json(goal.number, record.job.tolerances->entries));
  json["low"] = goal.number.slopes ? Json(goal.low) : Json();
  json["high"] = goal.number.slopes ? Json(goal.high) : Json();
  json["min"] = optional_json(goal.min);
  json["max"] = optional_json(goal.max);
  json["allowed"] = goal.min || goal.max ? Json(goal.allowed) : Json();
  json["room"] = optional_json(goal.room);
  json["missed"] = optional_json(goal.missed);
  if (!record.job.cases.empty())
    json["decisive"] =
        goal.decisive ? place_json(record.job, record.mechanism, *goal.decisive) : Json();
  return json;
}

/// A row of values for each value of the first parameter.
Json map_rows_json(const MapValues& values, std::size_t columns) {
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
  const DriveList drives = drives_of(record);
  const std::size_t columns = found.parameters[1].size();
  Json quantities = Json::array();
  for (std::size_t q = 0; q < map.quantities.size(); ++q) {
    const Constraint& of = map.quantities[q];
    Json json = {{"label", of.label}};
    json.update(measure_json(of, drives));
    json["values"] = map_rows_json(found.quantities[q], columns);
    quantities.push_back(std::move(json));
  }
  return {{"parameters", parameters_json(record, map, found)},
          {"model", {{"accuracy", "reduced"}, {"atlas", found.looked_up}}},
          {"quantities", std::move(quantities)},
          {"margin", found.margin.empty() ? Json() : map_rows_json(found.margin, columns)},
          {"failed", found.failed},
          {"first_failure", found.first_failure}};
}

/// A row for each design of each map and each of its quantities.
std::string maps_csv(const RunRecord& record) {
  std::string text = csv::row({"map", "first parameter", "value [SI]", "second parameter",
                               "value [SI]", "quantity", "unit", "value", "margin [1]"});
  const DriveList drives = drives_of(record);
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
                          csv::text_cell(goal_unit(map.quantities[q], drives)),
                          csv::number_cell(found.quantities[q][k]),
                          found.margin.empty() ? "" : csv::number_cell(found.margin[k])});
  }
  return text;
}

Json errors_json(const std::vector<AssemblyError>& errors, const Mechanism& mechanism) {
  Json list = Json::array();
  for (const AssemblyError& e : errors)
    list.push_back({{"leaf", mechanism.leaves[e.leaf].name},
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
  Json json = measure_json(worst.of, drives);
  json.update({{"nominal", worst.nominal},
               {"corner", optional_json(worst.corner)},
               {"worst", optional_json(worst.worst)}});
  add_place(worst.place, record.job, json);
  json["misalignment"] = errors_json(worst.misalignment, record.mechanism);
  json["as_bad"] = list_json(
      worst.as_bad, [&](const auto& errors) { return errors_json(errors, record.mechanism); });
  json["evaluations"] = worst.evaluations;
  json["reason"] = worst.reason;
  return json;
}

}  // namespace

std::vector<const ToleratedQuantity*> widest_spreads(const RunRecord& record) {
  const std::vector<Tolerance>& entries = record.job.tolerances->entries;
  std::vector<const ToleratedQuantity*> widest;
  for (const ToleratedQuantity& q : record.tolerances->quantities) {
    const double spread = spread_of(q.number, entries);
    if (spread <= 1e-9 * std::abs(q.number.value)) continue;
    const auto known = std::ranges::find_if(widest, [&](const ToleratedQuantity* other) {
      return other->load_case == q.load_case && other->name == q.name;
    });
    if (known == widest.end())
      widest.push_back(&q);
    else if (spread > spread_of((*known)->number, entries))
      *known = &q;
  }
  return widest;
}

OrderedJson make_tolerances(const RunRecord& record) {
  assert(record.tolerances && record.job.tolerances);
  const ToleranceReport& report = *record.tolerances;
  const TolerancesSpec& spec = *record.job.tolerances;
  const DriveList drives = drives_of(record);
  const auto goal = [&](const ToleratedGoal& of) { return goal_json(record, of, drives); };
  Json json = {
      {"convention",
       "first order in the tolerances, by exact derivatives: worst is how far a number gets within "
       "the limits, shares are those of its variance, room is the largest common scale of all "
       "limits that keeps every constraint; a normal tolerance has its limits at three standard "
       "deviations; yield is the share of the samples that miss no bound by more than allowed (the "
       "constraint tolerance of the search), missed the share that misses this one; widest is "
       "where a quantity spreads most"},
      {"message", report.message},
      {"entries", entries_json(report.entries, resolve(record.job.design)->family())},
      {"goals", list_json(report.goals, goal)},
      {"room",
       report.room ? Json{{"scale", *report.room}, {"constraint", report.room_of}} : Json()},
      {"samples",
       {{"count", report.samples},
        {"seed", spec.seed},
        {"failed", report.failed},
        {"first_failure", report.first_failure}}},
      {"yield", optional_json(report.yield)},
      {"widest", widest_json(record, drives)},
      {"path", path_json(record, 0)}};
  for (std::size_t k = 0; k < record.job.cases.size(); ++k)
    json["cases"][record.job.cases[k].name] = {{"path", path_json(record, k)}};
  return json;
}

std::string tolerances_csv(const RunRecord& record) {
  const std::vector<Tolerance>& entries = record.job.tolerances->entries;
  const std::vector<JobCase> cases = cases_of(record.job);
  const bool several = !record.job.cases.empty();
  std::vector<std::string> cells;
  if (several) cells.push_back("case");
  cells.insert(cells.end(),
               {"point", "stroke [SI]", "quantity", "unit", "value", "worst", "standard deviation",
                "sampled mean", "sampled standard deviation", "sampled low", "sampled high"});
  for (const Tolerance& entry : entries) cells.push_back(csv::text_cell("share: " + entry.name));
  std::string text = csv::row(cells);
  const DriveList drives = drives_of(record);
  for (const ToleratedQuantity& q : record.tolerances->quantities) {
    cells.clear();
    const JobCase& one = cases[q.load_case];
    if (several) cells.push_back(csv::text_cell(one.name));
    const ToleratedNumber& n = q.number;
    cells.insert(cells.end(),
                 {fmt::format("{}", q.point), csv::number_cell(one.request.points[q.point]),
                  csv::text_cell(q.name), csv::text_cell(quantity_unit(q.name, drives)),
                  csv::number_cell(n.value)});
    std::optional<double> worst, deviation;
    if (n.slopes) worst = farthest(*n.slopes), deviation = standard_deviation(entries, *n.slopes);
    cells.push_back(csv::number_cell(worst));
    cells.push_back(csv::number_cell(deviation));
    for (const auto member : {&SampledNumber::mean, &SampledNumber::standard_deviation,
                              &SampledNumber::low, &SampledNumber::high})
      cells.push_back(n.sampled ? csv::number_cell((*n.sampled).*member) : "");
    const VectorXd shares = n.slopes ? variance_shares(entries, *n.slopes) : VectorXd();
    for (std::size_t e = 0; e < entries.size(); ++e)
      cells.push_back(n.slopes ? csv::number_cell(shares[e]) : "");
    text += csv::row(cells);
  }
  return text;
}

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

OrderedJson make_assembly(const RunRecord& record) {
  assert(record.assembly);
  const AssemblyReport& report = *record.assembly;
  const DriveList drives = drives_of(record);
  const auto worst = [&](const WorstAssembly& of) { return worst_json(of, record, drives); };
  Json json = {
      {"convention",
       "worst: found in the box of errors by local searches from its middle and from "
       "points of a Sobol sequence; as_bad: other places that were met and are no better but for "
       "rounding; corner: where the gradients in the middle point to; "
       "critical: the scale of the box up to which nothing critical was found in it"},
      {"message", report.message},
      {"worst_case", list_json(report.quantities, worst)},
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
