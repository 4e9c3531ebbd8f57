#include "optim/problem/worst_assembly_goals.hpp"

#include "core/math/ridders.hpp"
#include "optim/problem/design_problem.hpp"
#include "optim/problem/evaluation_book.hpp"
#include "optim/search/optimise.hpp"
#include "tests/optim/guide_job.hpp"

namespace {

json document() {
  return test::guide_job(R"({
    "design": {"parameters": {"width": "20 mm", "thickness": "0.4 mm"},
      "material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3, "density": "7800 kg/m^3"}},
    "end_effector": null, "model": {"flexure": "beam", "mesh": [6, 2], "accuracy": "full"},
    "assembly": [{"leaf": "leaf -y", "end": "base", "turn": [0, "0.3 mrad", 0]}],
    "stroke": {"at": ["1 mm", "4 mm"]}, "frequencies": 0,
    "assembly_tolerances": {
      "edges": [{"leaf": "leaf +y", "end": "base", "turn": ["1 mrad", "2 mrad", 0]},
                {"leaf": "leaf -y", "end": "tip", "move": [0, 0, "50 um"]}], "starts": 2},
    "optimise": {
      "variables": [{"parameter": "thickness", "min": "0.3 mm", "max": "0.6 mm"},
                    {"parameter": "width", "min": "10 mm", "max": "30 mm"}],
      "objective": {"maximise": "support_stiffness.uz", "under": "assembly_tolerances"},
      "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "max": "5 N",
                       "under": "assembly_tolerances"},
                      {"quantity": "drive_stiffness", "over_stroke": "last", "min": "10 N/m",
                       "under": "assembly_tolerances", "as": "worst"},
                      {"quantity": "max_stress", "max": "200 MPa"}],
      "algorithm": {"library": "nlopt", "name": "LD_SLSQP"}, "starts": 1}})");
}

const Variables at{0.4e-3, 0.02};

/// The same under two loads, with paths of their own; the second constraint is about one of them.
json two_cases() {
  json all = document();
  all["assembly_tolerances"]["edges"].erase(1);
  all["cases"] = json::parse(R"({
    "pressed": {"loads": [{"force": ["-30 N", 0, 0]}], "stroke": {"at": ["1 mm", "2 mm", "4 mm"]}},
    "pulled": {"loads": [{"force": ["20 N", 0, "1 N"]}]}})");
  all["optimise"]["constraints"][1]["case"] = "pulled";
  return all;
}

/// The goal of each point at errors of assembly at z of the box of document().
std::vector<double> sampled(const Job& job, const Variables& design, const std::string& quantity,
                            double x, double y, double z) {
  ParameterValues parameters = job.design.parameters;
  parameters["thickness"] = design[0];
  parameters["width"] = design[1];
  StrokeRequest request = job.request;
  request.outputs = needs_of(quantity);
  request.loads.assembly.push_back({0, 0, Vector3d::Zero(), {1e-3 * x, 2e-3 * y, 0}});
  request.loads.assembly.push_back({1, 1, {0, 0, 5e-5 * z}, Vector3d::Zero()});
  std::vector<double> values;
  for (const PathPoint& p :
       evaluate_stroke(make_mechanism(job, parameters), job.model, request).path)
    values.push_back(*value_of(p, quantity));
  return values;
}

/// Exact derivatives of the first goals against differences of whole searches.
void check_derivatives(const json& task, std::size_t goals) {
  Job job = parse_job(task);
  job.request.newton.tolerance = 1e-11;
  for (JobCase& one : job.cases) one.request.newton.tolerance = 1e-11;
  const DesignProblem problem(job);
  const DesignValues exact = problem.evaluate(at, true), values = problem.evaluate(at);
  INFO(exact.message << exact.no_gradient);
  REQUIRE(exact.gradient.rows() > 0);
  CHECK(exact.goals == values.goals);
  for (std::size_t j = 0; j < at.size(); ++j) {
    const auto along = [&](double x) {
      Variables moved = at;
      moved[j] = x;
      const DesignValues there = problem.evaluate(moved);
      REQUIRE(there.ok);
      std::vector<double> numbers;
      for (std::size_t g = 0; g < there.goals.size(); ++g)
        numbers.push_back(aggregate(problem.goals()[g], there.goals[g]));
      return numbers;
    };
    const Derivatives differences = ridders(along, at[j], 0.02 * at[j], 4);
    Eigen::Index first = 0;
    for (std::size_t g = 0; g < goals; ++g) {
      const Extreme e = extreme(problem.goals()[g], exact.goals[g]);
      const double found = e.sign * exact.gradient(first + static_cast<Eigen::Index>(e.entry),
                                                   static_cast<Eigen::Index>(j));
      INFO(problem.goals()[g].label << " by variable " << j << ": " << found << " not "
                                    << differences.value[g] << ", known to "
                                    << differences.error[g] / std::abs(differences.value[g]));
      CHECK(std::abs(found - differences.value[g]) <=
            1e-8 * std::abs(differences.value[g]) + 5 * differences.error[g]);
      first += static_cast<Eigen::Index>(exact.goals[g].size());
    }
  }
}

