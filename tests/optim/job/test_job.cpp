#include "core/response/response.hpp"
#include "tests/optim/job/patched_job.hpp"

TEST_CASE("an evaluate job is read into SI") {
  const Job job = parse_job(base_job("evaluate"));
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

TEST_CASE("what stays away gets the defaults of the structs") {
  const Job job = read_patched(R"({"end_effector": null, "loads": null, "model": null,
      "frequencies": null, "job": null, "name": null, "stroke": {"from": null, "points": null}})");
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

TEST_CASE("gravity, warmth and errors of assembly are read by the names of leaves") {
  json document = patched(R"({
    "design": {"material": {"thermal_expansion": "12e-6 1/K"}}, "gravity": [0, "-9.81 m/s^2", 0],
    "temperature": {"change": "20 K", "leaves": {"leaf -y": 5}},
    "assembly": [{"leaf": "leaf -y", "end": "tip", "turn": ["2 mrad", 0, 0]},
                 {"leaf": "leaf +y", "end": "base", "move": [0, 0, "10 um"]}]})");
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
  CHECK(loads.mounting.empty());
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

TEST_CASE("steps of the mounting say when each load comes") {
  const Job job = parse_job(patched(R"({
    "loads": [{"name": "payload", "force": [0, 0, "-5 N"]}, {"name": "pull", "force": ["1 N", 0, 0]}],
    "gravity": [0, "-9.81 m/s^2", 0],
    "assembly": {"steps": [
      {"name": "bases", "drive": "free", "edges": [{"leaf": "leaf -y", "end": "base", "move": ["1 mm", 0, 0]}]},
      {"gravity": true, "stroke": "2 mm", "edges": [{"leaf": "leaf -y", "end": "base", "turn": [0, 0, "1 deg"]}]},
      {"loads": ["pull"]}]}})"));
  const LoadCase& loads = job.request.loads;
  REQUIRE(loads.mounting.size() == 4);  // one more for what no step names
  CHECK(loads.mounting[0].drives_free);
  CHECK(loads.mounting[0].name == "bases");
  CHECK_FALSE(loads.mounting[1].drives_free);
  REQUIRE(loads.mounting[1].strokes);
  CHECK((*loads.mounting[1].strokes)[0] == Approx(2e-3));
  CHECK_FALSE(loads.mounting[2].strokes);
  REQUIRE(loads.assembly.size() == 2);
  CHECK(loads.assembly[0].step == 0);
  CHECK(loads.assembly[1].step == 1);
  CHECK(loads.gravity_step == 1);
  CHECK(loads.constant[0].step == 3);
  CHECK(loads.constant[1].step == 2);
  // where all is named there is no more
  const Job named = parse_job(patched(R"({"loads": [], "gravity": [0, "-9.81 m/s^2", 0],
    "assembly": {"steps": [{"gravity": true}]}})"));
  CHECK(named.request.loads.mounting.size() == 1);
}

TEST_CASE("all of one material that is warm expands freely, whatever its leaves consist of") {
  const json base = json::parse(R"({
    "flexopt": 1, "job": "evaluate", "stroke": {"at": [0]}, "model": {"mesh": [6, 2]},
    "temperature": {"change": "100 K", "bodies": {"ground": "100 K", "end_effector": "100 K"}},
    "design": {"parameters": {},
      "material": {"youngs_modulus": 2e11, "poissons_ratio": 0.3, "density": 7850,
                   "thermal_expansion": 1.1e-5},
      "mechanism": {"flexopt_design": 1, "drive": {"direction": "uy"},
        "bodies": [{"name": "end_effector", "at": [0.1, 0, 0.02]}],
        "leaves": [{"name": "a", "base": {"body": "ground", "at": [0, 0, 0.02]},
                    "tip": {"body": "end_effector", "at": [0.1, 0, 0.02]},
                    "across": [0, 0, 1], "width": 0.02, "thickness": 0.0005}]}}})");
  const double strain = 1.1e-3;
  const auto evaluated = [&](const json& patch) {
    const Job job = parse_job(base.patch(patch));
    StrokeRequest request = job.request;
    request.outputs.add(Output::stress);
    const StrokeResponse r =
        evaluate_stroke(make_mechanism(job, job.design.parameters), job.model, request);
    INFO(r.message);
    REQUIRE(r.path[0].status == PointStatus::converged);
    return r.path[0];
  };
  const std::string leaf = "/design/mechanism/leaves/0";
  for (
      const char* text :
      {R"([{"op": "add", "path": "LEAF/reinforcement", "value": {"fraction": 0.6, "thickness": 0.003}}])",
       R"([{"op": "add", "path": "LEAF/reinforcement",
                "value": {"fraction": 0.6, "thickness": 0.003, "rigid": false}}])",
       R"([{"op": "add", "path": "LEAF/curve", "value": {"angle": "40 deg"}}])",
       R"([{"op": "replace", "path": "LEAF/width", "value": [0.02, 0.01]}])",
       R"([{"op": "add", "path": "LEAF/fold", "value": {"at": [0.05, 0.05, 0.02]}}])",
       R"([{"op": "replace", "path": "LEAF/tip", "value": {"body": "fold", "at": [0.05, 0.05, 0.02]}},
               {"op": "add", "path": "/design/mechanism/bodies/-", "value": {"name": "fold", "at": [0.05, 0.05, 0.02]}},
               {"op": "add", "path": "/design/mechanism/leaves/-",
                "value": {"name": "b", "base": {"body": "fold", "at": [0.05, 0.05, 0.02]},
                          "tip": {"body": "end_effector", "at": [0.1, 0, 0.02]},
                          "across": [0, 0, 1], "width": 0.02, "thickness": 0.0005}}])"}) {
    std::string patch = text;
    for (std::size_t at; (at = patch.find("LEAF")) != std::string::npos;)
      patch.replace(at, 4, leaf);
    INFO(patch);
    const PathPoint p = evaluated(json::parse(patch));
    CHECK((p.displacement - strain * Vector3d(0.1, 0, 0.02)).norm() < 1e-9);
    CHECK(p.max_stress->value < 1e3);  // of 220 MPa where expansion is hindered
  }
  // a piece that is named is as warm as is said
  const PathPoint cold = evaluated(json::parse(
      R"([{"op": "add", "path": "/design/mechanism/leaves/0/reinforcement", "value": {"fraction": 0.6, "thickness": 0.003}},
          {"op": "add", "path": "/temperature/bodies/a~1reinforcement", "value": 0}])"));
  CHECK(cold.max_stress->value > 1e7);
}

