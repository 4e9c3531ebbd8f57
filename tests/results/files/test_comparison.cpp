// A comparison's files: result.json as the contract names it, comparison.csv, summary, report.
#include "optim/studies/compare.hpp"
#include "results/cli/printed.hpp"
#include "results/files/result_parts.hpp"
#include "results/report/report.hpp"
#include "results/run/progress.hpp"
#include "results/run/run.hpp"
#include "tests/results/results_tests.hpp"

namespace {

Job batch() {
  return parse_job(json::parse(R"({
    "name": "batch", "job": "compare",
    "design": {"family": "parallel_guide", "material": "stavax",
      "parameters": {"length": 0.1, "width": 0.03, "thickness": 5e-4, "spacing": 0.06}},
    "end_effector": {"mass": 0.5, "inertia": [4e-4, 4e-4, 4e-4]},
    "stroke": {"to": 0.01, "points": 3}, "frequencies": 3,
    "samples": {"method": "list",
      "designs": [{}, {"width": 0.06}, {"length": 0.006, "thickness": 1e-3}]},
    "models": [{"name": "default"}, {"name": "linear, thin", "free_edge_torsion": false}]
  })"));
}

RunRecord run(const fs::path& folder) {
  Silent silent;
  return run_any(batch(), {folder, 2}, silent);
}

}  // namespace

TEST_CASE("A comparison is written as the contract names it") {
  const test::TemporaryFolder folder;
  const RunRecord record = run(folder.path());
  const WrittenRun written = write_run(folder.path(), record);
  const OrderedJson& result = *written.result;
  CHECK(result["status"] == "ok");
  CHECK(usable(result));
  CHECK(result["path"].empty());
  const OrderedJson& comparison = result["comparison"];
  CHECK(comparison["designs"] == 3);
  CHECK(comparison["failed_designs"] == 1);  // no 6 mm leaf reaches 10 mm to its side
  CHECK(comparison["samples"][2]["status"] == "failed");
  CHECK_FALSE(comparison["samples"][2]["message"].get<std::string>().empty());
  REQUIRE(comparison["models"].size() == 2);
  const OrderedJson &standard = comparison["models"][0], &thin = comparison["models"][1];
  CHECK(standard["name"] == "default");
  CHECK(standard["failures"] == 0);
  CHECK(standard["speed_up"].get<double>() > 0);
  for (const ComparedQuantity& quantity : record.comparison->quantities) {
    const std::string& name = quantity.name;
    CAPTURE(name);
    const OrderedJson& errors = standard["errors"][name];
    CHECK(errors["median"].get<double>() >= 0);
    CHECK(errors["p99"].get<double>() >= errors["median"].get<double>());
    CHECK(errors["worst"].get<double>() >= errors["p99"].get<double>());
    CHECK(errors["worst"].get<double>() < 1e-2);
  }
  const OrderedJson& directions = standard["errors"]["support_stiffness"]["by_direction"];
  CHECK(directions.size() == 5);
  CHECK_FALSE(directions.contains("uy"));
  CHECK(directions["ux"]["worst"].get<double>() > 0);
  CHECK(thin["errors"]["support_stiffness"]["worst"].get<double>() >
        10 * standard["errors"]["support_stiffness"]["worst"].get<double>());
  const OrderedJson& points = standard["points"];
  for (const auto& [name, column] : points.items()) CHECK(column.size() == points["design"].size());

  const std::string table = test::content_of(folder.path() / "comparison.csv");
  CHECK(std::count(table.begin(), table.end(), '\n') == 1 + 3 * 2);
  std::istringstream lines(table);
  std::string header;
  std::getline(lines, header);
  CHECK_THAT(header, Contains("design,model,status,length [m]") &&
                         Contains("error: support_stiffness.ux [1]"));
  CHECK_THAT(table, Contains("\"linear, thin\"") && Contains("full accuracy failed"));
  CHECK_FALSE(fs::exists(folder.path() / "path.csv"));
  CHECK_THAT(summary_of(record), Contains("default, errors:") && Contains("support_stiffness") &&
                                     Contains("1 design not to the end at full accuracy"));
  CHECK_THAT(make_report(result, nullptr), Contains("against full accuracy"));
}

