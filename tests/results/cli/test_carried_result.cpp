// A project goes on from what a run found, with no number copied: commands with --result, jobs
// whose design is a result, first jobs of a result, and folders of results as archives.
#include "tests/results/results_tests.hpp"

namespace {

/// A guide as a design file with a part, and jobs that name it; one of them is run.
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
    nlohmann::json job =
        nlohmann::json::parse(R"({"flexopt": 1, "name": "thinner", "job": "optimise",
      "design": {"file": "guide.json", "material": "stavax"},
      "end_effector": {"mass": "0.2 kg", "inertia": [1e-5, 1e-5, 1e-5]},
      "stroke": {"from": 0, "to": "2 mm", "points": 2}, "frequencies": 2,
      "model": {"flexure": "beam", "mesh": [4, 2]},
      "optimise": {"variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "0.6 mm"}],
                   "objective": {"minimise": "thickness"},
                   "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "min": "10 N"}],
                   "algorithm": {"library": "nlopt", "name": "LD_SLSQP"}}})");
    put("opt.json", job);
    job["job"] = "evaluate";
    job.erase("optimise");
    put("eval.json", job);
    ran = run("run opt.json --out opt.out");
    found =
        nlohmann::json::parse(content("opt.out/result.json"))["optimum"]["parameters"]["thickness"];
  }
  test::Outcome ran;
  double found = 0;
};

double thickness_of(const json& result) { return result["leaves"][0]["thickness"]; }

}  // namespace

TEST_CASE("every command with a job takes it to what a run found") {
  const Project project;
  CHECK(project.ran.code == 0);
  REQUIRE(project.found > 2.1e-4);
  CHECK(project.run("run eval.json --result opt.out --out eval.out").code == 0);
  const json result = json::parse(project.content("eval.out/result.json"));
  CHECK(thickness_of(result) == project.found);
  CHECK(result["path"][1]["drive_load"].get<double>() == Approx(10).epsilon(1e-4));
  CHECK(project.run("show eval.json --result opt.out --out drawn").code == 0);
  CHECK_THAT(project.content("drawn/report.html"),
             Contains("\"thickness\":" + json(project.found).dump()));
  CHECK(project.run("validate eval.json --result opt.out").code == 0);
  CHECK_THAT(project.run("expand eval.json --result opt.out").out,
             Contains(json(project.found).dump()));
  CHECK(project.run("export eval.json --result opt.out --format spacar --out deck").code == 0);
  // The optimisation goes on from there.
  CHECK(project.run("run opt.json --result opt.out --out again").code == 0);
  CHECK(json::parse(project.content("again/result.json"))["optimum"]["variables"][0]["initial"] ==
        project.found);
}

TEST_CASE("the design of a job may be the result of another") {
  const Project project;
  json job = json::parse(project.content("eval.json"));
  job["design"] = {{"result", "../opt.out"}};
  fs::create_directory(project / "jobs");
  project.put("jobs/next.json", job);
  CHECK(project.run("run jobs/next.json --out next.out").code == 0);
  const json result = json::parse(project.content("next.out/result.json"));
  CHECK(thickness_of(result) == project.found);
  CHECK(result["material"]["name"] == "stavax");
  job["design"]["parameters"] = {{"thickness", "0.5 mm"}};  // the job's own go before
  project.put("jobs/thick.json", job);
  CHECK(project.run("run jobs/thick.json --out thick.out").code == 0);
  CHECK(thickness_of(json::parse(project.content("thick.out/result.json"))) == 5e-4);
}

TEST_CASE("a first job of a result has its design and what the run was asked for") {
  const Project project;
  CHECK(project.run("new opt.out --out first.json").code == 0);
  const json job = json::parse(project.content("first.json"));
  CHECK(job["end_effector"]["mass"] == 0.2);
  CHECK(project.run("run first.json --out first.out").code == 0);
  CHECK(thickness_of(json::parse(project.content("first.out/result.json"))) ==
        Approx(project.found).epsilon(1e-9));
}

TEST_CASE("a folder of results needs no other file") {
  const Project project;
  fs::create_directory(project / "elsewhere");
  fs::rename(project / "opt.out", project / "elsewhere/kept");
  for (const char* file : {"guide.json", "leaf.json", "opt.json", "eval.json"})
    fs::remove(project / file);
  CHECK(project.run("validate elsewhere/kept/job.json").code == 0);
  CHECK(project.run("run elsewhere/kept/job.json --out again").code == 0);
  CHECK(project.content("again/job.json") == project.content("elsewhere/kept/job.json"));
  CHECK(project.run("run elsewhere/kept/job.json --result elsewhere/kept --out third").code == 0);
  CHECK(project.run("report elsewhere/kept").code == 0);
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
