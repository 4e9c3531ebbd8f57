#include "optim/studies/comparison.hpp"
#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

/// Guides by their ratios: L/w, L/t and a stroke that grows with the length.
json by_ratios() {
  json job = guide::stiff_guide();
  job["job"] = "compare";
  job.erase("optimise");
  job["samples"] = json::parse(R"({
    "count": 32,
    "vary": [
      {"parameter": "length", "min": "50 mm", "max": "150 mm"},
      {"symbol": "aspect", "min": 0.5, "max": 8, "scale": "log"},
      {"symbol": "thinness", "min": 100, "max": 400},
      {"parameter": "width", "expression": "length/aspect"},
      {"parameter": "thickness", "expression": "min(length, width)/thinness"}
    ],
    "largest_stroke": "0.2*length"
  })");
  return job;
}

}  // namespace

TEST_CASE("samples keep to their ranges and follow their formulas") {
  const std::vector<Sample> samples = make_samples(parse_job(by_ratios()));
  REQUIRE(samples.size() == 32);
  int wide = 0;
  for (const Sample& s : samples) {
    REQUIRE(s.refused.empty());
    const double L = s.parameters.at("length"), w = s.parameters.at("width");
    const double aspect = s.symbols.at("aspect"), thinness = s.symbols.at("thinness");
    CHECK((L >= 0.05 && L <= 0.15 && aspect >= 0.5 && aspect <= 8));
    CHECK((thinness >= 100 && thinness <= 400));
    CHECK(w == Approx(L / aspect).epsilon(1e-14));
    CHECK(s.parameters.at("thickness") == Approx(std::min(L, w) / thinness).epsilon(1e-14));
    CHECK(s.parameters.at("spacing") == 0.06);  // the job's own
    REQUIRE(s.stroke.size() == 3);
    CHECK(s.stroke[0] == 0);
    CHECK(s.stroke[1] == Approx(0.1 * L));
    CHECK(s.stroke[2] == Approx(0.2 * L));
    if (aspect < 2) ++wide;
  }
  CHECK(wide == 16);  // even in the logarithm: half of them below the geometric mean
}

TEST_CASE("a grid and a list give the designs they say") {
  json grid = by_ratios();
  grid["samples"] = json::parse(R"({"method": "grid", "points": 2, "vary": [
      {"parameter": "length", "min": "50 mm", "max": "150 mm", "points": 3},
      {"parameter": "width", "min": "10 mm", "max": "40 mm"}]})");
  const std::vector<Sample> samples = make_samples(parse_job(grid));
  REQUIRE(samples.size() == 6);
  CHECK(samples[3].parameters.at("length") == Approx(0.1));
  CHECK(samples[3].parameters.at("width") == Approx(0.04));
  CHECK(samples[3].stroke == std::vector<double>{0, 2.5e-3, 5e-3});

  json list = by_ratios();
  list["samples"] = json::parse(R"({"method": "list", "designs": [{}, {"length": "80 mm"}],
      "vary": [{"parameter": "width", "expression": "length/2"}]})");
  const std::vector<Sample> listed = make_samples(parse_job(list));
  REQUIRE(listed.size() == 2);
  CHECK(listed[0].parameters.at("width") == Approx(0.03));
  CHECK(listed[1].parameters.at("width") == Approx(0.04));
}

TEST_CASE("material and end-effector may differ from design to design") {
  json document = by_ratios();
  document["samples"] = json::parse(R"J({"method": "grid", "points": 2, "vary": [
      {"parameter": "material.youngs_modulus", "min": "100 GPa", "max": "200 GPa"},
      {"parameter": "end_effector.mass", "min": "1 kg", "max": "2 kg"},
      {"parameter": "thickness", "expression": "0.5e-3*(2e11/material.youngs_modulus)^(1/3)"}]})J");
  const Job job = parse_job(document);
  const std::vector<Sample> samples = make_samples(job);
  REQUIRE(samples.size() == 4);
  for (const Sample& s : samples) {
    REQUIRE(s.refused.empty());
    const double E = s.parameters.at("material.youngs_modulus"), t = s.parameters.at("thickness");
    CHECK(E * t * t * t == Approx(2e11 * 1.25e-10));
    const Mechanism mechanism = make_mechanism(job, s.parameters);
    CHECK(mechanism.leaves[0].material.youngs_modulus == E);
    CHECK(mechanism.bodies[mechanism.end_effector].mass == s.parameters.at("end_effector.mass"));
  }
}

TEST_CASE("a design whose formula leaves its range is refused in words, not left out") {
  json job = by_ratios();
  job["samples"]["vary"][3]["expression"] = "sqrt(aspect - 2)*10";  // nothing, or up to 24 m
  const std::vector<Sample> samples = make_samples(parse_job(job));
  REQUIRE(samples.size() == 32);
  int nothing = 0, too_wide = 0;
  for (const Sample& s : samples) {
    if (s.symbols.at("aspect") < 2) {
      ++nothing;
      CHECK_THAT(s.refused, Contains("/samples/vary/3/expression") && Contains("no finite value"));
    } else if (!s.refused.empty()) {
      ++too_wide;
      CHECK_THAT(s.refused, Contains("/design/parameters/width"));
    }
  }
  CHECK(nothing == 16);
  CHECK(too_wide > 0);
}

TEST_CASE("a compare job as read is read again to the same") {
  json document = by_ratios();
  document["models"] =
      json::parse(R"([{"name": "a"}, {"name": "b", "mesh": [6, 2], "degree": 7}])");
  document["model"] = {{"tolerance", 1e-8}};
  const Job job = parse_job(document);
  REQUIRE(job.compare);
  REQUIRE(job.compare->models.size() == 2);
  CHECK(job.compare->full.model.accuracy == Accuracy::full);
  CHECK(job.compare->full.newton.tolerance == 1e-8);
  CHECK(job.compare->models[0].model.accuracy == Accuracy::reduced);
  CHECK(job.compare->models[0].model.mesh == ModelOptions().mesh);
  CHECK(job.compare->models[1].model.mesh == std::array{6, 2});
  CHECK(job.compare->models[1].model.degree == 7);
  CHECK(job.compare->models[1].newton.tolerance == 1e-8);
  CHECK(*parse_job(*job.as_read).as_read == *job.as_read);

  document.erase("models");
  document["model"] = {{"accuracy", "full"}};
  const Job standard = parse_job(document);
  REQUIRE(standard.compare->models.size() == 1);
  CHECK(standard.compare->models[0].name == "default");
  CHECK(standard.compare->models[0].model.accuracy == Accuracy::reduced);
}