TEST_CASE("loads add up, stroke points may be listed, modes may be skipped") {
  const Job job = read_patched(R"({
    "loads": [{"force": ["1 N", 2, 0]}, {"force": [0, 1, 0], "moment": [0, 0, "3 N mm"]}],
    "stroke": {"from": null, "to": null, "points": null, "at": ["1 mm", "-2 mm", 0]},
    "parasitic": {"drive": "free", "skip": ["leaf", "intermediate_body"]},
    "model": {"flexure": null, "accuracy": "full", "mesh": [16, 8], "free_edge_torsion": false,
      "degree": 7, "leaf_modes": 0, "mass": "constant", "tolerance": 1e-10,
      "method": "mixed_potential"}})");
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

TEST_CASE("loads act on any body at any place") {
  const Job job = parse_job(patched("cantilever", R"({"design": {"tip": "hinged"}, "loads": [
    {"name": "payload", "force": [0, 0, "-2 N"]},
    {"name": "push", "body": "tip edge", "at": ["90 mm", "2 mm", 0], "force": [1, 0, 0],
     "moment": [0, 0, "3 N mm"]},
    {"body": "end_effector", "force": [0, 1, 0]}]})"));
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
  CHECK(check_rules(job.request.loads, mechanism));
  const Job plain = read_patched(R"({"loads": [{"force": [1, 0, 0], "at": [0.1, "2 mm", 0]}]})");
  CHECK(plain.request.loads.constant[0].place == Vector3d(0.1, 2e-3, 0));
}

