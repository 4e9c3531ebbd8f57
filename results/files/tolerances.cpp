#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/response/quantities.hpp"
#include "results/files/csv_text.hpp"
#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"
#include "results/files/units.hpp"

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
    for (std::size_t e = 0; e < entries.size(); ++e)
      json["shares"][entries[e].name] = shares[static_cast<Eigen::Index>(e)];
  }
  json["sampled"] = sampled_json(number.sampled);
  return json;
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
               {"unit", goal_unit(goal.quantity, drives)}};
  json.update(number_json(goal.number, record.job.tolerances->entries));
  json["low"] = goal.number.slopes ? Json(goal.low) : Json();
  json["high"] = goal.number.slopes ? Json(goal.high) : Json();
  json["min"] = optional_json(goal.min);
  json["max"] = optional_json(goal.max);
  json["room"] = optional_json(goal.room);
  if (!record.job.cases.empty())
    json["decisive"] =
        goal.decisive ? place_json(record.job, record.mechanism, *goal.decisive) : Json();
  return json;
}

}  // namespace

OrderedJson make_tolerances(const RunRecord& record) {
  assert(record.tolerances && record.job.tolerances);
  const ToleranceReport& report = *record.tolerances;
  const TolerancesSpec& spec = *record.job.tolerances;
  const DriveList drives(record.mechanism);
  Json goals = Json::array();
  for (const ToleratedGoal& goal : report.goals) goals.push_back(goal_json(record, goal, drives));
  Json json = {
      {"convention",
       "first order in the tolerances, by exact derivatives: worst is how far a number gets within "
       "the limits, shares are those of its variance, room is the largest common scale of all "
       "limits that keeps every constraint; a normal tolerance has its limits at three standard "
       "deviations"},
      {"message", report.message},
      {"entries", entries_json(report.entries, resolve(record.job.design)->family())},
      {"goals", std::move(goals)},
      {"room",
       report.room ? Json{{"scale", *report.room}, {"constraint", report.room_of}} : Json()},
      {"samples",
       {{"count", report.samples},
        {"seed", spec.seed},
        {"failed", report.failed},
        {"first_failure", report.first_failure}}},
      {"yield", optional_json(report.yield)},
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
  const DriveList drives(record.mechanism);
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
      cells.push_back(n.slopes ? csv::number_cell(shares[static_cast<Eigen::Index>(e)]) : "");
    text += csv::row(cells);
  }
  return text;
}

}  // namespace flexopt