TEST_CASE("Every quantity of the table can be compared, and stands in all files", "[slow]") {
  json document = *batch().as_read;
  document["design"]["material"] = json::parse(R"({"name": "strong",
    "youngs_modulus": 2e11, "poissons_ratio": 0.3, "density": 7800, "yield_strength": 1.4e9,
    "ultimate_strength": 1.7e9, "endurance_limit": 5e8,
    "s_n_curve": {"coefficient": 1.758e9, "exponent": -0.0977, "knee": 1e6}})");
  document["loads"] = json::parse(R"([{"name": "payload", "force": [-5, 0, 0]}])");
  document["buckling"] = {{"load", "payload"}, {"largest_factor", 1e4}};
  document["load_capacity"] = {{"directions", {"-ux", "uz"}}};
  document["stroke_capacity"] = {{"up_to", 8e-3}, {"stress", "100 MPa"}};
  document["points"] = json::parse(
      R"([{"name": "a", "body": "end_effector", "at": [0.2, 0.01, 0], "direction": "uy"}])");
  document["dynamics"] =
      json::parse(R"({"transmissibility": {"direction": "uz", "from": 10, "to": 400},
                      "transfers": [{"from": "a", "to": "a"}]})");
  document["gauges"] = json::parse(R"([{"name": "b", "leaf": "leaf +y", "along": 0.1}])");
  document["bridges"] = json::parse(R"([{"name": "c", "signs": {"b": 1}}])");
  document["fillet"] = 3e-4;
  document["stroke"] = {{"to", 4e-3}, {"points", 3}};
  document["end_effector"]["center_of_mass"] = {0.02, 0.005, 0};  // the drive's mass line ends
  document["samples"]["designs"] = json::parse(R"([{}, {"width": 0.02}])");
  document["models"] = json::parse(R"([{"name": "beam", "flexure": "beam"}])");
  document["quantities"] = comparable_quantities();
  document["quantities"].push_back(
      {{"name", "ratio"}, {"expression", "support_stiffness.uz/drive_stiffness"}});
  const test::TemporaryFolder folder;
  RunRecord record;
  record.job = parse_job(document);
  record.mechanism = make_mechanism(record.job, record.job.design.parameters);
  record.comparison = compare(record.job).comparison;
  conclude(record);
  const WrittenRun written = write_run(folder.path(), record);
  const OrderedJson& model = (*written.result)["comparison"]["models"][0];
  const std::string table = test::content_of(folder.path() / "comparison.csv");
  for (const QuantityRow& row : quantity_rows()) {
    CAPTURE(row.name);
    if (row.of_kind) continue;  // of which the guide has none
    const std::string name = row.name.starts_with("frequencies.") ? "frequencies" : row.name;
    const OrderedJson& errors = model["errors"][name];
    CHECK(errors["missing"] == 0);
    CHECK(model["points"].contains(name));
    CHECK_THAT(table, Contains("error: " + name + " [1]"));
    CHECK_THAT(summary_of(record), Contains(name));
    CHECK(errors["count"].get<int>() > 0);
    CHECK(errors["worst"].get<double>() < 0.5);
    if (!row.of_design) CHECK(errors["worst"].get<double>() > 0);
  }
  CHECK(model["errors"]["ratio"]["count"] == model["errors"]["drive_stiffness"]["count"]);
  CHECK(model["errors"]["ratio"]["worst"].get<double>() > 0);
  CHECK_THAT(table, Contains("error: ratio [1]"));
  CHECK(model["errors"]["load_capacity"]["by_direction"].size() == 2);
  CHECK(model["errors"]["buckling"]["by_component"].size() == 2);
  CHECK_THAT(table,
             Contains("error: load_capacity.-ux [1]") && !Contains("error: load_capacity.rx [1]"));
}

TEST_CASE("Numbers that a model lacks are counted, and named with the reason") {
  RunRecord record;
  record.job = batch();
  record.mechanism = make_mechanism(record.job, record.job.design.parameters);
  CompareOptions options;
  options.evaluator = [](const Mechanism& mechanism, const ModelOptions& model,
                         const StrokeRequest& request) {
    StrokeResponse response = evaluate_stroke(mechanism, model, request);
    if (model.accuracy != Accuracy::full && model.free_edge_torsion)
      for (PathPoint& point : response.path) {
        point.max_stress.reset();
        point.fillet_fault = "no factor";
      }
    return response;
  };
  record.comparison = compare(record.job, options).comparison;
  conclude(record);
  const OrderedJson result = make_result(record);
  const OrderedJson& model = result["comparison"]["models"][0];
  CHECK(model["errors"]["max_stress"]["count"] == 0);
  CHECK(model["errors"]["max_stress"]["missing"].get<int>() >= 6);
  REQUIRE(model["exceptions"].size() >= 2);
  CHECK(model["exceptions"][0]["status"] == "missing_numbers");
  CHECK_THAT(model["exceptions"][0]["missing"].get<std::string>(),
             Contains("max_stress at point 0, which the model lacks: no factor"));
  CHECK(result["comparison"]["models"][1]["errors"]["max_stress"]["missing"] == 0);
  CHECK_THAT(summary_of(record), Contains("numbers that only one has"));
}

TEST_CASE("An interrupted comparison's report tells what its log holds") {
  const test::TemporaryFolder folder;
  run(folder.path());
  const fs::path log = folder.path() / "evaluations.jsonl";
  const std::string whole = test::content_of(log);
  std::size_t cut = 0;
  for (int line = 0; line < 6; ++line) cut = whole.find('\n', cut) + 1;
  fs::resize_file(log, cut + 3);
  const OrderedJson result = read_result(folder.path());
  CHECK(result["status"] == "interrupted");
  CHECK_THAT(result["message"].get<std::string>(), Contains("after 5 of 9 evaluations"));
  CHECK(result["comparison"]["models"][0]["errors"]["drive_load"]["count"] == 2 + 2);
  CHECK(result["comparison"]["models"][1]["errors"]["drive_load"]["count"] == 2);
}

TEST_CASE("A comparison without one design to compare is not usable") {
  json document = *batch().as_read;
  document["samples"]["designs"] = json::parse(R"([{"length": 0.006}])");
  document["stroke"] = {{"at", {0.011}}};
  RunRecord record;
  record.job = parse_job(document);
  record.mechanism = make_mechanism(record.job, record.job.design.parameters);
  record.comparison = compare(record.job).comparison;
  conclude(record);
  CHECK(record.status == "failed");
  CHECK_THAT(record.message, Contains("None of 1 design could be compared"));
  const OrderedJson result = make_result(record);
  CHECK_FALSE(usable(result));
  CHECK(result["comparison"]["models"][0]["errors"]["drive_load"]["worst"].is_null());
  CHECK(result["comparison"]["models"][0]["speed_up"].is_null());

  document["stroke"] = {{"at", {0, 0.011}}};  // the point at rest is found
  record.job = parse_job(document);
  record.comparison = compare(record.job).comparison;
  conclude(record);
  CHECK(record.status == "failed");
  CHECK_THAT(record.message, Contains("None of 1 design could be compared to its end"));
}
