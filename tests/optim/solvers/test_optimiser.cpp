// The algorithms on problems whose optima and multipliers are known.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/spec/spec_error.hpp"
#include "optim/solvers/multipliers.hpp"
#include "optim/solvers/problem.hpp"

using namespace flexopt;

namespace {

VectorXd vector(std::initializer_list<double> values) {
  VectorXd v(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), v.data());
  return v;
}

/// Rosenbrock's function in the disk x² + y² ≤ 1.5: the optimum lies on the circle.
Problem rosenbrock_in_disk() {
  Problem p;
  p.lower = vector({-1.5, -1.5});
  p.upper = vector({1.5, 1.5});
  p.constraints = 1;
  p.evaluate = [](const VectorXd& x, bool gradient) {
    Problem::Value v;
    v.ok = true;
    const double a = 1 - x[0], b = x[1] - x[0] * x[0];
    v.f = a * a + 100 * b * b;
    v.c = vector({x.squaredNorm() - 1.5});
    if (gradient) {
      v.df = vector({-2 * a - 400 * x[0] * b, 200 * b});
      v.dc = 2 * x.transpose();
    }
    return v;
  };
  return p;
}

/// On the circle x = √1.5 (cos φ, sin φ) by Newton in φ: the reference that the algorithms must
/// hit.
VectorXd rosenbrock_optimum() {
  const double r = std::sqrt(1.5);
  double best = 1e9, phi = 0;
  const auto f = [&](double t) {
    const double x = r * std::cos(t), y = r * std::sin(t);
    return std::pow(1 - x, 2) + 100 * std::pow(y - x * x, 2);
  };
  for (int i = 0; i < 100000; ++i) {
    const double t = 0.5 * std::numbers::pi * i / 100000;
    if (f(t) < best) best = f(t), phi = t;
  }
  return vector({r * std::cos(phi), r * std::sin(phi)});
}

/// HS071 [Hock and Schittkowski 1981, no. 71]; of its equality |x|² = 40 the side |x|² ≤ 40 holds
/// the optimum.
Problem hs071() {
  Problem p;
  p.lower = VectorXd::Ones(4);
  p.upper = VectorXd::Constant(4, 5.0);
  p.constraints = 2;
  p.evaluate = [](const VectorXd& x, bool gradient) {
    Problem::Value v;
    v.ok = true;
    v.f = x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2];
    v.c = vector({(25 - x.prod()) / 25, (x.squaredNorm() - 40) / 40});
    if (gradient) {
      v.df = vector({x[3] * (2 * x[0] + x[1] + x[2]), x[0] * x[3], x[0] * x[3] + 1,
                     x[0] * (x[0] + x[1] + x[2])});
      v.dc.resize(2, 4);
      for (int j = 0; j < 4; ++j) v.dc(0, j) = -x.prod() / x[j] / 25, v.dc(1, j) = x[j] / 20;
    }
    return v;
  };
  return p;
}

/// max min(f1, f2), f1 = 1 + x − y²/2 rising, f2 = 2 − x − (y − 0.5)² falling, as
/// max t, t ≤ f1, t ≤ f2: the optimum sits on the kink f1 = f2.
Problem kink() {
  Problem p;
  const double inf = std::numeric_limits<double>::infinity();
  p.lower = vector({-1, -1, -inf});
  p.upper = vector({2, 2, inf});
  p.constraints = 2;
  p.evaluate = [](const VectorXd& x, bool gradient) {
    Problem::Value v;
    v.ok = true;
    v.f = -x[2];
    const double f1 = 1 + x[0] - 0.5 * x[1] * x[1], f2 = 2 - x[0] - std::pow(x[1] - 0.5, 2);
    v.c = vector({x[2] - f1, x[2] - f2});
    if (gradient) {
      v.df = vector({0, 0, -1});
      v.dc.resize(2, 3);
      v.dc << -1, x[1], 1, 1, 2 * (x[1] - 0.5), 1;
    }
    return v;
  };
  return p;
}

