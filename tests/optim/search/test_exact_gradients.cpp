// Exact derivatives on their way from the mechanics through goals and formulas to the optimiser.
#include <limits>

#include "optim/problem/posing.hpp"
#include "optim/problem/stroke_sensitivity.hpp"
#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

using namespace flexopt::guide;

namespace {

/// Width and spacing follow from the variables by formulas, one of them of two variables.
json linked_guide() {
  json job = stiff_guide();
  job["design"]["parameters"]["width"] = {{"expression", "0.3*length + 2*thickness"}};
  job["design"]["parameters"]["spacing"] = {{"expression", "sqrt(length*0.036)"}};
  job["optimise"]["constraints"].push_back(
      {{"expression", "width*spacing/length"}, {"max", "1 m"}});
  return job;
}

struct Setting {
  Calls calls;
  DesignProblem problem;
  EvaluationLog log;
  ProgressBoard board{{}, 1, true, 1e-4};
  EvaluationBook book;

  explicit Setting(const Job& job, bool exact)
      : problem(job, {evaluator(calls), exact ? gradient_evaluator(calls) : by_differences}),
        log(problem.job()),
        book(problem, log, board, Stage::search, 0, exact) {
    int cost = 0;
    VectorXd middle = VectorXd::Constant(problem.size(), 0.4);
    book.set_scales(problem.scales(nullptr));
    const DesignValues values = book.at(problem.variables(middle), cost);
    book.set_scales(problem.scales(&values));
  }
};

}  // namespace

TEST_CASE("goals are differentiated through parameters that are formulas") {
  const Job job = parse_job(linked_guide());
  Setting exact(job, true), differences(job, false);
  for (const double at : {0.2, 0.55, 0.9}) {
    const VectorXd x = (VectorXd(2) << at, 1 - 0.8 * at).finished();
    int cost = 0, cost_of_differences = 0;
    const auto a = exact.book.derivatives(x, cost);
    const auto b = differences.book.derivatives(x, cost_of_differences);
    REQUIRE(a);
    REQUIRE(b);
    CHECK(cost == 1);
    CHECK(cost_of_differences == 5);
    REQUIRE(a->rows() == 3 + 3 + 3 + 1 + 1);
    REQUIRE(a->rows() == b->rows());
    for (Eigen::Index i = 0; i < a->rows(); ++i) {
      CAPTURE(i);
      // h² = 2.5e-7 of third derivatives of order ten
      const double size = b->row(i).lpNorm<Eigen::Infinity>();
      CHECK((a->row(i) - b->row(i)).lpNorm<Eigen::Infinity>() <= 2e-5 * size);
    }
    CHECK(a->lpNorm<Eigen::Infinity>() > 0);
    // formulas need no differences
    CHECK((a->bottomRows(2) - b->bottomRows(2)).norm() <= 1e-14 * b->bottomRows(2).norm());
  }
  CHECK_FALSE(exact.book.used_differences());
  CHECK(differences.book.used_differences());
}

TEST_CASE("the posed programme has exact gradients, slack and branches included") {
  const auto make = GENERATE(linked_guide, crossing_modes);
  Setting s(parse_job(make()), true);
  const Pose pose = job_pose(s.problem);
  for (const Aim aim : {Aim::objective, Aim::feasibility})
    for (const bool slack : {true, false}) {
      Posing posing(s.book, pose, slack, aim, 0.5);
      const Problem p = posing.problem();
      VectorXd x = VectorXd::Constant(p.lower.size(), 0.37);
      const Problem::Value v = p.evaluate(x, true);
      REQUIRE(v.ok);
      if (p.constraints > 0 || aim == Aim::objective) CHECK(v.df.norm() + v.dc.norm() > 0);
      for (Eigen::Index j = 0; j < x.size(); ++j) {
        VectorXd up = x, down = x;
        const double h = 1e-5;
        up[j] += h, down[j] -= h;
        const Problem::Value a = p.evaluate(up, false), b = p.evaluate(down, false);
        CHECK(v.df[j] == Approx((a.f - b.f) / (2 * h)).epsilon(1e-6).margin(1e-8));
        for (Eigen::Index i = 0; i < v.c.size(); ++i)
          CHECK(v.dc(i, j) == Approx((a.c[i] - b.c[i]) / (2 * h)).epsilon(1e-6).margin(1e-7));
      }
    }
}

