#include <limits>

#include "core/math/rotation.hpp"
#include "results/files/result_parts.hpp"
#include "support/models.hpp"
#include "tests/results/results_tests.hpp"

TEST_CASE("strokes, loads and stiffnesses of drives with names stand under these") {
  RunRecord record = test::evaluated_hinge();
  record.mechanism.drives = {{.name = "x", .direction = Direction::ux},
                             {.name = "turn", .direction = Direction::rz}};
  record.response.frequency_derivatives.resize(2);
  record.response.frequency_derivatives[1].drive = 1;
  record.job.request.frequencies = 1;
  for (PathPoint& p : record.response.path) {
    p.drive_names = {"x", "turn"};
    p.strokes = {1e-3, p.stroke};
    p.drive_loads = {p.drive_load, 7};
    p.drive_stiffnesses = {p.drive_stiffness, 9};
    p.gain.assign(12, std::nullopt);
    p.gain[1] = 3;
    p.gain[11] = 4;
  }
  record.response.path[1].status = PointStatus::not_reached;
  const OrderedJson result = make_result(record);
  const PathPoint& point = record.response.path[0];
  CHECK(unlike(result["path"][0], {{"stroke", {{"x", 1e-3}, {"turn", point.stroke}}},
                                   {"drive_load", {{"x", point.drive_load}, {"turn", 7}}},
                                   {"drive_stiffness", {{"turn", 9}}},
                                   {"gain", {{"x", {{"uy", 3}}}, {"turn", {{"rz", 4}}}}}}) == "");
  CHECK(unlike_text(result["path"][1], R"({"stroke": {"x": 1e-3}, "drive_load": null})") == "");
  CHECK(unlike_text(result, R"({
    "units": {"stroke": {"x": "m", "turn": "rad"}, "drive_load": {"turn": "N m"}},
    "conventions": {"drive": {"turn": "rz"}}})") == "");
  CHECK(result["frequency_derivatives"][1]["stroke"] == "turn");
  // one drive that is not along an axis of the end-effector
  record.mechanism.drives = {{.direction = Direction::uy, .axes = rotation_exp({0.1, 0, 0})}};
  for (PathPoint& p : record.response.path) p.drive_names.clear();
  const OrderedJson one = make_result(record);
  CHECK(one["path"][0]["stroke"] == point.stroke);
  CHECK(one["conventions"]["drive"] == "uy of shuttle in axes of its own");
}

