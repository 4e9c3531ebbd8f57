// The algorithms on problems whose optima and multipliers are known.
#include <numbers>

#include "tests/optim/optim_tests.hpp"
#include "tests/optim/solvers/problems.hpp"

using test::options, test::posed, test::Dual, test::Duals;

namespace {

/// Rosenbrock's function in the disk x² + y² ≤ 1.5: the optimum lies on the circle.
Problem rosenbrock_in_disk() {
  return posed(VectorXd{{-1.5, -1.5}}, VectorXd{{1.5, 1.5}}, 1,
               [](const Duals& x, Dual& f, Duals& c) {
                 f = pow(1 - x[0], 2) + 100 * pow(x[1] - x[0] * x[0], 2);
                 c[0] = x[0] * x[0] + x[1] * x[1] - 1.5;
               });
}
const VectorXd in_disk{{-0.5, 0.5}};  // where searches begin, with f = 8.5

/// On the circle x = √1.5 (cos φ, sin φ) by Newton in φ: the reference that the algorithms must
/// hit.
VectorXd rosenbrock_optimum() {
  const double r = std::sqrt(1.5);
  double best = 1e9;
  VectorXd place;
  for (int i = 0; i < 100000; ++i) {
    const double phi = 0.5 * std::numbers::pi * i / 100000, x = r * std::cos(phi),
                 y = r * std::sin(phi), f = std::pow(1 - x, 2) + 100 * std::pow(y - x * x, 2);
    if (f < best) best = f, place = VectorXd{{x, y}};
  }
  return place;
}

/// HS071 [Hock and Schittkowski 1981, no. 71]; of its equality |x|² = 40 the side |x|² ≤ 40 holds
/// the optimum.
Problem hs071() {
  return posed(VectorXd::Ones(4), VectorXd::Constant(4, 5.0), 2,
               [](const Duals& x, Dual& f, Duals& c) {
                 f = x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2];
                 c[0] = (25 - x[0] * x[1] * x[2] * x[3]) / 25;
                 c[1] = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] - 40) / 40;
               });
}

/// max min(f1, f2), f1 = 1 + x − y²/2 rising, f2 = 2 − x − (y − 0.5)² falling, as
/// max t, t ≤ f1, t ≤ f2: the optimum sits on the kink f1 = f2.
Problem kink() {
  const double inf = std::numeric_limits<double>::infinity();
  return posed(VectorXd{{-1, -1, -inf}}, VectorXd{{2, 2, inf}}, 2,
               [](const Duals& x, Dual& f, Duals& c) {
                 f = -x[2];
                 c[0] = x[2] - (1 + x[0] - 0.5 * x[1] * x[1]);
                 c[1] = x[2] - (2 - x[0] - pow(x[1] - 0.5, 2));
               });
}

/// min (x − 2)² + y² where only x² + y² < 1 − 0.2 y can be evaluated, and x ≤ 0.9 is asked for: the
/// way to the optimum (0.9, 0) runs past the edge of what works.
Problem half_blind(int& failures) {
  Problem p = posed(VectorXd{{-2, -2}}, VectorXd{{2, 2}}, 1, [](const Duals& x, Dual& f, Duals& c) {
    f = pow(x[0] - 2, 2) + x[1] * x[1];
    c[0] = x[0] - 0.9;
  });
  p.evaluate = [&failures, inner = p.evaluate](const VectorXd& x, bool gradient) {
    if (x.squaredNorm() < 1 - 0.2 * x[1]) return inner(x, gradient);
    ++failures;
    return Problem::Value{};
  };
  return p;
}

}  // namespace

TEST_CASE("every local algorithm finds the optimum on a curved constraint") {
  const auto name = GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LN_NELDERMEAD",
                             "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt");
  CAPTURE(name);
  const OptimiserSummary s = minimise(rosenbrock_in_disk(), in_disk, options(name));
  INFO(s.message);
  CHECK(s.reason == StopReason::converged);
  CHECK(s.c[0] <= 1e-4);
  // Rosenbrock's valley: f is flat along it, so the place is less sure than the value.
  CHECK((s.x - rosenbrock_optimum()).norm() < 3e-3);
  CHECK(s.evaluations <= 3000);
}

