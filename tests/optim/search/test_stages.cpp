// What follows the starts: stock sizes, the front of two objectives, the optimum of full accuracy.
// On the guide in closed form: load 60e6 N (t/L)³, envelope L + 40 t ≤ 120 mm.
#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

using namespace flexopt::guide;

namespace {

constexpr double E = 200e9, w = 0.03, x = 5e-3;

Optimum run(const json& document, int threads = 1, bool exact = false) {
  Calls calls;
  OptimiseOptions options;
  options.threads = threads;
  return guide::run(document, calls, exact, options);
}

double load(double t, double L) { return 60e6 * std::pow(t / L, 3); }

}  // namespace

TEST_CASE("the best neighbouring stock design is optimised in the other variables") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "LN_COBYLA", "ipopt");
  CAPTURE(name);
  json document = stiff_guide(name);
  document["optimise"]["variables"][1]["stock"] = {"0.6 mm", "0.3 mm", "0.46 mm", "5 mm"};
  const Optimum o = run(document);
  INFO(o.stop_reason);
  // 0.6 mm needs L ≥ 120 mm for the load and L ≤ 96 mm for the envelope; 0.46 mm: L ≥ 92 mm
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.parameters.at("thickness") == 0.46e-3);
  CHECK(o.parameters.at("length") == Approx(0.092).epsilon(1e-3));
  CHECK(o.objective == Approx(support(E, w, 0.46e-3, 0.092, x)).epsilon(1e-3));
  CHECK(o.constraints[1].active);
  REQUIRE(o.stock);
  CHECK(o.stock->continuous.at("thickness") == Approx(0.5e-3).epsilon(1e-3));
  CHECK(o.stock->continuous_objective > o.objective);
  CHECK(o.stock->neighbours == 2);
  REQUIRE(o.stock->designs.size() == 3);  // these two, and 0.3 mm beside the chosen one
  REQUIRE(o.stock->chosen == 0);
  CHECK(o.stock->designs[0].feasible);
  CHECK(o.stock->designs[0].sizes == ParameterValues{{"thickness", 0.46e-3}});
  CHECK_FALSE(o.stock->designs[1].feasible);
  CHECK(o.stock->designs[1].sizes.at("thickness") == 0.6e-3);
  REQUIRE(o.verified);
  CHECK(o.verified->objective == Approx(1.01 * o.objective));
}

TEST_CASE("a step makes the sizes, and a size that is hit has no neighbour") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["variables"][1]["step"] = "0.09 mm";
  const Optimum o = run(document);
  CHECK(o.parameters.at("thickness") == 0.45e-3);
  CHECK(o.parameters.at("length") == Approx(0.09).epsilon(1e-3));
  // the same job where the optimum is a size already: held by a constraint
  document["optimise"]["constraints"].push_back({{"expression", "thickness"}, {"max", "0.36 mm"}});
  const Optimum hit = run(document);
  REQUIRE(hit.stock);
  CHECK(hit.stock->neighbours >= 1);
  CHECK(hit.parameters.at("thickness") == 0.36e-3);
}

TEST_CASE("all variables may be stock, and threads do not change the choice") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["variables"][0]["stock"] = {"85 mm", "95 mm", "110 mm"};
  document["optimise"]["variables"][1]["stock"] = {"0.46 mm", "0.6 mm"};
  const Optimum o = run(document), again = run(document, 3);
  CHECK(o.parameters.at("length") == 0.095);
  CHECK(o.parameters.at("thickness") == 0.46e-3);
  CHECK(o.stock->neighbours == 4);
  CHECK(o.stock->tried == 6);  // and the two that are beside the best of these
  CHECK(o.stock->settled);
  CHECK_THAT(o.stop_reason, Contains("6 combinations of sizes tried"));
  CHECK(again.parameters == o.parameters);
  REQUIRE(again.history.size() == o.history.size());
  for (std::size_t i = 0; i < o.history.size(); ++i)
    CHECK(again.history[i].variables == o.history[i].variables);
}