TEST_CASE("Every number of a stroke point is in the result, under the contract's name") {
  const RunRecord record = test::evaluated_hinge();
  const OrderedJson result = OrderedJson::parse(json_text(make_result(record)));
  CHECK(result["status"] == "ok");
  CHECK(result["job"] == OrderedJson(*record.job.as_read));
  CHECK(result["flexopt"]["version"].get<std::string>().size() >= 5);
  CHECK(result["flexopt"]["format"] == 1);
  CHECK_FALSE(result["flexopt"]["commit"].get<std::string>().empty());
  REQUIRE(result["path"].size() == 5);
  for (std::size_t i = 0; i < 5; ++i) {
    const auto& json = result["path"][i];
    const PathPoint& point = record.response.path[i];
    CHECK(unlike(json, {{"stroke", point.stroke},  // bit for bit
                        {"drive_load", point.drive_load},
                        {"drive_stiffness", point.drive_stiffness},
                        {"parasitic_frequency", *point.parasitic_frequency},
                        {"max_stress", point.max_stress->value},
                        {"displacement",
                         std::vector(point.displacement.begin(), point.displacement.end())},
                        {"rotation", std::vector(point.rotation.begin(), point.rotation.end())},
                        {"support_stiffness", {{"uz", *point.support_stiffness[2]}}},
                        {"frequencies",
                         {{"drive_free", point.frequencies_free},
                          {"drive_locked", point.frequencies_locked}}}}) == "");
    CHECK(unlike_text(json, R"({"status": "converged", "newton_iterations": 4, "stable": true,
        "max_stress_place": {"leaf": "leaf 2"}, "buckling_load_factor": null})") == "");
    CHECK(json["max_stress_place"].contains("allowable_stress"));
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) {
        CHECK(json["compliance"]["drive_free"][a][b] == point.compliance_free(a, b));
        CHECK(json["compliance"]["drive_locked"][a][b] == point.compliance_locked(a, b));
      }
    CHECK(json["support_stiffness"].size() == 5);
    CHECK_FALSE(json["support_stiffness"].contains("rz"));
    const OrderedJson& softest = json["principal_stiffness"];
    CHECK(softest["value"].get<double>() ==
          Approx(std::min({*point.support_stiffness[0], *point.support_stiffness[1],
                           *point.support_stiffness[2]}))
              .epsilon(1e-12));
    REQUIRE(softest["direction"].size() == 3);
    CHECK(softest["direction"][0].get<double>() + softest["direction"][1].get<double>() +
              softest["direction"][2].get<double>() ==
          Approx(1));
    CHECK(unlike(json["modes"][0],
                 {{"frequency", *point.parasitic_frequency}, {"kind", "end_effector"}}) == "");
    CHECK(unlike_text(json["modes"][3], R"({"kind": "drive", "participation": {"drive": 0.99}})") ==
          "");
    CHECK(json["leaves"][1]["model"] == "full");
    CHECK_THAT(json["leaves"][1]["reason"].get<std::string>(), Contains("off-ray"));
  }
  CHECK(unlike_text(result["units"], R"({"drive_load": "N m", "principal_stiffness": "N/m",
      "support_stiffness": {"ux": "N/m"}, "parameters": {"half_angle": "rad"}})") == "");
  // where the report finds what its tables show
  REQUIRE(result["quantities"].size() > 8);
  for (const OrderedJson& q : result["quantities"]) {
    INFO(q.dump());
    const OrderedJson* value = &result["path"][0];
    for (const OrderedJson& key : q["at"]) value = &value->at(key.get<std::string>());
    CHECK(value->is_number());
  }
}

TEST_CASE("Frequency derivatives are in the result, under the contract's names") {
  RunRecord record = test::evaluated_hinge();
  FrequencyDerivatives d{.index = 1, .omega2 = 1.29e6, .d_omega2 = -3, .d2_omega2 = -9.1e8};
  d.mode.frequency = 180.8;
  d.mode.kind = ModeKind::end_effector;
  d.compliance = 1 / d.omega2;
  d.d_compliance = 2e-12;
  d.d2_compliance = 5.4e-4;
  d.compliance_valid_to = 0.21;
  record.response.frequency_derivatives = {d};
  record.job.request.frequencies = 4;
  const OrderedJson result = OrderedJson::parse(json_text(make_result(record)));
  REQUIRE(result["frequency_derivatives"].size() == 1);
  CHECK(unlike_text(result["frequency_derivatives"][0], R"({
    "mode": 1, "kind": "end_effector", "drive": "free", "frequency": 180.8, "d_omega2": -3,
    "d2_omega2": -9.1e8, "d_compliance": 2e-12, "d2_compliance": 5.4e-4,
    "valid_to": {"omega2": null, "compliance": 0.21}})") == "");
  CHECK_THAT(result["units"]["frequency_derivatives"].get<std::string>(),
             Contains("per stroke in rad"));
  record.job.request.loads.growing = {load_at_O(Vector6d::Zero())};  // nothing is driven
  CHECK_FALSE(make_result(record).contains("frequency_derivatives"));
}

TEST_CASE("Every body has its motion at every point of the result") {
  RunRecord record = test::evaluated_hinge();
  RigidBody second = record.mechanism.bodies[0];
  second.name = "second";
  record.mechanism.bodies.push_back(second);
  for (PathPoint& point : record.response.path)
    point.bodies = {{point.displacement, point.rotation}, {{1e-3, 0, 2e-3}, {0, 0.1, -0.2}}};
  const OrderedJson result = make_result(record);
  for (std::size_t i = 0; i < 5; ++i) {
    const auto& json = result["path"][i];
    REQUIRE(json["bodies"].size() == 2);
    CHECK(json["bodies"]["shuttle"]["displacement"] == json["displacement"]);
    CHECK(json["bodies"]["shuttle"]["rotation"] == json["rotation"]);
    CHECK(unlike_text(json["bodies"]["second"],
                      R"({"displacement": [1e-3, 0, 2e-3], "rotation": [0, 0.1, -0.2]})") == "");
  }
}

