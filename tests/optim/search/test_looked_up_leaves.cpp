// A search on leaves that are looked up, with their own derivatives, against one on full leaves.
#include "optim/search/optimise.hpp"
#include "support/small_atlas.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

std::shared_ptr<const TubeAtlas> atlas_of_guides(bool tables) {
  AtlasSettings s = test::small_settings();
  s.rays = {-1, 1};
  s.dynamics = tables;
  s.stress_patterns = tables ? 60 : 0;
  s.stress_samples = 20;
  return test::kept_atlas(tables ? "tables" : "statics", s, test::unchecked());
}

/// Of load and stiffness, or of frequency and stress.
Job guide(const std::string& algorithm, bool dynamic, bool tables = true) {
  json document = json::parse(R"({
    "flexopt": 1, "name": "guide", "job": "optimise",
    "design": {"family": "parallel_guide",
      "parameters": {"length": "100 mm", "width": "30 mm", "thickness": "0.5 mm", "spacing": "100 mm"},
      "material": {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3, "density": "7800 kg/m^3"}},
    "end_effector": {"mass": "1 kg", "inertia": ["8.33e-5 kg m^2", "9.08e-4 kg m^2", "8.42e-4 kg m^2"]},
    "stroke": {"from": 0, "to": "12 mm", "points": 3},
    "frequencies": 3,
    "model": {"mesh": [4, 2]},
    "optimise": {
      "variables": [{"parameter": "width", "min": "26 mm", "max": "38 mm"},
                    {"parameter": "thickness", "min": "0.43 mm", "max": "0.61 mm"}],
      "objective": {"minimise": "drive_load", "over_stroke": "max_abs"},
      "constraints": [{"quantity": "support_stiffness.uz", "over_stroke": "min", "min": "3e5 N/m"},
                      {"expression": "width + 60*thickness", "max": "62 mm"}],
      "starts": 1, "max_evaluations": 60}
  })");
  document["optimise"]["algorithm"] = {{"library", "nlopt"}, {"name", algorithm}};
  if (dynamic) {
    document["optimise"]["objective"] = {{"maximise", "parasitic_frequency"},
                                         {"over_stroke", "min"}};
    document["optimise"]["constraints"][0] = {
        {"quantity", "max_stress"}, {"over_stroke", "max"}, {"max", "380 MPa"}};
  }
  Job job = parse_job(document);
  job.model.atlas = atlas_of_guides(tables);
  return job;
}

}  // namespace

TEST_CASE("a search on looked-up leaves ends at the optimum of full ones", "[slow]") {
  const bool dynamic = GENERATE(false, true);
  Job full = guide("LD_SLSQP", dynamic);
  full.model.accuracy = Accuracy::full;
  const Optimum truth = optimise(full, {});
  REQUIRE(truth.status == OptimumStatus::optimal);
  CHECK_FALSE(truth.of_reduced_leaves);
  CHECK_FALSE(truth.verified->loop);

  const Optimum o = optimise(guide("LD_SLSQP", dynamic), {});
  INFO(o.stop_reason);
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.gradients == "exact");
  CHECK(o.of_reduced_leaves);
  CHECK(o.at_full_accuracy);
  REQUIRE(o.verified->loop);
  const VerificationLoop& loop = *o.verified->loop;
  INFO(loop.message);
  CHECK(loop.converged);
  CHECK(loop.steps.front().difference > 1e-7);  // the leaves are others
  CHECK(loop.steps.size() <= 3);
  REQUIRE(loop.kkt);
  CHECK(*loop.kkt <= 1e-5);
  CHECK(o.objective == Approx(truth.objective).epsilon(1e-6));
  for (const char* name : {"width", "thickness"})
    CHECK(o.parameters.at(name) == Approx(truth.parameters.at(name)).epsilon(1e-5));
  REQUIRE(o.constraints[0].multiplier);
  CHECK(*o.constraints[0].multiplier == Approx(*truth.constraints[0].multiplier).epsilon(1e-3));
}

TEST_CASE("goals that looked-up leaves do not cover are searched on full ones") {
  const Optimum o = optimise(guide("LD_SLSQP", true, false), {});
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.gradients == "exact");
  CHECK_FALSE(o.of_reduced_leaves);
  CHECK_FALSE(o.verified->loop);
}

TEST_CASE("a search without gradients is that of the job's model", "[slow]") {
  const Optimum o = optimise(guide("LN_COBYLA", false), {});
  CHECK(o.gradients == "none");
  CHECK_FALSE(o.of_reduced_leaves);
  CHECK_FALSE(o.verified->loop);
}