/// min (x − 2)² + y² where only x² + y² < 1 − 0.2 y can be evaluated, and x ≤ 0.9 is asked for: the
/// way to the optimum (0.9, 0) runs past the edge of what works.
Problem half_blind(int& failures) {
  Problem p;
  p.lower = vector({-2, -2});
  p.upper = vector({2, 2});
  p.constraints = 1;
  p.evaluate = [&failures](const VectorXd& x, bool gradient) {
    Problem::Value v;
    if (x.squaredNorm() >= 1 - 0.2 * x[1]) {
      ++failures;
      return v;
    }
    v.ok = true;
    v.f = std::pow(x[0] - 2, 2) + x[1] * x[1];
    v.c = vector({x[0] - 0.9});
    if (gradient) {
      v.df = vector({2 * (x[0] - 2), 2 * x[1]});
      v.dc.resize(1, 2);
      v.dc << 1, 0;
    }
    return v;
  };
  return p;
}

OptimiserOptions options(const std::string& name, int evaluations = 3000) {
  OptimiserOptions o;
  o.library = name == "ipopt" ? "ipopt" : "nlopt";
  o.name = name == "ipopt" ? "" : name;
  o.max_evaluations = evaluations;
  o.tolerance = 1e-6;
  return o;
}

}  // namespace

TEST_CASE("every local algorithm finds the optimum on a curved constraint", "[optim]") {
  const auto name = GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LN_NELDERMEAD",
                             "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt");
  CAPTURE(name);
  const OptimiserSummary s = minimise(rosenbrock_in_disk(), vector({-0.5, 0.5}), options(name));
  INFO(s.message);
  CHECK(s.reason == StopReason::converged);
  CHECK(s.c[0] <= 1e-4);
  // Rosenbrock's valley: f is flat along it, so the place is less sure than the value.
  CHECK((s.x - rosenbrock_optimum()).norm() < 3e-3);
  CHECK(s.evaluations <= 3000);
}

TEST_CASE("gradient methods give the multipliers of HS071", "[optim]") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt");
  CAPTURE(name);
  const OptimiserSummary s = minimise(hs071(), vector({1, 5, 5, 1}), options(name));
  INFO(s.message);
  CHECK(s.reason == StopReason::converged);
  CHECK(s.f == Approx(17.0140173).epsilon(2e-4));
  REQUIRE(s.multipliers.size() == 2);
  // 0.552294 and 0.161469 of the unscaled constraints [Hock and Schittkowski; Ipopt's manual]
  CHECK(s.multipliers[0] == Approx(0.5522937 * 25).epsilon(2e-3));
  CHECK(s.multipliers[1] == Approx(0.1614686 * 40).epsilon(2e-3));
}

TEST_CASE("COBYLA solves HS071 without gradients", "[optim]") {
  const OptimiserSummary s = minimise(hs071(), vector({1, 5, 5, 1}), options("LN_COBYLA"));
  INFO(s.message);
  CHECK(s.reason == StopReason::converged);
  CHECK(s.f == Approx(17.0140173).epsilon(1e-3));
  CHECK(s.multipliers.size() == 0);
}

TEST_CASE("a slack variable takes every algorithm that models constraints to the kink", "[optim]") {
  // KKT: λ1 + λ2 = 1, λ1 = λ2 → ½ each; y·½ + 2(y − ½)·½ = 0 → y = 1/3; f1 = f2 → x.
  const double y = 1.0 / 3, x = 0.5 * (1 - std::pow(y - 0.5, 2) + 0.5 * y * y);
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt");
  CAPTURE(name);
  const OptimiserSummary s = minimise(kink(), vector({-0.5, 1.5, -2}), options(name));
  INFO(s.message);
  CHECK(algorithm_of(options(name)).slack);
  CHECK(s.reason == StopReason::converged);
  // The tolerated violation, 3e-5, moves a flat optimum by √(3e-5 / 0.75).
  CHECK(s.x[0] == Approx(x).margin(6e-3));
  CHECK(s.x[1] == Approx(y).margin(6e-3));
  CHECK(-s.f == Approx(1 + x - 0.5 * y * y).epsilon(2e-4));
  if (!algorithm_of(options(name)).gradients) return;
  CHECK(s.multipliers[0] == Approx(0.5).margin(5e-3));
  CHECK(s.multipliers[1] == Approx(0.5).margin(5e-3));
}

