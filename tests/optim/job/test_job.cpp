#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>
#include <set>

#include "core/response/quantities.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/quantity.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

constexpr double degree = std::numbers::pi / 180;

json base(const std::string& name) {
  return read_json_file(FLEXOPT_SOURCE_DIR "/tests/jobs/wrong/cases.json")["bases"][name];
}

std::vector<std::filesystem::path> shipped_jobs() {
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"/designs/jobs", "/designs/studies"})
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string(FLEXOPT_SOURCE_DIR) + folder))
      if (entry.path().extension() == ".json") files.push_back(entry.path());
  return files;
}

}  // namespace

TEST_CASE("an evaluate job is read into SI", "[optim][job]") {
  const Job job = parse_job(base("evaluate"));
  CHECK(job.name == "guide");
  CHECK(job.kind == JobKind::evaluate);
  CHECK(job.design.family == "parallel_guide");
  CHECK(
      job.design.parameters ==
      ParameterValues{{"length", 0.1}, {"width", 0.03}, {"thickness", 0.5e-3}, {"spacing", 0.06}});
  CHECK(job.design.material.youngs_modulus == Approx(200e9));
  CHECK(job.design.material.allowable_stress.value() == Approx(600e6));
  CHECK(job.end_effector.mass == 0.5);
  CHECK(job.end_effector.inertia == Matrix3d(4e-4 * Matrix3d::Identity()));
  CHECK(job.request.points == std::vector<double>{0, 2.5e-3, 5e-3});
  REQUIRE(job.request.loads.constant.size() == 1);
  CHECK(job.request.loads.constant[0].force == Vector3d(0, 0, -5));
  CHECK(job.request.loads.constant[0].moment.isZero(0));
  CHECK(job.request.frequencies == 4);
  CHECK(job.request.parasitic.drive == DriveState::locked);
  CHECK(job.model.accuracy == Accuracy::reduced);
  CHECK_FALSE(job.optimise);
  CHECK(job.notes.empty());
}

TEST_CASE("what stays away gets the defaults of the structs", "[optim][job]") {
  json document = base("evaluate");
  for (const char* key : {"end_effector", "loads", "model", "frequencies", "job", "name"})
    document.erase(key);
  document["stroke"] = {{"to", "5 mm"}};
  const Job job = parse_job(document);
  const ModelOptions model;
  const NewtonOptions newton;
  CHECK(job.model.mesh == model.mesh);
  CHECK(job.model.accuracy == model.accuracy);
  CHECK(job.model.degree == model.degree);
  CHECK(job.model.leaf_modes == model.leaf_modes);
  CHECK(job.model.mass == LeafMass::consistent);
  CHECK(job.model.free_edge_torsion == model.free_edge_torsion);
  CHECK(job.request.newton.tolerance == newton.tolerance);
  CHECK(job.request.points.size() == 11);
  CHECK(job.request.loads.constant.empty());
  CHECK(job.end_effector.mass == 0);
  CHECK(job.kind == JobKind::evaluate);
}

TEST_CASE("gravity, warmth and errors of assembly are read by the names of leaves",
          "[optim][job]") {
  json document = base("evaluate");
  document["design"]["material"]["thermal_expansion"] = "12e-6 1/K";
  document["gravity"] = json::parse(R"([0, "-9.81 m/s^2", 0])");
  document["temperature"] = json::parse(R"({"change": "20 K", "leaves": {"leaf -y": 5}})");
  document["assembly"] = json::parse(
      R"([{"leaf": "leaf -y", "end": "tip", "turn": ["2 mrad", 0, 0]},
          {"leaf": "leaf +y", "end": "base", "move": [0, 0, "10 um"]}])");
  const Job job = parse_job(document);
  const LoadCase& loads = job.request.loads;
  CHECK(loads.gravity == Vector3d(0, -9.81, 0));
  CHECK(loads.temperature == std::vector<double>{20, 5});
  REQUIRE(loads.assembly.size() == 2);
  CHECK(loads.assembly[0].leaf == 1);
  CHECK(loads.assembly[0].end == 1);
  CHECK(loads.assembly[0].turn == Vector3d(2e-3, 0, 0));
  CHECK(loads.assembly[1].leaf == 0);
  CHECK(loads.assembly[1].end == 0);
  CHECK((loads.assembly[1].move - Vector3d(0, 0, 1e-5)).norm() < 1e-18);
  const Mechanism mechanism = make_mechanism(job, job.design.parameters);
  CHECK(mechanism.leaves[0].material.thermal_expansion.value() == Approx(12e-6));
  CHECK(warmed(mechanism, loads).leaves[1].growth == Approx(1 + 6e-5));
  // the reduced job says before its run that these leaves are full models
  const auto says = [](const Job& of) {
    return std::ranges::any_of(of.notes, [](const std::string& note) {
      return note.find("not reduced are leaf +y, leaf -y") != std::string::npos;
    });
  };
  CHECK(says(job));
  document["model"]["accuracy"] = "full";
  CHECK_FALSE(says(parse_job(document)));
  document["model"]["accuracy"] = "reduced";
  document.erase("gravity");
  document.erase("temperature");
  CHECK_FALSE(says(parse_job(document)));
}

