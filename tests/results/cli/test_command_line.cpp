// The program as a user starts it: exit codes, what it prints where, and what it leaves behind.
#include <cstdlib>
#include <regex>

#include "results/files/json_text.hpp"
#include "support/wrong_designs.hpp"
#include "tests/results/results_tests.hpp"

namespace {

OrderedJson optimise_job() {
  OrderedJson job = test::optimised_leaf();
  job["name"] = "stiff leaf";
  job["frequencies"] = 1;
  job["stroke"]["points"] = 2;
  return job;
}

}  // namespace

TEST_CASE("Help, version, schema, designs and quantities go to stdout and exit 0") {
  const test::Workplace folder;
  for (const char* arguments : {"--help", "--version", "schema", "designs", "designs leaf_spring",
                                "designs cross_hinge", "quantities", "quantities cross_hinge"}) {
    CAPTURE(arguments);
    const test::Outcome outcome = folder.run(arguments);
    CHECK(outcome.code == 0);
    CHECK(outcome.out.size() > 10);
    CHECK(outcome.err.empty());
  }
  CHECK(std::regex_search(folder.run("--version").out,
                          std::regex(R"(^flexopt \d+\.\d+\.\d+ \(.+\)\n$)")));
  CHECK(OrderedJson::parse(folder.run("schema").out).contains("properties"));
  CHECK(OrderedJson::parse(folder.run("schema").out)["type"] == "object");
  folder.put("leaf.json", test::leaf_job());
  for (const char* sets : {"", " --set '/stroke/to=3 mm' --set /model/mesh=[4,2]"})
    CHECK(folder.run("validate leaf.json" + std::string(sets)).code == 0);
  CHECK_THAT(folder.run("designs leaf_spring").out, Contains("thickness"));
  const std::string of_guide = folder.run("quantities parallel_guide").out,
                    of_hinge = folder.run("quantities cross_hinge").out;
  CHECK_THAT(of_guide, Contains("buckling_load_factor") && Contains("max_stress"));
  CHECK(of_guide != of_hinge);  // a drive that moves, a drive that turns
}

TEST_CASE("check-gradients compares every derivative that a job has", "[slow]") {
  const test::Workplace folder;
  const auto cases = OrderedJson::parse(R"([
    {"name": "a leaf", "job": {"frequencies": 2, "model": {"mesh": [6, 2]}},
     "says": ["material.youngs_modulus", "thickness", "derivatives agree"]},
    {"name": "joints",
     "job": {"frequencies": 2, "model": {"mesh": [6, 2]}, "design": {"tip": "hinged"}},
     "says": ["derivatives agree"]},
    {"name": "a mass without derivatives",
     "job": {"frequencies": 2, "model": {"mesh": [6, 2], "mass": "constant"}},
     "says": ["drive_stiffness",
              "no exact derivatives: parasitic_frequency, frequencies.drive_free.0"]},
    {"name": "both translations in the plane of a hinge at 45 deg at rest are the softest; along the angle one of them falls and the other rises",
     "job": {"frequencies": 0, "model": {"mesh": [4, 2]}, "stroke": {"at": [0]},
             "design": {"family": "cross_hinge", "parameters": {
               "length": "50 mm", "width": "100 mm", "thickness": "0.35 mm",
               "half_angle": "45 deg", "gap": "5 mm"}}},
     "says": ["principal_stiffness", "has a derivative on either side alone",
              "along half_angle at point 0"],
     "says_not": ["along length"]},
    {"name": "what says how many there are is left out",
     "job": {"frequencies": 0, "model": {"accuracy": null, "flexure": "beam", "mesh": [4, 2]},
             "stroke": {"at": [0]},
             "design": {"family": "overconstrained_guide", "parameters": {
               "count": 2, "length": "80 mm", "width": null, "thickness": null}}},
     "says": ["drive_stiffness              pitch", "derivatives agree"]},
    {"name": "a parameter at its least value is differenced from there upwards",
     "job": {"frequencies": 3, "model": {"accuracy": null, "flexure": "beam", "mesh": [4, 2]},
             "stroke": {"at": [0]},
             "design": {"family": "butterfly_hinge", "parameters": {
               "stage_mass": 0, "length": null, "width": null, "thickness": null}}},
     "says": ["parasitic_frequency          stage_mass"], "says_not": ["no differences"]}])");
  for (const OrderedJson& one : cases) {
    OrderedJson job = test::leaf_job();
    if (one["job"].contains("stroke")) job.erase("stroke");
    job.merge_patch(one["job"]);
    folder.put("job.json", job);
    const test::Outcome checked = folder.run("check-gradients job.json");
    CAPTURE(one["name"], checked.out, checked.err);
    CHECK(checked.code == 0);
    CHECK_THAT(checked.out, !Contains("WRONG"));
    for (const std::string text : one["says"]) CHECK_THAT(checked.out, Contains(text));
    for (const std::string text : one.value("says_not", OrderedJson::array()))
      CHECK_THAT(checked.out, !Contains(text));
  }
}

