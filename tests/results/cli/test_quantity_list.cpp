// Every number that `flexopt quantities` lists, everywhere: goals, their derivatives, result.json,
// path.csv. The table of quantities drives these tests: a new row is in them by itself.
#include "optim/job/job_numbers.hpp"
#include "optim/problem/design_problem.hpp"
#include "results/cli/printed.hpp"
#include "results/files/result_parts.hpp"
#include "tests/results/results_tests.hpp"

namespace {

/// A guide of a material with strengths, that is shaken, loaded, and pressed until it gives way;
/// coarse beams, so that it takes little time.
json document() {
  return json::parse(R"({
    "name": "guide", "job": "evaluate",
    "design": {"family": "parallel_guide",
      "parameters": {"length": 0.1, "width": 0.03, "thickness": 5e-4, "spacing": 0.06},
      "material": {"youngs_modulus": 2e11, "poissons_ratio": 0.3, "density": 7800,
        "yield_strength": 1.4e9, "ultimate_strength": 1.7e9, "endurance_limit": 5e8,
        "s_n_curve": {"coefficient": 1.758e9, "exponent": -0.0977, "knee": 1e6}}},
    "end_effector": {"mass": 0.5, "inertia": [4e-4, 4e-4, 4e-4], "center_of_mass": [0.02, 0.005, 0]},
    "loads": [{"name": "payload", "force": [-5, 0, 0]}],
    "buckling": {"load": "payload", "largest_factor": 1e4},
    "load_capacity": {"drive": "free", "directions":
      ["ux", "uy", "uz", "rx", "ry", "rz", "-ux", "-uy", "-uz", "-rx", "-ry", "-rz"]},
    "stroke_capacity": {"up_to": 0.02, "stress": 1e8},
    "points": [{"name": "encoder", "body": "end_effector", "at": [0.2, 0.01, 0], "direction": "uy"},
      {"name": "middle of a leaf", "at": [0.05, 0.03, 0], "direction": [1, 2, 0]}],
    "dynamics": {"transmissibility": {"direction": "uz", "from": 10, "to": 400},
      "transfers": [{"from": "encoder", "to": "middle of a leaf"}, {"from": "ground", "to": "encoder"},
        {"from": "encoder", "to": "middle of a leaf", "excitation": "motion"}]},
    "gauges": [{"name": "a", "leaf": "leaf +y", "along": 0.1}],
    "bridges": [{"name": "force", "signs": {"a": 1}, "gauge_factor": 2}],
    "fillet": 3e-4, "frequencies": 12,
    "stroke": {"from": 0, "to": 2e-3, "points": 2},
    "model": {"flexure": "beam", "mesh": [6, 2]}
  })");
}

std::vector<Quantity> all_quantities() {
  const Job job = parse_job(document());
  return quantities(drives_of(job, make_mechanism(job, job.design.parameters)));
}

/// The document with an optimisation whose constraints are all these quantities.
json with_goals(const std::vector<Quantity>& wanted) {
  json job = document();
  job["job"] = "optimise";
  json& goals = job["optimise"];
  goals["variables"] = {{{"parameter", "thickness"}, {"min", 3e-4}, {"max", 8e-4}}};
  goals["objective"] = {{"maximise", wanted.front().name}, {"over_stroke", "min"}};
  goals["algorithm"] = {{"library", "ipopt"}};
  goals["constraints"] = json::array();
  for (const Quantity& q : wanted)
    goals["constraints"].push_back({{"quantity", q.name}, {"over_stroke", "first"}, {"min", -1}});
  return job;
}

/// "load_capacity.-ux" → "/load_capacity/-ux"
json::json_pointer pointer_of(const Quantity& q) {
  if (q.row->of_names)
    return json::json_pointer() / q.row->name / q.name.substr(q.row->name.size() + 1);
  std::string text = "/" + q.name;
  std::ranges::replace(text, '.', '/');
  if (q.row->layout == Layout::list && !q.row->components.empty())
    text = text.substr(0, text.rfind('/') + 1) + std::to_string(q.component);
  if (q.row->direction) text += "/value";
  return json::json_pointer(text);
}

}  // namespace