TEST_CASE("a row keeps its mode when two modes cross from one design to the next") {
  json document = crossing_modes();
  set_algorithm(document, "LD_SLSQP");
  Setting s(parse_job(document), true);
  const Pose pose = job_pose(s.problem);
  Posing posing(s.book, pose, true);
  const Problem p = posing.problem();
  // u² = 1.5 at rest: width 36.7 mm, x = 0.4825; fa rises with the width, fb falls
  VectorXd x = VectorXd::Constant(p.lower.size(), 0.47);
  const Problem::Value below = p.evaluate(x, true);
  x[0] = 0.5;
  const Problem::Value above = p.evaluate(x, true);
  REQUIRE(below.ok);
  REQUIRE(above.ok);
  int rising = 0, falling = 0;
  for (Eigen::Index i = 0; i < below.dc.rows(); ++i) {
    CAPTURE(i);
    CHECK(below.dc(i, 0) * above.dc(i, 0) >= 0);
    rising += above.dc(i, 0) > 0;
    falling += above.dc(i, 0) < 0;
    // a curvature of order one, not a jump from mode to mode
    CHECK(std::abs(above.dc(i, 0) - below.dc(i, 0)) < 0.2);
  }
  CHECK(rising == 3);
  CHECK(falling == 3);
}

TEST_CASE("the modulus of the material is a variable as any other") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["variables"].push_back(
      {{"parameter", "material.youngs_modulus"}, {"min", "100 GPa"}, {"max", "210 GPa"}});
  document["optimise"]["constraints"].push_back(
      {{"expression", "material.youngs_modulus*length"}, {"max", "1.5e10 N/m"}});
  Calls calls, calls_of_differences;
  const Optimum exact = run(document, calls, true);
  const Optimum differences = run(document, calls_of_differences, false);
  INFO(exact.stop_reason << "\n" << differences.stop_reason);
  CHECK(exact.gradients == "exact");
  CHECK(exact.status == OptimumStatus::optimal);
  CHECK(exact.objective == Approx(differences.objective).epsilon(1e-4));
  const double E = exact.parameters.at("material.youngs_modulus"),
               L = exact.parameters.at("length"), t = exact.parameters.at("thickness");
  CHECK(E * L <= 1.5e10 * (1 + 1e-4));
  // d/dE of the drive load, which is active: F / E
  CHECK(exact.constraints[1].active);
  CHECK(exact.constraints[1].value == Approx(2 * E * 0.03 * t * t * t * 5e-3 / (L * L * L)));
  bool found = false;
  for (const Sensitivity& s : exact.sensitivities)
    if (s.parameter == "material.youngs_modulus" && s.of == exact.constraints[1].label) {
      found = true;
      CHECK(s.value == Approx(exact.constraints[1].value / E).epsilon(1e-9));
    }
  CHECK(found);
}

TEST_CASE("exact gradients take a fraction of the evaluations to the same optimum") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "LD_MMA", "ipopt");
  CAPTURE(name);
  json document = stiff_guide(name);
  Calls calls, calls_of_differences;
  const Optimum exact = run(document, calls, true);
  const Optimum differences = run(document, calls_of_differences, false);
  INFO(exact.stop_reason << "\n" << differences.stop_reason);
  CHECK(exact.gradients == "exact");
  CHECK(exact.gradients_message.empty());
  CHECK(differences.gradients == "central differences");
  CHECK(exact.status == OptimumStatus::optimal);
  CHECK(exact.objective == Approx(differences.objective).epsilon(1e-4));
  CHECK(2 * exact.evaluations < differences.evaluations);
  CHECK(calls.gradients == exact.evaluations - exact.failed_evaluations);
  for (const EvaluationRecord& r : exact.history) CHECK_FALSE(r.difference);
  REQUIRE(exact.constraints[1].multiplier);
  REQUIRE(differences.constraints[1].multiplier);
  CHECK(*exact.constraints[1].multiplier ==
        Approx(*differences.constraints[1].multiplier).epsilon(5e-3));
}

TEST_CASE("a model without derivatives is differentiated by differences") {
  Calls calls;
  const Optimum o = run(stiff_guide("LD_SLSQP"), calls, true, {}, 1e99, false);
  CHECK(o.gradients == "central differences");
  CHECK_THAT(o.gradients_message, Catch::StartsWith("none, first at length = "));
  CHECK(o.status == OptimumStatus::optimal);
  int differences = 0;
  for (const EvaluationRecord& r : o.history) differences += r.difference ? 1 : 0;
  CHECK(differences > 10);
}

