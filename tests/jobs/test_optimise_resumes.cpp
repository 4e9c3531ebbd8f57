// An optimisation that is killed at any moment, again and again, ends with the same bytes as one
// that ran through: starts, front, stock sizes and verification included. No evaluation is lost or
// made twice.

#include <map>
#include <random>
#include <set>

#include "child.hpp"

using namespace child;

namespace {

json job_document() {
  return json::parse(R"({
    "flexopt": 1, "name": "killed", "job": "optimise",
    "design": {"family": "cross_hinge",
      "parameters": {"length": "60 mm", "width": "20 mm", "thickness": "0.3 mm", "gap": "2 mm"},
      "material": "stavax"},
    "end_effector": {"mass": "0.3 kg", "inertia": ["1e-4 kg m^2", "1e-4 kg m^2", "1e-4 kg m^2"]},
    "stroke": {"to": "15 deg", "points": 3}, "frequencies": 0,
    "model": {"mesh": [6, 2], "method": "linear_craig_bampton"},
    "optimise": {
      "variables": [
        {"parameter": "length", "min": "30 mm", "max": "90 mm"},
        {"parameter": "thickness", "min": "0.1 mm", "max": "0.8 mm", "step": "0.05 mm"}],
      "objective": {"maximise": "support_stiffness.ux"},
      "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "max": "0.15 N m"}],
      "algorithm": {"library": "nlopt", "name": "LD_SLSQP"},
      "pareto": {"quantity": "drive_load", "over_stroke": "max_abs", "points": 3},
      "verify": {"tolerance": 1e-3},
      "starts": 4, "seed": 3, "max_evaluations": 60}
  })");
}

/// Whole lines of a log after its heading.
std::vector<json> lines(const fs::path& file) {
  std::vector<json> all;
  const std::string text = read(file);
  for (std::size_t begin = text.find('\n'), end;
       begin != std::string::npos && (end = text.find('\n', begin + 1)) != std::string::npos;
       begin = end)
    all.push_back(json::parse(text.substr(begin + 1, end - begin - 1)));
  return all;
}

/// What was evaluated, and how often.
std::map<std::string, int> counted(const std::vector<json>& evaluations) {
  std::map<std::string, int> count;
  for (const json& e : evaluations)
    ++count[json{e["variables"], e["full"], e["gradient"].is_null()}.dump()];
  return count;
}

}  // namespace

TEST_CASE("an optimisation killed ten times ends with the same bytes", "[slow]") {
  const bool global = GENERATE(false, true);
  CAPTURE(global);
  const Folder folder;
  const fs::path job = folder / "job.json";
  json document = job_document();
  if (global) {  // the kills fall into the screening, too
    document["optimise"].update({{"search", "global"}, {"screened_designs", 400}, {"starts", 3}});
    document["maps"] = {{{"parameters", {{{"parameter", "length"}}, {{"parameter", "thickness"}}}},
                         {"points", {4, 3}}}};
  }
  const fs::path through = folder / "through";
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(finished(start(job, document, through, "1")) == 0);
  const auto whole = std::chrono::steady_clock::now() - begin;
  const json result = json::parse(read(through / "result.json"));
  REQUIRE(result["optimum"]["pareto"]["points"].size() == 3);
  REQUIRE(result["optimum"]["stock"]["chosen"].is_number());
  REQUIRE(result["optimum"]["verified"]["loop"]["full_evaluations"].get<int>() >= 1);

  for (const char* threads : {"1", "2"}) {
    CAPTURE(threads);
    const fs::path out = folder / ("killed" + std::string(threads));
    std::mt19937 random(static_cast<unsigned>(threads[0]));  // moments, not numbers: any will do
    int kills = 0;
    std::size_t before = 0;
    bool ended = false;
    for (int k = 0; k < 10; ++k) {
      const pid_t child = start(job, out, threads);
      const auto patience = whole * (0.05 + 0.1 * std::generate_canonical<double, 20>(random));
      std::this_thread::sleep_for(patience);
      ended = ended_or_killed(child);
      if (ended) break;
      ++kills;
      const auto log = lines(out / "evaluations.jsonl");
      const std::size_t known = log.size() + lines(out / "evaluations.screening.jsonl").size();
      CHECK(known >= before);  // nothing is lost
      before = known;
      // nothing is made twice, but where two starts meet at a design by themselves
      const auto once = counted(lines(through / "evaluations.jsonl"));
      for (const auto& [design, count] : counted(log)) {
        const auto found = once.find(design);
        REQUIRE(found != once.end());
        CHECK(count <= found->second);
      }
    }
    if (!ended) REQUIRE(finished(start(job, out, threads)) == 0);
    CHECK(kills >= 5);
    std::vector<std::string> files{"result.json", "evaluations.jsonl", "history.csv",
                                   "pareto.csv",  "path.csv",          "report.html"};
    if (global) files.insert(files.end(), {"evaluations.screening.jsonl", "maps.csv"});
    check_same(through, out, files);
  }
}

TEST_CASE("an infeasible job exits 1 with the least violated design") {
  const Folder folder;
  json document = job_document();
  json& o = document["optimise"];
  o["constraints"][0]["max"] = "1e-4 N m";
  const fs::path out = folder / "out";
  CHECK(finished(start(folder / "job.json", document, out, "2")) == 1);
  const json result = json::parse(read(out / "result.json"));
  CHECK(result["status"] == "infeasible");
  const json& optimum = result["optimum"];
  CHECK(optimum["status"] == "infeasible");
  CHECK(optimum["stop_reason"].get<std::string>().find("drive_load max_abs over stroke") !=
        std::string::npos);
  // the softest hinge in the box
  CHECK(optimum["parameters"]["length"].get<double>() == Approx(0.09).epsilon(1e-3));
  CHECK(optimum["parameters"]["thickness"].get<double>() == Approx(1e-4).epsilon(1e-2));
  CHECK(optimum["constraints"][0]["margin"].get<double>() < 0);
  CHECK(optimum["agreeing_starts"] == 0);
  CHECK(optimum["pareto"].is_null());
  CHECK(optimum["stock"].is_null());
}
