// What a run says while it goes on, on a terminal and in a file, and run --json.
#include <fmt/format.h>

#include <chrono>
#include <regex>

#include "tests/results/results_tests.hpp"

namespace {

const std::string wipe = "\r\x1b[K";

OrderedJson smaller(OrderedJson job) {
  job["stroke"]["points"] = 2;
  job["frequencies"] = 1;
  return job;
}

OrderedJson leaf_job() { return smaller(test::leaf_job()); }
OrderedJson optimise_job() { return smaller(test::optimised_leaf()); }

/// What stood in the live line, one after the other.
std::vector<std::string> frames_of(const std::string& text) {
  std::vector<std::string> frames;
  for (std::size_t at = text.find(wipe); at != std::string::npos;) {
    const std::size_t begin = at + wipe.size();
    at = text.find(wipe, begin);
    const std::string frame = text.substr(begin, at == std::string::npos ? at : at - begin);
    if (frame.find('\n') == std::string::npos && !frame.empty()) frames.push_back(frame);
  }
  return frames;
}

}  // namespace

TEST_CASE("On a terminal an optimisation has one line, wiped before the summary") {
  const test::Workplace folder;
  folder.put("stiff.json", optimise_job());
  const auto begin = std::chrono::steady_clock::now();
  const test::Outcome outcome = test::run_on_terminal(folder.path(), "run stiff.json", 200);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  CAPTURE(outcome.out);
  REQUIRE(outcome.code == 0);
  const std::vector<std::string> frames = frames_of(outcome.out);
  REQUIRE_FALSE(frames.empty());
  CHECK(static_cast<double>(frames.size()) <= 1 + 10 * seconds);
  // what follows the starts is counted without a total
  CHECK(std::regex_search(
      frames.back(), std::regex(R"(^\[=* *\] \d+(/80)? evaluations.*, best support_stiffness\.uz )"
                                R"([-+.e\d]+ N/m, worst drive_load max_abs over stroke )"
                                R"([-+.e\d]+ %$)")));
  const std::size_t summary = outcome.out.find("leaf: optimal");
  REQUIRE(summary != std::string::npos);
  CHECK(outcome.out.substr(summary - wipe.size(), wipe.size()) == wipe);
  CHECK(outcome.out.find(wipe, summary) == std::string::npos);
  // no colours, with NO_COLOR or without
  CHECK_FALSE(std::regex_search(outcome.out, std::regex("\x1b\\[[^K]")));
}

TEST_CASE("The line fits a narrow terminal") {
  const test::Workplace folder;
  folder.put("stiff.json", optimise_job());
  const std::vector<std::string> frames =
      frames_of(test::run_on_terminal(folder.path(), "run stiff.json", 40).out);
  REQUIRE_FALSE(frames.empty());
  for (const std::string& frame : frames) CHECK(frame.size() <= 39);
  CHECK_THAT(frames.back(), Contains(" evaluations"));
}

TEST_CASE("Maps and tolerances are counted on a terminal, and in a file there is no line of it") {
  const test::Workplace folder;
  OrderedJson job = leaf_job();
  job["maps"] = OrderedJson::parse(R"([{"points": [3, 2], "parameters": [
      {"parameter": "thickness", "min": "0.2 mm", "max": "0.6 mm"},
      {"parameter": "length", "min": "60 mm", "max": "90 mm"}],
    "quantities": [{"quantity": "drive_load", "over_stroke": "last"}]}])");
  job["tolerances"] = {{"thickness", "10 um"}};
  job["tolerance_samples"] = {{"count", 8}, {"seed", 1}};
  folder.put("leaf.json", job);
  const std::string shown = test::run_on_terminal(folder.path(), "run leaf.json", 120).out;
  CAPTURE(shown);
  CHECK_THAT(shown, Contains(wipe + "[") && Contains("/8 sampled designs"));
  const test::Outcome file = folder.run("run leaf.json");
  CHECK(file.code == 0);
  CHECK_THAT(file.err, Contains("tolerances: 8 sampled designs\n") &&
                           Contains("map 1 of 1: 6 designs\n") && !Contains("\r") &&
                           !Contains("\x1b") && !Contains("/8") && !Contains("/6"));
  // without goals the quantities are told
  CHECK_THAT(file.out, Contains("within the tolerances:") && Contains("\n  drive_load, point 1 ") &&
                           Contains("thickness 100 %") && Contains("\n  8 sampled designs\n"));
  const auto tolerances = folder.json("leaf.out/result.json")["tolerances"];
  const auto& widest = tolerances["widest"];
  const auto load =
      std::ranges::find_if(widest, [](const auto& one) { return one["quantity"] == "drive_load"; });
  REQUIRE(load != widest.end());
  CHECK((*load)["sampled"] == tolerances["path"][1]["quantities"]["drive_load"]["sampled"]);
}