TEST_CASE("An atlas that cannot be written is refused before it is made") {
  const test::Workplace folder;
  const test::Outcome refused = folder.run("atlas --out /proc/no/such/folder/one.atlas");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("--out") && Contains("/proc/no/such/folder/one.atlas"));
  CHECK(folder.run("atlas --mesh 1 4").code == 2);
  const test::Outcome none = folder.run("atlas --show --out none.atlas");
  CHECK(none.code == 1);
  CHECK_THAT(none.err, Contains("none.atlas"));
}

TEST_CASE("A wrong command line exits 2 and says why") {
  const test::Workplace folder;
  folder.put("leaf.json", test::leaf_job());
  const auto wrong = OrderedJson::parse(R"(["", "fly", "run", "run leaf.json --threads 0",
      "run leaf.json --threads many", "run leaf.json --set", "run leaf.json --unknown",
      "run leaf.json more.json", "run missing.json", "run .", "run leaf.json --out leaf.json",
      "run leaf.json --out leaf.json/below", "run leaf.json --out /proc/flexopt.out",
      "run leaf.json --out ''", "run leaf.json --set /design/parameters/thickness=-1",
      "run leaf.json --set nonsense", "validate", "validate missing.json",
      "validate leaf.json --set stroke=1", "validate leaf.json --set /stroke/to",
      "validate leaf.json --set /strok/to=1", "validate leaf.json --set /stroke/to=1N",
      "designs no_such_family", "quantities no_such_family", "report missing", "report .",
      "check-gradients missing.json"])");
  for (const std::string arguments : wrong) {
    CAPTURE(arguments);
    const test::Outcome outcome = folder.run(arguments);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    CHECK_FALSE(outcome.err.empty());
    CHECK(folder.names() == std::vector<std::string>{"leaf.json"});
  }
  for (const char* out : {"leaf.json", "leaf.json/below"})
    CHECK_THAT(folder.run("run leaf.json --out " + std::string(out)).err, Contains(out));
  CHECK(folder.json("leaf.json") == test::leaf_job());
  CHECK_THAT(folder.run("designs no_such_family").err, Contains("parallel_guide"));
  CHECK_THAT(folder.run("vaildate leaf.json").err, Contains("did you mean 'validate'"));
  CHECK_THAT(folder.run("run leaf.json --sett /stroke/to=1").err, Contains("did you mean '--set'"));
  CHECK_THAT(folder.run("check-gradients leaf.json --tolerance -1").err, Contains("--tolerance"));
  folder.put("stage.json", test::cantilever().dump());
  CHECK_THAT(folder.run("run stage.json").err, Contains("it is a design file"));
  CHECK_THAT(folder.run("validate stage.json").out, Contains("/parameters/count: no formula"));
}

TEST_CASE("A stream that takes no text ends no run, and one may bring the job") {
  const test::Workplace folder;
  folder.put("leaf.json", test::leaf_job());
  const auto shell = [&](const std::string& before, const std::string& after) {
    const std::string command =
        "cd '" + folder.path().string() + "' && " + before + "'" + test::binary() + "' " + after;
    const int status = std::system(command.c_str());
    REQUIRE(WIFEXITED(status));
    return WEXITSTATUS(status);
  };
  const std::string full = " >/dev/full 2>/dev/full", null = " >/dev/null 2>&1";
  CHECK(shell("", "run leaf.json" + full) == 0);
  CHECK(folder.has("leaf.out/result.json"));
  CHECK(shell("", "run missing.json" + full) == 2);
  CHECK(shell("", "schema" + full) == 2);
  // and a job comes by a pipe as well
  CHECK(shell("cat leaf.json | ", "validate /dev/stdin" + null) == 0);
  CHECK(shell("cat leaf.json | ", "run /dev/stdin --out piped" + null) == 0);
  CHECK(folder.has("piped/result.json"));
}

