// The worst and the critical errors of assembly of a run: in result.json and in the summary.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "results/cli/printed.hpp"
#include "results/files/result_json.hpp"
#include "results/files/result_parts.hpp"
#include "results/run/progress.hpp"
#include "results/run/run.hpp"
#include "support/temporary_folder.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

TEST_CASE("errors of assembly stand in the result with leaf, end and stroke", "[assembly]") {
  const Job job = parse_job(nlohmann::json::parse(R"({
    "name": "misaligned", "job": "evaluate",
    "design": {"family": "parallel_guide", "material": "stavax",
      "parameters": {"length": 0.1, "width": 0.03, "thickness": 5e-4, "spacing": 0.06}},
    "model": {"flexure": "beam", "mesh": [4, 2], "accuracy": "full"},
    "stroke": {"at": [1e-4, 2e-3]}, "frequencies": 0,
    "assembly_tolerances": {
      "edges": [{"leaf": "leaf -y", "end": "tip", "turn": [0, "2 mrad", 0]}],
      "quantities": [{"quantity": "support_stiffness.uz", "over_stroke": "min"}],
      "stiffness_share": 0.9, "starts": 2}})"));
  Silent silent;
  const RunRecord record = run_any(job, {}, silent);
  REQUIRE(record.assembly);
  const nlohmann::json json = make_assembly(record);
  const nlohmann::json& worst = json["worst_case"][0];
  CHECK(worst["quantity"] == "support_stiffness.uz");
  CHECK(worst["unit"] == "N/m");
  CHECK(worst["over_stroke"] == "min");
  CHECK(worst["worst"].get<double>() < worst["nominal"].get<double>());
  CHECK(worst["misalignment"][0]["leaf"] == "leaf -y");
  CHECK(worst["misalignment"][0]["end"] == "tip");
  CHECK(std::abs(worst["misalignment"][0]["turn"][1].get<double>()) == Approx(2e-3));
  CHECK(worst["stroke"] == 2e-3);  // stiffness falls along the stroke
  const nlohmann::json& critical = json["critical"];
  CHECK(critical["limit"] == "stiffness");
  CHECK(std::abs(critical["misalignment"][0]["turn"][1].get<double>()) ==
        Approx(2e-3 * critical["scale"].get<double>()));
  CHECK_THAT(summary_of(record), Contains("critical errors of assembly: the box times"));
}

TEST_CASE("errors of assembly over load cases say which case is the worst", "[assembly][cases]") {
  const Job job = parse_job(nlohmann::json::parse(R"({
    "name": "misaligned", "job": "evaluate",
    "design": {"family": "parallel_guide", "material": "stavax",
      "parameters": {"length": 0.1, "width": 0.03, "thickness": 5e-4, "spacing": 0.06}},
    "model": {"flexure": "beam", "mesh": [4, 2], "accuracy": "full"}, "frequencies": 0,
    "cases": {"far": {"stroke": {"at": [3e-3]}}, "near": {"stroke": {"at": [1e-4, 2e-3]}}},
    "assembly_tolerances": {
      "edges": [{"leaf": "leaf -y", "end": "tip", "turn": [0, "2 mrad", 0]}],
      "quantities": [{"quantity": "support_stiffness.uz", "over_stroke": "min"},
                     {"quantity": "support_stiffness.uz", "over_stroke": "min", "case": "near"}],
      "stiffness_share": 0.9, "starts": 2}})"));
  Silent silent;
  const RunRecord record = run_any(job, {}, silent);
  REQUIRE(record.assembly);
  const nlohmann::json json = make_assembly(record);
  CHECK(json["worst_case"][0]["case"] == "far");
  CHECK(json["worst_case"][0]["stroke"] == 3e-3);
  CHECK(json["worst_case"][1]["case"] == "near");
  CHECK(json["worst_case"][1]["stroke"] == 2e-3);
  CHECK(json["critical"].contains("case"));
  CHECK_THAT(summary_of(record), Contains("case near"));
}