TEST_CASE("run --json prints the summary's numbers in SI") {
  const test::Workplace folder;
  folder.put("leaf.json", leaf_job());
  const test::Outcome outcome = folder.run("run leaf.json --json --out here");
  REQUIRE(outcome.code == 0);
  const auto printed = OrderedJson::parse(outcome.out);
  const auto result = folder.json("here/result.json");
  CHECK(unlike_text(printed, R"({"status": "ok", "usable": true, "folder": "here"})") == "");
  CHECK_FALSE(printed.contains("error"));
  bool load = false, support = false;
  for (const auto& row : printed["table"]) {
    if (row["quantity"] == "stroke") CHECK(row["values"] == OrderedJson({0.0, 0.004}));
    if (row["quantity"] == "drive_load") {
      load = true;
      CHECK(row["unit"] == "N");
      CHECK(row["values"][1] == result["path"][1]["drive_load"]);
    }
    if (row["label"] == "weakest support, translation") {
      support = true;
      const std::string direction = row["directions"][1];
      CHECK(row["values"][1] == result["path"][1]["support_stiffness"][direction]);
    }
  }
  CHECK((load && support));
}

TEST_CASE("run --json of an optimisation has the optimum with its constraints and differences") {
  const test::Workplace folder;
  OrderedJson job = optimise_job();
  job["model"]["accuracy"] = "reduced";
  folder.put("stiff.json", job);
  const test::Outcome outcome = folder.run("run stiff.json --json --quiet");
  CAPTURE(outcome.out, outcome.err);
  REQUIRE(outcome.code == 0);
  const auto optimum = OrderedJson::parse(outcome.out)["optimum"],
             whole = folder.json("stiff.out/result.json")["optimum"];
  CHECK(unlike(optimum,
               {{"objective", whole["objective"]},
                {"parameters", whole["parameters"]},
                {"verified",
                 {{"objective_difference", whole["verified"]["objective_difference"]}}}}) == "");
  CHECK(optimum["parameters"]["thickness"].get<double>() > 2e-4);
  CHECK(unlike_text(optimum["constraints"], R"([{"active": true, "max": 1}])") == "");
  CHECK(optimum["verified"]["constraints"].size() == 1);
}

TEST_CASE("run --json of a comparison has its worst errors") {
  const test::Workplace folder;
  OrderedJson job = leaf_job();
  job["job"] = "compare";
  job["model"] = {{"mesh", {4, 2}}};
  job["samples"] = OrderedJson::parse(R"({
    "method": "sobol", "count": 2, "seed": 1,
    "vary": [{"parameter": "thickness", "min": "0.2 mm", "max": "0.4 mm"}]})");
  job["models"] = OrderedJson::parse(R"([{"name": "default"}])");
  folder.put("two.json", job);
  const test::Outcome outcome = folder.run("run two.json --json --quiet");
  CAPTURE(outcome.out, outcome.err);
  REQUIRE(outcome.code == 0);
  const auto model = OrderedJson::parse(outcome.out)["comparison"]["models"][0],
             whole = folder.json("two.out/result.json")["comparison"]["models"][0];
  CHECK(model["name"] == "default");
  CHECK(model["errors"]["drive_load"]["worst"] == whole["errors"]["drive_load"]["worst"]);
  CHECK(model["errors"]["drive_load"]["worst"].get<double>() > 0);
}