TEST_CASE("no combination of sizes is better than the chosen one") {
  const auto [name, steps] =
      GENERATE(table<std::string, std::pair<double, double>>({{"LD_SLSQP", {0.01, 0.05e-3}},
                                                              {"LD_SLSQP", {0.003, 0.07e-3}},
                                                              {"ipopt", {0.02, 0.03e-3}},
                                                              {"LN_COBYLA", {0.007, 0.11e-3}}}));
  CAPTURE(name, steps.first, steps.second);
  json document = stiff_guide(name);
  document["optimise"]["variables"][0]["step"] = steps.first;
  document["optimise"]["variables"][1]["step"] = steps.second;
  const Optimum o = run(document, 1, true);
  INFO(o.stop_reason);
  double best = 0;
  for (int i = 0; i * steps.first <= 0.15 * (1 + 1e-9); ++i)
    for (int k = 0; k * steps.second <= 1e-3 * (1 + 1e-9); ++k) {
      const double L = i * steps.first, t = k * steps.second;
      if (L < 0.05 * (1 - 1e-9) || t < 0.2e-3 * (1 - 1e-9)) continue;
      if (load(t, L) > 7.5 * (1 + 1e-4) || L + 40 * t > 0.12 * (1 + 1e-4)) continue;
      best = std::max(best, support(E, w, t, L, x));
    }
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.objective == Approx(best).epsilon(1e-9));
  REQUIRE(o.stock);
  CHECK(o.stock->settled);
  CHECK_THAT(o.stop_reason, Contains("combinations of sizes tried") && Contains("is better"));
}

TEST_CASE("no feasible stock design is said, with the optimum of any size") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["variables"][1]["stock"] = {"0.6 mm", "0.8 mm"};
  const Optimum o = run(document);
  CHECK(o.status == OptimumStatus::infeasible);
  CHECK_THAT(o.stop_reason, Contains("none of the 2 neighbouring stock designs"));
  REQUIRE(o.stock);
  CHECK(o.stock->chosen == -1);
  CHECK(o.parameters.at("thickness") == Approx(0.5e-3).epsilon(1e-3));
}

TEST_CASE("the front of stiffness and drive load is the one on paper") {
  const auto [name, exact] = GENERATE(table<std::string, bool>(
      {{"LD_SLSQP", false}, {"LD_SLSQP", true}, {"ipopt", true}, {"LN_COBYLA", false}}));
  CAPTURE(name, exact);
  json document = stiff_guide(name);
  document["optimise"]["pareto"] = {
      {"quantity", "drive_load"}, {"over_stroke", "max_abs"}, {"points", 6}};
  document["optimise"]["max_evaluations"] = 4000;
  const Optimum o = run(document, 1, exact);
  CHECK(o.status == OptimumStatus::optimal);
  REQUIRE(o.pareto);
  INFO(o.pareto->message);
  REQUIRE(o.pareto->points.size() == 6);
  CHECK(o.pareto->message.empty());
  const double least = load(0.2e-3, 0.112);
  // K on the front: t = r L, L + 40 t = 120 mm, r³ = ε / 60e6
  const auto front = [](double bound) {
    const double r = std::cbrt(bound / 60e6), L = 0.12 / (1 + 40 * r);
    return support(E, w, r * L, L, x);
  };
  for (std::size_t i = 0; i < 6; ++i) {
    const ParetoPoint& p = o.pareto->points[i];
    CAPTURE(i, p.stop_reason);
    const double bound = 7.5 + (least - 7.5) * static_cast<double>(i) / 5;
    CHECK(p.ok);
    CHECK(p.feasible);
    CHECK(p.second == Approx(bound).epsilon(2e-3));
    CHECK(p.objective == Approx(front(p.second)).epsilon(3e-3));
    CHECK(p.violation <= 1e-4);
    if (i == 0) CHECK_FALSE(p.bound);
    if (i > 0) CHECK(*p.bound == Approx(bound).epsilon(2e-3));
    if (i > 0) CHECK(p.objective < o.pareto->points[i - 1].objective);
    if (i > 0 && i < 5 && name != "LN_COBYLA") {
      REQUIRE(p.trade_off);
      const double h = 1e-4 * bound;
      CHECK(*p.trade_off == Approx((front(bound + h) - front(bound - h)) / (2 * h)).epsilon(2e-2));
    }
  }
  for (const EvaluationRecord& r : o.history)
    if (r.stage == Stage::pareto && r.ok) CHECK(r.constraints.size() == 4);  // the second one too
  CHECK(o.constraints.size() == 3);
}

TEST_CASE("a second objective may be a formula that is to grow") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["pareto"] = {{"expression", "length"}, {"sense", "maximise"}, {"points", 4}};
  const Optimum o = run(document);
  REQUIRE(o.pareto);
  REQUIRE(o.pareto->points.size() == 4);
  CHECK(o.pareto->points.back().second == Approx(0.112).epsilon(1e-3));
  CHECK(o.pareto->points.back().parameters.at("thickness") == Approx(0.2e-3).epsilon(1e-2));
  for (std::size_t i = 1; i < 4; ++i) {
    const ParetoPoint& p = o.pareto->points[i];
    // the envelope binds: 40 t = 120 mm − L
    CHECK(p.objective == Approx(support(E, w, (0.12 - p.second) / 40, p.second, x)).epsilon(3e-3));
  }
}