TEST_CASE("What holds a mechanism twice is in the result, in words") {
  const OrderedJson constraints = make_result(test::evaluated_hinge())["constraints"];
  CHECK(unlike_text(constraints, R"({
    "degrees_of_freedom": 1, "end_effector_degrees_of_freedom": 1, "overconstraints": 1,
    "tolerance": 1e-8,
    "redundant": [{"body": "shuttle", "direction": "uz", "shared_by": ["leaf 1", "leaf 2"],
      "text": "displacement of `shuttle` along z is held twice, by `leaf 1` and `leaf 2`"}]})") ==
        "");
}

TEST_CASE("Keys stand in the contract's order and a matrix row on one line") {
  const std::string text = json_text(make_result(test::evaluated_hinge()));
  const auto at = [&](const char* key) { return text.find(std::string("\n  \"") + key + "\":"); };
  CHECK(at("flexopt") < at("job"));
  CHECK(at("job") < at("status"));
  CHECK(at("status") < at("message"));
  CHECK(at("message") < at("path"));
  CHECK(at("path") != std::string::npos);
  CHECK(text.back() == '\n');
  const std::string tail = ", 0.0, 0.0, 0.0, 0.0],\n";
  CHECK(text.find(tail) != std::string::npos);
}

TEST_CASE(
    "how far elastic bodies bend is told of optima too, and turns of imported matrices alone") {
  const auto bend = [](RunRecord& record, StrokeResponse& response) {
    record.mechanism.elastic_bodies.emplace_back().name = "arm";
    for (PathPoint& p : response.path)
      p.elastic_bodies = {{.turn = 0.05, .geometric_share = 0.2, .degree_error = 0.02}};
  };
  RunRecord record = test::evaluated_hinge();
  bend(record, record.response);
  conclude(record);
  CHECK_THAT(record.message, Contains("of the energy of arm a stiffness is off by up to 2 %") &&
                                 !Contains("turns by"));
  record.mechanism.elastic_bodies[0].imported = std::make_shared<const ImportedMatrices>();
  conclude(record);
  CHECK_THAT(record.message, Contains("An interface of arm turns by 0.05 rad"));
  RunRecord best = test::optimised_hinge();
  bend(best, best.optimum->response);
  conclude(best);
  CHECK_THAT(best.message, Contains("of the energy of arm a stiffness is off by up to 2 %"));
}

TEST_CASE("A point without equilibrium has nulls and the run is not usable") {
  RunRecord record = test::evaluated_hinge();
  record.response.status = Status::no_equilibrium;
  record.response.message = "Newton stopped at 0.2 rad";
  PathPoint& last = record.response.path.back();
  last = {};
  last.stroke = 0.35;
  last.status = PointStatus::no_equilibrium;
  last.message = "|r| = 3.1e-2";
  conclude(record);
  const OrderedJson result = make_result(record);
  CHECK_FALSE(usable(result));
  CHECK(result["status"] == "no_equilibrium");
  CHECK(result["message"] == "Newton stopped at 0.2 rad.");
  record.response.message.clear();
  conclude(record);
  CHECK(record.message == "4 of 5 stroke points converged.");
  const auto& json = result["path"][4];
  CHECK(json["status"] == "no_equilibrium");
  CHECK(json["message"] == "|r| = 3.1e-2");
  const OrderedJson converged = result["path"][0];
  for (const auto& [key, value] : converged.items()) CHECK(json.contains(key));
  CHECK(json["drive_load"].is_null());
  CHECK(json["compliance"].is_null());
}

