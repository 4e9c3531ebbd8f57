// The worst and the critical errors of assembly of a run: in result.json and in the summary.
#include "results/cli/printed.hpp"
#include "results/files/result_parts.hpp"
#include "results/run/progress.hpp"
#include "results/run/run.hpp"
#include "tests/results/results_tests.hpp"

namespace {

/// What a guide with an edge that may be turned comes to, and how that is written.
std::pair<RunRecord, OrderedJson> misaligned(const char* patch) {
  json document = json::parse(R"({
    "name": "misaligned", "job": "evaluate",
    "design": {"family": "parallel_guide", "material": "stavax",
      "parameters": {"length": 0.1, "width": 0.03, "thickness": 5e-4, "spacing": 0.06}},
    "model": {"flexure": "beam", "mesh": [4, 2], "accuracy": "full"}, "frequencies": 0,
    "assembly_tolerances": {
      "edges": [{"leaf": "leaf -y", "end": "tip", "turn": [0, "2 mrad", 0]}],
      "quantities": [{"quantity": "support_stiffness.uz", "over_stroke": "min"}],
      "stiffness_share": 0.9, "starts": 2}})");
  document.merge_patch(json::parse(patch));
  Silent silent;
  const RunRecord record = run_any(parse_job(document), {}, silent);
  REQUIRE(record.assembly);
  return {record, make_assembly(record)};
}

}  // namespace

TEST_CASE("errors of assembly stand in the result with leaf, end and stroke") {
  const auto [record, written] = misaligned(R"({"stroke": {"at": [1e-4, 2e-3]}})");
  const OrderedJson& worst = written["worst_case"][0];
  CHECK(unlike_text(worst, R"({"quantity": "support_stiffness.uz", "unit": "N/m",
      "over_stroke": "min", "stroke": 2e-3})") == "");  // stiffness falls along the stroke
  CHECK(unlike_text(worst["misalignment"][0], R"({"leaf": "leaf -y", "end": "tip"})") == "");
  CHECK(worst["worst"].get<double>() < worst["nominal"].get<double>());
  CHECK(std::abs(worst["misalignment"][0]["turn"][1].get<double>()) == Approx(2e-3));
  const OrderedJson& critical = written["critical"];
  CHECK(critical["limit"] == "stiffness");
  CHECK(std::abs(critical["misalignment"][0]["turn"][1].get<double>()) ==
        Approx(2e-3 * critical["scale"].get<double>()));
  CHECK_THAT(summary_of(record), Contains("critical errors of assembly: the box times"));
}

TEST_CASE("errors of assembly over load cases say which case is the worst") {
  const auto [record, written] = misaligned(R"({
    "cases": {"far": {"stroke": {"at": [3e-3]}}, "near": {"stroke": {"at": [1e-4, 2e-3]}}},
    "assembly_tolerances": {
      "quantities": [{"quantity": "support_stiffness.uz", "over_stroke": "min"},
                     {"quantity": "support_stiffness.uz", "over_stroke": "min",
                      "case": "near"}]}})");
  CHECK(unlike_text(written["worst_case"], R"([{"case": "far", "stroke": 3e-3},
                                               {"case": "near", "stroke": 2e-3}])") == "");
  CHECK(written["critical"].contains("case"));
  CHECK_THAT(summary_of(record), Contains("case near"));
}
