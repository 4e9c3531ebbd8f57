// The program as a user starts it: exit codes, what it prints where, and what it leaves behind.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "results/files/json_text.hpp"
#include "support/leaf_job.hpp"
#include "support/program.hpp"
#include "support/wrong_designs.hpp"

using namespace flexopt;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

OrderedJson optimise_job() {
  OrderedJson job = test::leaf_job();
  job["name"] = "stiff leaf";
  job["job"] = "optimise";
  job["frequencies"] = 1;
  job["stroke"]["points"] = 2;
  job["optimise"] = test::thickest_leaf();
  return job;
}

void save(const fs::path& file, const OrderedJson& job) { std::ofstream(file) << job.dump(2); }

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
  return names;
}

}  // namespace

TEST_CASE("Help, version, schema, designs and quantities go to stdout and exit 0",
          "[results][command]") {
  const test::TemporaryFolder folder;
  for (const char* arguments : {"--help", "--version", "schema", "designs", "designs leaf_spring",
                                "quantities", "quantities cross_hinge"}) {
    CAPTURE(arguments);
    const test::Outcome outcome = test::run_program(folder.path(), arguments);
    CHECK(outcome.code == 0);
    CHECK(outcome.out.size() > 10);
    CHECK(outcome.err.empty());
  }
  CHECK(std::regex_search(test::run_program(folder.path(), "--version").out,
                          std::regex(R"(^flexopt \d+\.\d+\.\d+ \(.+\)\n$)")));
  CHECK(OrderedJson::parse(test::run_program(folder.path(), "schema").out).contains("properties"));
  CHECK_THAT(test::run_program(folder.path(), "designs leaf_spring").out, Contains("thickness"));
  const std::string of_guide = test::run_program(folder.path(), "quantities parallel_guide").out,
                    of_hinge = test::run_program(folder.path(), "quantities cross_hinge").out;
  CHECK_THAT(of_guide, Contains("buckling_load_factor") && Contains("max_stress"));
  CHECK(of_guide != of_hinge);  // a drive that moves, a drive that turns
}

TEST_CASE("check-gradients compares every derivative of a job", "[results][command][slow]") {
  const test::TemporaryFolder folder;
  OrderedJson job = test::leaf_job();
  job["frequencies"] = 2;
  job["model"]["mesh"] = OrderedJson::array({6, 2});
  save(folder.path() / "leaf.json", job);
  const test::Outcome good = test::run_program(folder.path(), "check-gradients leaf.json");
  CHECK(good.code == 0);
  CHECK_THAT(good.out, Contains("material.youngs_modulus") && Contains("thickness") &&
                           !Contains("WRONG") && Contains("derivatives agree"));
  const test::Outcome joints =
      test::run_program(folder.path(), "check-gradients leaf.json --set /design/tip=hinged");
  CHECK(joints.code == 0);
  CHECK_THAT(joints.out, !Contains("WRONG") && Contains("derivatives agree"));
  const test::Outcome constant =
      test::run_program(folder.path(), "check-gradients leaf.json --set /model/mass=constant");
  CHECK(constant.code == 0);
  CHECK_THAT(constant.out, Contains("drive_stiffness") && !Contains("WRONG") &&
                               Contains("no exact derivatives: parasitic_frequency, "
                                        "frequencies.drive_free.0"));
}

TEST_CASE(
    "check-gradients knows where stiffnesses are equal and where there is nothing but rounding",
    "[results][command]") {
  // both translations in the plane of a hinge at 45 deg at rest are the softest
  const test::TemporaryFolder folder;
  OrderedJson job = test::leaf_job();
  job["design"]["family"] = "cross_hinge";
  job["design"]["parameters"] = {{"length", "50 mm"},
                                 {"width", "100 mm"},
                                 {"thickness", "0.35 mm"},
                                 {"half_angle", "45 deg"},
                                 {"gap", "5 mm"}};
  job["stroke"] = {{"at", {0}}};
  job["frequencies"] = 0;
  job["model"]["mesh"] = OrderedJson::array({4, 2});
  save(folder.path() / "hinge.json", job);
  const test::Outcome tied = test::run_program(folder.path(), "check-gradients hinge.json");
  CAPTURE(tied.out);
  CHECK(tied.code == 0);
  CHECK_THAT(tied.out, Contains("principal_stiffness") && !Contains("WRONG"));
  // along the angle one of them falls and the other rises
  CHECK_THAT(tied.out, Contains("has a derivative on either side alone") &&
                           Contains("along half_angle at point 0") && !Contains("along length"));
}