TEST_CASE("loads add up, stroke points may be listed, modes may be skipped", "[optim][job]") {
  json document = base("evaluate");
  document["loads"] = json::parse(R"([{"force": ["1 N", 2, 0]}, {"force": [0, 1, 0],
                                       "moment": [0, 0, "3 N mm"]}])");
  document["stroke"] = json::parse(R"({"at": ["1 mm", "-2 mm", 0]})");
  document["parasitic"] =
      json::parse(R"({"drive": "free", "skip": ["leaf", "intermediate_body"]})");
  document["model"] = json::parse(
      R"({"accuracy": "full", "mesh": [16, 8], "free_edge_torsion": false, "degree": 7,
          "leaf_modes": 0, "mass": "constant", "tolerance": 1e-10, "method": "mixed_potential"})");
  const Job job = parse_job(document);
  Vector6d load = Vector6d::Zero();
  for (const DeadLoad& l : job.request.loads.constant) {
    load.head<3>() += l.force;
    load.tail<3>() += l.moment;
  }
  CHECK((load - (Vector6d() << 1, 3, 0, 0, 0, 3e-3).finished()).norm() < 1e-15);
  CHECK(job.request.points == std::vector<double>{1e-3, -2e-3, 0});
  CHECK(job.request.parasitic.drive == DriveState::free);
  CHECK_FALSE(job.request.parasitic.admits(ModeKind::leaf));
  CHECK_FALSE(job.request.parasitic.admits(ModeKind::intermediate_body));
  CHECK(job.model.accuracy == Accuracy::full);
  CHECK(job.model.mesh == std::array<int, 2>{16, 8});
  CHECK_FALSE(job.model.free_edge_torsion);
  CHECK(job.model.degree == 7);
  CHECK(job.model.leaf_modes == 0);
  CHECK(job.model.mass == LeafMass::constant);
  CHECK(job.request.newton.tolerance == 1e-10);
}

TEST_CASE("loads act on any body at any place", "[optim][job]") {
  json document = base("cantilever");
  document["design"]["tip"] = "hinged";
  document["loads"] = json::parse(R"([
    {"name": "payload", "force": [0, 0, "-2 N"]},
    {"name": "push", "body": "tip edge", "at": ["90 mm", "2 mm", 0], "force": [1, 0, 0],
     "moment": [0, 0, "3 N mm"]},
    {"body": "end_effector", "force": [0, 1, 0]}])");
  const Job job = parse_job(document);
  const std::vector<DeadLoad>& loads = job.request.loads.constant;
  REQUIRE(loads.size() == 3);
  CHECK(loads[0].name == "payload");
  CHECK_FALSE(loads[0].body);
  CHECK_FALSE(loads[0].place);
  const Mechanism mechanism = make_mechanism(job, job.design.parameters);
  REQUIRE(loads[1].body);
  CHECK(mechanism.bodies[*loads[1].body].name == "tip edge");
  CHECK(loads[1].place == Vector3d(0.09, 2e-3, 0));
  CHECK(loads[1].moment == Vector3d(0, 0, 3e-3));
  CHECK_FALSE(loads[2].body);
  CHECK_FALSE(loads[2].place);
  CHECK_FALSE(broken_rule(job.request.loads, mechanism));
  document = base("evaluate");
  document["loads"][0]["at"] = {0.1, "2 mm", 0};
  CHECK(parse_job(document).request.loads.constant[0].place == Vector3d(0.1, 2e-3, 0));
}

