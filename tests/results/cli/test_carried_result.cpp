// A project goes on from the design of a run that only evaluated it, and folders that do not fit
// are refused; test_project.py goes on from optima.
#include "tests/results/results_tests.hpp"

namespace {

/// A guide as a design file with a part, a job that names it, and a run of a thinner one.
class Project : public test::Workplace {
 public:
  Project() {
    put("leaf.json", R"({"flexopt_design": 1,
      "parameters": {"long": {"unit": "m", "above": 0}, "thick": {"unit": "m", "above": 0}},
      "bodies": [{"name": "a", "at": [0, 0, 0]}, {"name": "b", "at": ["long", 0, 0]}],
      "leaves": [{"name": "leaf", "base": {"body": "a", "at": [0, 0, 0]},
                  "tip": {"body": "b", "at": ["long", 0, 0]}, "across": [0, 0, 1],
                  "width": "20 mm", "thickness": "thick"}],
      "drive": {"body": "b", "direction": "uy"}})");
    put("guide.json", R"({"flexopt_design": 1,
      "parameters": {"length": {"unit": "m", "above": 0, "default": "60 mm"},
                     "thickness": {"unit": "m", "above": 0, "default": "0.4 mm"}},
      "bodies": [{"name": "end_effector", "at": ["length", 0, 0]}],
      "frames": [{"name": "up", "at": [0, "20 mm", 0]}, {"name": "down", "at": [0, "-20 mm", 0]}],
      "parts": [{"name": "upper", "design": "leaf.json", "frame": "up",
                 "parameters": {"long": "length", "thick": "thickness"},
                 "join": {"a": "ground", "b": "end_effector"}},
                {"name": "lower", "design": "leaf.json", "frame": "down",
                 "parameters": {"long": "length", "thick": "thickness"},
                 "join": {"a": "ground", "b": "end_effector"}}],
      "drive": {"direction": "uy"}})");
    put("eval.json", R"({"flexopt": 1, "name": "guide", "job": "evaluate",
      "design": {"file": "guide.json", "material": "stavax"},
      "end_effector": {"mass": "0.2 kg", "inertia": [1e-5, 1e-5, 1e-5]},
      "stroke": {"from": 0, "to": "2 mm", "points": 2}, "frequencies": 2,
      "model": {"flexure": "beam", "mesh": [4, 2]}})");
    CHECK(run(R"(run eval.json --set '/design/parameters={"thickness": 3e-4}' --out thin.out)")
              .code == 0);
  }
};

double thickness_of(const json& result) { return result["leaves"][0]["thickness"]; }

}  // namespace

TEST_CASE("the design that a run evaluated goes on with --result, in a job and in a first job") {
  const Project project;
  CHECK(project.run("run eval.json --result thin.out --out first.out").code == 0);
  json job = json::parse(project.content("eval.json"));
  job["design"] = {{"result", "../thin.out"}};
  fs::create_directory(project / "jobs");
  project.put("jobs/next.json", job);
  CHECK(project.run("run jobs/next.json --out second.out").code == 0);
  CHECK(project.run("new thin.out --out third.json").code == 0);
  CHECK(project.run("run third.json --out third.out").code == 0);
  CHECK(project
            .run("run eval.json --result thin.out --out set.out --set "
                 "/design/parameters/thickness=0.0002")
            .code == 0);
  CHECK(thickness_of(json::parse(project.content("set.out/result.json"))) ==
        Approx(2e-4).epsilon(1e-12));
  for (const char* folder : {"first.out", "second.out", "third.out"}) {
    CAPTURE(folder);
    const json result = json::parse(project.content(folder + std::string("/result.json")));
    CHECK(thickness_of(result) == Approx(3e-4).epsilon(1e-12));
    CHECK(result["material"]["name"] == "stavax");
  }
}

TEST_CASE("a first job of a result keeps all that acted in its run, and says what it leaves out") {
  const Project project;
  json job = json::parse(project.content("eval.json"));
  job["temperature"] = {{"change", 10}};
  job["gravity"] = {0, -9.81, 0};
  job["probes"] = {{{"name", "p"}, {"at", {0.03, 0.02, 0}}}};
  job["load_capacity"]["directions"] = json::array({"uz"});
  job["cases"] = json::parse(R"({"light": {}, "heavy": {"loads": [{"force": [0, 0, "-1 N"]}]}})");
  project.put("acted.json", job);
  CHECK(project.run("run acted.json --out acted.out").code == 0);
  const test::Outcome plain = project.run("new acted.out --out next.json");
  CHECK(plain.code == 0);
  CHECK_THAT(plain.err, !Contains("left out"));
  json kept = json::parse(project.content("acted.out/job.json"));
  kept.erase("expect");
  CHECK(json::parse(project.content("next.json")) == kept);

  job["tolerances"] = {{"thickness", "10 um"}};
  job["tolerance_samples"] = {{"count", 2}};
  job["optimise"] = json::parse(R"({"variables": [{"parameter": "length", "min": 0.05, "max": 0.1}],
      "objective": {"minimise": "max_stress", "over_stroke": "max"}})");
  project.put("acted.json", job);
  CHECK(project.run("run acted.json --out acted.out").code == 0);
  const test::Outcome search = project.run("new acted.out --optimise --out search.json");
  CHECK(search.code == 0);
  CHECK_THAT(search.err,
             Contains("left out of the run's job: optimise, tolerances, tolerance_samples"));
  const json begun = json::parse(project.content("search.json"));
  CHECK(begun["cases"] == json::parse(project.content("acted.out/job.json"))["cases"]);
  CHECK(begun["optimise"]["variables"].size() == 2);
  CHECK(project.run("validate search.json").code == 0);
}

TEST_CASE("a design file is described as a family is") {
  const Project project;
  const test::Outcome o = project.run("designs guide.json");
  CHECK(o.code == 0);
  CHECK_THAT(o.out, Contains("length") && Contains("thickness") && Contains("0.0004"));
  CHECK(project.run("quantities guide.json").code == 0);
}

TEST_CASE("folders that found nothing for the job are refused") {
  const Project project;
  const auto refused = [&](const std::string& arguments) {
    const test::Outcome o = project.run(arguments);
    CHECK(o.code == 2);
    return o.err;
  };
  CHECK_THAT(refused("validate eval.json --result nowhere"),
             Contains("--result") && Contains("no such folder"));
  fs::create_directory(project / "empty");
  CHECK_THAT(refused("run eval.json --result empty"), Contains("no result.json"));
  json other = json::parse(project.content("eval.json"));
  other["design"] = json::parse(R"({"family": "leaf_spring", "material": "stavax",
      "parameters": {"length": 0.05, "width": 0.01, "thickness": 3e-4}})");
  project.put("other.json", other);
  CHECK(project.run("run other.json --out other.out").code == 0);
  CHECK_THAT(refused("run eval.json --result other.out"),
             Contains("another design") && Contains("width"));
  other["design"] = {{"result", "nowhere"}};
  project.put("lost.json", other);
  CHECK_THAT(refused("validate lost.json"), Contains("/design/result"));
  CHECK_THAT(refused("run eval.json --sett /stroke/points=3"),
             Contains("--sett") && Contains("--set"));
}
