// Whole optimisations of a guide in closed form: the optimum on paper, however it is looked for.
#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

using namespace flexopt::guide;

TEST_CASE("every local algorithm finds the guide's optimum on two active constraints") {
  const auto name = GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LN_NELDERMEAD",
                             "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt");
  CAPTURE(name);
  Calls calls;
  const Optimum o = run(stiff_guide(name), calls);
  INFO(o.stop_reason);
  INFO(o.evaluations << " evaluations");
  CHECK(o.status == OptimumStatus::optimal);
  const double best = support(200e9, 0.03, 0.5e-3, 0.1, 5e-3);
  CHECK(o.objective == Approx(best).epsilon(1e-3));
  CHECK(o.parameters.at("length") == Approx(0.1).epsilon(1e-3));
  CHECK(o.parameters.at("thickness") == Approx(0.5e-3).epsilon(1e-3));
  CHECK(o.parameters.at("width") == 0.03);
  REQUIRE(o.constraints.size() == 3);
  CHECK_FALSE(o.constraints[0].active);
  CHECK(o.constraints[0].margin == Approx(450e6).epsilon(5e-3));  // σ = 150 MPa of 600
  CHECK(o.constraints[1].active);
  CHECK(o.constraints[2].active);
  CHECK(o.constraints[1].value == Approx(7.5).epsilon(1e-4));
  CHECK(o.gradients == (name.starts_with("LN") ? "none" : "central differences"));
  CHECK(o.evaluations == static_cast<int>(o.history.size()));
  CHECK(calls.reduced == o.evaluations - o.failed_evaluations + 1);  // and once for the response

  // Multipliers and sensitivities against the derivatives on paper: logarithmic derivatives
  // K: (kt, −1) with kt = 1 + 2q/(1+q), q = 12/700 (x/t)²; F: (3, −3) in (t, L).
  const double L = 0.1, t = 0.5e-3, q = 12.0 / 700 * 100, kt = 1 + 2 * q / (1 + q);
  Eigen::Matrix2d gradients;  // columns: F, envelope; rows: L, t
  gradients << -3 * 7.5 / L, 1, 3 * 7.5 / t, 40;
  const Eigen::Vector2d dK(-best / L, kt * best / t);
  const Eigen::Vector2d lambda = gradients.colPivHouseholderQr().solve(dK);
  REQUIRE(o.constraints[1].multiplier);
  CHECK(std::abs(*o.constraints[0].multiplier) * 600e6 < 1e-4 * best);
  CHECK(*o.constraints[1].multiplier == Approx(lambda[0]).epsilon(5e-3));
  CHECK(*o.constraints[2].multiplier == Approx(lambda[1]).epsilon(5e-3));
  REQUIRE(o.sensitivities.size() == 6);  // objective, load, envelope × length, thickness
  CHECK(o.sensitivities[0].of == "objective");
  CHECK(o.sensitivities[0].parameter == "length");
  CHECK(o.sensitivities[0].value == Approx(dK[0]).epsilon(5e-3));
  CHECK(o.sensitivities[1].value == Approx(dK[1]).epsilon(5e-3));
  CHECK(o.sensitivities[3].of == "drive_load max_abs over stroke");
  CHECK(o.sensitivities[3].value == Approx(3 * 7.5 / t).epsilon(5e-3));
  CHECK(o.sensitivities[5].value == Approx(40).epsilon(1e-6));

  REQUIRE(o.verified);
  CHECK(calls.full == 1);
  CHECK(o.verified->objective == Approx(1.01 * o.objective));
  CHECK(o.verified->objective_difference == Approx(1 / 1.01 - 1));
  CHECK(o.verified->constraint_differences[1] == Approx(1 / 1.01 - 1));
  CHECK(o.verified->constraint_differences[2] == 0.0);  // a formula has no accuracy
  CHECK(o.response.path.size() == 3);
  CHECK(o.response.path[2].max_stress);
}

TEST_CASE("modes that cross at the optimum stall no algorithm") {
  const auto name = GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LN_NELDERMEAD",
                             "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt");
  CAPTURE(name);
  json document = crossing_modes();
  set_algorithm(document, name);
  Calls calls;
  const Optimum o = run(document, calls);
  INFO(o.stop_reason);
  const double u = std::sqrt(144.0 / 98.0);
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.objective == Approx(98 * u).epsilon(1e-3));
  CHECK(o.parameters.at("width") == Approx(0.03 * u).epsilon(1e-3));
  CHECK(o.parameters.at("thickness") == Approx(0.5e-3).margin(0.02e-3));
}

TEST_CASE("failed evaluations are recorded and stepped back from") {
  // No equilibrium beyond 180 MPa: the optimum at 150 MPa can be evaluated, much round it cannot.
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LD_SLSQP", "LD_MMA", "ipopt");
  CAPTURE(name);
  json document = stiff_guide(name);
  document["design"]["parameters"]["length"] = "130 mm";
  document["optimise"]["starts"] = 3;
  Calls calls;
  const Optimum o = run(document, calls, false, {}, 180e6);
  INFO(o.stop_reason);
  CHECK(o.failed_evaluations > 0);
  CHECK(o.objective == Approx(support(200e9, 0.03, 0.5e-3, 0.1, 5e-3)).epsilon(1e-3));
  int failed = 0;
  for (const EvaluationRecord& r : o.history)
    if (!r.ok) {
      ++failed;
      CHECK_THAT(r.message, Contains("no equilibrium at stroke 0.00") &&
                                Contains("Newton stopped after 25 iterations"));
    }
  CHECK(failed == o.failed_evaluations);
}