TEST_CASE("check-gradients leaves out what says how many there are", "[results][command]") {
  const test::TemporaryFolder folder;
  OrderedJson job = test::leaf_job();
  job["design"]["family"] = "overconstrained_guide";
  job["design"]["parameters"] = {{"count", 2}, {"length", "80 mm"}};
  job["stroke"] = {{"at", {0}}};
  job["frequencies"] = 0;
  job["model"] = {{"flexure", "beam"}, {"mesh", OrderedJson::array({4, 2})}};
  save(folder.path() / "guide.json", job);
  const test::Outcome guide = test::run_program(folder.path(), "check-gradients guide.json");
  CAPTURE(guide.out);
  CHECK(guide.code == 0);
  CHECK_THAT(guide.out, Contains("drive_stiffness              pitch") &&
                            Contains("derivatives agree") && !Contains("WRONG"));
}

TEST_CASE("check-gradients differences a parameter at its least value from there upwards",
          "[results][command][slow]") {
  const test::TemporaryFolder folder;
  OrderedJson job = test::leaf_job();
  job["design"]["family"] = "butterfly_hinge";
  job["design"]["parameters"] = {{"stage_mass", 0}};
  job["stroke"] = {{"at", {0}}};
  job["frequencies"] = 3;
  job["model"] = {{"flexure", "beam"}, {"mesh", OrderedJson::array({4, 2})}};
  save(folder.path() / "hinge.json", job);
  const test::Outcome massless = test::run_program(folder.path(), "check-gradients hinge.json");
  CAPTURE(massless.out);
  CHECK(massless.code == 0);
  CHECK_THAT(massless.out, Contains("parasitic_frequency          stage_mass") &&
                               !Contains("no differences") && !Contains("WRONG"));
}

TEST_CASE("An atlas that cannot be written is refused before it is made", "[results][command]") {
  const test::TemporaryFolder folder;
  const test::Outcome refused =
      test::run_program(folder.path(), "atlas --out /proc/no/such/folder/one.atlas");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("--out") && Contains("/proc/no/such/folder/one.atlas"));
  CHECK(test::run_program(folder.path(), "atlas --mesh 1 4").code == 2);
  const test::Outcome none = test::run_program(folder.path(), "atlas --show --out none.atlas");
  CHECK(none.code == 1);
  CHECK_THAT(none.err, Contains("none.atlas"));
}

TEST_CASE("A wrong command line exits 2 and says why", "[results][command]") {
  const test::TemporaryFolder folder;
  save(folder.path() / "leaf.json", test::leaf_job());
  for (const char* arguments : {"",
                                "fly",
                                "run",
                                "run leaf.json --threads 0",
                                "run leaf.json --threads many",
                                "run leaf.json --set",
                                "run leaf.json --unknown",
                                "run leaf.json more.json",
                                "run missing.json",
                                "run .",
                                "run leaf.json --out leaf.json",
                                "run leaf.json --out ''",
                                "run leaf.json --set /design/parameters/thickness=-1",
                                "run leaf.json --set nonsense",
                                "validate missing.json",
                                "designs no_such_family",
                                "quantities no_such_family",
                                "report missing",
                                "report .",
                                "check-gradients missing.json"}) {
    CAPTURE(arguments);
    const test::Outcome outcome = test::run_program(folder.path(), arguments);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    CHECK_FALSE(outcome.err.empty());
    CHECK(names_in(folder.path()) == std::set<std::string>{"leaf.json"});
  }
  CHECK_THAT(test::run_program(folder.path(), "designs no_such_family").err,
             Contains("parallel_guide"));
  CHECK_THAT(test::run_program(folder.path(), "vaildate leaf.json").err,
             Contains("did you mean 'validate'"));
  CHECK_THAT(test::run_program(folder.path(), "check-gradients leaf.json --tolerance -1").err,
             Contains("--tolerance"));
  std::ofstream(folder.path() / "stage.json") << test::cantilever().dump();
  CHECK_THAT(test::run_program(folder.path(), "run stage.json").err,
             Contains("it is a design file"));
}

TEST_CASE("A stream that takes no text ends no run", "[results][command]") {
  const test::TemporaryFolder folder;
  save(folder.path() / "leaf.json", test::leaf_job());
  const auto code = [&](const std::string& arguments) {
    const std::string command = "cd '" + folder.path().string() + "' && '" + test::binary() + "' " +
                                arguments + " >/dev/full 2>/dev/full";
    const int status = std::system(command.c_str());
    REQUIRE(WIFEXITED(status));
    return WEXITSTATUS(status);
  };
  CHECK(code("run leaf.json") == 0);
  CHECK(fs::exists(folder.path() / "leaf.out" / "result.json"));
  CHECK(code("run missing.json") == 2);
  CHECK(code("schema") == 2);
}