TEST_CASE("the reduction and the cut of the leaves are read", "[optim][job]") {
  json document = base("evaluate");
  CHECK(parse_job(document).model.method == Reduction::mixed_potential);
  document["model"]["superelements"] = 1;  // says what is
  CHECK(parse_job(document).model.method == Reduction::mixed_potential);
  document["model"]["method"] = "linear_craig_bampton";
  CHECK(parse_job(document).model.superelements == std::array<int, 2>{1, 0});
  document["model"]["superelements"] = 4;
  CHECK(parse_job(document).model.superelements == std::array<int, 2>{4, 0});
  document["model"]["superelements"] = {10, 1};
  const Job job = parse_job(document);
  CHECK(job.model.method == Reduction::linear_craig_bampton);
  CHECK(job.model.superelements == std::array<int, 2>{10, 1});
  document["model"]["superelements"] = 2;
  document["model"]["method"] = "quadratic_manifold";
  CHECK(parse_job(document).model.method == Reduction::quadratic_manifold);
  document["model"]["method"] = "modal_derivatives";
  CHECK(parse_job(document).model.method == Reduction::modal_derivatives);
  CHECK(parse_job(document).model.modal_derivatives == ModalDerivativeSet::all);
  document["model"]["modal_derivatives"] = "third_order";
  CHECK(parse_job(document).model.modal_derivatives == ModalDerivativeSet::third_order);
  document["model"]["modal_derivatives"] = "bending";
  CHECK(parse_job(document).model.modal_derivatives == ModalDerivativeSet::bending);
}

TEST_CASE("the stroke holds both ends exactly, and may stay at zero", "[optim][job]") {
  json document = base("optimise");
  document["stroke"] = {{"from", "-20 deg"}, {"to", "20 deg"}, {"points", 9}};
  const std::vector<double> points = parse_job(document).request.points;
  REQUIRE(points.size() == 9);
  CHECK(points.front() == Approx(-20 * degree).epsilon(1e-15));
  CHECK(points.back() == -points.front());
  CHECK(std::abs(points[4]) < 1e-16);
  document["stroke"] = {{"to", 0}, {"points", 3}};
  CHECK(parse_job(document).request.points == std::vector<double>{0, 0, 0});
  document["stroke"] = {{"to", 0}, {"points", 1}};
  CHECK(parse_job(document).request.points == std::vector<double>{0});
}

TEST_CASE("a symmetric inertia is read whole", "[optim][job]") {
  json document = base("evaluate");
  document["end_effector"]["inertia"] = json::parse("[[2, 0.1, 0], [0.1, 2, 0.2], [0, 0.2, 2]]");
  document["end_effector"]["center_of_mass"] = {"10 mm", 0, "-5 mm"};
  const EndEffector body = parse_job(document).end_effector;
  CHECK(body.inertia(1, 2) == 0.2);
  CHECK(body.inertia == body.inertia.transpose());
  CHECK((body.center_of_mass - Vector3d(0.01, 0, -0.005)).norm() < 1e-17);
}

TEST_CASE("odd but allowed input leaves a note", "[optim][job]") {
  const auto notes = [](const json& patch) {
    json document = base("evaluate");
    document.merge_patch(patch);
    std::string all;
    for (const std::string& note : parse_job(document).notes) all += note;
    return all;
  };
  // E = 210 GPa with G = 70 GPa, as many public scripts have it, is an incompressible solid
  const json scripts = json::parse(R"({"design": {"material": {"youngs_modulus": "210 GPa",
      "shear_modulus": "70 GPa", "poissons_ratio": null}}})");
  CHECK_THAT(notes(scripts), Contains("Poisson's ratio E/(2G) - 1 is 0.5"));
  CHECK_THAT(notes(json::parse(R"({"design": {"material": {"poissons_ratio": 0}}})")),
             Contains("Poisson's ratio is 0"));
  CHECK_THAT(notes(json::parse(R"({"end_effector": {"inertia": null}})")), Contains("point mass"));
  CHECK_THAT(notes(json::parse(R"({"design": {"parameters": {"thickness": "5 mm"}}})")),
             Contains("plate theory"));
}