TEST_CASE("a derivative that is not finite is named, and replaced by differences") {
  const test::TemporaryFolder folder;
  json document = stiff_guide("LD_SLSQP");
  Calls calls;
  OptimiseOptions options;
  options.log = folder / "log.jsonl";
  options.evaluators.values = evaluator(calls);
  options.evaluators.gradients = [exact = gradient_evaluator(calls)](
                                     const Job& job, const ParameterValues& parameters,
                                     const std::vector<std::string>& names,
                                     const ModelOptions& model, const StrokeRequest& request) {
    StrokeSensitivity s = exact(job, parameters, names, model, request);
    if (s.gradients && parameters.at("thickness") > 0.4e-3) {
      REQUIRE(names[1] == "thickness");
      s.gradients->path.back().drive_load[1] = std::numeric_limits<double>::quiet_NaN();
    }
    return s;
  };
  const Job job = parse_job(document);
  const Optimum o = optimise(job, options);
  CHECK(o.gradients == "central differences");
  CHECK_THAT(
      o.gradients_message,
      Catch::StartsWith("the derivative of drive_load max_abs over stroke along thickness") &&
          Contains(" is not finite, first at length = ") && Contains(", thickness = 0.0004"));
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.objective == Approx(run(document, calls, true).objective).epsilon(1e-4));
  // the log knows it too
  const int before = calls.gradients;
  CHECK(optimise(job, options).gradients_message == o.gradients_message);
  CHECK(calls.gradients == before);
}

TEST_CASE("a goal without exact derivatives is named") {
  Setting s(parse_job(stiff_guide()), true);
  const Variables design = s.problem.variables(VectorXd::Constant(2, 0.4));
  const DesignValues whole = s.problem.evaluate(design, true);
  CHECK(whole.gradient.rows() > 0);
  CHECK(whole.no_gradient.empty());
  CHECK(s.problem.evaluate(design).no_gradient.empty());
  DesignProblem partly(
      parse_job(stiff_guide()),
      {evaluator(s.calls), [exact = gradient_evaluator(s.calls)](const auto&... all) {
         StrokeSensitivity found = exact(all...);
         found.gradients->path.front().support_stiffness[0].reset();
         return found;
       }});
  const DesignValues values = partly.evaluate(design, true);
  REQUIRE(values.ok);
  CHECK(values.gradient.size() == 0);
  CHECK(values.no_gradient == "objective (support_stiffness.ux) has no exact derivatives");
}

TEST_CASE("a method without gradients asks for them at its end alone") {
  Calls calls;
  const Optimum o = run(stiff_guide("LN_COBYLA"), calls, true);
  CHECK(o.gradients == "none");
  CHECK(calls.gradients == 1);
  CHECK(o.sensitivities.size() == 6);
}

TEST_CASE("a run with exact gradients resumes from its log to the same bytes") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "ipopt", "LN_COBYLA");
  CAPTURE(name);
  const test::TemporaryFolder folder;
  json document = stiff_guide(name);
  document["optimise"]["starts"] = 2;
  document["optimise"]["max_evaluations"] = 60;
  OptimiseOptions options;
  options.log = folder / "log.jsonl";
  Calls calls;
  const Optimum whole = run(document, calls, true, options);
  const std::string log = test::content_of(options.log);
  const int total = calls.reduced;
  const std::vector<std::size_t> begins = test::line_begins(log);
  REQUIRE(static_cast<int>(begins.size()) == whole.evaluations + 2);
  const std::size_t lines = begins.size() - 1;
  for (const std::size_t kept : {lines / 4, lines / 2, lines - 2}) {
    test::put(options.log, log.substr(0, begins[kept + 1] + 7));
    Calls again;
    const Optimum resumed = run(document, again, true, options);
    CHECK(test::content_of(options.log) == log);
    CHECK(resumed.objective == whole.objective);
    CHECK(resumed.stop_reason == whole.stop_reason);
    // what the log held was not evaluated again
    CHECK(again.reduced == total - static_cast<int>(kept));
  }
}