TEST_CASE("A job comes by a pipe as well", "[results][command]") {
  const test::TemporaryFolder folder;
  save(folder.path() / "leaf.json", test::leaf_job());
  for (const char* arguments : {"validate /dev/stdin", "run /dev/stdin --out piped"}) {
    CAPTURE(arguments);
    const std::string command = "cd '" + folder.path().string() + "' && cat leaf.json | '" +
                                test::binary() + "' " + arguments + " >/dev/null 2>&1";
    CHECK(std::system(command.c_str()) == 0);
  }
  CHECK(fs::exists(folder.path() / "piped/result.json"));
}

TEST_CASE("A run takes nothing away that is not its own", "[results][command]") {
  const test::TemporaryFolder folder;
  save(folder.path() / "job.json", test::leaf_job());
  const std::string before = test::content_of(folder.path() / "job.json");
  const test::Outcome refused = test::run_program(folder.path(), "run job.json --out .");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("would replace the job itself"));
  CHECK(test::content_of(folder.path() / "job.json") == before);
  fs::create_directories(folder.path() / "out" / "cases" / "mine");
  std::ofstream(folder.path() / "out" / "cases" / "mine" / "a.txt") << "mine";
  CHECK(test::run_program(folder.path(), "run job.json --out out").code == 0);
  CHECK(fs::exists(folder.path() / "out" / "cases" / "mine" / "a.txt"));
  // an evaluation into the folder of an optimisation leaves nothing of that
  std::ofstream(folder.path() / "out" / "history.csv") << "evaluation\n";
  CHECK(test::run_program(folder.path(), "run out/job.json --out out").code == 0);
  CHECK_FALSE(fs::exists(folder.path() / "out" / "history.csv"));
}

TEST_CASE("An unstable mechanism is called so where it is told of", "[results][command]") {
  const test::TemporaryFolder folder;
  OrderedJson job = test::leaf_job();
  job["loads"] = {{{"force", {"-1 kN", 0, 0}}}};
  job["stroke"] = {{"to", "1 mm"}, {"points", 2}};
  save(folder.path() / "leaf.json", job);
  const test::Outcome outcome = test::run_program(folder.path(), "run leaf.json");
  CAPTURE(outcome.out);
  CHECK_THAT(outcome.out, Contains("With the drive held it is unstable at 2 of 2 points."));
}

TEST_CASE("A run writes its folder, a summary and progress lines", "[results][command]") {
  const test::TemporaryFolder folder;
  save(folder.path() / "leaf.json", test::leaf_job());
  const test::Outcome outcome = test::run_program(folder.path(), "run leaf.json");
  CAPTURE(outcome.err, outcome.out);
  REQUIRE(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("drive load") && Contains("4 mm"));
  CHECK_THAT(outcome.err, Contains("evaluating leaf"));
  const fs::path out = folder.path() / "leaf.out";
  CHECK(names_in(out) == std::set<std::string>{"job.json", "path.csv", "report.html", "result.json",
                                               "scene.json", "shape_000.vtu", "shape_001.vtu",
                                               "shape_002.vtu", "shapes.pvd", "timings.json"});
  const auto result = OrderedJson::parse(test::content_of(out / "result.json"));
  CHECK(result["status"] == "ok");
  CHECK(result["path"][2]["drive_load"].get<double>() > 0);

  // job.json is itself a job with the same outcome; quietly, elsewhere, with another thread count.
  const test::Outcome again =
      test::run_program(folder.path(), "run leaf.out/job.json --out a/b --threads 1 --quiet");
  CHECK(again.code == 0);
  CHECK(again.err.empty());
  for (const std::string& name : names_in(out)) {
    CAPTURE(name);
    if (name != "timings.json")
      CHECK((test::content_of(out / name) == test::content_of(folder.path() / "a" / "b" / name)));
  }

  fs::remove(out / "report.html");
  CHECK(test::run_program(folder.path(), "report leaf.out").code == 0);
  CHECK((test::content_of(out / "report.html") ==
         test::content_of(folder.path() / "a" / "b" / "report.html")));
}

TEST_CASE("A wrong expectation exits 1, on stderr and in the result", "[results][command]") {
  const test::TemporaryFolder folder;
  OrderedJson job = test::leaf_job();
  job["expect"] = {{{"pointer", "/path/2/drive_load"},
                    {"value", 1e6},
                    {"tolerance", 1.0},
                    {"source", "wrong on purpose"}}};
  save(folder.path() / "leaf.json", job);
  const test::Outcome outcome = test::run_program(folder.path(), "run leaf.json --quiet");
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err, Contains("/path/2/drive_load") && Contains("wrong on purpose"));
  const auto result =
      OrderedJson::parse(test::content_of(folder.path() / "leaf.out" / "result.json"));
  CHECK(result["status"] == "expectation_failed");

  // Expected are the numbers of the job as written.
  const test::Outcome changed =
      test::run_program(folder.path(), "run leaf.json --set /stroke/points=4");
  CHECK(changed.code == 0);
  CHECK_THAT(changed.err, Contains("not checked"));
  CHECK(test::run_program(folder.path(), "run leaf.json --set /expect/0/tolerance=1e9").code == 0);
  CHECK(test::run_program(folder.path(), "run leaf.json --set /expect/0/tolerance=2").code == 1);
}