TEST_CASE("the reduction and the cut of the leaves are read") {
  json document = base_job("evaluate");
  const auto model = [&](const char* patch) {
    document["model"].merge_patch(json::parse(patch));
    return parse_job(document).model;
  };
  using Cut = std::array<int, 2>;
  CHECK(model("{}").method == Reduction::mixed_potential);
  CHECK(model(R"({"superelements": 1})").method == Reduction::mixed_potential);  // says what is
  CHECK(model(R"({"method": "linear_craig_bampton"})").superelements == Cut{1, 0});
  CHECK(model(R"({"superelements": 4})").superelements == Cut{4, 0});
  const ModelOptions cut = model(R"({"superelements": [10, 1]})");
  CHECK(cut.method == Reduction::linear_craig_bampton);
  CHECK(cut.superelements == Cut{10, 1});
  CHECK(model(R"({"superelements": 2, "method": "quadratic_manifold"})").method ==
        Reduction::quadratic_manifold);
  const ModelOptions modal = model(R"({"method": "modal_derivatives"})");
  CHECK(modal.method == Reduction::modal_derivatives);
  CHECK(modal.modal_derivatives == ModalDerivativeSet::all);
  CHECK(model(R"({"modal_derivatives": "third_order"})").modal_derivatives ==
        ModalDerivativeSet::third_order);
  CHECK(model(R"({"modal_derivatives": "bending"})").modal_derivatives ==
        ModalDerivativeSet::bending);
}

TEST_CASE("the stroke holds both ends exactly, and may stay at zero") {
  const auto points_of = [](const char* stroke) {
    json document = base_job("optimise");
    document["stroke"] = json::parse(stroke);
    return parse_job(document).request.points;
  };
  const auto points = points_of(R"({"from": "-20 deg", "to": "20 deg", "points": 9})");
  REQUIRE(points.size() == 9);
  CHECK(points.front() == Approx(-20 * degree).epsilon(1e-15));
  CHECK(points.back() == -points.front());
  CHECK(std::abs(points[4]) < 1e-16);
  CHECK(points_of(R"({"to": 0, "points": 3})") == std::vector<double>{0, 0, 0});
  CHECK(points_of(R"({"to": 0, "points": 1})") == std::vector<double>{0});
}

TEST_CASE("a symmetric inertia is read whole") {
  const EndEffector body = read_patched(R"({"end_effector": {
      "inertia": [[2, 0.1, 0], [0.1, 2, 0.2], [0, 0.2, 2]],
      "center_of_mass": ["10 mm", 0, "-5 mm"]}})")
                               .end_effector;
  CHECK(body.inertia(1, 2) == 0.2);
  CHECK(body.inertia == body.inertia.transpose());
  CHECK((body.center_of_mass - Vector3d(0.01, 0, -0.005)).norm() < 1e-17);
}

TEST_CASE("odd but allowed input leaves a note") {
  const auto notes = [](const char* patch) {
    std::string all;
    for (const std::string& note : read_patched(patch).notes) all += note;
    return all;
  };
  // E = 210 GPa with G = 70 GPa, as many public scripts have it, is an incompressible solid
  CHECK_THAT(notes(R"({"design": {"material": {"youngs_modulus": "210 GPa",
                 "shear_modulus": "70 GPa", "poissons_ratio": null}}})"),
             Contains("Poisson's ratio E/(2G) - 1 is 0.5"));
  CHECK_THAT(notes(R"({"design": {"material": {"poissons_ratio": 0}}})"),
             Contains("Poisson's ratio is 0"));
  CHECK_THAT(notes(R"({"end_effector": {"inertia": null}})"), Contains("point mass"));
  CHECK_THAT(notes(R"({"design": {"parameters": {"thickness": "5 mm"}}})"),
             Contains("plate theory"));
  // a body of a design file with an inertia of the plane alone
  CHECK_THAT(notes(R"({"end_effector": {"mass": null, "inertia": null}, "design": {"family": null,
        "parameters": {"length": null, "width": null, "thickness": null, "spacing": null},
        "mechanism": {"flexopt_design": 1, "name": "leaf", "drive": {"direction": "uy"},
          "bodies": [{"name": "end_effector", "at": [0.08, 0, 0], "mass": 1, "inertia": [0, 0, 1]}],
          "leaves": [{"name": "leaf", "base": {"body": "ground", "at": [0, 0, 0]},
                      "tip": {"body": "end_effector", "at": [0.08, 0, 0]},
                      "across": [0, 0, 1], "width": 0.02, "thickness": 3e-4}]}}})"),
             Contains("/design/mechanism/bodies/0/inertia = principal values 0, 0, 1 kg m^2"));
}