TEST_CASE("A number that is not finite is null, is named, and makes the run unusable") {
  RunRecord record = test::evaluated_hinge();
  record.response.path[1].drive_load = std::numeric_limits<double>::quiet_NaN();
  record.response.path[2].compliance_free(0, 1) = std::numeric_limits<double>::infinity();
  const OrderedJson result = make_result(record);
  CHECK(result["path"][1]["drive_load"].is_null());
  CHECK(result["status"] == "not_finite");
  CHECK_THAT(result["message"].get<std::string>(),
             Contains("2 numbers are not finite, first at /path/1/drive_load"));
  CHECK_FALSE(usable(result));
}

TEST_CASE("The optimum keeps the names of the contract") {
  const RunRecord record = test::optimised_hinge();
  const OrderedJson result = OrderedJson::parse(json_text(make_result(record)));
  const auto& optimum = result["optimum"];
  CHECK(result["status"] == "ok");
  CHECK(result["path"].size() == 5);
  CHECK(unlike_text(optimum, R"({
    "status": "optimal", "parameters": {"thickness": 0.35e-3}, "objective": 169.2,
    "goal": {"sense": "maximise", "unit": "Hz"}, "evaluations": 32,
    "verified": {"objective": 168.9}})") == "");
  CHECK(unlike_text(optimum["constraints"][0], R"({"quantity": "max_stress", "value": 449.99e6,
      "bound": 450e6, "margin": 1e4, "active": true, "multiplier": 3.1e-7})") == "");
  CHECK(unlike_text(optimum["constraints"][1], R"({"bound": 1, "multiplier": null})") ==
        "");  // the nearer one of ±1
  CHECK(optimum["starts"].size() == 2);
  CHECK(unlike_text(optimum["variables"][0], R"({"initial": 0.35e-3, "at_bound": null})") == "");
  CHECK(optimum["verified"]["constraints"][1]["difference"] == -2e-4);
  CHECK(optimum["verified"]["path"].size() == 5);
  CHECK(optimum["sensitivities"][0]["unit"] == "Hz");
  CHECK(unlike_text(optimum["sensitivities"][1], R"({"unit": "Pa", "per": "m"})") == "");
  CHECK(optimum["history"]["objective"].size() == 32);
  CHECK(optimum["history"]["objective"][2].is_null());  // a failed evaluation
}

