#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {

namespace {

using Json = OrderedJson;

/// How a design did, as far as that decides on its place.
struct Standing {
  int group = 2;         ///< 0 feasible, 1 infeasible, 2 nothing to compare
  double objective = 0;  ///< objective of feasible designs
  double violation = 0;  ///< relative, of infeasible ones
  Json worst = nullptr;  ///< the constraint with the least margin
};

/// Violation of a constraint relative to its bound; negative inside it.
double violation_of(const Json& constraint) {
  if (!constraint["margin"].is_number()) return 0;
  const double bound =
      constraint["bound"].is_number() ? std::abs(constraint["bound"].get<double>()) : 0;
  const double size =
      bound > 0 ? bound : std::max(1e-300, std::abs(constraint.value("value", 1.0)));
  return -constraint["margin"].get<double>() / size;
}

Standing standing_of(const Json& result) {
  Standing standing;
  if (!result.is_object() || !result.contains("optimum")) return standing;
  const Json& optimum = result["optimum"];
  double most = -std::numeric_limits<double>::infinity();
  for (const Json& constraint : optimum["constraints"])
    if (const double v = violation_of(constraint); v > most) {
      most = v;
      standing.worst = {{"label", constraint["label"]},   {"value", constraint["value"]},
                        {"bound", constraint["bound"]},   {"unit", constraint["unit"]},
                        {"margin", constraint["margin"]}, {"violation", v}};
    }
  if (!optimum["objective"].is_number()) return standing;
  standing.objective = optimum["objective"];
  standing.violation = std::max(0.0, most);
  const std::string status = optimum["status"];
  standing.group = status == "infeasible" ? 1 : status == "failed" ? 2 : 0;
  return standing;
}

/// Places of the designs, the best first; equal ones stay in the order of the job.
std::vector<std::size_t> ranked(const std::vector<Standing>& standings, bool maximise) {
  std::vector<std::size_t> order(standings.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](std::size_t i, std::size_t j) {
    const Standing &a = standings[i], &b = standings[j];
    if (a.group != b.group) return a.group < b.group;
    if (a.group == 0) return maximise ? a.objective > b.objective : a.objective < b.objective;
    return a.group == 1 && a.violation < b.violation;
  });
  return order;
}

Json entry_of(const ListedDesign& design, std::size_t k, const Json& result) {
  const bool begun = result.is_object();
  return {{"name", design.label},
          {"family", design.job->design.family},
          {"design", k},
          {"folder", design.folder},
          {"status", begun ? result["status"] : Json("not_begun")},
          {"message", begun ? result["message"] : Json("The run has not come to this design.")}};
}

std::string with_unit(const Json& value, const std::string& unit) {
  if (!value.is_number()) return "-";
  return fmt::format("{:.6g}{}{}", value.get<double>(), unit.empty() ? "" : " ", unit);
}

std::string goal_text(const Json& goal) {
  if (goal.contains("expression")) return goal["expression"];
  return fmt::format("{} {}", goal["quantity"].get<std::string>(),
                     goal["over_stroke"].get<std::string>());
}