TEST_CASE("A stroke beyond reach exits 1 with the points that converged", "[results][command]") {
  const test::TemporaryFolder folder;
  save(folder.path() / "leaf.json", test::leaf_job());
  const test::Outcome outcome =
      test::run_program(folder.path(), "run leaf.json --quiet --set '/stroke/to=\"160 mm\"'");
  CAPTURE(outcome.err, outcome.out);
  CHECK(outcome.code == 1);
  const auto result =
      OrderedJson::parse(test::content_of(folder.path() / "leaf.out" / "result.json"));
  CHECK(result["status"] == "no_equilibrium");
  CHECK(result["path"][0]["status"] == "converged");
  CHECK(result["path"][2]["status"] != "converged");
}

TEST_CASE("An optimisation resumes from its log and ends with the same bytes",
          "[results][command]") {
  const test::TemporaryFolder folder;
  save(folder.path() / "stiff.json", optimise_job());
  const test::Outcome whole =
      test::run_program(folder.path(), "run stiff.json --quiet --out whole");
  CAPTURE(whole.err, whole.out);
  REQUIRE(whole.code == 0);
  const fs::path out = folder.path() / "whole";
  const auto result = OrderedJson::parse(test::content_of(out / "result.json"));
  CHECK(result["optimum"]["status"] == "optimal");
  CHECK(result["optimum"]["verified"]["status"] == "ok");
  CHECK_THAT(whole.out, Contains("support_stiffness.uz") && Contains("full accuracy"));

  // Interrupted in the middle of a line: job.json and a torn log are all that is there.
  const fs::path torn = folder.path() / "torn";
  fs::create_directory(torn);
  fs::copy(out / "job.json", torn);
  const std::string log = test::content_of(out / "evaluations.jsonl");
  std::ofstream(torn / "evaluations.jsonl") << log.substr(0, log.size() / 2);
  const test::Outcome report = test::run_program(folder.path(), "report torn");
  CAPTURE(report.err);
  CHECK(report.code == 0);
  const std::string page = test::content_of(torn / "report.html");
  CHECK_THAT(page, Contains("\"status\":\"interrupted\"") && Contains("was interrupted after"));

  const test::Outcome resumed =
      test::run_program(folder.path(), "run stiff.json --quiet --out torn --threads 1");
  CHECK(resumed.code == 0);
  CHECK(names_in(torn) == names_in(out));
  for (const std::string& name : names_in(out)) {
    CAPTURE(name);
    if (name != "timings.json")
      CHECK((test::content_of(torn / name) == test::content_of(out / name)));
  }

  // Another job may take over the folder of a finished run, but not that of an interrupted one.
  const std::string changed = " --set '/stroke/to=\"3 mm\"'";
  CHECK(test::run_program(folder.path(), "run stiff.json --quiet --out torn" + changed).code == 0);
  fs::remove(out / "result.json");
  const test::Outcome refused =
      test::run_program(folder.path(), "run stiff.json --quiet --out whole" + changed);
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("evaluations.jsonl"));
  CHECK((test::content_of(out / "evaluations.jsonl") == log));
}

TEST_CASE("Every wrong design file is refused by place and rule before anything is written",
          "[results][command][slow]") {
  const test::TemporaryFolder folder;
  OrderedJson job = test::leaf_job();
  job["design"] = {{"file", "stage.json"}, {"material", job["design"]["material"]}};
  save(folder.path() / "job.json", job);
  for (const test::WrongDesign& wrong : test::wrong_designs()) {
    save(folder.path() / "stage.json",
         OrderedJson::parse(test::changed(wrong.pointer, wrong.value).dump()));
    const test::Outcome outcome = test::run_program(folder.path(), "run job.json");
    INFO(wrong.pointer << " = " << wrong.value.dump() << "\n" << outcome.err);
    CHECK(outcome.code == 2);
    CHECK(std::regex_search(outcome.err, std::regex("(stage|job)\\.json:[0-9]+:[0-9]+: /")));
    CHECK_THAT(outcome.err, Contains(wrong.at) && Contains(wrong.rule));
    CHECK(names_in(folder.path()) == std::set<std::string>{"job.json", "stage.json"});
  }
}
