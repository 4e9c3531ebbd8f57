#include <cstdlib>
#include <limits>
#include <map>

#include "core/response/quantities.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/problem/goals.hpp"
#include "results/cli/printed.hpp"
#include "results/files/result_parts.hpp"
#include "support/models.hpp"
#include "tests/results/results_tests.hpp"

namespace {

/// RFC 4180, read back independently of the writer.
std::vector<std::vector<std::string>> parse_csv(const std::string& text) {
  std::vector<std::vector<std::string>> rows(1, {""});
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"')
      rows.back().back() += text[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      rows.back().emplace_back();
    else if (c == '\n' && !quoted)
      rows.push_back({""});
    else
      rows.back().back() += c;
  }
  rows.pop_back();
  return rows;
}

/// Column by header, one text a row.
std::map<std::string, std::vector<std::string>> columns_of(const std::string& text) {
  const auto rows = parse_csv(text);
  std::map<std::string, std::vector<std::string>> columns;
  for (std::size_t c = 0; c < rows[0].size(); ++c)
    for (std::size_t r = 1; r < rows.size(); ++r) {
      REQUIRE(rows[r].size() == rows[0].size());
      columns[rows[0][c]].push_back(rows[r][c]);
    }
  REQUIRE(columns.size() == rows[0].size());  // no header twice
  return columns;
}

double number(const std::string& text) { return std::strtod(text.c_str(), nullptr); }

}  // namespace

TEST_CASE("path.csv has a row a stroke point and numbers that read back exactly") {
  const RunRecord record = test::evaluated_hinge();
  const auto columns =
      columns_of(path_csv(record.response, drive_direction(record.mechanism), record.job.request));
  const auto& path = record.response.path;
  REQUIRE(columns.at("stroke [rad]").size() == path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    CHECK(number(columns.at("stroke [rad]")[i]) == path[i].stroke);
    CHECK(columns.at("status")[i] == "converged");
    CHECK(number(columns.at("drive_load [N m]")[i]) == path[i].drive_load);
    CHECK(number(columns.at("support_stiffness.uz [N/m]")[i]) == *path[i].support_stiffness[2]);
    CHECK(number(columns.at("principal_stiffness [N/m]")[i]) ==
          value_of(path[i], "principal_stiffness"));
    CHECK(number(columns.at("displacement.x [m]")[i]) == path[i].displacement[0]);
    CHECK(number(columns.at("parasitic_frequency [Hz]")[i]) == *path[i].parasitic_frequency);
    CHECK(number(columns.at("max_stress [Pa]")[i]) == path[i].max_stress->value);
    CHECK(number(columns.at("frequencies.drive_free.0 [Hz]")[i]) == path[i].frequencies_free[0]);
    CHECK(columns.at("kind.drive_free.0")[i] == "drive");
    CHECK(number(columns.at("compliance.drive_free.ux_rz [m/(N m)]")[i]) ==
          path[i].compliance_free(0, 5));
    CHECK(columns.at("stable")[i] == "true");
  }
}

TEST_CASE("path.csv has a column for each drive with a name") {
  RunRecord record = test::evaluated_hinge();
  record.mechanism.drives = {{.name = "x", .direction = Direction::ux},
                             {.name = "turn", .direction = Direction::rz}};
  for (PathPoint& p : record.response.path) {
    p.drive_names = {"x", "turn"};
    p.strokes = {1e-3, p.stroke};
    p.drive_loads = {p.drive_load, 7};
    p.drive_stiffnesses = {p.drive_stiffness, 9};
  }
  const auto columns =
      columns_of(path_csv(record.response, DriveList(record.mechanism), record.job.request));
  CHECK(columns.count("stroke [rad]") == 0);
  CHECK(columns.count("support_stiffness.ux [N/m]") == 0);
  const auto& path = record.response.path;
  for (std::size_t i = 0; i < path.size(); ++i) {
    CHECK(number(columns.at("stroke.x [m]")[i]) == 1e-3);
    CHECK(number(columns.at("stroke.turn [rad]")[i]) == path[i].stroke);
    CHECK(number(columns.at("drive_load.x [N]")[i]) == path[i].drive_load);
    CHECK(number(columns.at("drive_load.turn [N m]")[i]) == 7);
    CHECK(number(columns.at("drive_stiffness.turn [N m/rad]")[i]) == 9);
  }
}

TEST_CASE("path.csv has the measures of the dynamics where the job asks for them") {
  RunRecord record = test::evaluated_hinge();
  const Direction drive = drive_direction(record.mechanism);
  const auto plain = columns_of(path_csv(record.response, drive, record.job.request));
  CHECK(plain.count("bandwidth [Hz]") + plain.count("transmissibility [1]") == 0);
  record.job.request.dynamics = {0.01, TransmissibilityRule{Direction::ux, 1, 2, DriveState::free}};
  record.response.path[0].bandwidths = {std::nullopt};
  record.response.path[1].bandwidths = {1.0 / 3};
  record.response.path[1].transmissibility = {7.5, 1.5};
  const auto columns = columns_of(path_csv(record.response, drive, record.job.request));
  CHECK(columns.at("bandwidth [Hz]")[0].empty());
  CHECK(number(columns.at("bandwidth [Hz]")[1]) == 1.0 / 3);
  CHECK(number(columns.at("transmissibility [1]")[1]) == 7.5);
}