TEST_CASE("A run takes nothing away that is not its own") {
  const test::Workplace folder;
  folder.put("job.json", test::leaf_job());
  const std::string before = folder.content("job.json");
  const test::Outcome refused = folder.run("run job.json --out .");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("would replace the job itself"));
  CHECK(folder.content("job.json") == before);
  fs::create_directories(folder / "out/cases/mine");
  folder.put("out/cases/mine/a.txt", "mine");
  CHECK(folder.run("run job.json --out out").code == 0);
  CHECK(folder.has("out/cases/mine/a.txt"));
  // an evaluation into the folder of an optimisation leaves nothing of that
  folder.put("out/history.csv", "evaluation\n");
  CHECK(folder.run("run out/job.json --out out").code == 0);
  CHECK_FALSE(folder.has("out/history.csv"));
}

TEST_CASE("An unstable mechanism is called so where it is told of") {
  const test::Workplace folder;
  OrderedJson job = test::leaf_job();
  job["loads"] = {{{"force", {"-1 kN", 0, 0}}}};
  job["stroke"] = {{"to", "1 mm"}, {"points", 2}};
  folder.put("leaf.json", job);
  const test::Outcome outcome = folder.run("run leaf.json");
  CAPTURE(outcome.out);
  CHECK_THAT(outcome.out, Contains("With the drive held it is unstable at 2 of 2 points."));
}

TEST_CASE("A run writes its folder, a summary and progress lines") {
  const test::Workplace folder;
  folder.put("leaf.json", test::leaf_job());
  const test::Outcome outcome = folder.run("run leaf.json");
  CAPTURE(outcome.err, outcome.out);
  REQUIRE(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("drive load") && Contains("4 mm"));
  CHECK_THAT(outcome.err, Contains("evaluating leaf"));
  const fs::path out = folder / "leaf.out";
  CHECK(test::names_in(out) ==
        std::vector<std::string>{"job.json", "path.csv", "report.html", "result.json", "scene.json",
                                 "shape_000.vtu", "shape_001.vtu", "shape_002.vtu", "shapes.pvd",
                                 "timings.json"});
  const auto result = OrderedJson::parse(test::content_of(out / "result.json"));
  CHECK(result["status"] == "ok");
  CHECK(result["path"][2]["drive_load"].get<double>() > 0);

  // job.json is itself a job with the same outcome; quietly, elsewhere, with another thread count.
  const test::Outcome again = folder.run("run leaf.out/job.json --out a/b --threads 1 --quiet");
  CHECK(again.code == 0);
  CHECK(again.err.empty());
  for (const std::string& name : test::names_in(out)) {
    CAPTURE(name);
    if (name != "timings.json")
      CHECK((test::content_of(out / name) == test::content_of(folder / "a/b" / name)));
  }

  fs::remove(out / "report.html");
  CHECK(folder.run("report leaf.out").code == 0);
  CHECK((test::content_of(out / "report.html") == folder.content("a/b/report.html")));
}

TEST_CASE("A wrong expectation exits 1, on stderr and in the result") {
  const test::Workplace folder;
  OrderedJson job = test::leaf_job();
  job["expect"] = {{{"pointer", "/path/2/drive_load"},
                    {"value", 1e6},
                    {"tolerance", 1.0},
                    {"source", "wrong on purpose"}}};
  folder.put("leaf.json", job);
  const test::Outcome outcome = folder.run("run leaf.json --quiet");
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err, Contains("/path/2/drive_load") && Contains("wrong on purpose"));
  const auto result = folder.json("leaf.out/result.json");
  CHECK(result["status"] == "expectation_failed");

  // Expected are the numbers of the job as written.
  const test::Outcome changed = folder.run("run leaf.json --set /stroke/points=4");
  CHECK(changed.code == 0);
  CHECK_THAT(changed.err, Contains("not checked"));
  CHECK(folder.run("run leaf.json --set /expect/0/tolerance=1e9").code == 0);
  CHECK(folder.run("run leaf.json --set /expect/0/tolerance=2").code == 1);
}

