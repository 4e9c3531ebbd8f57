#include "core/response/quantities.hpp"
#include "core/spec/quantity.hpp"
#include "tests/optim/job/patched_job.hpp"

TEST_CASE("an optimise job is read with names, units and defaults") {
  const Job job = parse_job(base_job("optimise"));
  REQUIRE(job.optimise);
  const OptimiseSpec& spec = *job.optimise;
  REQUIRE(spec.variables.size() == 2);
  CHECK(spec.variables[0].parameter == "length");
  CHECK(spec.variables[0].min == Approx(0.02));
  CHECK(spec.variables[0].max == Approx(0.1));
  CHECK(spec.variables[0].start.value() == Approx(0.05));
  CHECK(spec.objective.maximise);
  CHECK(spec.objective.quantity == "parasitic_frequency");
  CHECK(spec.objective.over_stroke == OverStroke::min);
  REQUIRE(spec.constraints.size() == 2);
  CHECK(spec.constraints[0].label == "max_stress max over stroke");
  CHECK(spec.constraints[0].max.value() == Approx(450e6));
  CHECK_FALSE(spec.constraints[0].min);
  CHECK(spec.constraints[1].expression == "length*cos(half_angle)");
  CHECK(spec.constraints[1].max.value() == Approx(0.06));
  CHECK(spec.algorithm.library == "nlopt");
  CHECK(spec.algorithm.name == "LN_COBYLA");  // as it says
  CHECK(spec.tolerance == OptimiseSpec{}.tolerance);
  CHECK_FALSE(spec.pareto);
  CHECK_FALSE(spec.verify);
}

TEST_CASE("without a name the search is one by gradients where the model has exact ones") {
  json document = base_job("optimise");
  document["optimise"].erase("algorithm");
  CHECK(parse_job(document).optimise->algorithm.name == "LD_SLSQP");
  CHECK(document_of(parse_job(document))["optimise"]["algorithm"]["name"] == "LD_SLSQP");
  document["model"]["method"] = "modal_derivatives";
  const Job job = parse_job(document);
  CHECK(job.optimise->algorithm.name == "LN_COBYLA");
  CHECK(std::ranges::any_of(job.notes, [](const std::string& note) {
    return note.starts_with("LN_COBYLA searches, which needs no gradients");
  }));
  document["optimise"]["algorithm"] = {{"name", "LD_MMA"}};
  CHECK(parse_job(document).optimise->algorithm.name == "LD_MMA");
}

TEST_CASE("objective and constraint default to the worst of the stroke") {
  const OptimiseSpec spec = read_search(R"({
    "objective": {"maximise": null, "over_stroke": null, "minimise": "max_stress"},
    "constraints": [{"quantity": "parasitic_frequency", "min": "50 Hz"},
                    {"quantity": "max_stress", "max": "1 GPa"}]})");
  CHECK_FALSE(spec.objective.maximise);
  CHECK(spec.objective.over_stroke == OverStroke::max);
  CHECK(spec.constraints[0].over_stroke == OverStroke::min);
  CHECK(spec.constraints[1].over_stroke == OverStroke::max);
}

TEST_CASE("bounds of formulas take the unit that the formula has") {
  const auto bound = [](const std::string& formula, const json& value) {
    json document = base_job("optimise");
    document["optimise"]["constraints"] = {{{"expression", formula}, {"max", value}}};
    return parse_job(document).optimise->constraints[0].max.value();
  };
  CHECK(bound("2*outer_width + inner_width + 2*gap", "100 mm") == Approx(0.1));
  CHECK(bound("length*inner_width", "20 mm^2") == Approx(2e-5));
  CHECK(bound("length/inner_width", "50 %") == Approx(0.5));
  CHECK(bound("half_angle", "50 deg") == Approx(50 * degree));
  CHECK(bound("0.1 - inner_width", "10 mm") == Approx(0.01));  // a plain number: any unit in reach
  CHECK(bound("length*half_angle", "10 mm") == Approx(0.01));
  CHECK(bound("length^2 + gap^2", 0.3) == 0.3);
  CHECK_THROWS_WITH(bound("length^2 + gap", 0.3), Contains("an area") && Contains("a length"));
  CHECK(bound("length + 5 mm", "20 mm") == Approx(0.02));
  CHECK(bound("material.density*length*inner_width*thickness", "100 g") == Approx(0.1));
  CHECK(bound("material.youngs_modulus*thickness^3/length^2", "2 N/mm") == Approx(2000));
  CHECK(bound("end_effector.inertia.xx/end_effector.mass", "1 cm^2") == Approx(1e-4));
  CHECK_THROWS_AS(bound("material.density*length^3", "20 mm"), SpecError);
  CHECK_THROWS_AS(bound("length*inner_width", "20 mm"), SpecError);
  CHECK_THROWS_AS(bound("half_angle", "20 mm"), SpecError);
}