TEST_CASE("every local algorithm steps back from where evaluations fail", "[optim]") {
  const auto name = GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LN_NELDERMEAD",
                             "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt");
  CAPTURE(name);
  int failures = 0;
  const OptimiserSummary s = minimise(half_blind(failures), vector({-0.5, 0.6}), options(name));
  INFO(s.message);
  if (std::string(name) != "ipopt") CHECK(failures > 0);  // its barrier happens to keep away
  CHECK(s.failed_evaluations == failures);
  CHECK(s.reason == StopReason::converged);
  CHECK(s.x[0] == Approx(0.9).margin(2e-3));
  CHECK(s.x[1] == Approx(0.0).margin(2e-2));
  CHECK(s.f == Approx(1.21).epsilon(5e-3));
}

TEST_CASE("a start that fails gives way to a point nearer the middle of the box", "[optim]") {
  int failures = 0;
  const OptimiserSummary s = minimise(half_blind(failures), vector({-2, 2}), options("LD_SLSQP"));
  INFO(s.message);
  CHECK(failures >= 3);
  CHECK(s.f == Approx(1.21).epsilon(5e-3));
}

TEST_CASE("an optimum on the edge of what can be evaluated is approached from inside", "[optim]") {
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LD_SLSQP", "LD_MMA", "ipopt");
  CAPTURE(name);
  Problem p;  // min −x, evaluable for x < 0.7 only
  p.lower = vector({0, 0});
  p.upper = vector({1, 1});
  p.evaluate = [](const VectorXd& x, bool gradient) {
    Problem::Value v;
    v.ok = x[0] < 0.7;
    v.f = -x[0] + std::pow(x[1] - 0.5, 2);
    if (gradient) v.df = vector({-1, 2 * (x[1] - 0.5)});
    v.dc.resize(0, 2);
    return v;
  };
  const OptimiserSummary s = minimise(p, vector({0.1, 0.2}), options(name));
  INFO(s.message);
  CHECK(s.f < -0.69);
  CHECK(s.f >= -0.7);
}

TEST_CASE("nothing that can be evaluated is a status, not an exception", "[optim]") {
  Problem p;
  p.lower = vector({0});
  p.upper = vector({1});
  p.evaluate = [](const VectorXd&, bool) { return Problem::Value{}; };
  for (const char* name : {"LN_COBYLA", "ipopt"}) {
    const OptimiserSummary s = minimise(p, vector({0.3}), options(name));
    CHECK(s.reason == StopReason::failed);
    CHECK(s.failed_evaluations == 5);
    CHECK(s.x.size() == 0);
  }
}

TEST_CASE("global algorithms spend their evaluations and keep the best point", "[optim]") {
  const auto name = GENERATE(as<std::string>(), "GN_ISRES", "GN_ORIG_DIRECT", "GN_ORIG_DIRECT_L");
  CAPTURE(name);
  const OptimiserSummary s =
      minimise(rosenbrock_in_disk(), vector({-0.5, 0.5}), options(name, 2000));
  INFO(s.message);
  CHECK(s.evaluations <= 2000);
  CHECK(s.c[0] <= 1e-4);
  CHECK(s.f < 0.2);  // 0.002 at best; the start has 8.5
  const OptimiserSummary again =
      minimise(rosenbrock_in_disk(), vector({-0.5, 0.5}), options(name, 2000));
  CHECK(again.x == s.x);
}

TEST_CASE("bounded algorithms without constraints work within bounds and refuse constraints",
          "[optim]") {
  const auto name = GENERATE(as<std::string>(), "GN_DIRECT", "GN_DIRECT_L", "GN_CRS2_LM");
  CAPTURE(name);
  Problem p = rosenbrock_in_disk();
  CHECK_THROWS_WITH(minimise(p, vector({0, 0}), options(name)),
                    Catch::Contains("/optimise/algorithm/name = " + name) &&
                        Catch::Contains("takes no constraints") && Catch::Contains("LN_COBYLA"));
  p.constraints = 0;
  const auto constrained = p.evaluate;
  p.evaluate = [constrained](const VectorXd& x, bool gradient) {
    Problem::Value v = constrained(x, gradient);
    v.c.resize(0);
    v.dc.resize(0, 2);
    return v;
  };
  const OptimiserSummary s = minimise(p, vector({-0.5, 0.5}), options(name, 3000));
  CHECK(s.f < 0.2);  // 0 at (1, 1); the start has 8.5
}

