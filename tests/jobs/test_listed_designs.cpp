// Several designs in one job: ranked, each as if it had run alone, and killed at any moment the
// same bytes in the end.

#include <map>

#include "child.hpp"

using namespace child;

namespace {

json job_document() {
  return json::parse(R"({
    "flexopt": 1, "name": "which", "job": "optimise",
    "designs": [
      {"name": "too stiff", "family": "cartwheel_hinge",
       "parameters": {"length": "10 mm", "width": "20 mm", "thickness": "0.5 mm"},
       "variables": [{"parameter": "thickness", "min": "0.4 mm", "max": "0.8 mm"}]},
      {"family": "cross_hinge",
       "parameters": {"length": "60 mm", "width": "20 mm", "thickness": "0.3 mm", "gap": "2 mm"},
       "variables": [{"parameter": "length", "min": "30 mm", "max": "90 mm"},
                     {"parameter": "thickness", "min": "0.1 mm", "max": "0.8 mm"}]},
      {"family": "three_flexure_cross_hinge",
       "parameters": {"length": "60 mm", "outer_width": "10 mm", "inner_width": "20 mm",
                      "thickness": "0.3 mm", "gap": "2 mm"},
       "variables": [{"parameter": "thickness", "min": "0.1 mm", "max": "0.8 mm"}]}],
    "material": "stavax",
    "end_effector": {"mass": "0.3 kg", "inertia": ["1e-4 kg m^2", "1e-4 kg m^2", "1e-4 kg m^2"]},
    "stroke": {"to": "15 deg", "points": 3}, "frequencies": 0,
    "model": {"mesh": [6, 2], "method": "linear_craig_bampton"},
    "optimise": {
      "objective": {"maximise": "support_stiffness.ux"},
      "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "max": "0.15 N m"},
                      {"quantity": "envelope.cylinder", "max": "80 mm"}],
      "algorithm": {"library": "nlopt", "name": "LD_SLSQP"},
      "starts": 2, "seed": 3, "max_evaluations": 40}
  })");
}

}  // namespace

TEST_CASE("listed designs are ranked, one without a feasible point last", "[slow]") {
  const Folder folder;
  const fs::path file = folder / "job.json", out = folder / "out";
  REQUIRE(finished(start(file, job_document(), out, "2")) == 0);
  const json result = json::parse(read(out / "result.json"));
  const json& ranking = result["ranking"];
  REQUIRE(ranking.size() == 3);
  CHECK(ranking[2]["name"] == "too stiff");
  CHECK(ranking[2]["feasible"] == false);
  CHECK(ranking[2]["worst_constraint"]["label"] == "drive_load max_abs over stroke");
  CHECK(ranking[0]["objective"].get<double>() > ranking[1]["objective"].get<double>());
  for (int k = 0; k < 2; ++k) {
    const json& own = ranking[k]["result"];
    CHECK(own["optimum"]["gradients"] == "central differences");  // the method has no others
    CHECK(own["path"][0]["envelope"]["cylinder"].get<double>() <= 0.08 * (1 + 1e-4));
  }
  CHECK(result["optimum"] == ranking[0]["result"]["optimum"]);

  // each as it would be alone: the job in its folder is one of its own
  for (const json& entry : ranking) {
    const fs::path own = out / entry["folder"].get<std::string>(), alone = folder / "alone";
    fs::remove_all(alone);
    (void)finished(start(own / "job.json", alone, "2"));
    CHECK(read(own / "result.json") == read(alone / "result.json"));
    CHECK(json::parse(read(own / "result.json")) == entry["result"]);
    CHECK(read(own / "evaluations.jsonl") == read(alone / "evaluations.jsonl"));
  }
}

TEST_CASE("listed designs killed again and again end with the same bytes", "[slow]") {
  const Folder folder;
  const fs::path file = folder / "job.json", through = folder / "through", out = folder / "out";
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(finished(start(file, job_document(), through, "1")) == 0);
  const auto whole = std::chrono::steady_clock::now() - begin;
  int kills = 0;
  bool ended = false;
  for (int k = 0; k < 6 && !ended; ++k) {
    const pid_t child = start(file, out, "1");
    std::this_thread::sleep_for(whole * (0.15 + 0.05 * k));
    ended = ended_or_killed(child);
    kills += !ended;
  }
  if (!ended) REQUIRE(finished(start(file, out, "1")) == 0);
  CHECK(kills >= 3);
  check_same(through, out,
             {"result.json", "ranking.csv", "report.html", "job.json",
              "designs/too_stiff/evaluations.jsonl", "designs/cross_hinge/history.csv",
              "designs/three_flexure_cross_hinge/result.json"});
}

TEST_CASE("listed designs are evaluated side by side") {
  const Folder folder;
  json document = job_document();
  document["job"] = "evaluate";
  document.erase("optimise");
  const fs::path file = folder / "job.json", out = folder / "out";
  CHECK(finished(start(file, document, out, "1")) == 0);
  const json result = json::parse(read(out / "result.json"));
  REQUIRE(result["designs"].size() == 3);
  CHECK_FALSE(result.contains("ranking"));
  CHECK(result["designs"][1]["name"] == "cross_hinge");
  CHECK(result["designs"][1]["result"]["path"].size() == 3);
  CHECK(result["path"] == result["designs"][0]["result"]["path"]);
}

TEST_CASE("of six hinges, shortened, the cartwheel wins, and slaving the stage helps", "[slow]") {
  const Folder folder;
  json document =
      json::parse(read(fs::path(FLEXOPT_SOURCE_DIR) / "designs/studies/six_hinges.json"));
  document["stroke"] = {{"to", "20 deg"}, {"points", 3}};
  document["optimise"]["starts"] = 1;
  document.erase("expect");
  const fs::path file = folder / "job.json", out = folder / "out";
  REQUIRE(finished(start(file, document, out, "2")) == 0);
  const json result = json::parse(read(out / "result.json"));
  std::map<std::string, double> best;
  for (const json& entry : result["ranking"]) {
    CAPTURE(entry["name"]);
    REQUIRE(entry["feasible"] == true);
    best[entry["name"]] = entry["objective"];
    const json& own = entry["result"];
    CHECK(own["optimum"]["gradients"] == "exact");
    for (const json& point : own["path"]) {
      CHECK(point["envelope"]["moving"]["cylinder"].get<double>() <= 0.1 * (1 + 1e-4));
      CHECK(point["envelope"]["z"].get<double>() <= 0.1 * (1 + 1e-4));
      if (!point["clearance"].is_null()) CHECK(point["clearance"].get<double>() >= 0.499e-3);
    }
  }
  REQUIRE(best.size() == 6);
  CHECK(result["ranking"][0]["name"] == "cartwheel_hinge");
  CHECK(best["cartwheel_hinge"] == Approx(277.14).epsilon(1e-3));  // of the whole study
  CHECK(best["infinity_hinge"] > best["butterfly_hinge"]);
  CHECK(best["three_flexure_cross_hinge"] > best["cross_hinge"]);
}