TEST_CASE("numbers of material and end-effector are variables too") {
  const Job job = parse_job(patched("optimise", R"({"optimise": {"variables": [
      {"parameter": "thickness", "min": "0.1 mm", "max": "1 mm"},
      {"parameter": "material.youngs_modulus", "min": "70 GPa", "max": "210 GPa"},
      {"parameter": "end_effector.mass", "min": "100 g", "max": "2 kg", "step": "0.5 kg"},
      {"parameter": "end_effector.center_of_mass.y", "min": "-5 mm", "max": "5 mm"},
      {"parameter": "end_effector.inertia.zz", "min": "5e-4 kg m^2", "max": "3e-3 kg m^2"}]}})"));
  const std::vector<Variable>& v = job.optimise->variables;
  CHECK(v[1].min == Approx(70e9));
  CHECK(v[1].start.value() == job.design.material.youngs_modulus);
  CHECK(v[2].start.value() == 1);
  CHECK(v[2].stock == std::vector<double>{0.5, 1, 1.5, 2});
  CHECK(v[3].start.value() == 0);
  CHECK(v[4].start.value() == 1e-3);

  ParameterValues values = job.design.parameters;
  values["material.youngs_modulus"] = 80e9;
  values["end_effector.center_of_mass.y"] = 4e-3;
  values["end_effector.inertia.zz"] = 1.5e-3;
  const Mechanism changed = make_mechanism(job, values),
                  own = make_mechanism(job, job.design.parameters);
  CHECK(changed.leaves[0].material.youngs_modulus == 80e9);
  CHECK(changed.leaves[0].material.density == own.leaves[0].material.density);
  const RigidBody &a = changed.bodies[changed.end_effector], &b = own.bodies[own.end_effector];
  CHECK(a.center_of_mass - b.center_of_mass == Vector3d(0, 4e-3, 0));
  CHECK(a.inertia - b.inertia == Vector3d(0, 0, 1.5e-3 - 1e-3).asDiagonal().toDenseMatrix());
  CHECK(a.mass == 1);
  // beyond the sum of the other two there is no body
  values["end_effector.inertia.zz"] = 2.1e-3;
  CHECK_THROWS_WITH(make_mechanism(job, values), Contains("the sum of the other two"));
  values["end_effector.inertia.zz"] = 1e-3;
  values["material.density"] = -1;
  CHECK_THROWS_WITH(make_mechanism(job, values), Contains("/design/material/density"));
}

TEST_CASE("a formula may be the objective") {
  const Objective objective = read_search(
                                  R"({"objective":
          {"maximise": null, "over_stroke": null, "minimise": "length*inner_width"}})")
                                  .objective;
  CHECK(objective.quantity.empty());
  CHECK(objective.expression == "length*inner_width");
}

TEST_CASE("a start outside the box moves to its edge, with a note") {
  json document = base_job("optimise");
  document["optimise"]["variables"][0]["max"] = "40 mm";
  const Job job = parse_job(document);
  CHECK(job.optimise->variables[0].start.value() == Approx(0.04));
  REQUIRE(job.notes.size() == 1);
  CHECK_THAT(job.notes[0], Contains("outside the variable's range"));
}

TEST_CASE("an optimise job can be evaluated as it stands") {
  const Job job = parse_job(patched("optimise", R"({"job": "evaluate"})"));
  CHECK_FALSE(job.optimise);
  CHECK(job.notes.size() == 1);
}

