#include "optim/problem/robust_goals.hpp"

#include "optim/problem/design_problem.hpp"
#include "optim/problem/evaluation_book.hpp"
#include "tests/optim/guide_job.hpp"

namespace {

json document() {
  return test::guide_job(R"J({
    "design": {"parameters": {"width": {"expression": "length/3"}, "thickness": "0.4 mm"}},
    "model": {"mesh": [4, 2]}, "stroke": {"from": "-3 mm", "to": "5 mm", "points": 3},
    "frequencies": 3,
    "tolerances": {"thickness": {"plus_minus": "2 %", "distribution": "normal"},
                   "length": "50 um", "width": "0.1 mm", "material.youngs_modulus": "3 %"},
    "optimise": {
      "variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "1 mm"},
                    {"parameter": "length", "min": "60 mm", "max": "120 mm"}],
      "constraints": [{"quantity": "max_stress", "max": "400 MPa"},
                      {"quantity": "drive_load", "over_stroke": "max_abs", "max": "6 N"},
                      {"quantity": "support_stiffness.uz", "min": "1 N/mm"},
                      {"expression": "length*thickness", "max": "100 mm^2"},
                      {"expression": "support_stiffness.uz/drive_stiffness*(length/thickness)",
                       "min": 1}]}})J");
}

json under_tolerances(const std::string& as) {
  json robust = document();
  robust["optimise"]["objective"].update({{"under", "tolerances"}, {"as", as}});
  for (json& c : robust["optimise"]["constraints"]) c.update({{"under", "tolerances"}, {"as", as}});
  return robust;
}

const Variables at{0.45e-3, 0.09};

/// One number for each point of each goal: the sum of its candidates, which may change ranks.
VectorXd by_points(const DesignProblem& problem, const DesignValues& values, const VectorXd& all) {
  std::vector<double> sums;
  Eigen::Index row = 0;
  for (std::size_t g = 0; g < values.goals.size(); ++g) {
    const Eigen::Index branches = problem.goals()[g].branches,
                       end = row + static_cast<Eigen::Index>(values.goals[g].size());
    for (; row < end; row += branches) sums.push_back(all.segment(row, branches).sum());
  }
  return Eigen::Map<const VectorXd>(sums.data(), static_cast<Eigen::Index>(sums.size()));
}
VectorXd by_points(const DesignProblem& problem, const DesignValues& values) {
  return by_points(problem, values, flattened(values));
}

}  // namespace

TEST_CASE("the margin of a value is its farthest, or its standard deviations") {
  const std::vector<Tolerance> entries{{"a", ToleranceSpread::uniform, {}},
                                       {"b", ToleranceSpread::normal, {}}};
  const VectorXd slopes = (VectorXd(2) << 3, -4).finished();
  const ToleranceMargin worst{ToleranceMargin::Kind::worst, 0},
      two{ToleranceMargin::Kind::deviations, 2};
  CHECK(tolerance_margin(worst, entries, slopes) == 7);
  CHECK(tolerance_margin(two, entries, slopes) ==
        Approx(2 * std::sqrt(9.0 / 3 + 16.0 / 9)).epsilon(1e-14));
  for (const ToleranceMargin& margin : {worst, two}) {
    const VectorXd c = margin_weights(margin, entries, slopes);
    CHECK(c.dot(slopes) == Approx(tolerance_margin(margin, entries, slopes)));  // homogeneous
    for (Eigen::Index e = 0; e < 2; ++e) {
      VectorXd more = slopes;
      more[e] += 1e-6;
      CHECK(c[e] == Approx((tolerance_margin(margin, entries, more) -
                            tolerance_margin(margin, entries, slopes)) /
                           1e-6)
                        .epsilon(1e-5));
    }
    CHECK(margin_weights(margin, entries, VectorXd::Zero(2)).isZero());
  }
}