TEST_CASE("the budget of evaluations is kept", "[optim]") {
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LN_NELDERMEAD", "LD_SLSQP", "LD_MMA", "ipopt");
  CAPTURE(name);
  int calls = 0;
  Problem p = rosenbrock_in_disk();
  const auto evaluate = p.evaluate;
  p.evaluate = [&](const VectorXd& x, bool gradient) {
    ++calls;
    return evaluate(x, gradient);
  };
  const OptimiserSummary s = minimise(p, vector({-0.5, 0.5}), options(name, 12));
  INFO(s.message);
  CHECK(s.reason == StopReason::max_evaluations);
  CHECK(calls <= 13);  // one more for the multipliers
  CHECK(s.f <= 8.5);   // no worse than the start
}

TEST_CASE("wherever its evaluations end, an augmented Lagrangian says so", "[optim][slow]") {
  const auto name = GENERATE(as<std::string>(), "LD_AUGLAG", "LN_AUGLAG");
  for (int budget = 2; budget <= 80; ++budget) {
    CAPTURE(name, budget);
    const OptimiserSummary s =
        minimise(rosenbrock_in_disk(), vector({-0.5, 0.5}), options(name, budget));
    INFO(s.message);
    CHECK((s.reason == StopReason::max_evaluations || s.reason == StopReason::converged));
    CHECK(s.f <= 8.5);
  }
}

TEST_CASE("what the problem throws comes out of every library", "[optim]") {
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LD_SLSQP", "LD_MMA", "ipopt");
  CAPTURE(name);
  int calls = 0;
  Problem p = rosenbrock_in_disk();
  const auto evaluate = p.evaluate;
  p.evaluate = [&](const VectorXd& x, bool gradient) {
    if (++calls == 5) throw std::runtime_error("the disk is full");
    return evaluate(x, gradient);
  };
  CHECK_THROWS_WITH(minimise(p, vector({-0.5, 0.5}), options(name)), "the disk is full");
}

TEST_CASE("unknown libraries and algorithms are refused with what there is", "[optim]") {
  OptimiserOptions o;
  o.library = "matlab";
  CHECK_THROWS_WITH(
      algorithm_of(o).gradients,
      Catch::Contains("/optimise/algorithm/library = matlab") && Catch::Contains("nlopt or ipopt"));
  o.library = "nlopt";
  o.name = "LD_SLSQ";
  CHECK_THROWS_AS(minimise(rosenbrock_in_disk(), vector({0, 0}), o), SpecError);
  CHECK_THROWS_WITH(minimise(rosenbrock_in_disk(), vector({0, 0}), o),
                    Catch::Contains("LD_SLSQP") && Catch::Contains("GN_ISRES"));
  CHECK(algorithms().size() == 21);
}

TEST_CASE("SLSQP and Ipopt stay within the move limit of what they know", "[optim]") {
  const auto name = GENERATE(as<std::string>(), "LD_SLSQP", "ipopt");
  CAPTURE(name);
  Problem p = rosenbrock_in_disk();
  std::vector<VectorXd> known;
  double farthest = 0;
  p.evaluate = [&, inner = p.evaluate](const VectorXd& x, bool gradient) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const VectorXd& from : known)
      nearest = std::min(nearest, (x - from).lpNorm<Eigen::Infinity>());
    if (!known.empty()) farthest = std::max(farthest, nearest);
    if (gradient) known.push_back(x);
    return inner(x, gradient);
  };
  OptimiserOptions o;
  o.library = name == "ipopt" ? "ipopt" : "nlopt";
  if (name != "ipopt") o.name = name;
  o.move_limit = 0.1;
  const OptimiserSummary s = minimise(p, vector({-1.2, 1}), o);
  INFO(s.message);
  CHECK(farthest > 0);
  CHECK(farthest <= 0.1);
  CHECK(s.reason == StopReason::converged);
  CHECK((s.x - rosenbrock_optimum()).norm() < 1e-3);
}