TEST_CASE("stock sizes, steps, a front and the verification are read") {
  const Job job = parse_job(patched("optimise", R"({"optimise": {
    "variables": [{"parameter": "length", "min": "20 mm", "max": "100 mm",
                   "stock": ["70 mm", 0.05, "50 mm", "300 mm", "25 mm"]},
                  {"parameter": "thickness", "min": "0.1 mm", "max": "1 mm", "step": "0.15 mm"}],
    "pareto": {"quantity": "drive_load"}, "verify": {}, "spread": "latin_hypercube",
    "algorithm": {"library": null, "name": "LD_AUGLAG", "local": "LD_MMA"}}})"));
  const OptimiseSpec& spec = *job.optimise;
  CHECK(spec.variables[0].stock == std::vector<double>{0.025, 0.05, 0.07});
  CHECK(spec.variables[1].stock == std::vector<double>{1.5e-4, 3e-4, 4.5e-4, 6e-4, 7.5e-4, 9e-4});
  REQUIRE(spec.pareto);
  CHECK(spec.pareto->quantity == "drive_load");
  CHECK(spec.pareto->over_stroke == OverStroke::max);
  CHECK_FALSE(spec.pareto->maximise);
  CHECK(spec.pareto->points == 9);
  CHECK(spec.pareto->label == "drive_load max over stroke");
  REQUIRE(spec.verify);
  CHECK(spec.verify->tolerance == 0.002);
  CHECK(spec.verify->max_full_evaluations == 6);
  CHECK(spec.spread == Spread::latin_hypercube);
  CHECK(spec.algorithm.local == "LD_MMA");
  CHECK(*parse_job(*job.as_read).as_read == *job.as_read);  // as shown, it reads as the same
  CHECK(parse_job(*job.as_read).optimise->variables[1].stock == spec.variables[1].stock);

  const OptimiseSpec other = read_search(R"({
    "pareto": {"expression": "inner_width*length", "sense": "maximise", "points": 4},
    "algorithm": {"library": null, "name": "LN_AUGLAG"}})");
  CHECK(other.pareto->maximise);
  CHECK(other.pareto->expression == "inner_width*length");
  CHECK(other.algorithm.local == "LN_SBPLX");
}

TEST_CASE("an algorithm without constraints takes neither those nor a front") {
  json document = base_job("optimise");
  json& o = document["optimise"];
  o["algorithm"] = {{"name", "GD_MLSL_LDS"}, {"local", "LD_SLSQP"}};
  o["constraints"] = json::array();
  CHECK(parse_job(document).optimise->algorithm.local == "LD_SLSQP");
  o["pareto"] = {{"quantity", "drive_load"}};
  CHECK_THROWS_WITH(parse_job(document),
                    Contains("/optimise/algorithm/name") && Contains("takes no constraints"));
  o.erase("pareto");
  o["constraints"] = {{{"quantity", "drive_load"}, {"max", "5 N m"}}};
  CHECK_THROWS_WITH(parse_job(document),
                    Contains("/optimise/algorithm/name") && Contains("takes no constraints"));
  o["algorithm"]["name"] = "LN_AUGLAG";
  o["algorithm"].erase("local");
  CHECK(parse_job(document).optimise->constraints.size() == 1);
}

TEST_CASE("parameters that are formulas follow the others") {
  const Job job = parse_job(base_job("optimise"));
  CHECK(job.design.parameters.at("outer_width") == Approx(0.0245));
  ParameterValues moved = job.design.parameters;
  moved["inner_width"] = 0.08;
  CHECK(complete_parameters(job.design, moved).at("outer_width") == Approx(0.009));
  const Mechanism mechanism = make_mechanism(job, moved);
  CHECK(mechanism.leaves[0].width == Approx(0.009));
  CHECK(mechanism.leaves[1].width == 0.08);
}

TEST_CASE("every quantity's unit is one that bounds can be written in") {
  for (const Family& family : families())
    for (const Quantity& quantity : quantities(family.drives)) {
      INFO(quantity.name << " in " << quantity.unit);
      CHECK(is_known_unit(quantity.unit));
    }
}