TEST_CASE("a beam may be of any E and G; a Poisson's ratio above a half is noted", "[optim][job]") {
  json document = base("evaluate");
  document.merge_patch(json::parse(R"({"model": {"flexure": "beam", "warping": "free"},
      "design": {"material": {"youngs_modulus": "12 GPa", "shear_modulus": "0.8 GPa",
                              "poissons_ratio": null}}})"));
  const Job job = parse_job(document);
  CHECK(job.model.flexure == Flexure::beam);
  CHECK(job.model.warping == Warping::free);
  CHECK(job.design.material.poissons_ratio == Approx(6.5));
  CHECK(job.design.material.shear_modulus() == Approx(0.8e9));
  REQUIRE(!job.notes.empty());
  CHECK_THAT(job.notes[0], Contains("E/(2G) - 1 is 6.5"));
  // what the result shows as the job reads as the same job
  CHECK(parse_job(*job.as_read).design.material.poissons_ratio == Approx(6.5));
  document["model"]["flexure"] = "plate";
  CHECK_THROWS_WITH(parse_job(document), Contains("a beam (/model/flexure) takes any"));
}

TEST_CASE("a wire's width is its thickness, also while an optimiser varies it", "[optim][job]") {
  json document = base("evaluate");
  document["design"] = json::parse(R"({"family": "leaf_spring", "section": "circular",
      "parameters": {"length": "60 mm", "thickness": "0.6 mm"}, "material": "stavax"})");
  document["model"] = {{"flexure", "beam"}};
  document["stroke"] = {{"to", "2 mm"}, {"points", 2}};
  const Job job = parse_job(document);
  ParameterValues parameters = job.design.parameters;
  CHECK(parameters.at("width") == 0.6e-3);
  parameters["thickness"] = 0.8e-3;
  const Mechanism m = make_mechanism(job, parameters);
  CHECK(m.leaves[0].section == Section::circular);
  CHECK(m.leaves[0].width == 0.8e-3);
  document["design"]["parameters"]["width"] = "0.6 mm";
  CHECK(parse_job(document).design.parameters.at("width") == 0.6e-3);
}

TEST_CASE("a built-in material is found by name and shown with its constants", "[optim][job]") {
  json document = base("evaluate");
  for (const NamedMaterial& named : materials()) {
    document["design"]["material"] = named.material.name;
    const Job job = parse_job(document);
    CHECK(job.design.material.youngs_modulus == named.material.youngs_modulus);
    CHECK((*job.as_read)["design"]["material"]["density"] == named.material.density);
  }
}

TEST_CASE("an optimise job is read with names, units and defaults", "[optim][job]") {
  const Job job = parse_job(base("optimise"));
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
  CHECK(spec.algorithm.name == "LN_COBYLA");
  CHECK(spec.tolerance == OptimiseSpec{}.tolerance);
}

TEST_CASE("objective and constraint default to the worst of the stroke", "[optim][job]") {
  json document = base("optimise");
  document["optimise"]["objective"] = {{"minimise", "max_stress"}};
  document["optimise"]["constraints"] =
      json::parse(R"([{"quantity": "parasitic_frequency", "min": "50 Hz"},
                      {"quantity": "max_stress", "max": "1 GPa"}])");
  const OptimiseSpec spec = *parse_job(document).optimise;
  CHECK_FALSE(spec.objective.maximise);
  CHECK(spec.objective.over_stroke == OverStroke::max);
  CHECK(spec.constraints[0].over_stroke == OverStroke::min);
  CHECK(spec.constraints[1].over_stroke == OverStroke::max);
}