TEST_CASE("objectives that do not conflict have a front of one design") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["pareto"] = {{"expression", "thickness"}, {"sense", "maximise"}};
  const Optimum o = run(document);  // 0.5 mm is both stiffest and thickest
  REQUIRE(o.pareto);
  CHECK(o.pareto->points.size() == 1);
  CHECK_THAT(o.pareto->message, Contains("the front is one design"));
}

namespace {

/// The truth: loads 5 % larger at t = 0.5 mm and growing with t, stiffness 8 % smaller and falling
/// with L.
struct Truth {
  static double of_load(double t) { return 1.05 + 0.15 * (t / 0.5e-3 - 1); }
  static double of_stiffness(double L) { return 0.92 - 0.3 * (L / 0.1 - 1); }
  static void distort(StrokeResponse& response, double t, double L) {
    for (PathPoint& p : response.path) {
      p.drive_load *= of_load(t);
      if (p.support_stiffness[0]) *p.support_stiffness[0] *= of_stiffness(L);
    }
  }
};

ModelOptions reduced(ModelOptions model) {
  model.accuracy = Accuracy::reduced;
  return model;
}

Optimum run(const json& document, const Evaluators& evaluators) {
  OptimiseOptions options;
  options.evaluators = evaluators;
  return optimise(parse_job(document), options);
}

StrokeEvaluator two_models(Calls& calls, bool always_truth = false, double full_breaks_at = 1e99) {
  return
      [&calls, always_truth, plain = evaluator(calls), breaking = evaluator(calls, full_breaks_at)](
          const Mechanism& m, const ModelOptions& model, const StrokeRequest& request) {
        const bool full = model.accuracy == Accuracy::full;
        StrokeResponse r = (full ? breaking : plain)(m, reduced(model), request);
        if (full) ++calls.full;
        if (full || always_truth) Truth::distort(r, m.leaves[0].thickness, m.leaves[0].length);
        return r;
      };
}

StrokeGradientEvaluator two_gradients(Calls& calls) {
  return [plain = gradient_evaluator(calls), &calls](
             const Job& job, const ParameterValues& at, const std::vector<std::string>& names,
             const ModelOptions& model, const StrokeRequest& request) {
    StrokeSensitivity s = plain(job, at, names, reduced(model), request);
    if (model.accuracy != Accuracy::full) return s;
    ++calls.full;
    const double t = at.at("thickness"), L = at.at("length");
    for (std::size_t i = 0; i < s.response.path.size(); ++i) {
      PathPoint& p = s.response.path[i];
      PointGradients& g = s.gradients->path[i];
      g.drive_load *= Truth::of_load(t);
      *g.support_stiffness[0] *= Truth::of_stiffness(L);
      for (std::size_t j = 0; j < names.size(); ++j) {
        const auto k = static_cast<Eigen::Index>(j);
        if (names[j] == "thickness") g.drive_load[k] += p.drive_load * 0.15 / 0.5e-3;
        if (names[j] == "length") (*g.support_stiffness[0])[k] -= *p.support_stiffness[0] * 3;
      }
    }
    Truth::distort(s.response, t, L);
    return s;
  };
}

}  // namespace