TEST_CASE("HS071 is solved, by gradient methods with its multipliers") {
  const auto name =
      GENERATE(as<std::string>(), "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt", "LN_COBYLA");
  CAPTURE(name);
  const OptimiserSummary s = minimise(hs071(), VectorXd{{1, 5, 5, 1}}, options(name));
  INFO(s.message);
  CHECK(s.reason == StopReason::converged);
  CHECK(s.f == Approx(17.0140173).epsilon(algorithm_of(options(name)).gradients ? 2e-4 : 1e-3));
  REQUIRE(s.multipliers.size() == (algorithm_of(options(name)).gradients ? 2 : 0));
  if (!algorithm_of(options(name)).gradients) return;
  // 0.552294 and 0.161469 of the unscaled constraints [Hock and Schittkowski; Ipopt's manual]
  CHECK(s.multipliers[0] == Approx(0.5522937 * 25).epsilon(2e-3));
  CHECK(s.multipliers[1] == Approx(0.1614686 * 40).epsilon(2e-3));
}

TEST_CASE("a slack variable takes every algorithm that models constraints to the kink") {
  // KKT: λ1 + λ2 = 1, λ1 = λ2 → ½ each; y·½ + 2(y − ½)·½ = 0 → y = 1/3; f1 = f2 → x.
  const double y = 1.0 / 3, x = 0.5 * (1 - std::pow(y - 0.5, 2) + 0.5 * y * y);
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt");
  CAPTURE(name);
  const OptimiserSummary s = minimise(kink(), VectorXd{{-0.5, 1.5, -2}}, options(name));
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

TEST_CASE("every local algorithm steps back from where evaluations fail") {
  const auto name = GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LN_NELDERMEAD",
                             "LD_SLSQP", "LD_MMA", "LD_CCSAQ", "ipopt");
  CAPTURE(name);
  int failures = 0;
  const OptimiserSummary s = minimise(half_blind(failures), VectorXd{{-0.5, 0.6}}, options(name));
  INFO(s.message);
  if (std::string(name) != "ipopt") CHECK(failures > 0);  // its barrier happens to keep away
  CHECK(s.failed_evaluations == failures);
  CHECK(s.reason == StopReason::converged);
  CHECK(s.x[0] == Approx(0.9).margin(2e-3));
  CHECK(s.x[1] == Approx(0.0).margin(2e-2));
  CHECK(s.f == Approx(1.21).epsilon(5e-3));
}

TEST_CASE("a start that fails gives way to a point nearer the middle of the box") {
  int failures = 0;
  const OptimiserSummary s = minimise(half_blind(failures), VectorXd{{-2, 2}}, options("LD_SLSQP"));
  INFO(s.message);
  CHECK(failures >= 3);
  CHECK(s.f == Approx(1.21).epsilon(5e-3));
}

TEST_CASE("an optimum on the edge of what can be evaluated is approached from inside") {
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LD_SLSQP", "LD_MMA", "ipopt");
  CAPTURE(name);
  // min −x, evaluable for x < 0.7 only
  Problem p = posed(VectorXd{{0, 0}}, VectorXd{{1, 1}}, 0,
                    [](const Duals& x, Dual& f, Duals&) { f = -x[0] + pow(x[1] - 0.5, 2); });
  p.evaluate = [inner = p.evaluate](const VectorXd& x, bool gradient) {
    Problem::Value v = inner(x, gradient);
    v.ok = x[0] < 0.7;
    return v;
  };
  const OptimiserSummary s = minimise(p, VectorXd{{0.1, 0.2}}, options(name));
  INFO(s.message);
  CHECK(s.f < -0.69);
  CHECK(s.f >= -0.7);
}

TEST_CASE("nothing that can be evaluated is a status, not an exception") {
  const Problem p{.lower = VectorXd{{0.0}},
                  .upper = VectorXd{{1.0}},
                  .evaluate = [](const VectorXd&, bool) { return Problem::Value{}; }};
  for (const char* name : {"LN_COBYLA", "ipopt"}) {
    const OptimiserSummary s = minimise(p, VectorXd{{0.3}}, options(name));
    CHECK(s.reason == StopReason::failed);
    CHECK(s.failed_evaluations == 5);
    CHECK(s.x.size() == 0);
  }
}

TEST_CASE("global algorithms spend their evaluations and keep the best point") {
  const auto name = GENERATE(as<std::string>(), "GN_ISRES", "GN_ORIG_DIRECT", "GN_ORIG_DIRECT_L");
  CAPTURE(name);
  const OptimiserSummary s = minimise(rosenbrock_in_disk(), in_disk, options(name, 2000));
  INFO(s.message);
  CHECK(s.evaluations <= 2000);
  CHECK(s.c[0] <= 1e-4);
  CHECK(s.f < 0.2);  // 0.002 at best; the start has 8.5
  CHECK(minimise(rosenbrock_in_disk(), in_disk, options(name, 2000)).x == s.x);
}

