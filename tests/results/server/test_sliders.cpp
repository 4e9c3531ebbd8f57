#include "optim/job/found_design.hpp"
#include "results/server/serve.hpp"
#include "tests/results/results_tests.hpp"

namespace {

json hinge() {
  return json::parse(R"({
    "flexopt": 1, "name": "hinge", "job": "evaluate",
    "design": {"family": "three_flexure_cross_hinge",
      "parameters": {"length": "50 mm", "thickness": "0.4 mm", "half_angle": "60 deg",
                     "inner_width": "49 mm", "gap": "1 mm", "crossing_fraction": 0.6,
                     "outer_width": {"expression": "(0.1 - inner_width - 2*gap)/2"}},
      "material": {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3, "density": "7800 kg/m^3"}},
    "end_effector": {"mass": "1 kg", "inertia": ["1e-3 kg m^2", "2e-3 kg m^2", "2e-3 kg m^2"]},
    "stroke": {"from": 0, "to": "20 deg", "points": 3}, "frequencies": 2,
    "expect": [{"pointer": "/path/0/stroke", "value": 0, "tolerance": 1, "source": "none"}]})");
}

json optimised() {
  json job = hinge();
  job["job"] = "optimise";
  job["optimise"] = json::parse(R"({
    "variables": [{"parameter": "length", "min": "20 mm", "max": "100 mm", "start": "40 mm"},
                  {"parameter": "material.density", "min": 2000, "max": 9000},
                  {"parameter": "end_effector.mass", "min": "0.5 kg", "max": "2 kg"},
                  {"parameter": "end_effector.center_of_mass.y", "min": 0, "max": "20 mm"},
                  {"parameter": "end_effector.inertia.xy", "min": "-1e-4 kg m^2",
                   "max": "1e-4 kg m^2"}],
    "objective": {"maximise": "parasitic_frequency"}})");
  return job;
}

const Slider& named(const std::vector<Slider>& sliders, const std::string& name) {
  const auto found = std::ranges::find(sliders, name, &Slider::name);
  REQUIRE(found != sliders.end());
  return *found;
}

}  // namespace

TEST_CASE("Sliders go from half to twice a value, as far as the design allows") {
  const Job job = parse_job(hinge());
  const auto sliders = sliders_of(job);
  CHECK(sliders.size() == 6);  // none for the formula
  CHECK(named(sliders, "length").min == Approx(0.025).margin(0));
  CHECK(named(sliders, "length").max == Approx(0.1).margin(0));
  const Family& family = resolve(job.design)->family();
  for (const Slider& slider : sliders) {
    CAPTURE(slider.name);
    CHECK(slider.min < slider.value);
    CHECK(slider.value < slider.max);
    const auto p = std::ranges::find(family.parameters, slider.name, &Parameter::name);
    CHECK((p->open_min ? slider.min > p->min : slider.min >= p->min));
    CHECK((p->open_max ? slider.max < p->max : slider.max <= p->max));
  }
  CHECK(named(sliders, "half_angle").max < 1.5707963);  // not twice 60°
}