/// The worst of a grid, and of its points.
double worst_of_grid(const Job& job, const Variables& design, const Constraint& of, bool least) {
  double worst = least ? 1e99 : -1e99;
  for (const double x : {-1.0, 0.0, 1.0})
    for (const double y : {-1.0, -0.5, 0.0, 0.5, 1.0})
      for (const double z : {-1.0, 0.0, 1.0}) {
        std::vector<double> values = sampled(job, design, of.quantity, x, y, z);
        if (of.over_stroke == OverStroke::last) values = {values.back()};
        for (double v : values) {
          if (of.over_stroke == OverStroke::max_abs) v = std::abs(v);
          worst = least ? std::min(worst, v) : std::max(worst, v);
        }
      }
  return worst;
}

}  // namespace

TEST_CASE("goals under errors of assembly are as bad as any place of the box") {
  const Job job = parse_job(document());
  const DesignProblem problem(job);
  const DesignValues values = problem.evaluate(at);
  INFO(values.message);
  REQUIRE(values.ok);
  REQUIRE(problem.worst_assembly());
  const Constraint uz{.quantity = "support_stiffness.uz", .over_stroke = OverStroke::min};
  const double worst_uz = worst_of_grid(job, at, uz, true);
  CHECK(problem.objective(values) <= worst_uz * (1 + 1e-9));
  CHECK(problem.objective(values) == Approx(worst_uz).epsilon(2e-3));  // a grid has no better place
  for (std::size_t k : {0U, 1U}) {
    const Constraint& c = job.optimise->constraints[k];
    const bool least = c.min.has_value();
    const double worst = worst_of_grid(job, at, c, least), found = problem.constraints(values)[k];
    INFO(c.label << " " << found << " on the grid " << worst);
    CHECK((least ? found <= worst * (1 + 1e-9) : found >= worst * (1 - 1e-9)));
    CHECK(found == Approx(worst).epsilon(2e-3));
  }
  // what the box takes, against the design as drawn
  json plain = document();
  plain.erase("assembly_tolerances");
  plain["optimise"]["objective"].erase("under");
  for (json& c : plain["optimise"]["constraints"]) c.erase("under"), c.erase("as");
  const DesignProblem nominal(parse_job(plain));
  const DesignValues drawn = nominal.evaluate(at);
  CHECK(problem.objective(values) < nominal.objective(drawn));
  CHECK(problem.constraints(values)[0] > nominal.constraints(drawn)[0]);
  CHECK(problem.constraints(values)[1] < nominal.constraints(drawn)[1]);
  CHECK(problem.constraints(values)[2] == nominal.constraints(drawn)[2]);  // it bears nothing
}

TEST_CASE("derivatives of goals under errors of assembly are those of their values", "[slow]") {
  check_derivatives(document(), 3);  // stress may jump from place to place
}

TEST_CASE("goals over load cases are as bad as the worst case at its worst errors") {
  const DesignProblem problem(parse_job(two_cases()));
  const DesignValues values = problem.evaluate(at);
  INFO(values.message);
  REQUIRE(values.ok);
  std::vector<DesignValues> each;
  for (const char* name : {"pressed", "pulled"}) {
    json one = two_cases();
    one.update(one["cases"][name]);
    one.erase("cases");
    for (json& c : one["optimise"]["constraints"]) c.erase("case");
    each.push_back(DesignProblem(parse_job(one)).evaluate(at));
    INFO(each.back().message);
    REQUIRE(each.back().ok);
  }
  json plain = two_cases();
  plain.erase("cases");
  for (json& c : plain["optimise"]["constraints"]) c.erase("case");
  const DesignProblem alone(parse_job(plain));  // reads goals of one case
  const double uz[] = {alone.objective(each[0]), alone.objective(each[1])};
  const auto first = alone.constraints(each[0]), second = alone.constraints(each[1]);
  REQUIRE(std::abs(uz[0] - uz[1]) > 1e-3 * uz[0]);
  REQUIRE(std::abs(first[0] - second[0]) > 1e-3 * first[0]);
  CHECK(problem.objective(values) == Approx(std::min(uz[0], uz[1])).epsilon(1e-9));
  CHECK(problem.constraints(values)[0] == Approx(std::max(first[0], second[0])).epsilon(1e-9));
  CHECK(problem.constraints(values)[1] == Approx(second[1]).epsilon(1e-9));  // it names its case
  CHECK(problem.constraints(values)[2] == Approx(std::max(first[2], second[2])).epsilon(1e-9));
}

