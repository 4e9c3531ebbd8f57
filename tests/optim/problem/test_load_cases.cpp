// Goals over several load cases, against the goals of each case alone.
#include "optim/problem/check_gradients.hpp"
#include "optim/problem/design_problem.hpp"
#include "optim/problem/goals.hpp"
#include "optim/search/optimise.hpp"
#include "tests/optim/guide_job.hpp"

namespace {

json document() {
  return test::guide_job(R"({
    "design": {"parameters": {"thickness": "0.4 mm"}}, "model": {"mesh": [4, 2]},
    "stroke": {"to": "5 mm", "points": 3},
    "cases": {
      "hanging": {"loads": [{"force": ["40 N", 0, 0]}]},
      "standing": {"loads": [{"force": ["-40 N", 0, 0]}], "stroke": {"to": "8 mm", "points": 2}}},
    "optimise": {
      "variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "1 mm"},
                    {"parameter": "length", "min": "60 mm", "max": "120 mm"}],
      "constraints": [{"quantity": "max_stress", "max": "400 MPa"},
                      {"quantity": "drive_load", "over_stroke": "max_abs", "max": "6 N",
                       "case": "hanging"},
                      {"quantity": "drive_load", "over_stroke": "last", "min": "1 N"}]}})");
}

/// The job under one load case alone.
Job alone(const std::string& name) {
  json one = document();
  const json own = one["cases"][name];
  one.erase("cases");
  one["optimise"]["constraints"][1].erase("case");
  for (const auto& [key, value] : own.items()) one[key] = value;
  return parse_job(one);
}

}  // namespace

TEST_CASE("the number of a goal over load cases is the worst of theirs") {
  Goal goal{"", "drive_load", {}, OverStroke::last, 1, {{0, 2}, {1, 3}}, false};
  const GoalValues v{1, 4, 7, 8, 3};
  CHECK(aggregate(goal, v) == 4);
  CHECK(extreme(goal, v).entry == 1);
  CHECK(place_of(goal, 1).load_case == 0);
  goal.least = true;
  CHECK(aggregate(goal, v) == 3);
  CHECK(place_of(goal, 4).load_case == 1);
  CHECK(place_of(goal, 4).point == 2);
  goal.over_stroke = OverStroke::max;  // the best point of the worst case
  CHECK(aggregate(goal, v) == 4);
  goal.least = false;
  CHECK(aggregate(goal, v) == 8);
}

TEST_CASE("goals over load cases have the values and exact derivatives of each case") {
  const DesignProblem both(parse_job(document())), hanging(alone("hanging")),
      standing(alone("standing"));
  const Variables at{0.45e-3, 0.09};
  const DesignValues all = both.evaluate(at, true), h = hanging.evaluate(at, true),
                     s = standing.evaluate(at, true);
  REQUIRE(all.ok);
  REQUIRE(all.gradient.rows() > 0);
  Eigen::Index row = 0, row_h = 0, row_s = 0;
  for (std::size_t g = 0; g < all.goals.size(); ++g) {
    GoalValues expected = h.goals[g];
    MatrixXd rows = h.gradient.middleRows(row_h, static_cast<Eigen::Index>(h.goals[g].size()));
    if (g != 2) {  // the goal that names a case
      expected.insert(expected.end(), s.goals[g].begin(), s.goals[g].end());
      const MatrixXd more =
          s.gradient.middleRows(row_s, static_cast<Eigen::Index>(s.goals[g].size()));
      rows.conservativeResize(rows.rows() + more.rows(), rows.cols());
      rows.bottomRows(more.rows()) = more;
    }
    CHECK(all.goals[g] == expected);
    CHECK(all.gradient.middleRows(row, rows.rows()) == rows);
    row += rows.rows();
    row_h += static_cast<Eigen::Index>(h.goals[g].size());
    row_s += static_cast<Eigen::Index>(s.goals[g].size());
  }
  CHECK(both.objective(all) == std::min(hanging.objective(h), standing.objective(s)));
  CHECK(both.constraints(all)[0] ==
        std::max(hanging.constraints(h)[0], standing.constraints(s)[0]));
  CHECK(both.constraints(all)[1] == hanging.constraints(h)[1]);
}

TEST_CASE("an optimum over load cases keeps all, and is no better than that of any one", "[slow]") {
  const Job job = parse_job(document());
  const Optimum both = optimise(job, {}), hanging = optimise(alone("hanging"), {});
  REQUIRE(both.status == OptimumStatus::optimal);
  REQUIRE(hanging.status == OptimumStatus::optimal);
  CHECK(both.gradients == "exact");
  CHECK(both.objective < hanging.objective);
  REQUIRE(both.decisive);
  CHECK(job.cases[both.decisive->load_case].name == "standing");
  REQUIRE(both.cases.size() == 2);
  CHECK(both.response.path.size() == 3);
  CHECK(both.cases[1].path.size() == 2);
  REQUIRE(both.verified);
  CHECK(std::abs(both.verified->objective_difference) < 1e-3);
  const PathPoint& decisive = both.cases[1].path[both.decisive->point];
  CHECK(*decisive.parasitic_frequency == Approx(both.objective).epsilon(1e-3));
}

TEST_CASE("derivatives are checked in every load case", "[slow]") {
  json small = document();
  small["stroke"] = {{"at", {"2 mm"}}};
  small["cases"]["standing"].erase("stroke");
  const GradientReport report = check_gradients(parse_job(small), 1e-6, 2);
  CHECK(report.ok);
  for (const char* name : {"hanging", "standing"})
    CHECK(std::ranges::count(report.checks, name, &GradientCheck::load_case) > 20);
}

TEST_CASE("derivatives by mass and inertia are checked where an end-effector has none", "[slow]") {
  const Job job = parse_job(test::guide_job(R"({
    "job": "evaluate", "end_effector": null, "optimise": null, "stroke": {"at": ["1 mm"]},
    "design": {"parameters": {"spacing": "80 mm"}, "material": "spring_steel_1.4310"},
    "model": {"accuracy": "full", "mesh": [4, 2]}})"));
  const GradientReport report = check_gradients(job, 1e-6, 2);
  CHECK(report.ok);
  for (const char* name : {"end_effector.mass", "end_effector.inertia.zz"})
    CHECK(std::ranges::count(report.checks, name, &GradientCheck::parameter) > 5);
  for (const GradientCheck& check : report.checks) CHECK(std::isfinite(check.difference));
}