TEST_CASE("A point without equilibrium has empty cells, never NaN") {
  RunRecord record = test::evaluated_hinge();
  record.response.path[1].status = PointStatus::not_reached;
  record.response.path[2].drive_load = std::numeric_limits<double>::quiet_NaN();
  const std::string text =
      path_csv(record.response, drive_direction(record.mechanism), record.job.request);
  const auto columns = columns_of(text);
  CHECK(columns.at("status")[1] == "not_reached");
  CHECK(columns.at("drive_load [N m]")[1].empty());
  CHECK(columns.at("compliance.drive_free.ux_ux [m/N]")[1].empty());
  CHECK(columns.at("drive_load [N m]")[2].empty());
  CHECK(text.find("nan") == std::string::npos);
  CHECK(text.find("inf") == std::string::npos);
}

TEST_CASE("history.csv has a row an evaluation, failed ones with their reason") {
  const RunRecord record = test::optimised_hinge();
  const Optimum& optimum = *record.optimum;
  const auto columns =
      columns_of(history_csv(record.job, optimum, drive_direction(record.mechanism)));
  REQUIRE(columns.at("start").size() == 32);
  CHECK(columns.at("ok")[2] == "false");
  CHECK(columns.at("message")[2] == optimum.history[2].message);  // has a comma and quotes
  CHECK(columns.at("objective: parasitic_frequency min [Hz]")[2].empty());
  std::optional<double> best;
  for (std::size_t i = 0; i < 32; ++i) {
    const EvaluationRecord& trial = optimum.history[i];
    CHECK(number(columns.at("thickness [m]")[i]) == trial.variables.at("thickness"));
    if (trial.ok) {
      CHECK(number(columns.at("objective: parasitic_frequency min [Hz]")[i]) == trial.objective);
      CHECK(number(columns.at("max_stress max over stroke [Pa]")[i]) == trial.constraints[0]);
      CHECK(number(columns.at("drive_load, max abs [N m]")[i]) == trial.constraints[1]);
      if (trial.violation == 0) best = std::max(best.value_or(trial.objective), trial.objective);
    }
    if (best) CHECK(number(columns.at("best")[i]) == *best);
  }
  REQUIRE(best);
}

TEST_CASE("points have columns of their displacement and of the part along their direction") {
  RunRecord record = test::evaluated_hinge();
  StrokeRequest& request = record.job.request;
  request.named_points = {{.name = "gauge"},
                          {.name = "tilt", .body = 0, .direction = Vector6d::Unit(5)},
                          {.name = "old", .body = 0, .kind = "probe"}};
  for (PathPoint& p : record.response.path) {
    p.named_points.assign(3, {0.1, 0.2, p.stroke});
    p.motions_along = {std::nullopt, p.bodies[0].rotation[2], std::nullopt};
  }
  const auto columns =
      columns_of(path_csv(record.response, drive_direction(record.mechanism), request));
  for (std::size_t i = 0; i < record.response.path.size(); ++i) {
    const PathPoint& p = record.response.path[i];
    CHECK(number(columns.at("points.gauge.z [m]")[i]) == p.stroke);
    CHECK(number(columns.at("points.tilt [rad]")[i]) == p.bodies[0].rotation[2]);
    CHECK(number(columns.at("probes.old.y [m]")[i]) == 0.2);
  }
  CHECK(columns.count("points.gauge [m]") == 0);
}

TEST_CASE("quantities that a job defines stand in every file and table, with their units") {
  const Job job = parse_job(json::parse(R"J({
    "design": {"family": "parallel_guide", "parameters": {"length": "100 mm", "width": "30 mm",
      "thickness": "0.5 mm", "spacing": "60 mm"}, "material": "stavax"},
    "quantities": [{"name": "ratio", "expression": "support_stiffness.ux/drive_stiffness"},
                   {"name": "sag", "expression": "2*displacement.x"},
                   {"name": "lost", "expression": "1 N/drive_load"}],
    "model": {"flexure": "beam", "mesh": [4, 2]}, "frequencies": 0,
    "stroke": {"to": "5 mm", "points": 2}})J"));
  RunRecord record{.job = job, .mechanism = make_mechanism(job, job.design.parameters)};
  record.response = evaluate_stroke(record.mechanism, job.model, job.request);
  add_defined_quantities(job, complete_numbers(job, job.design.parameters), record.response);
  conclude(record);
  const double ratio = *value_of(record.response.path[1], "ratio");
  CHECK(ratio ==
        *record.response.path[1].support_stiffness[0] / record.response.path[1].drive_stiffness);
  const OrderedJson result = make_result(record);
  CHECK(result["path"][1]["quantities"]["ratio"] == ratio);
  CHECK(result["path"][0]["quantities"]["lost"].is_null());
  CHECK(result["units"]["quantities"] ==
        OrderedJson::parse(R"({"ratio": "1", "sag": "m", "lost": "1"})"));
  CHECK(result["quantities"].back() ==
        OrderedJson::parse(
            R"({"name": "lost", "label": "lost", "unit": "1", "at": ["quantities", "lost"]})"));
  const auto columns = columns_of(path_csv(record));
  CHECK(number(columns.at("ratio [1]")[1]) == ratio);
  CHECK(columns.at("lost [1]")[0] == "");
  CHECK(columns.contains("sag [m]"));
  CHECK_THAT(summary_of(record), Catch::Contains("ratio") && Catch::Contains("sag"));
}