TEST_CASE("A stroke beyond reach exits 1 with the points that converged") {
  const test::Workplace folder;
  folder.put("leaf.json", test::leaf_job());
  const test::Outcome outcome = folder.run("run leaf.json --quiet --set '/stroke/to=\"160 mm\"'");
  CAPTURE(outcome.err, outcome.out);
  CHECK(outcome.code == 1);
  const auto result = folder.json("leaf.out/result.json");
  CHECK(result["status"] == "no_equilibrium");
  CHECK(result["path"][0]["status"] == "converged");
  CHECK(result["path"][2]["status"] != "converged");
}

TEST_CASE("An optimisation resumes from its log and ends with the same bytes") {
  const test::Workplace folder;
  folder.put("stiff.json", optimise_job());
  const test::Outcome whole = folder.run("run stiff.json --quiet --out whole");
  CAPTURE(whole.err, whole.out);
  REQUIRE(whole.code == 0);
  const fs::path out = folder / "whole";
  const auto result = OrderedJson::parse(test::content_of(out / "result.json"));
  CHECK(result["optimum"]["status"] == "optimal");
  CHECK(result["optimum"]["verified"]["status"] == "ok");
  CHECK_THAT(whole.out, Contains("support_stiffness.uz") && Contains("maximised"));

  // Interrupted in the middle of a line: job.json and a torn log are all that is there.
  const fs::path torn = folder / "torn";
  fs::create_directory(torn);
  fs::copy(out / "job.json", torn);
  const std::string log = test::content_of(out / "evaluations.jsonl");
  std::ofstream(torn / "evaluations.jsonl") << log.substr(0, log.size() / 2);
  const test::Outcome report = folder.run("report torn");
  CAPTURE(report.err);
  CHECK(report.code == 0);
  const std::string page = test::content_of(torn / "report.html");
  CHECK_THAT(page, Contains("\"status\":\"interrupted\"") && Contains("was interrupted after"));

  const test::Outcome resumed = folder.run("run stiff.json --quiet --out torn --threads 1");
  CHECK(resumed.code == 0);
  CHECK(test::names_in(torn) == test::names_in(out));
  for (const std::string& name : test::names_in(out)) {
    CAPTURE(name);
    if (name != "timings.json")
      CHECK((test::content_of(torn / name) == test::content_of(out / name)));
  }

  // Another job may take over the folder of a finished run, but not that of an interrupted one.
  const std::string changed = " --set '/stroke/to=\"3 mm\"'";
  CHECK(folder.run("run stiff.json --quiet --out torn" + changed).code == 0);
  fs::remove(out / "result.json");
  const test::Outcome refused = folder.run("run stiff.json --quiet --out whole" + changed);
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("evaluations.jsonl"));
  CHECK((test::content_of(out / "evaluations.jsonl") == log));
}

TEST_CASE("Every wrong design file is refused before anything is written", "[slow]") {
  const test::Workplace folder;
  OrderedJson job = test::leaf_job();
  job["design"] = {{"file", "stage.json"}, {"material", job["design"]["material"]}};
  folder.put("job.json", job);
  for (const test::WrongDesign& wrong : test::wrong_designs()) {
    folder.put("stage.json", OrderedJson::parse(test::changed(wrong.pointer, wrong.value).dump()));
    const test::Outcome outcome = folder.run("run job.json");
    INFO(wrong.pointer << " = " << wrong.value.dump() << "\n" << outcome.err);
    CHECK(outcome.code == 2);
    CHECK(std::regex_search(outcome.err, std::regex("(stage|job)\\.json:[0-9]+:[0-9]+: /")));
    CHECK_THAT(outcome.err, Contains(wrong.at) && Contains(wrong.rule));
    CHECK(folder.names() == std::vector<std::string>{"job.json", "stage.json"});
  }
}
