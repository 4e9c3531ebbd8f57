// Optimisations whose accuracy is chosen search on looked-up leaves of the job's own mesh, and end
// at the optimum of the mesh that was chosen.
#include "core/reduction/atlas/atlas_file.hpp"
#include "results/run/progress.hpp"
#include "results/run/run.hpp"
#include "support/small_atlas.hpp"
#include "tests/results/results_tests.hpp"

namespace {

// In the place of the user's atlas while it lives.
struct SmallAtlas {
  test::AtlasPlace place;
  SmallAtlas() {
    AtlasSettings s = test::small_settings();
    s.mesh = {6, 2};
    s.width = {0.2, 0.5};
    s.thickness = {1.0 / 240, 1.0 / 150};
    s.points = {5, 4};
    s.poissons_ratios = {0.3};
    s.rays = {-1, 1};
    s.sigmas = {0, 0.05, 0.25};
    s.dynamics = true;
    s.stress_samples = 20;
    const auto kept = test::kept_atlas("guides", s, test::unchecked());
    REQUIRE(write_atlas(*kept, place.file()));
  }
};

json guide(const std::string& atlas) {
  json job = json::parse(R"({
    "flexopt": 1, "name": "guide", "job": "optimise",
    "design": {"family": "parallel_guide",
      "parameters": {"length": "100 mm", "width": "25 mm", "thickness": "0.6 mm",
                     "spacing": "80 mm"},
      "material": {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3, "density": "7800 kg/m^3"}},
    "end_effector": {"mass": "0.5 kg", "inertia": ["3e-4 kg m^2", "3e-4 kg m^2", "3e-4 kg m^2"]},
    "stroke": {"from": 0, "to": "8 mm", "points": 3}, "frequencies": 6,
    "model": {"mesh": [6, 2], "accuracy": "auto", "tolerance": 0.015},
    "optimise": {
      "variables": [{"parameter": "width", "min": "22 mm", "max": "45 mm"},
                    {"parameter": "thickness", "min": "0.45 mm", "max": "0.65 mm"}],
      "objective": {"maximise": "parasitic_frequency", "over_stroke": "min"},
      "constraints": [{"quantity": "max_stress", "over_stroke": "max", "max": "320 MPa"},
                      {"quantity": "drive_load", "over_stroke": "max_abs", "max": "30 N"}],
      "algorithm": {"library": "nlopt", "name": "LD_SLSQP"}, "starts": 1}})");
  job["model"]["atlas"] = atlas;
  return job;
}

}  // namespace

TEST_CASE("a search on looked-up leaves ends at the optimum of the chosen mesh", "[slow]") {
  const SmallAtlas atlas;
  Silent listener;
  const RunRecord found = run_any(parse_job(guide("auto")), {}, listener),
                  built = run_any(parse_job(guide("off")), {}, listener);
  CAPTURE(found.message, built.message);
  REQUIRE(found.status == "ok");
  REQUIRE(built.status == "ok");
  REQUIRE(found.job.model.mesh != std::array<int, 2>{6, 2});
  CHECK(found.job.model.mesh == built.job.model.mesh);
  REQUIRE(found.job.search_model);
  CHECK(found.job.search_model->mesh == std::array<int, 2>{6, 2});
  CHECK_FALSE(built.job.search_model);

  const Optimum &a = *found.optimum, &b = *built.optimum;
  CHECK(a.of_reduced_leaves);
  REQUIRE(a.verified->loop);
  CHECK(a.verified->loop->converged);
  CHECK(a.verified->loop->steps.size() > 1);  // the meshes differ
  CHECK(a.objective == Approx(b.objective).epsilon(1e-5));
  for (const auto& [name, value] : b.parameters)
    CHECK(a.parameters.at(name) == Approx(value).epsilon(1e-3));
  // what is told is of the chosen mesh, and so are the differences from full leaves
  for (const PathPoint& point : found.response.path)
    for (const LeafReport& leaf : point.leaves) CHECK(leaf.source != "atlas");
  CHECK(std::abs(a.verified->objective_difference) < 2e-4);
  const json result = make_result(found);
  CHECK(result["optimum"]["searched_on"] == json{{"accuracy", "reduced"}, {"mesh", {6, 2}}});
  CHECK(result["atlas"]["mesh"] == json{6, 2});
  CHECK(make_result(built)["optimum"]["searched_on"].is_null());
}

TEST_CASE("designs in stock sizes are searched on the mesh that was chosen", "[slow]") {
  const SmallAtlas atlas;
  json job = guide("auto");
  job["optimise"]["variables"][1]["step"] = "0.05 mm";
  Silent listener;
  const RunRecord found = run_any(parse_job(job), {}, listener);
  CAPTURE(found.message);
  CHECK(found.status == "ok");
  CHECK_FALSE(found.job.search_model);
}