void add_ranking(const Job& job, const std::vector<Json>& results, Json& whole) {
  std::vector<Standing> standings;
  for (const Json& result : results) standings.push_back(standing_of(result));
  const auto order = ranked(standings, job.optimise->objective.maximise);
  int feasible = 0;
  bool interrupted = false;
  Json ranking = Json::array();
  for (std::size_t place = 0; place < order.size(); ++place) {
    const std::size_t k = order[place];
    const Standing& standing = standings[k];
    feasible += standing.group == 0;
    const Json& result = results[k];
    Json entry = {{"rank", place + 1}};
    entry.update(entry_of(job.designs[k], k, result));
    const bool begun = result.is_object();
    interrupted = interrupted || !begun || result["status"] == "interrupted";
    const bool optimum = begun && result.contains("optimum");
    entry["feasible"] = standing.group == 0;
    entry["objective"] = optimum ? result["optimum"]["objective"] : Json();
    entry["worst_constraint"] = standing.worst;
    entry["evaluations"] = optimum ? result["optimum"]["evaluations"] : Json(0);
    entry["result"] = result;
    ranking.push_back(std::move(entry));
  }
  const std::size_t best = order.front();
  const Json& first = results[best];
  if (first.is_object()) whole = first;
  const std::string& name = job.designs[best].label;
  if (feasible > 0) {
    const Json& goal = first["optimum"]["goal"];
    whole["message"] =
        fmt::format("{} of {} designs meet every constraint; best is \"{}\" with {} {}. {}",
                    feasible, order.size(), name, goal_text(goal),
                    with_unit(first["optimum"]["objective"], goal["unit"].get<std::string>()),
                    first["message"].get<std::string>());
  } else if (standings[best].group == 1) {
    whole["message"] = fmt::format(
        "None of {} designs meets every constraint; \"{}\" misses them least: {} by "
        "{:.3g} of its bound.",
        order.size(), name, standings[best].worst["label"].get<std::string>(),
        standings[best].violation);
  } else {
    whole["message"] = fmt::format("None of {} designs could be evaluated.", order.size());
  }
  if (interrupted) {
    whole["status"] = "interrupted";
    whole["message"] = "The run was interrupted; run the same command to go on. So far: " +
                       whole["message"].get<std::string>();
  } else if (!first.is_object()) {
    whole["status"] = "failed";
  }
  whole["ranking"] = std::move(ranking);
}

void add_designs(const Job& job, const std::vector<Json>& results, Json& whole) {
  Json designs = Json::array();
  std::size_t good = 0;
  bool begun = true;
  for (std::size_t k = 0; k < results.size(); ++k) {
    Json entry = entry_of(job.designs[k], k, results[k]);
    good += entry["status"] == "ok";
    begun = begun && results[k].is_object();
    entry["result"] = results[k];
    designs.push_back(std::move(entry));
  }
  if (results.front().is_object()) whole = results.front();
  whole["status"] = good == results.size() ? "ok" : begun ? "no_equilibrium" : "interrupted";
  whole["message"] = fmt::format("{} of {} designs found equilibrium over the whole stroke.", good,
                                 results.size());
  whole["designs"] = std::move(designs);
}

/// A quantity of every design at a point of its path, and its ratio to that of the first design.
std::string compared_line(const std::string& label, const std::string& unit,
                          const Json::json_pointer& at, std::size_t point, const Json& designs) {
  std::string text = fmt::format("  {:<28}", label);
  double first = 0;
  for (const Json& entry : designs) {
    const Json value = entry["result"]["path"][point].value(at, Json());
    std::string cell = value.is_number() ? quantity_text(value, unit) : "-";
    if (&entry == &designs.front())
      first = value.is_number() ? value.get<double>() : 0;
    else if (first != 0 && value.is_number())
      cell += fmt::format(" ({:.3f})", value.get<double>() / first);
    text += fmt::format(" {:>26}", cell);
  }
  return text + "\n";
}

/// Stiffnesses and frequencies of designs that were evaluated side by side, at both ends.
std::string compared_lines(const Json& whole) {
  const Json& designs = whole["designs"];
  std::string text;
  const std::size_t points = whole["path"].size();
  for (const std::size_t k : std::set<std::size_t>{0, points - 1}) {
    const Json& stroke = whole["path"][k]["stroke"];
    text += fmt::format(
        "  {:<28}", stroke.is_number() ? "stroke " + quantity_text(stroke, whole["units"]["stroke"])
                                       : fmt::format("point {}", k + 1));
    for (const Json& entry : designs)
      text += fmt::format(" {:>26}", entry["name"].get<std::string>());
    text += "\n";
    for (const Json& q : whole["quantities"]) {
      Json::json_pointer at;
      for (const Json& key : q["at"]) at /= key.is_number() ? key.dump() : key.get<std::string>();
      if (q["at"][0] == "drive_stiffness" || q["at"][0] == "support_stiffness")
        text += compared_line(q["label"], q["unit"], at, k, designs);
    }
    const std::string locked = "/frequencies/drive_locked";
    const Json modes = whole["path"][k].value(Json::json_pointer(locked), Json::array());
    for (std::size_t i = 0; i < modes.size(); ++i)
      text += compared_line(fmt::format("frequency {}, drive locked", i + 1), "Hz",
                            Json::json_pointer(fmt::format("{}/{}", locked, i)), k, designs);
  }
  return text;
}

