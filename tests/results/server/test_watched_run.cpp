#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/spec/spec_error.hpp"
#include "results/files/folder.hpp"
#include "results/run/run.hpp"
#include "results/server/serve.hpp"
#include "support/fixture.hpp"

using namespace flexopt;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

std::string record_line(int number, double objective, double violation) {
  return OrderedJson{{"stage", "search"},
                     {"start", 0},
                     {"number", number},
                     {"full", false},
                     {"variables", {{"length", 0.05 + 1e-3 * number}, {"thickness", 4e-4}}},
                     {"ok", true},
                     {"message", ""},
                     {"objective", objective},
                     {"constraints", {450e6 * (1 + violation), 0.5}},
                     {"violation", violation},
                     {"difference", false}}
             .dump() +
         "\n";
}

/// The folder of an optimisation that has begun.
struct Begun {
  test::TemporaryFolder folder;
  fs::path log = folder.path() / "evaluations.jsonl";

  Begun() {
    write_file(folder.path() / "job.json", R"({
      "flexopt": 1, "name": "hinge", "job": "optimise",
      "design": {"family": "three_flexure_cross_hinge",
        "parameters": {"length": 0.05, "thickness": 0.0004, "half_angle": 0.8,
                       "inner_width": 0.049, "outer_width": 0.025, "gap": 0.001},
        "material": {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "density": 7800}},
      "end_effector": {"mass": 1, "inertia": [1e-3, 1e-3, 1e-3]},
      "stroke": {"from": 0, "to": 0.3, "points": 3}, "frequencies": 2,
      "optimise": {"variables": [{"parameter": "length", "min": 0.02, "max": 0.1},
                                 {"parameter": "thickness", "min": 3e-4, "max": 1e-3}],
        "objective": {"maximise": "parasitic_frequency"},
        "constraints": [{"quantity": "max_stress", "max": 450e6},
                        {"quantity": "drive_load", "over_stroke": "max_abs", "max": 1}]}})");
    append("{\"flexopt_evaluations\":{}}\n");
  }
  void append(const std::string& text) const {
    std::ofstream(log, std::ios::app | std::ios::binary) << text;
  }
};

/// Looks again when the watcher does.
OrderedJson next_state(WatchedRun& run, const std::string& since = "") {
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  return OrderedJson::parse(run.state(since));
}

}  // namespace

TEST_CASE("A run is shown as far as its log goes, half a record left out", "[results][server]") {
  const Begun begun;
  WatchedRun run(begun.folder.path());
  begun.append(record_line(1, 140, 0.2) + record_line(2, 120, 0) + record_line(3, 130, 0));
  const std::string fourth = record_line(4, 150, 0);
  begun.append(fourth.substr(0, 40));
  const OrderedJson state = next_state(run);
  CHECK(state["finished"] == false);
  CHECK(state["age"] < 60);
  const OrderedJson& result = state["result"];
  CHECK(result["status"] == "running");
  CHECK_THAT(result["message"].get<std::string>(), Contains("3 evaluations so far"));
  CHECK(result["optimum"]["objective"] == 130.0);  // the best feasible one
  REQUIRE(result["optimum"]["constraints"].size() == 2);
  CHECK(result["optimum"]["constraints"][0]["value"] == 450e6);
  CHECK(result["optimum"]["constraints"][0]["active"] == true);
  CHECK(result["optimum"]["constraints"][1]["margin"] == 0.5);
  CHECK(state["scene"]["evaluations"]["values"]["shape"] == OrderedJson{3, 6});

  const std::string version = state["version"];
  CHECK(next_state(run, version)["unchanged"] == true);
  begun.append(fourth.substr(40));
  const OrderedJson more = next_state(run, version);
  CHECK(more["version"] != version);
  CHECK(more["result"]["optimum"]["evaluations"] == 4);
  CHECK(more["result"]["optimum"]["objective"] == 150.0);
}

TEST_CASE("A finished run is shown whole", "[results][server]") {
  const test::TemporaryFolder folder;
  const RunRecord record = test::optimised_hinge();
  write_job(folder.path(), record.job);
  write_run(folder.path(), record);
  WatchedRun run(folder.path());
  const OrderedJson state = next_state(run);
  CHECK(state["finished"] == true);
  OrderedJson result = read_result(folder.path());
  result.erase("shapes");
  CHECK(state["result"] == result);
  CHECK_FALSE(state["scene"]["designs"].empty());
}

TEST_CASE(
    "Where there is nothing yet, that is said, and where there is no folder, it is wrong input",
    "[results][server]") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(WatchedRun(folder.path() / "missing"), SpecError);
  WatchedRun run(folder.path());
  const OrderedJson state = next_state(run);
  CHECK(state["age"].is_null());
  CHECK_THAT(state["waiting"].get<std::string>(), Contains("no result.json in it"));
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("A question about a run is one version", "[results][server]") {
  CHECK(read_since(R"({"since": "12ab"})") == "12ab");
  for (const char* body : {"", "[]", "{}", R"({"since": 1})", R"({"since": "", "path": "/etc"})"})
    CHECK_THROWS_AS(read_since(body), SpecError);
}

TEST_CASE("A log that another one replaces is read anew", "[results][server]") {
  const Begun begun;
  GrowingLog log;
  CHECK(log.read(begun.log).empty());
  begun.append(record_line(1, 1, 0) + record_line(2, 2, 0));
  CHECK(log.read(begun.log).size() == 2);
  CHECK(log.read(begun.log).size() == 2);
  begun.append(record_line(3, 3, 0));
  REQUIRE(log.read(begun.log).size() == 3);
  CHECK(log.read(begun.log)[2].objective == 3);
  write_file(begun.log, "{\"flexopt_evaluations\":{}}\n" + record_line(7, 7, 0));  // by a rename
  REQUIRE(log.read(begun.log).size() == 1);
  CHECK(log.read(begun.log)[0].number == 7);
  begun.append("{\"variables\": 3}\n");
  CHECK_THROWS_AS(log.read(begun.log), SpecError);
}