TEST_CASE("run --json tells what is wrong on stdout, with the usual exit code") {
  const test::Workplace folder;
  folder.put("leaf.json", leaf_job());
  const auto printed = [&](const std::string& arguments, int code) {
    const test::Outcome outcome = folder.run("run " + arguments);
    CAPTURE(arguments, outcome.out, outcome.err);
    CHECK(outcome.code == code);
    return OrderedJson::parse(outcome.out);
  };
  const auto wrong =
      printed("leaf.json --json --set /stroke/to='\"5 N\"' --set /frequencies=-1", 2);
  CHECK(wrong["status"] == "wrong_input");
  CHECK(wrong["errors"].size() == 2);
  CHECK(wrong["error"] == wrong["errors"][0]);
  const auto& error = wrong["errors"][wrong["errors"][0]["pointer"] == "/stroke/to" ? 0 : 1];
  CHECK(unlike_text(error, R"({"pointer": "/stroke/to", "value": "\"5 N\""})") == "");
  CHECK_THAT(error["rule"].get<std::string>(), Contains("expected a length"));
  CHECK_THAT(error["message"].get<std::string>(), Contains("/stroke/to") && Contains("5 N"));
  CHECK(printed("none.json --json", 2)["error"]["value"] == "none.json");
  CHECK_THAT(printed("leaf.json --threads 0 --json", 2)["error"]["message"].get<std::string>(),
             Contains("--threads"));
  CHECK(printed("--json", 2)["status"] == "wrong_input");
  const auto lost = printed("leaf.json --json --quiet --set '/stroke/to=\"160 mm\"'", 1);
  CHECK(unlike_text(lost, R"({"status": "no_equilibrium", "usable": false})") == "");
}

TEST_CASE(
    "run --rigid shows a design beside itself with a rigid frame, with the ratio of each number") {
  const test::Workplace folder;
  const std::string job = FLEXOPT_SOURCE_DIR "/designs/jobs/elastic_stage.json";
  const test::Outcome both = folder.run("run " + job + " --rigid --out both --quiet");
  CAPTURE(both.out, both.err);
  REQUIRE(both.code == 0);  // what the job expects of the elastic one is met
  const OrderedJson designs = folder.json("both/result.json")["designs"];
  REQUIRE(designs.size() == 2);
  CHECK(designs[0]["name"] == "elastic");
  CHECK(designs[1]["name"] == "rigid");
  const auto path = [&](std::size_t k) { return designs[k]["result"]["path"]; };
  // Solids of a guide with a rigid stage against solids of all of it: 53.4 % in the fourth
  // frequency. Leaves with rigid edges are off by 0.5 % in each of the two.
  const double mode = path(1)[0]["frequencies"]["drive_locked"][3].get<double>() /
                      path(0)[0]["frequencies"]["drive_locked"][3].get<double>();
  CHECK(mode == Approx(1.534).epsilon(0.01));
  CHECK_THAT(both.out, Contains(fmt::format("({:.3f})", mode)));
  for (const char* row : {"drive stiffness", "support stiffness ux", "support stiffness rz",
                          "frequency 6, drive locked", "stroke 0 mm", "stroke 6 mm"})
    CHECK_THAT(both.out, Contains(row));

  // the rigid one is that of the option
  const test::Outcome rigid =
      folder.run("run " + job + " --set /design/elastic_bodies=rigid --out rigid --quiet");
  CHECK(rigid.code == 0);
  CHECK(folder.json("rigid/result.json")["path"] == path(1));

  const test::Outcome none =
      folder.run("run " FLEXOPT_SOURCE_DIR "/designs/jobs/notch_hinge.json --rigid");
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains("no elastic bodies but hinges"));
  folder.put("optimise.json", optimise_job());
  const test::Outcome other = folder.run("run optimise.json --rigid");
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Contains("it is for an evaluation"));
}