TEST_CASE("goals under tolerances are the nominal ones and what first-order derivatives say") {
  const DesignProblem nominal(parse_job(document())),
      robust(parse_job(under_tolerances("mean + 2 sigma")));
  const DesignValues plain = nominal.evaluate(at, true), margins = robust.evaluate(at);
  REQUIRE(plain.ok);
  REQUIRE(margins.ok);
  CHECK(margins.gradient.size() == 0);
  // thickness, length and the formula's width deviate each by itself; E scales what is a load
  const ParameterValues parameters = robust.parameters(at);
  const std::vector<std::string> names{"length", "material.youngs_modulus", "thickness", "width"};
  const double uniform = 1 / std::sqrt(3.0);
  const std::vector<double> sigma{50e-6 * uniform,
                                  0.03 * parameters.at("material.youngs_modulus") * uniform,
                                  0.02 * at[0] / 3, 0.1e-3 * uniform};
  const StrokeSensitivity exact =
      Evaluators().gradients(robust.job(), parameters, names, robust.job().model, robust.request());
  REQUIRE(exact.gradients);
  for (std::size_t g = 0; g < 4; ++g) {
    const GoalReading reading =
        read_goal(robust.goals()[g], exact.response, robust.request(), &*exact.gradients).value();
    REQUIRE(reading.gradient.rows() > 0);
    for (std::size_t i = 0; i < reading.values.size(); ++i) {
      double variance = 0;
      for (std::size_t j = 0; j < names.size(); ++j)
        variance += std::pow(
            reading.gradient(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * sigma[j],
            2);
      const double m = 2 * std::sqrt(variance), v = plain.goals[g][i];
      const bool smaller = g == 0 || g == 3;
      CHECK(margins.goals[g][i] == Approx(smaller || v < 0 ? v - m : v + m).epsilon(1e-9));
    }
  }
  const double product = at[0] * at[1];  // the formula: (σ_l t)² + (σ_t l)²
  CHECK(margins.goals[4][0] ==
        Approx(product + 2 * std::hypot(sigma[0] * at[0], sigma[2] * at[1])).epsilon(1e-12));
  CHECK(*robust.formula(4, at) == Approx(margins.goals[4][0]).epsilon(1e-14));
}

TEST_CASE("derivatives of goals under tolerances are those of their values") {
  for (const std::string as : {"worst", "mean + 3 sigma"}) {
    INFO(as);
    json job = under_tolerances(as);
    job["tolerances"]["mismatch"] = {
        {"plus_minus", "1 %"}, {"parameters", {{"thickness", 1}}}, {"each", "leaf"}};
    const DesignProblem robust(parse_job(job));
    const DesignValues exact = robust.evaluate(at, true), values = robust.evaluate(at);
    REQUIRE(exact.ok);
    REQUIRE(exact.no_gradient == "");
    REQUIRE(exact.gradient.rows() > 0);
    CHECK(exact.goals == values.goals);
    for (std::size_t j = 0; j < at.size(); ++j) {
      const double h = 1e-4 * at[j];
      Variables up = at, down = at;
      up[j] += h, down[j] -= h;
      const VectorXd difference =
          (by_points(robust, robust.evaluate(up)) - by_points(robust, robust.evaluate(down))) /
          (2 * h);
      const VectorXd derivative =
          by_points(robust, exact, exact.gradient.col(static_cast<Eigen::Index>(j)));
      const VectorXd size = by_points(robust, values);
      for (Eigen::Index i = 0; i < difference.size(); ++i) {
        INFO("point " << i << " by variable " << j);
        CHECK(derivative[i] ==
              Approx(difference[i]).epsilon(1e-5).margin(1e-6 * std::abs(size[i]) / at[j]));
      }
    }
  }
}

TEST_CASE("a goal that bears tolerances but has no derivatives fails with the reason") {
  const DesignProblem robust(parse_job(under_tolerances("worst")),
                             Evaluators(evaluate_stroke, by_differences));
  const DesignValues values = robust.evaluate(at);
  CHECK_FALSE(values.ok);
  CHECK(values.message.find("tolerances cannot be counted") != std::string::npos);
}