TEST_CASE("bounded algorithms without constraints work within bounds and refuse constraints") {
  const auto name = GENERATE(as<std::string>(), "GN_DIRECT", "GN_DIRECT_L", "GN_CRS2_LM");
  CAPTURE(name);
  Problem p = rosenbrock_in_disk();
  CHECK_THROWS_WITH(minimise(p, VectorXd{{0, 0}}, options(name)),
                    Contains("/optimise/algorithm/name = " + name) &&
                        Contains("takes no constraints") && Contains("LN_COBYLA"));
  p.constraints = 0;
  p.evaluate = [constrained = p.evaluate](const VectorXd& x, bool gradient) {
    Problem::Value v = constrained(x, gradient);
    v.c.resize(0);
    v.dc.resize(0, 2);
    return v;
  };
  const OptimiserSummary s = minimise(p, in_disk, options(name));
  CHECK(s.f < 0.2);  // 0 at (1, 1); the start has 8.5
}

TEST_CASE("the budget of evaluations is kept") {
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LN_NELDERMEAD", "LD_SLSQP", "LD_MMA", "ipopt");
  CAPTURE(name);
  int calls = 0;
  Problem p = rosenbrock_in_disk();
  p.evaluate = [&, evaluate = p.evaluate](const VectorXd& x, bool gradient) {
    ++calls;
    return evaluate(x, gradient);
  };
  const OptimiserSummary s = minimise(p, in_disk, options(name, 12));
  INFO(s.message);
  CHECK(s.reason == StopReason::max_evaluations);
  CHECK(calls <= 13);  // one more for the multipliers
  CHECK(s.f <= 8.5);   // no worse than the start
}

TEST_CASE("wherever its evaluations end, an augmented Lagrangian says so", "[slow]") {
  const auto name = GENERATE(as<std::string>(), "LD_AUGLAG", "LN_AUGLAG");
  for (int budget = 2; budget <= 80; ++budget) {
    CAPTURE(name, budget);
    const OptimiserSummary s = minimise(rosenbrock_in_disk(), in_disk, options(name, budget));
    INFO(s.message);
    CHECK((s.reason == StopReason::max_evaluations || s.reason == StopReason::converged));
    CHECK(s.f <= 8.5);
  }
}

TEST_CASE("what the problem throws comes out of every library") {
  const auto name =
      GENERATE(as<std::string>(), "LN_COBYLA", "LN_SBPLX", "LD_SLSQP", "LD_MMA", "ipopt");
  CAPTURE(name);
  int calls = 0;
  Problem p = rosenbrock_in_disk();
  p.evaluate = [&, evaluate = p.evaluate](const VectorXd& x, bool gradient) {
    if (++calls == 5) throw std::runtime_error("the disk is full");
    return evaluate(x, gradient);
  };
  CHECK_THROWS_WITH(minimise(p, in_disk, options(name)), "the disk is full");
}

TEST_CASE("unknown libraries and algorithms are refused with what there is") {
  OptimiserOptions o;
  o.library = "matlab";
  CHECK_THROWS_WITH(algorithm_of(o).gradients,
                    Contains("/optimise/algorithm/library = matlab") && Contains("nlopt or ipopt"));
  o.library = "nlopt";
  o.name = "LD_SLSQ";
  CHECK_THROWS_AS(minimise(rosenbrock_in_disk(), in_disk, o), SpecError);
  CHECK_THROWS_WITH(minimise(rosenbrock_in_disk(), in_disk, o),
                    Contains("LD_SLSQP") && Contains("GN_ISRES"));
  CHECK(algorithms().size() == 21);
}

TEST_CASE("SLSQP and Ipopt stay within the move limit of what they know") {
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
  OptimiserOptions o = options(name, OptimiserOptions{}.max_evaluations);
  o.tolerance = OptimiserOptions{}.tolerance;
  o.move_limit = 0.1;
  const OptimiserSummary s = minimise(p, VectorXd{{-1.2, 1}}, o);
  INFO(s.message);
  CHECK(farthest > 0);
  CHECK(farthest <= 0.1);
  CHECK(s.reason == StopReason::converged);
  CHECK((s.x - rosenbrock_optimum()).norm() < 1e-3);
}