TEST_CASE("goals over load cases under errors of assembly have exact derivatives", "[slow]") {
  check_derivatives(two_cases(), 3);
}

TEST_CASE("the failure of a goal under errors of assembly says its load case") {
  json wide = two_cases();
  wide["assembly_tolerances"]["edges"][0]["turn"] = {0, "40 mrad", 0};
  const DesignValues values = DesignProblem(parse_job(wide)).evaluate(at);
  CHECK_FALSE(values.ok);
  INFO(values.message);
  CHECK(values.message.find("of their box") != std::string::npos);
  CHECK(values.message.find("(load case p") != std::string::npos);
}

TEST_CASE("each point of the stroke has its candidates from the worst on") {
  const DesignProblem problem(parse_job(document()));
  const DesignValues values = problem.evaluate(at);
  REQUIRE(values.ok);
  const Goal& uz = problem.goals()[0];
  REQUIRE(uz.branches > 1);
  REQUIRE(values.goals[0].size() == 2 * static_cast<std::size_t>(uz.branches));
  for (std::size_t k = 0; k + 1 < values.goals[0].size(); ++k)
    if ((k + 1) % static_cast<std::size_t>(uz.branches) != 0)
      CHECK(values.goals[0][k] <= values.goals[0][k + 1]);
}

TEST_CASE("a guide is optimised for its worst errors of assembly", "[slow]") {
  json task = document();
  task["optimise"]["constraints"][2]["under"] = "assembly_tolerances";
  const Job job = parse_job(task);
  const Optimum optimum = optimise(job);
  INFO(optimum.stop_reason);
  REQUIRE(optimum.status == OptimumStatus::optimal);
  CHECK(optimum.gradients == "exact");
  const Variables best{optimum.parameters.at("thickness"), optimum.parameters.at("width")};
  // sampled in the box the optimum keeps its bounds and has its objective
  const Constraint uz{.quantity = "support_stiffness.uz", .over_stroke = OverStroke::min};
  CHECK(worst_of_grid(job, best, uz, true) == Approx(optimum.objective).epsilon(2e-3));
  bool active = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Constraint& c = job.optimise->constraints[k];
    const double worst = worst_of_grid(job, best, c, c.min.has_value());
    INFO(c.label << " " << worst);
    CHECK(worst == Approx(optimum.constraints[k].value).epsilon(5e-3));
    if (c.max) CHECK(worst <= *c.max * (1 + 1e-3));
    if (c.min) CHECK(worst >= *c.min * (1 - 1e-3));
    active = active || optimum.constraints[k].active;
  }
  CHECK(active);
  // designs beside it that keep the bounds in the box are no better
  const DesignProblem problem(job);
  for (const double t : {0.97, 1.0, 1.03})
    for (const double w : {0.97, 1.0, 1.03}) {
      const Variables beside{std::clamp(t * best[0], 0.3e-3, 0.6e-3),
                             std::clamp(w * best[1], 0.01, 0.03)};
      const DesignValues there = problem.evaluate(beside);
      if (!there.ok || problem.violation(problem.constraints(there), problem.scales(&there)) > 1e-4)
        continue;
      CHECK(problem.objective(there) <= optimum.objective * (1 + 1e-4));
    }
}

TEST_CASE("a formula of quantities counts its own worst errors of assembly") {
  json task = document();
  task["optimise"]["objective"]["maximise"] = "support_stiffness.uz/drive_stiffness*width";
  check_derivatives(task, 1);
  const Job job = parse_job(task);
  const Constraint& looked_at = job.assembly_tolerances->quantities.front();
  CHECK(looked_at.expression == job.optimise->objective.expression);
  const double worst = DesignProblem(job).objective(DesignProblem(job).evaluate(at));
  for (const double x : {-1.0, 0.0, 1.0})
    for (const double z : {-1.0, 1.0}) {
      const std::vector<double> across = sampled(job, at, "support_stiffness.uz", x, -x, z),
                                along = sampled(job, at, "drive_stiffness", x, -x, z);
      for (std::size_t i = 0; i < across.size(); ++i)
        CHECK(across[i] / along[i] * at[1] >= worst * (1 - 1e-9));
    }
}