TEST_CASE("mechanisms of wires alone are beams where the job does not say") {
  json document = patched(R"({"model": null, "design": {"family": "five_strut_guide"}})");
  document["design"]["parameters"] = json::object();
  const Job job = parse_job(document);
  CHECK(job.model.flexure == Flexure::beam);
  CHECK((*job.as_read)["model"]["flexure"] == "beam");
  document["model"] = {{"flexure", "plate"}};
  CHECK_THROWS_WITH(parse_job(document), Contains("a leaf of circular section is a beam"));
}

TEST_CASE("a beam may be of any E and G, and a Poisson's ratio above a half is noted") {
  json document = patched(R"({"model": {"flexure": "beam", "warping": "free"},
      "design": {"material": {"youngs_modulus": "12 GPa", "shear_modulus": "0.8 GPa",
                              "poissons_ratio": null}}})");
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

TEST_CASE("a wire's width is its thickness, also while an optimiser varies it") {
  json document = patched(R"({"model": {"flexure": "beam", "accuracy": null},
      "stroke": {"from": null, "to": "2 mm", "points": 2},
      "design": {"family": "leaf_spring", "section": "circular", "material": "stavax",
                 "parameters": {"length": "60 mm", "width": null, "thickness": "0.6 mm",
                                "spacing": null}}})");
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

TEST_CASE("a built-in material is found by name and shown with its constants") {
  json document = base_job("evaluate");
  for (const NamedMaterial& named : materials()) {
    document["design"]["material"] = named.material.name;
    const Job job = parse_job(document);
    CHECK(job.design.material.youngs_modulus == named.material.youngs_modulus);
    CHECK((*job.as_read)["design"]["material"]["density"] == named.material.density);
  }
}

TEST_CASE("parameters out of range make no mechanism") {
  const Job job = parse_job(base_job("optimise"));
  ParameterValues moved = job.design.parameters;
  moved["inner_width"] = 0.2;  // leaves a negative outer width
  CHECK_THROWS_AS(make_mechanism(job, moved), SpecError);
  moved["inner_width"] = std::nan("");
  CHECK_THROWS_AS(make_mechanism(job, moved), SpecError);
}

TEST_CASE("a job as read reads as itself") {
  for (const char* name : {"evaluate", "optimise"}) {
    const json once = *parse_job(base_job(name)).as_read;
    CHECK(*parse_job(once).as_read == once);
  }
}

TEST_CASE("overrides change a job before it is read") {
  const std::string file = FLEXOPT_SOURCE_DIR "/designs/jobs/parallel_guide.json";
  const Job job = read_job(file, {"/stroke/to=1 mm", "/model/accuracy=full", "/frequencies=2"});
  CHECK(job.request.points.back() == Approx(1e-3));
  CHECK(job.model.accuracy == Accuracy::full);
  CHECK(job.request.frequencies == 2);
  CHECK_THROWS_AS(read_job(file, {"/model/accuracy=fastest"}), SpecError);
  CHECK_THROWS_AS(read_job(file, {"/modle/accuracy=full"}), SpecError);
}

TEST_CASE("a job without name is called like its file") {
  const test::TemporaryFolder folder;
  test::put(folder / "nameless.json", patched(R"({"name": null})"));
  CHECK(read_job((folder / "nameless.json").string()).name == "nameless");
}

TEST_CASE("a tolerance beside \"auto\" is one of errors, and Newton keeps its own") {
  const Job chosen =
      read_patched(R"({"model": {"flexure": null, "accuracy": "auto", "tolerance": "0.2 %"}})");
  CHECK(chosen.accuracy.automatic);
  CHECK(chosen.accuracy.wants_estimates());
  CHECK(chosen.accuracy.tolerance == Approx(0.002));
  CHECK(chosen.request.newton.tolerance == NewtonOptions{}.tolerance);
  CHECK(chosen.model.accuracy == Accuracy::reduced);
  CHECK(read_patched(R"({"model": {"flexure": null, "accuracy": "auto"}})").accuracy.tolerance ==
        AccuracySpec{}.tolerance);
  const Job estimated =
      read_patched(R"({"model": {"flexure": null, "tolerance": 1e-8, "estimate": true}})");
  CHECK(estimated.accuracy.estimate);
  CHECK_FALSE(estimated.accuracy.automatic);
  CHECK(estimated.request.newton.tolerance == 1e-8);
  CHECK_FALSE(parse_job(base_job("evaluate")).accuracy.wants_estimates());
}