std::string number_cell(const Json& value) {
  return value.is_number() ? value.dump() : std::string();
}

}  // namespace

OrderedJson make_listed_result(const Job& job, const std::vector<OrderedJson>& results) {
  Json whole = Json::object();
  if (job.optimise)
    add_ranking(job, results, whole);
  else
    add_designs(job, results, whole);
  if (whole["status"] != "ok" || !job.optimise)  // else that of the best design
    whole["verdict"] = verdict_json(verdict_of(whole["status"], whole["message"]));
  std::string text = whole["message"];
  if (whole["status"] == "ok" && job.optimise && whole["verdict"]["tone"] != "good")
    text += " The best of them: " + whole["verdict"]["text"].get<std::string>();
  whole["verdict"]["text"] = text;
  whole["job"] = Json(document_of(job));
  whole["notes"] = job.notes;
  return whole;
}

std::string ranking_csv(const OrderedJson& result) {
  std::string unit = "SI", label = "objective";
  for (const Json& entry : result["ranking"])
    if (entry["result"].is_object() && entry["result"].contains("optimum")) {
      const Json& goal = entry["result"]["optimum"]["goal"];
      unit = goal["unit"];
      label += ": " + goal_text(goal);
      break;
    }
  std::string text = fmt::format(
      "rank,design,family,status,feasible,{},worst constraint,value [SI],bound [SI],"
      "violation [1],evaluations,folder\n",
      csv::text_cell(fmt::format("{} [{}]", label, unit)));
  for (const Json& entry : result["ranking"]) {
    const Json& worst = entry["worst_constraint"];
    const bool has = worst.is_object();
    text += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{}\n", entry["rank"].dump(),
        csv::text_cell(entry["name"]), csv::text_cell(entry["family"]),
        csv::text_cell(entry["status"]), entry["feasible"].dump(), number_cell(entry["objective"]),
        has ? csv::text_cell(worst["label"]) : "", has ? number_cell(worst["value"]) : "",
        has ? number_cell(worst["bound"]) : "", has ? number_cell(worst["violation"]) : "",
        entry["evaluations"].dump(), csv::text_cell(entry["folder"]));
  }
  return text;
}

std::string listed_summary(const OrderedJson& result) {
  const std::string name = result["job"].value("name", "");
  const OrderedJson& verdict = result["verdict"];
  std::string text =
      fmt::format("{}: {}. {}\n", name.empty() ? "run" : name, verdict["word"].get<std::string>(),
                  verdict["text"].get<std::string>());
  const auto line = [&](const std::string& place, const Json& entry, const std::string& rest) {
    text += fmt::format("  {:>3} {:<28} {:<14} {}\n", place, entry["name"].get<std::string>(),
                        entry["status"].get<std::string>(), rest);
  };
  if (result.contains("designs")) {
    for (const Json& entry : result["designs"]) line("", entry, "");
    if (result["status"] == "ok" && result.contains("path")) text += compared_lines(result);
  }
  if (!result.contains("ranking")) return text;
  for (const Json& entry : result["ranking"]) {
    std::string rest;
    if (entry["objective"].is_number())
      rest = with_unit(entry["objective"], entry["result"]["optimum"]["goal"]["unit"]);
    if (const Json& worst = entry["worst_constraint"]; worst.is_object())
      rest += fmt::format(
          "; tightest: {}, {}", worst["label"].get<std::string>(),
          entry["feasible"].get<bool>()
              ? fmt::format("margin {:.3g} %", -100 * worst["violation"].get<double>())
              : fmt::format("missed by {:.3g} %", 100 * worst["violation"].get<double>()));
    line(entry["rank"].dump(), entry, rest);
  }
  return text;
}

}  // namespace flexopt