TEST_CASE("bounds of formulas take the unit that the formula has", "[optim][job]") {
  const auto bound = [](const std::string& formula, const json& value) {
    json document = base("optimise");
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

TEST_CASE("numbers of material and end-effector are variables too", "[optim][job]") {
  json document = base("optimise");
  document["optimise"]["variables"] = json::parse(R"([
      {"parameter": "thickness", "min": "0.1 mm", "max": "1 mm"},
      {"parameter": "material.youngs_modulus", "min": "70 GPa", "max": "210 GPa"},
      {"parameter": "end_effector.mass", "min": "100 g", "max": "2 kg", "step": "0.5 kg"},
      {"parameter": "end_effector.center_of_mass.y", "min": "-5 mm", "max": "5 mm"},
      {"parameter": "end_effector.inertia.zz", "min": "5e-4 kg m^2", "max": "3e-3 kg m^2"}])");
  const Job job = parse_job(document);
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

TEST_CASE("a formula may be the objective", "[optim][job]") {
  json document = base("optimise");
  document["optimise"]["objective"] = {{"minimise", "length*inner_width"}};
  const OptimiseSpec spec = *parse_job(document).optimise;
  CHECK(spec.objective.quantity.empty());
  CHECK(spec.objective.expression == "length*inner_width");
}

TEST_CASE("a start outside the box moves to its edge, with a note", "[optim][job]") {
  json document = base("optimise");
  document["optimise"]["variables"][0]["max"] = "40 mm";
  const Job job = parse_job(document);
  CHECK(job.optimise->variables[0].start.value() == Approx(0.04));
  REQUIRE(job.notes.size() == 1);
  CHECK_THAT(job.notes[0], Contains("outside the variable's range"));
}

TEST_CASE("an optimise job can be evaluated as it stands", "[optim][job]") {
  json document = base("optimise");
  document["job"] = "evaluate";
  const Job job = parse_job(document);
  CHECK_FALSE(job.optimise);
  CHECK(job.notes.size() == 1);
}

TEST_CASE("stock sizes, steps, a front and the verification are read", "[optim][job]") {
  json document = base("optimise");
  json& o = document["optimise"];
  o["variables"][0]["stock"] = {"70 mm", 0.05, "50 mm", "300 mm", "25 mm"};
  o["variables"][1]["step"] = "0.15 mm";
  o["pareto"] = {{"quantity", "drive_load"}};
  o["verify"] = json::object();
  o["spread"] = "latin_hypercube";
  o["algorithm"] = {{"name", "GD_MLSL_LDS"}, {"local", "LD_SLSQP"}};
  const Job job = parse_job(document);
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
  CHECK(spec.algorithm.local == "LD_SLSQP");
  CHECK(*parse_job(*job.as_read).as_read == *job.as_read);  // as shown, it reads as the same
  CHECK(parse_job(*job.as_read).optimise->variables[1].stock == spec.variables[1].stock);

  o["pareto"] = {{"expression", "inner_width*length"}, {"sense", "maximise"}, {"points", 4}};
  o["algorithm"] = {{"name", "LN_AUGLAG"}};
  const OptimiseSpec other = *parse_job(document).optimise;
  CHECK(other.pareto->maximise);
  CHECK(other.pareto->expression == "inner_width*length");
  CHECK(other.algorithm.local == "LN_SBPLX");
  CHECK_FALSE(parse_job(base("optimise")).optimise->pareto);
  CHECK_FALSE(parse_job(base("optimise")).optimise->verify);
}

TEST_CASE("parameters that are formulas follow the others", "[optim][job]") {
  const Job job = parse_job(base("optimise"));
  CHECK(job.design.parameters.at("outer_width") == Approx(0.0245));
  ParameterValues moved = job.design.parameters;
  moved["inner_width"] = 0.08;
  CHECK(complete_parameters(job.design, moved).at("outer_width") == Approx(0.009));
  const Mechanism mechanism = make_mechanism(job, moved);
  CHECK(mechanism.leaves[0].width == Approx(0.009));
  CHECK(mechanism.leaves[1].width == 0.08);
}

TEST_CASE("parameters out of range make no mechanism", "[optim][job]") {
  const Job job = parse_job(base("optimise"));
  ParameterValues moved = job.design.parameters;
  moved["inner_width"] = 0.2;  // leaves a negative outer width
  CHECK_THROWS_AS(make_mechanism(job, moved), SpecError);
  moved["inner_width"] = std::nan("");
  CHECK_THROWS_AS(make_mechanism(job, moved), SpecError);
}

TEST_CASE("a job as read reads as itself", "[optim][job]") {
  for (const char* name : {"evaluate", "optimise"}) {
    const json once = *parse_job(base(name)).as_read;
    CHECK(*parse_job(once).as_read == once);
  }
}

TEST_CASE("the shipped jobs are read", "[optim][job]") {
  REQUIRE(shipped_jobs().size() >= 4);
  for (const auto& file : shipped_jobs()) {
    INFO(file.string());
    const Job job = read_job(file.string());
    CHECK(job.notes.empty());
    CHECK_FALSE(job.expect.empty());
    for (const Expectation& e : job.expect) CHECK(e.source != "unnamed");
  }
}

TEST_CASE("overrides change a job before it is read", "[optim][job]") {
  const std::string file = FLEXOPT_SOURCE_DIR "/designs/jobs/parallel_guide.json";
  const Job job = read_job(file, {"/stroke/to=1 mm", "/model/accuracy=full", "/frequencies=2"});
  CHECK(job.request.points.back() == Approx(1e-3));
  CHECK(job.model.accuracy == Accuracy::full);
  CHECK(job.request.frequencies == 2);
  CHECK_THROWS_AS(read_job(file, {"/model/accuracy=fastest"}), SpecError);
  CHECK_THROWS_AS(read_job(file, {"/modle/accuracy=full"}), SpecError);
}

TEST_CASE("a job without name is called like its file", "[optim][job]") {
  const auto file = std::filesystem::temp_directory_path() / "flexopt_test_nameless.json";
  json document = base("evaluate");
  document.erase("name");
  std::ofstream(file) << document;
  CHECK(read_job(file.string()).name == "flexopt_test_nameless");
  std::filesystem::remove(file);
}

namespace {

/// The part of JSON Schema that the job's schema uses; what is not understood fails the test.
bool valid(const json& schema, const json& value) {
  static const std::set<std::string> understood{"$schema",
                                                "title",
                                                "description",
                                                "default",
                                                "type",
                                                "properties",
                                                "required",
                                                "additionalProperties",
                                                "items",
                                                "minItems",
                                                "maxItems",
                                                "enum",
                                                "const",
                                                "minLength",
                                                "maxLength",
                                                "minimum",
                                                "maximum",
                                                "exclusiveMinimum",
                                                "exclusiveMaximum",
                                                "anyOf",
                                                "allOf",
                                                "if",
                                                "then",
                                                "pattern"};
  for (const auto& [key, unused] : schema.items()) REQUIRE(understood.count(key) == 1);
  if (schema.contains("const") && value != schema["const"]) return false;
  if (schema.contains("enum") &&
      std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
    return false;
  if (schema.contains("type")) {
    const std::string type = schema["type"];
    if (type == "object" && !value.is_object()) return false;
    if (type == "array" && !value.is_array()) return false;
    if (type == "string" && !value.is_string()) return false;
    if (type == "boolean" && !value.is_boolean()) return false;
    if (type == "number" && !value.is_number()) return false;
    if (type == "integer" && !value.is_number_integer()) return false;
  }
  if (value.is_number()) {
    const double x = value;
    if (schema.contains("minimum") && x < schema["minimum"]) return false;
    if (schema.contains("maximum") && x > schema["maximum"]) return false;
    if (schema.contains("exclusiveMinimum") && x <= schema["exclusiveMinimum"]) return false;
    if (schema.contains("exclusiveMaximum") && x >= schema["exclusiveMaximum"]) return false;
  }
  if (value.is_string() && schema.contains("pattern") &&
      !std::regex_search(value.get<std::string>(),
                         std::regex(schema["pattern"].get<std::string>())))
    return false;
  if (value.is_array() && schema.contains("items")) {
    if (value.size() < schema["minItems"] || value.size() > schema["maxItems"]) return false;
    for (const json& item : value)
      if (!valid(schema["items"], item)) return false;
  }
  if (value.is_object()) {
    if (schema.contains("required"))
      for (const json& key : schema["required"])
        if (!value.contains(key.get<std::string>())) return false;
    const json properties = schema.value("properties", json::object());
    const json others = schema.value("additionalProperties", json(true));
    for (const auto& [key, item] : value.items()) {
      if (properties.contains(key) ? !valid(properties[key], item)
          : others.is_boolean()    ? others == false
                                   : !valid(others, item))
        return false;
    }
  }
  if (schema.contains("anyOf") && std::none_of(schema["anyOf"].begin(), schema["anyOf"].end(),
                                               [&](const json& one) { return valid(one, value); }))
    return false;
  if (schema.contains("allOf"))
    for (const json& one : schema["allOf"])
      if (!valid(one, value)) return false;
  if (schema.contains("if") && valid(schema["if"], value) && !valid(schema["then"], value))
    return false;
  return true;
}

}  // namespace

TEST_CASE("the schema accepts the shipped jobs and refuses slips", "[optim][job]") {
  const json schema = job_schema();
  for (const auto& file : shipped_jobs()) {
    INFO(file.string());
    CHECK(valid(schema, read_json_file(file.string())));
  }
  for (const char* name : {"evaluate", "optimise"}) CHECK(valid(schema, base(name)));
  const auto refused = [&](const char* at, const json& value) {
    json document = base("evaluate");
    document[json::json_pointer(at)] = value;
    return !valid(schema, document);
  };
  CHECK(refused("/strokes", 1));
  CHECK(refused("/design/family", "paralel_guide"));
  CHECK(refused("/design/parameters/half_angle", 0.5));
  CHECK(refused("/design/parameters/thickness", -1e-3));
  CHECK(refused("/design/parameters/thickness", "thin"));
  CHECK(refused("/model/accuracy", "best"));
  CHECK(refused("/stroke/points", 1.5));
  CHECK(refused("/end_effector/inertia", {1, 2}));
  // of a file the schema does not know the drives: strokes of one, or by name
  json own = base("evaluate");
  own["design"] = {{"file", "stage.json"}, {"material", "stavax"}};
  CHECK(valid(schema, own));
  own["stroke"] = {{"at", {{{"x", "1 mm"}, {"y", 0}}}}};
  CHECK(valid(schema, own));
  own["stroke"] = {{"grid", {{"x", {{"to", "1 mm"}, {"pionts", 3}}}}}};
  CHECK_FALSE(valid(schema, own));
  json without = base("evaluate");
  without["design"]["parameters"].erase("spacing");
  CHECK_FALSE(valid(schema, without));
}

TEST_CASE("every quantity's unit is one that bounds can be written in", "[optim][job]") {
  for (const Family& family : families())
    for (const Quantity& quantity : quantities(family.drives)) {
      INFO(quantity.name << " in " << quantity.unit);
      CHECK(is_known_unit(quantity.unit));
    }
}

TEST_CASE("a tolerance beside \"auto\" is one of errors, and Newton keeps its own",
          "[optim][job]") {
  json document = base("evaluate");
  document["model"] = {{"accuracy", "auto"}, {"tolerance", "0.2 %"}};
  const Job chosen = parse_job(document);
  CHECK(chosen.accuracy.automatic);
  CHECK(chosen.accuracy.wants_estimates());
  CHECK(chosen.accuracy.tolerance == Approx(0.002));
  CHECK(chosen.request.newton.tolerance == NewtonOptions{}.tolerance);
  CHECK(chosen.model.accuracy == Accuracy::reduced);
  document["model"] = {{"accuracy", "auto"}};
  CHECK(parse_job(document).accuracy.tolerance == AccuracySpec{}.tolerance);
  document["model"] = {{"accuracy", "reduced"}, {"tolerance", 1e-8}, {"estimate", true}};
  const Job estimated = parse_job(document);
  CHECK(estimated.accuracy.estimate);
  CHECK_FALSE(estimated.accuracy.automatic);
  CHECK(estimated.request.newton.tolerance == 1e-8);
  CHECK_FALSE(parse_job(base("evaluate")).accuracy.wants_estimates());
}