TEST_CASE("places of large stress, material and end-effector have exact gradients") {
  json document = json::parse(R"({
    "flexopt": 1, "name": "hinge", "job": "optimise",
    "design": {
      "family": "cross_hinge",
      "parameters": {"length": "60 mm", "width": "20 mm", "thickness": "0.4 mm", "gap": "2 mm"},
      "material": {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3, "density": "7800 kg/m^3"}
    },
    "end_effector": {"mass": "1 kg", "inertia": ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"],
                     "center_of_mass": ["5 mm", 0, 0]},
    "stroke": {"at": ["10 deg"]},
    "frequencies": 3, "model": {"mesh": [8, 3]},
    "optimise": {
      "variables": [
        {"parameter": "crossing_fraction", "min": 0.3, "max": 0.7},
        {"parameter": "thickness", "min": "0.3 mm", "max": "0.5 mm"},
        {"parameter": "material.youngs_modulus", "min": "100 GPa", "max": "220 GPa"},
        {"parameter": "material.density", "min": "2000 kg/m^3", "max": "9000 kg/m^3"},
        {"parameter": "end_effector.mass", "min": "0.5 kg", "max": "2 kg"},
        {"parameter": "end_effector.center_of_mass.x", "min": 0, "max": "10 mm"},
        {"parameter": "end_effector.inertia.xx", "min": "5e-4 kg m^2", "max": "1.5e-3 kg m^2"}
      ],
      "objective": {"maximise": "parasitic_frequency", "over_stroke": "min"},
      "constraints": [{"quantity": "max_stress", "max": "450 MPa"},
                      {"quantity": "drive_load", "over_stroke": "max_abs", "max": "1 N m"}],
      "algorithm": {"library": "nlopt", "name": "LD_MMA"}
    }
  })");
  const auto stress_rows = [&] { return DesignProblem(parse_job(document)).goals()[1].branches; };
  CHECK(stress_rows() == 1);
  set_algorithm(document, "LD_SLSQP");
  CHECK(stress_rows() == 6);
  set_algorithm(document, "ipopt");
  const Job job = parse_job(document);
  const DesignProblem problem(job);
  REQUIRE(problem.goals()[1].branches == 6);
  const VectorXd x = (VectorXd(7) << 0.55, 0.5, 0.8, 0.7, 0.3, 0.5, 0.4).finished();
  const DesignValues here = problem.evaluate(problem.variables(x), true);
  INFO(here.message);
  REQUIRE(here.ok);
  REQUIRE(here.gradient.rows() == 3 + 6 + 1);
  // the two ends of a leaf differ while the crossing is not in its middle
  const GoalValues& stress = here.goals[1];
  CHECK(std::is_sorted(stress.rbegin(), stress.rend()));
  CHECK(stress[5] < 0.999 * stress[0]);
  CHECK(stress[5] >= 0.8 * stress[0]);
  const VectorXd values = flattened(here);
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    CAPTURE(j);
    constexpr double h = 1e-4;  // truncation 1e-8 of a third derivative of order one
    VectorXd up = x, down = x;
    up[j] += h, down[j] -= h;
    const DesignValues a = problem.evaluate(problem.variables(up)),
                       b = problem.evaluate(problem.variables(down));
    REQUIRE((a.ok && b.ok));
    const VectorXd slope = (flattened(a) - flattened(b)) / (2 * h);
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      CAPTURE(i);
      CHECK(here.gradient(i, j) * problem.range(j) ==
            Approx(slope[i]).epsilon(1e-5).margin(1e-6 * values[i]));
    }
  }
  CHECK(here.gradient.col(4).head(3).norm() > 0);
  CHECK(here.gradient.col(4).tail(7).norm() == 0);
}

TEST_CASE("nothing said, the library differentiates the mechanics exactly") {
  const Job job = parse_job(stiff_guide("LD_SLSQP"));
  const DesignProblem plain(job), told(job, {evaluate_stroke, by_differences});
  CHECK(plain.differentiable());
  CHECK_FALSE(told.differentiable());
  CHECK(OptimiseOptions{}.evaluators.gradients != nullptr);
  CHECK(plain.request().values == PathValues::differentiable);
  CHECK(told.request().values == PathValues::as_modelled);
}

TEST_CASE("a design asks for what its goals are made of and nothing else") {
  Job job = parse_job(stiff_guide());
  const auto outputs_of = [&](const std::string& quantity) {
    job.optimise->objective.quantity = quantity;
    job.optimise->constraints.clear();
    return DesignProblem(job).request().outputs;
  };
  CHECK(outputs_of("drive_load") == Outputs{Output::equilibrium});
  CHECK(outputs_of("principal_stiffness") == Outputs{Output::stiffness});
  CHECK(outputs_of("max_stress") == Outputs{Output::stress});
  CHECK(outputs_of("parasitic_frequency") == Outputs{Output::parasitic_frequency});
  CHECK_FALSE(outputs_of("parasitic_frequency_screening").need_path());
  CHECK_THROWS_AS(outputs_of("no_such_quantity"), std::invalid_argument);
}