TEST_CASE("a start where nothing works is a failed start, not the end") {
  Calls calls;
  const Optimum o = run(stiff_guide(), calls, false, {}, 1e3);
  CHECK(o.status == OptimumStatus::failed);
  CHECK_THAT(o.stop_reason, Contains("could be evaluated") && Contains("no equilibrium"));
  CHECK(o.failed_evaluations == o.evaluations);
  CHECK_FALSE(o.verified);
}

TEST_CASE("geometry that contradicts itself is a failed evaluation") {
  Calls calls;
  const Job job = parse_job(stiff_guide());
  const auto broken = [](const Mechanism&, const ModelOptions&,
                         const StrokeRequest&) -> StrokeResponse {
    throw SpecError("/design/parameters/length", "0.1", "the leaves would meet");
  };
  const DesignValues v = DesignProblem(job, {broken, by_differences}).evaluate({0.1, 0.5e-3});
  CHECK_FALSE(v.ok);
  CHECK_THAT(v.message, Contains("the leaves would meet"));
}

TEST_CASE("a job without a feasible design says what stops it") {
  const auto name = GENERATE(as<std::string>(), "LN_COBYLA", "LD_SLSQP", "ipopt");
  CAPTURE(name);
  json document = stiff_guide(name);
  document["optimise"]["constraints"][1]["max"] = "0.01 N";  // least is 0.142 N
  document["optimise"]["max_evaluations"] = 300;
  Calls calls;
  const Optimum o = run(document, calls);
  CHECK(o.status == OptimumStatus::infeasible);
  CHECK_THAT(o.stop_reason, Contains("no feasible design") &&
                                Contains("drive_load max_abs over stroke") &&
                                Contains("at most 0.01"));
  CHECK(o.constraints[1].margin < 0);
  CHECK_FALSE(o.starts[0].feasible);
  CHECK_THAT(o.stop_reason, Contains("length + 40*thickness") && Contains("at most 0.12"));
  // least violation: L = 150 mm and t = 0.2 mm miss the load by 13 times, the envelope by 0.3
  CHECK(o.constraints[1].value == Approx(60e6 * std::pow(0.2 / 150, 3)).epsilon(1e-2));
}

TEST_CASE("a formula alone needs no mechanics but for the final look") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["objective"] = {{"minimise", "length*thickness"}};
  document["optimise"]["constraints"] =
      json::parse(R"([{"expression": "length + 100*thickness", "min": "100 mm"}])");
  Calls calls;
  const Optimum o = run(document, calls);
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(calls.reduced == 1);
  CHECK(calls.full == 1);
  // on L + 100 t = 0.1: L t least at an end: t = 0.2 mm, L = 80 mm, or L = 50 mm, t = 0.5 mm
  CHECK(o.objective == Approx(0.2e-3 * 0.08).epsilon(1e-3));
}

TEST_CASE("starts that miss a formula begin at the nearest point that keeps it") {
  json document = stiff_guide();
  document["design"]["parameters"]["length"] = "150 mm";
  document["design"]["parameters"]["thickness"] = "1 mm";
  document["optimise"]["starts"] = 6;
  Calls calls;
  const Optimum o = run(document, calls);
  REQUIRE(o.starts.size() == 6);
  for (const StartSummary& s : o.starts)
    CHECK(s.from.at("length") + 40 * s.from.at("thickness") <= 0.12 * (1 + 1e-6));
}

TEST_CASE("several starts: the best feasible end wins, each is told") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["starts"] = 4;
  document["optimise"]["seed"] = 7;
  Calls calls;
  const Optimum o = run(document, calls);
  REQUIRE(o.starts.size() == 4);
  int total = 0;
  for (const StartSummary& s : o.starts) {
    total += s.evaluations;
    CHECK(s.status == "converged");
    CHECK(s.feasible);
    CHECK(s.objective <= o.objective * (1 + 1e-12));
    CHECK(s.objective == Approx(o.objective).epsilon(1e-3));
  }
  CHECK(total == o.evaluations);
  CHECK(o.starts[1].from != o.starts[2].from);
  for (std::size_t i = 1; i < o.history.size(); ++i)
    CHECK((o.history[i].start > o.history[i - 1].start ||
           o.history[i].number == o.history[i - 1].number + 1));
}

// Waves of 10 mm: a step crosses several, and may end in a lower one than it crossed.
TEST_CASE("no start ends at a design that it passed by on the way to a worse optimum", "[slow]") {
  const auto name = GENERATE(as<std::string>(), "ipopt", "LD_SLSQP");
  CAPTURE(name);
  json document = stiff_guide(name);
  document["optimise"]["objective"] = {
      {"maximise", "sin(60*length/0.1)*thickness*cos(5000*thickness/0.1)"}};
  document["optimise"]["constraints"] =
      json::parse(R"([{"expression": "100*length*thickness", "max": 0.005}])");
  document["optimise"]["starts"] = 60;
  Calls calls;
  const Optimum o = run(document, calls);
  for (const StartSummary& s : o.starts) {
    CAPTURE(s.index, s.objective, s.stop_reason);
    CHECK(s.status == "converged");
    REQUIRE(s.kkt);
    CHECK(*s.kkt < 1e-2);  // where it passes by, the slope is 10 to 100
  }
}

TEST_CASE("the budget of each start is kept and said") {
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LN_NELDERMEAD", "LD_SLSQP", "GN_ISRES", "ipopt");
  CAPTURE(name);
  json document = stiff_guide(name);
  document["optimise"]["max_evaluations"] = 12;
  Calls calls;
  const Optimum o = run(document, calls);
  // one gradient may run over the end, and the final derivatives are not the algorithm's
  CHECK(o.evaluations <= 12 + 4 + 4);
  CHECK(o.status != OptimumStatus::optimal);
  CHECK(o.starts[0].status == "max_evaluations");
}