TEST_CASE("the verification loop ends at the optimum of full accuracy") {
  const auto [name, exact] = GENERATE(table<std::string, bool>(
      {{"LD_SLSQP", false}, {"LD_SLSQP", true}, {"ipopt", true}, {"LN_COBYLA", false}}));
  CAPTURE(name, exact);
  json document = stiff_guide(name);
  Calls calls;
  const Optimum truth = run(
      document, {two_models(calls, true), by_differences});  // optimised on full accuracy itself
  REQUIRE(truth.status == OptimumStatus::optimal);

  document["optimise"]["verify"] = {{"tolerance", 5e-4}};
  Calls mine;
  const Optimum o = run(document, {two_models(mine), exact ? two_gradients(mine) : by_differences});
  INFO(o.stop_reason);
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.at_full_accuracy);
  REQUIRE(o.verified);
  REQUIRE(o.verified->loop);
  const VerificationLoop& loop = *o.verified->loop;
  INFO(loop.message);
  CHECK(loop.converged);
  CHECK(loop.iterations >= 1);
  CHECK(loop.steps.size() <= 6);
  CHECK(loop.steps.front().difference > 0.05);
  CHECK(loop.difference <= 5e-4);
  CHECK(mine.full == static_cast<int>(loop.steps.size()) + 1);  // once for the path
  // the verified path is that of the values, the one beside it that of the job's model
  const auto least = [](const StrokeResponse& of) {
    double k = 1e99;
    for (const PathPoint& p : of.path) k = std::min(k, *p.support_stiffness[0]);
    return k;
  };
  CHECK(least(o.verified->response) == Approx(o.objective).epsilon(1e-12));
  CHECK(std::abs(least(o.response) / o.objective - 1) > 0.05);
  CHECK(o.objective == Approx(truth.objective).epsilon(1e-3));
  CHECK(o.parameters.at("length") == Approx(truth.parameters.at("length")).epsilon(2e-3));
  CHECK(o.parameters.at("thickness") == Approx(truth.parameters.at("thickness")).epsilon(2e-3));
  CHECK(o.verified->objective == Approx(o.objective).epsilon(1e-12));
  CHECK(std::abs(o.verified->objective_difference) > 0.05);  // of the model as it is
  CHECK(o.constraints[1].value <= 7.5 * (1 + 1e-4));
  CHECK(o.constraints[1].active);
  if (name != "LN_COBYLA") {
    REQUIRE(o.constraints[1].multiplier);
    CHECK(*o.constraints[1].multiplier ==
          Approx(*truth.constraints[1].multiplier).epsilon(exact ? 1e-2 : 0.2));
  }
  int full = 0;
  for (const EvaluationRecord& r : o.history) full += r.full ? 1 : 0;
  CHECK(full == static_cast<int>(loop.steps.size()));
}

TEST_CASE("a model that is right is verified by one evaluation") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["constraints"][1]["max"] = "8 N";
  document["optimise"]["verify"] = json::object();
  document["model"]["accuracy"] = "full";  // the same on both sides
  const Optimum o = run(document);
  REQUIRE(o.verified->loop);
  CHECK(o.verified->loop->converged);
  CHECK(o.verified->loop->iterations == 0);
  CHECK(o.verified->loop->steps.size() == 1);
  CHECK(o.verified->loop->difference == 0);
}

TEST_CASE("the budget of full evaluations is kept, and said") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["verify"] = {{"tolerance", 1e-9}, {"max_full_evaluations", 2}};
  Calls calls;
  const Optimum o = run(document, {two_models(calls), by_differences});
  REQUIRE(o.verified->loop);
  CHECK_FALSE(o.verified->loop->converged);
  CHECK(o.verified->loop->steps.size() == 2);
  CHECK_THAT(o.verified->loop->message, Contains("2 evaluations at full accuracy are spent"));
  CHECK(o.status != OptimumStatus::optimal);
}

TEST_CASE("full accuracy without equilibrium at the optimum is said") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["verify"] = json::object();
  Calls calls;
  // the optimum has 150 MPa
  const Optimum o = run(document, {two_models(calls, false, 100e6), by_differences});
  CHECK(o.status == OptimumStatus::feasible);
  CHECK_FALSE(o.at_full_accuracy);
  CHECK_THAT(o.stop_reason, Contains("full accuracy has no value") && Contains("no equilibrium"));
  REQUIRE(o.verified->loop);
  CHECK_FALSE(o.verified->loop->steps.front().ok);
}

TEST_CASE("stock sizes stay while full accuracy is approached") {
  json document = stiff_guide("LD_SLSQP");
  document["optimise"]["variables"][1]["stock"] = {"0.46 mm"};
  document["optimise"]["verify"] = json::object();
  Calls calls;
  const Optimum o = run(document, {two_models(calls), by_differences});
  CHECK(o.status == OptimumStatus::optimal);
  CHECK(o.parameters.at("thickness") == 0.46e-3);
  // 60e6 (t/L)³ q(t) = 7.5
  CHECK(o.parameters.at("length") ==
        Approx(0.46e-3 * std::cbrt(60e6 * Truth::of_load(0.46e-3) / 7.5)).epsilon(1e-3));
}

TEST_CASE("infeasible starts are brought to feasibility first") {
  json document = stiff_guide("LD_SLSQP");
  document["design"]["parameters"]["thickness"] = "0.9 mm";  // 65 times the load
  document["design"]["parameters"]["length"] = "52 mm";
  document["optimise"]["constraints"].erase(2);
  const Optimum o = run(document);
  REQUIRE(o.status == OptimumStatus::optimal);
  CHECK(o.history.front().violation > 1);
  // the violation falls to nothing before the objective leads
  std::size_t first = 0;
  while (first < o.history.size() &&
         (o.history[first].difference || o.history[first].violation > 1e-4))
    ++first;
  CHECK(first < 40);
  CHECK(o.starts[0].kkt);
  CHECK(o.starts[0].agrees);
  CHECK(o.agreeing_starts == 1);
}