TEST_CASE("A parameter that is zero can be moved, and so can a number of things") {
  json document = hinge();
  document["design"]["parameters"]["gap"] = 0;
  const auto sliders = sliders_of(parse_job(document));
  CHECK(named(sliders, "gap").min == Approx(-0.025));  // half the length
  CHECK(named(sliders, "gap").max == Approx(0.025));

  const auto moves = sliders_of(parse_job(json::parse(R"({
    "flexopt": 1, "name": "leaves", "job": "evaluate",
    "design": {"family": "overconstrained_guide",
      "parameters": {"count": 4, "length": "100 mm", "width": "30 mm", "thickness": "0.4 mm",
                     "pitch": "10 mm"},
      "material": {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3, "density": 7800}},
    "stroke": {"from": 0, "to": 1e-3, "points": 2}})")));
  const Slider count = named(moves, "count");
  CHECK(count.whole);
  CHECK(count.min == 2);
  CHECK(count.max == 8);
  CHECK_FALSE(named(moves, "pitch").whole);
  CHECK(read_move(R"({"parameters": {"count": 5}})", moves).at("count") == 5);
  CHECK_THROWS_WITH(read_move(R"({"parameters": {"count": 3.5}})", moves),
                    Contains("whole number from 2 to 8"));
}

TEST_CASE("An optimisation has its variables with their bounds") {
  const auto sliders = sliders_of(parse_job(optimised()));
  REQUIRE(sliders.size() == 5);
  CHECK(sliders[0].name == "length");
  CHECK(sliders[0].value == 0.04);  // its start
  CHECK(sliders[0].min == 0.02);
  CHECK(sliders[0].max == 0.1);
  CHECK(sliders[1].value == 7800);
  CHECK(sliders[2].unit == "kg");
}

TEST_CASE("Jobs without one design to look at have no sliders") {
  Job job = parse_job(hinge());
  job.kind = JobKind::compare;
  CHECK(test::refusal_of([&] { (void)sliders_of(job); }).pointer() == "/job");
}

TEST_CASE("A move is numbers of sliders inside their ranges, and nothing else") {
  const auto sliders = sliders_of(parse_job(hinge()));
  const auto read = [&](const std::string& body) { return read_move(body, sliders); };
  CHECK(read(R"({"parameters": {}})").empty());
  CHECK(read(R"({"parameters": {"length": 0.025, "gap": 1e-3}})") ==
        ParameterValues{{"gap", 1e-3}, {"length", 0.025}});
  for (const char* body :
       {"", "[]", "3", "null", "{}", R"({"parameters": []})", R"({"parameters": {}, "out": "x"})",
        R"({"parameters": {"length": "50 mm"}})", R"({"parameters": {"length": null}})",
        R"({"parameters": {"length": true}})", R"({"parameters": {"length": NaN}})",
        R"({"parameters": {"length": 1e999}})", R"({"parameters": {"length": 0.1000001}})",
        R"({"parameters": {"length": 0.0249999}})", R"({"parameters": {"length": [0.05]}})",
        R"({"parameters": {"outer_width": 0.02}})", R"({"parameters": {"/design/file": 1}})",
        R"({"parameters": {"length": 0.05, "length": 0.06}})"}) {
    CAPTURE(body);
    CHECK_THROWS_AS(read(body), SpecError);
  }
  CHECK_THROWS_WITH(
      read(R"({"parameters": {"length": 1}})"),
      Contains("/parameters/length = 1") && Contains("expected a number from 0.025 to 0.1 m"));
  CHECK_THROWS_WITH(read(R"({"parameters": {"lenght": 0.05}})"), Contains("did you mean 'length'"));
}

TEST_CASE("A job that was moved is a job with these numbers, all else as it was") {
  const Job job = parse_job(hinge());
  const json moved = moved_job(job, {{"length", 0.06}, {"inner_width", 0.04}});
  CHECK_FALSE(moved.contains("expect"));
  const Job read = parse_job(moved);
  CHECK(read.design.parameters.at("length") == 0.06);
  CHECK(read.design.parameters.at("outer_width") == Approx(0.029));  // its formula
  CHECK(read.design.parameters.at("gap") == 0.001);
  CHECK(read.request.points == job.request.points);
  CHECK(moved_job(job, {}) == moved_job(parse_job(moved_job(job, {})), {}));
}

TEST_CASE("Numbers of material and end-effector, and starts, are moved too") {
  const Job job = parse_job(optimised());
  const Job moved = parse_job(moved_job(job, {{"length", 0.06},
                                              {"material.density", 2700},
                                              {"end_effector.mass", 0.7},
                                              {"end_effector.center_of_mass.y", 0.01},
                                              {"end_effector.inertia.xy", 5e-5}}));
  CHECK(moved.design.parameters.at("length") == 0.06);
  CHECK(*moved.optimise->variables[0].start == 0.06);
  CHECK(moved.design.material.density == 2700);
  CHECK(moved.end_effector.mass == 0.7);
  CHECK(moved.end_effector.center_of_mass == Vector3d(0, 0.01, 0));
  CHECK(moved.end_effector.inertia(0, 1) == 5e-5);
  CHECK(moved.end_effector.inertia(1, 0) == 5e-5);
  CHECK(moved.end_effector.inertia(1, 1) == 2e-3);
}