TEST_CASE("Stock sizes, front and verification stand in the result as their README says") {
  RunRecord record = test::optimised_hinge();
  Optimum& o = *record.optimum;
  OptimiseSpec& spec = *record.job.optimise;
  const auto plain = OrderedJson::parse(json_text(make_result(record)))["optimum"];
  CHECK(unlike_text(plain, R"({"stock": null, "pareto": null, "verified": {"loop": null},
      "accuracy": "reduced"})") == "");

  o.starts[0].agrees = true;
  o.starts[0].kkt = 3e-7;
  o.agreeing_starts = 1;
  o.gradients_message = "drive_load has no exact derivatives";
  o.at_full_accuracy = true;
  StockDesign good{
      {true, true, 168.0, 0, "converged", "", 12}, {{"thickness", 3.5e-4}}, o.parameters};
  StockDesign failed{
      {false, false, 0, 0, "failed", "no equilibrium", 5}, {{"thickness", 4e-4}}, {}};
  o.stock = StockSearch{o.parameters, 169.2, 2, {good, failed}, 0};
  spec.pareto = ParetoSpec{
      {.quantity = "drive_load", .over_stroke = OverStroke::max_abs, .label = "drive_load"},
      false,
      2};
  o.pareto =
      ParetoFront{"",
                  {{{true, true, 169.2, 0, "converged", "", 0}, {}, 0.41, {}, o.parameters},
                   {{true, true, 120.5, 1e-6, "converged", "", 31}, 0.2, 0.2, 85.0, o.parameters}}};
  spec.verify = VerifySpec{0.002, 6};
  VerificationStep first{{{"thickness", 3.5e-4}}, 168.9, 0.01, 0.03, 0, true, true};
  VerificationStep lost{{{"thickness", 3.6e-4}}, 0, 0, 0, 0.2, false, false};
  o.verified->loop = VerificationLoop{true, "done", 1, 0.002, 1e-3, 3e-6, {first, lost}};
  EvaluationRecord full = o.history.front();
  full.stage = Stage::verification;
  full.full = true;
  o.history.push_back(full);

  const auto optimum = OrderedJson::parse(json_text(make_result(record)))["optimum"];
  CHECK(unlike_text(optimum, R"({
    "accuracy": "full", "agreeing_starts": 1, "gradients_of": null,
    "gradients_message": "drive_load has no exact derivatives",
    "stock": {"continuous": {"objective": 169.2}, "chosen": 0, "neighbours": 2,
              "designs": [{"sizes": {"thickness": 3.5e-4}}, {"objective": null}]},
    "pareto": {"second": {"unit": "N m", "sense": "minimise"},
               "points": [{"bound": null}, {"bound": 0.2, "trade_off": 85}]},
    "verified": {"loop": {"kkt_residual": 3e-6, "converged": true, "full_evaluations": 2,
                          "steps": [{"difference": 0.03}, {"objective": null}]}}})") == "");
  CHECK(unlike_text(optimum["starts"][0], R"({"agrees": true, "kkt_residual": 3e-7})") == "");
  CHECK(optimum["starts"][1]["kkt_residual"].is_null());
  CHECK(optimum["history"]["objective"].size() == 32);  // of the starts alone

  const std::string csv = pareto_csv(record.job, *o.pareto, drive_direction(record.mechanism));
  CHECK_THAT(csv, Catch::StartsWith("point,bound [N m],objective: parasitic_frequency min [Hz],"
                                    "second: drive_load [N m],d objective / d bound [SI],length"));
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 3);
  CHECK_THAT(csv, Contains("\n1,0.2,120.5,0.2,85,"));
  const std::string history = history_csv(record.job, o, drive_direction(record.mechanism));
  CHECK_THAT(history, Catch::EndsWith(",verification,full\n"));
}

TEST_CASE("Each end of an optimisation has its status") {
  RunRecord record = test::optimised_hinge();
  const auto status = [&](OptimumStatus end) {
    record.optimum->status = end;
    conclude(record);
    return record.status;
  };
  CHECK(status(OptimumStatus::optimal) == "ok");
  CHECK(status(OptimumStatus::local) == "ok");
  CHECK(status(OptimumStatus::feasible) == "not_converged");
  CHECK(status(OptimumStatus::infeasible) == "infeasible");
  CHECK(status(OptimumStatus::failed) == "failed");
}

TEST_CASE("Critical factors have both drive states, estimate, kind, mode and reason") {
  RunRecord record = test::evaluated_hinge();
  const std::size_t bodies = record.mechanism.bodies.size();
  Buckling& buckling = record.response.path[1].buckling.emplace();
  buckling.drive_locked.factor = 4.5;
  buckling.drive_locked.linearised = 4.0;
  buckling.drive_locked.mode.assign(bodies, {{0, 0.5, 0}, {0, 0, 1}});
  buckling.drive_free.none = true;
  buckling.drive_free.at_least = 50;
  buckling.drive_free.reason = "no singular tangent";
  const OrderedJson result = OrderedJson::parse(json_text(make_result(record)));
  CHECK(unlike_text(result["path"][0], R"({"buckling": null, "buckling_load_factor": null})") ==
        "");
  CHECK(unlike_text(result["path"][1], R"({
    "buckling_load_factor": 4.5,
    "buckling": {"drive_locked": 4.5, "drive_free": null, "linearised": {"drive_locked": 4},
                 "kind": {"drive_locked": "bifurcation"},
                 "reason": {"drive_free": "no singular tangent"},
                 "at_least": {"drive_locked": null, "drive_free": 50}}})") == "");
  CHECK(result["path"][1]["buckling"]["mode"]["drive_locked"][record.mechanism.bodies[0].name]
              ["displacement"][1] == 0.5);
}