TEST_CASE("every row of the table is listed with unit, meaning and what it costs") {
  const Job job = parse_job(document());
  const std::string list =
      describe_quantities(drives_of(job, make_mechanism(job, job.design.parameters)));
  const auto is_of_kind = [](const QuantityRow& row) { return row.of_kind != nullptr; };
  const auto missing = std::ranges::count_if(quantity_rows(), is_of_kind);
  CHECK(missing == 3);  // the drive is one of the end-effector, without actuator
  CHECK(std::ranges::count(list, '\n') == 1 + std::ssize(quantity_rows()) - missing);
  std::istringstream lines(list);
  std::string line;
  std::getline(lines, line);
  for (const QuantityRow& row : quantity_rows()) {
    if (row.of_kind) continue;
    std::getline(lines, line);
    CHECK_THAT(line, Catch::Matchers::StartsWith(row.name));
    CHECK(line.size() > 96);  // name, unit, needs, estimate and a meaning behind them
  }
}

TEST_CASE("every quantity may be an objective and a constraint") {
  const std::vector<Quantity> all = all_quantities();
  CHECK(all.size() > 60);
  for (const Quantity& q : all) {
    CAPTURE(q.name);
    json job = with_goals({q});
    for (const char* sense : {"maximise", "minimise"}) {
      job["optimise"]["objective"] = {{sense, q.name}, {"over_stroke", "min"}};
      const Job read = parse_job(job);
      CHECK(read.optimise->objective.quantity == q.name);
      CHECK(read.optimise->constraints.front().quantity == q.name);
    }
  }
}

TEST_CASE("every quantity has a value and an exact derivative as a goal", "[slow]") {
  const std::vector<Quantity> all = all_quantities();
  const DesignProblem problem(parse_job(with_goals(all)));
  const DesignValues values = problem.evaluate({5e-4}, true);
  INFO(values.message);
  REQUIRE(values.ok);
  INFO(values.no_gradient);
  REQUIRE(values.gradient.rows() > static_cast<Eigen::Index>(all.size()));
  CHECK(values.gradient.allFinite());
  REQUIRE(values.goals.size() == 1 + all.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    CAPTURE(all[k].name);
    REQUIRE_FALSE(values.goals[k + 1].empty());
    CHECK(std::isfinite(values.goals[k + 1].front()));
  }
}

TEST_CASE("every quantity stands in result.json and in path.csv") {
  RunRecord record;
  record.job = parse_job(document());
  record.mechanism = make_mechanism(record.job, record.job.design.parameters);
  StrokeRequest request = record.job.request;
  request.outputs = Outputs::numbers();
  record.response = evaluate_stroke(record.mechanism, record.job.model, request);
  conclude(record);
  const json result = make_result(record);
  const std::string table = path_csv(record.response, drives_of(record), record.job.request);
  const std::string header = "," + table.substr(0, table.find('\n')) + ",";
  const PathPoint& point = record.response.path[1];
  for (const Quantity& q : all_quantities()) {
    CAPTURE(q.name);
    const std::string column = q.row->name == "point" ? "points" + q.name.substr(5) : q.name;
    CHECK_THAT(header, Contains("," + column + " [" + q.unit + "],"));
    const json::json_pointer pointer = pointer_of(q);
    CAPTURE(pointer.to_string());
    const std::optional<double> value = q.value(point);
    if (value) {
      REQUIRE(result["path"][1].contains(pointer));
      CHECK(result["path"][1][pointer].get<double>() == *value);
    }
    // none at this point: a pull bears any load, a deflected guide gives way without a bifurcation
    const bool may_lack = q.name.starts_with("load_capacity.") || q.name.starts_with("buckling.") ||
                          q.name.starts_with("transfer_bandwidth.");
    if (!may_lack) CHECK(value);
  }
}
