#include "optim/studies/tolerance_study.hpp"

#include "optim/problem/stroke_sensitivity.hpp"
#include "tests/optim/guide_job.hpp"

namespace {

json guide() {
  return test::guide_job(R"({
    "job": null, "model": {"mesh": [4, 2]}, "stroke": {"at": ["5 mm"]},
    "tolerances": {"thickness": "10 um", "length": "0.5 mm",
                   "material.youngs_modulus": {"plus_minus": "3 %", "distribution": "normal"}},
    "tolerance_samples": {"count": 0},
    "optimise": {"algorithm": null,
      "constraints": [{"quantity": "max_stress", "max": "300 MPa"},
                      {"quantity": "drive_load", "over_stroke": "max_abs", "max": "9 N"},
                      {"expression": "2*length + 10*thickness", "max": "0.206 m"}]}})");
}

ToleranceReport study(const json& document, int threads = 2) {
  const Job job = parse_job(document);
  return study_tolerances(job, job.design.parameters, job.model, threads);
}

const ToleratedNumber& number(const ToleranceReport& report, const std::string& name) {
  const auto found = std::ranges::find(report.quantities, name, &ToleratedQuantity::name);
  REQUIRE(found != report.quantities.end());
  return found->number;
}

}  // namespace

TEST_CASE("slopes are derivatives times the limits, of material numbers, too") {
  const ToleranceReport report = study(guide());
  const Job job = parse_job(guide());
  StrokeRequest request = job.request;
  request.values = PathValues::differentiable;
  const StrokeSensitivity exact =
      stroke_sensitivity(job, job.design.parameters,
                         {"length", "material.youngs_modulus", "thickness"}, job.model, request);
  REQUIRE(exact.gradients);
  const VectorXd& gradient = exact.gradients->path[0].drive_stiffness;
  const ToleratedNumber& stiffness = number(report, "drive_stiffness");
  REQUIRE(stiffness.slopes);
  // entries in the order of their names
  CHECK((*stiffness.slopes)[0] == Approx(gradient[0] * 0.5e-3).epsilon(1e-12));
  CHECK((*stiffness.slopes)[1] ==
        Approx(gradient[1] * 0.03 * job.design.material.youngs_modulus).epsilon(1e-12));
  CHECK((*stiffness.slopes)[2] == Approx(gradient[2] * 10e-6).epsilon(1e-12));
  // all forces and stiffnesses are proportional to Young's modulus
  CHECK((*stiffness.slopes)[1] == Approx(0.03 * stiffness.value).epsilon(1e-9));
  CHECK(report.samples == 0);
  CHECK_FALSE(report.yield);
}

TEST_CASE("quantities that a job defines have tolerances as all others have") {
  json document = guide();
  document["quantities"] =
      json::parse(R"J([{"name": "own", "expression": "drive_stiffness*thickness/length"}])J");
  document["tolerance_samples"] = {{"count", 12}};
  const ToleranceReport report = study(document);
  const ToleratedNumber &own = number(report, "own"),
                        &stiffness = number(report, "drive_stiffness");
  CHECK(own.value == Approx(stiffness.value * 0.5e-3 / 0.1).epsilon(1e-12));
  REQUIRE(own.slopes);
  const VectorXd relative = *stiffness.slopes / stiffness.value;  // length, modulus, thickness
  CHECK((*own.slopes)[0] == Approx(own.value * (relative[0] - 0.5e-3 / 0.1)).epsilon(1e-9));
  CHECK((*own.slopes)[1] == Approx(own.value * relative[1]).epsilon(1e-9));
  CHECK((*own.slopes)[2] == Approx(own.value * (relative[2] + 10e-6 / 0.5e-3)).epsilon(1e-9));
  REQUIRE(own.sampled);
  CHECK(own.sampled->count == 12);
  CHECK(own.sampled->low < own.sampled->high);
}

TEST_CASE("the room of a linear constraint is exact, and the least of all is that of the job") {
  const ToleranceReport report = study(guide());
  REQUIRE(report.goals.size() == 4);
  // 0.206 m − 0.205 m over 2 · 0.5 mm + 10 · 10 µm
  CHECK(*report.goals[3].room == Approx(0.001 / 0.0011).epsilon(1e-9));
  CHECK(report.goals[3].high == Approx(0.2061).epsilon(1e-12));
  double least = 1e99;
  for (std::size_t g = 1; g < report.goals.size(); ++g)
    if (report.goals[g].room) least = std::min(least, *report.goals[g].room);
  REQUIRE(report.room);
  CHECK(*report.room == least);
}

TEST_CASE("a bound that an optimum meets to rounding spoils neither room nor yield") {
  json document = guide();
  document["tolerance_samples"] = {{"count", 20}};
  const ToleranceReport before = study(document);
  REQUIRE(*before.yield > 0);
  const double width = parse_job(document).design.parameters.at("width");
  document["optimise"]["constraints"].push_back(
      {{"expression", "width"}, {"max", width * (1 - 1e-12)}});
  const ToleranceReport report = study(document);
  CHECK(report.room == before.room);
  CHECK(report.yield == before.yield);
}

TEST_CASE("designs at the room's scale keep the constraints, and just", "[slow]") {
  json document = guide();
  document["optimise"]["constraints"].erase(2);
  const ToleranceReport report = study(document);
  REQUIRE(report.room);
  REQUIRE(report.room_of == "drive_load max_abs over stroke");
  // the corner in which the drive load grows: thick, stiff, short
  const double s = *report.room;
  json corner = document;
  corner["design"]["parameters"]["thickness"] = 0.5e-3 + s * 10e-6;
  corner["design"]["parameters"]["length"] = 0.1 - s * 0.5e-3;
  const Job job = parse_job(document);
  corner["design"]["material"] = {
      {"youngs_modulus", job.design.material.youngs_modulus * (1 + 0.03 * s)},
      {"poissons_ratio", job.design.material.poissons_ratio},
      {"density", job.design.material.density}};
  const double load = number(study(corner), "drive_load").value;
  // the error of a first order is the square of some per cent
  CHECK(load == Approx(9).epsilon(0.02));
}

TEST_CASE("standard deviations by gradients are those of 2000 samples within 5 %", "[slow]") {
  json document = guide();
  document["tolerance_samples"] = {{"count", 2000}, {"seed", 3}};
  const ToleranceReport report = study(document);
  CHECK(report.failed == 0);
  int compared = 0;
  for (const ToleratedQuantity& q : report.quantities) {
    const auto& [value, slopes, sampled] = q.number;
    // what hardly moves, and what is nothing but rounding
    if (!slopes || farthest(*slopes) < std::max(1e-3 * std::abs(value), 1e-12)) continue;
    INFO(q.name);
    REQUIRE(sampled);
    const Job job = parse_job(document);
    CHECK(sampled->standard_deviation ==
          Approx(standard_deviation(job.tolerances->entries, *slopes)).epsilon(0.05));
    CHECK(sampled->count == 2000);
    ++compared;
  }
  CHECK(compared > 10);
  for (const ToleratedGoal& goal : report.goals) {
    INFO(goal.label);
    const Job job = parse_job(document);
    CHECK(goal.number.sampled->standard_deviation ==
          Approx(standard_deviation(job.tolerances->entries, *goal.number.slopes)).epsilon(0.05));
  }
  REQUIRE(report.yield);
  CHECK(*report.yield > 0.5);
  CHECK(*report.yield < 1);
}

TEST_CASE("a cutting offset of several parameters is one tolerance with one sample for all") {
  json document = guide();
  document["tolerances"] = {
      {"offset", {{"plus_minus", "10 um"}, {"parameters", {{"thickness", 1}, {"length", -2}}}}}};
  document["tolerance_samples"] = {{"count", 20}};
  document["optimise"]["constraints"][2]["expression"] = "length + 2*thickness";
  const ToleranceReport report = study(document);
  const ToleratedNumber& sum = report.goals[3].number;  // the offset cancels in it
  CHECK(std::abs((*sum.slopes)[0]) < 1e-18);
  REQUIRE(sum.sampled);
  CHECK(sum.sampled->standard_deviation < 1e-15);
  CHECK(variance_shares(parse_job(document).tolerances->entries,
                        *number(report, "drive_stiffness").slopes)[0] == 1);
}

TEST_CASE("a deviation moves its own parameter, not those that are formulas of it") {
  json document = guide();
  document["design"]["parameters"]["width"] = {{"expression", "0.3*length"}};
  document["optimise"]["constraints"] = {{{"expression", "length + width"}, {"max", 1}}};
  document["tolerances"] = {{"length", "1 mm"}};
  document["tolerance_samples"] = {{"count", 50}};
  const ToleranceReport report = study(document);
  CHECK((*report.goals[1].number.slopes)[0] == Approx(1e-3).epsilon(1e-12));
  CHECK(report.goals[1].number.sampled->high <= 0.131 * (1 + 1e-12));
}

TEST_CASE("sampled designs are the same for any number of threads") {
  json document = guide();
  document["tolerance_samples"] = {{"count", 12}};
  const ToleranceReport one = study(document, 1), two = study(document, 2);
  CHECK(one.yield == two.yield);
  REQUIRE(one.quantities.size() == two.quantities.size());
  for (std::size_t q = 0; q < one.quantities.size(); ++q) {
    INFO(one.quantities[q].name);
    const auto &a = one.quantities[q].number.sampled, &b = two.quantities[q].number.sampled;
    REQUIRE(a.has_value() == b.has_value());
    if (a) CHECK((a->mean == b->mean && a->low == b->low && a->high == b->high));
  }
}

TEST_CASE("samples that are no mechanism are counted, with the reason, and keep no constraint") {
  json document = guide();
  document["frequencies"] = 0;
  document["stroke"] = {{"at", {0}}};
  // leaves 0.5 mm thick, 0.1 mm to 39.9 mm apart: one in a hundred at least intersects
  document["design"]["parameters"]["spacing"] = "20 mm";
  document["tolerances"] = {{"spacing", "19.9 mm"}};
  document["tolerance_samples"] = {{"count", 120}};
  document["optimise"]["objective"] = {{"maximise", "support_stiffness.uz"}};
  document["optimise"]["constraints"] = {{{"quantity", "support_stiffness.uz"}, {"min", 1}}};
  const ToleranceReport report = study(document);
  CHECK(report.failed >= 1);
  CHECK(report.failed < 10);
  CHECK_FALSE(report.first_failure.empty());
  CHECK(*report.yield == Approx((120.0 - report.failed) / 120));
}

namespace {

/// The guide with leaves of different thickness, at rest and far out.
json leaf_by_leaf(const json& entries) {
  json document = guide();
  document["stroke"]["at"] = {0, "5 mm"};
  document["tolerances"] = entries;
  return document;
}

}  // namespace

TEST_CASE("what leaves have in common is the sum of what each of them does") {
  const ToleranceReport report = study(leaf_by_leaf(
      {{"thickness", "10 um"},
       {"mismatch",
        {{"plus_minus", "10 um"}, {"parameters", {{"thickness", 1}}}, {"each", "leaf"}}}}));
  REQUIRE(report.entries.size() == 3);  // by their names: both leaves, then the thickness of all
  CHECK(report.entries[0].name == "mismatch of leaf +y");
  CHECK(report.entries[0].entry == "mismatch");
  CHECK(report.entries[2].entry == "thickness");
  int compared = 0;
  for (const ToleratedQuantity& q : report.quantities) {
    if (!q.number.slopes) continue;
    const VectorXd& s = *q.number.slopes;
    const double size = std::max(std::abs(s[0]), std::abs(s[1]));
    if (size < std::max(1e-6 * std::abs(q.number.value), 1e-12)) continue;  // rounding
    INFO(q.name << " at point " << q.point);
    CHECK(s[0] + s[1] == Approx(s[2]).epsilon(1e-6).margin(1e-6 * size));
    ++compared;
  }
  CHECK(compared > 10);
}

TEST_CASE("slopes of one leaf are differences of mechanisms in which it alone differs") {
  json document = leaf_by_leaf({{"thickness", {{"plus_minus", "1 %"}, {"each", "leaf"}}},
                                {"length", {{"plus_minus", "20 um"}, {"each", "leaf"}}}});
  document["model"]["accuracy"] = "full";
  const ToleranceReport report = study(document);
  const Job job = parse_job(document);
  StrokeRequest request = job.request;
  request.values = PathValues::differentiable;
  request.newton.tolerance = 1e-12;
  REQUIRE(report.entries.size() == 4);
  for (std::size_t e = 0; e < 4; ++e) {
    INFO(report.entries[e].name);
    const ToleranceTerm& term = report.entries[e].terms.at(0);
    constexpr double z = 0.1;
    const auto at = [&](double by) {
      ParameterValues moved = job.design.parameters;
      moved[term.parameter] += by * term.change;
      return evaluate_stroke(make_mechanism(job, moved), job.model, request);
    };
    const StrokeResponse up = at(z), down = at(-z);
    for (const std::string name : {"drive_load", "drive_stiffness", "rotation.z", "displacement.x",
                                   "support_stiffness.uz"}) {
      INFO(name);
      const auto of = std::ranges::find_if(report.quantities, [&](const ToleratedQuantity& q) {
        return q.name == name && q.point == 1;
      });
      REQUIRE(of != report.quantities.end());
      const double size =
          std::abs(of->number.value) + std::abs((*of->number.slopes)[static_cast<Eigen::Index>(e)]);
      CHECK((*of->number.slopes)[static_cast<Eigen::Index>(e)] ==
            Approx((*value_of(up.path[1], name) - *value_of(down.path[1], name)) / (2 * z))
                .epsilon(2e-3)
                .margin(1e-6 * size));
      // a longer leaf shortens less when bent: unequal leaves turn the body, equal ones hardly do
      const VectorXd& s = *of->number.slopes;
      if (name == "rotation.z") CHECK(std::abs(s[0] + s[1]) < 0.1 * std::abs(s[0] - s[1]));
    }
  }
}

TEST_CASE("samples of leaves that differ spread as the first order says", "[slow]") {
  json document = leaf_by_leaf({{"thickness", {{"plus_minus", "5 um"}, {"each", "leaf"}}}});
  document["tolerance_samples"] = {{"count", 150}, {"seed", 2}};
  const ToleranceReport report = study(document);
  CHECK(report.failed == 0);
  for (const std::string name : {"rotation.z", "drive_load"}) {
    INFO(name);
    const auto of = std::ranges::find_if(report.quantities, [&](const ToleratedQuantity& q) {
      return q.name == name && q.point == 1;
    });
    REQUIRE(of != report.quantities.end());
    CHECK(of->number.sampled->standard_deviation ==
          Approx(standard_deviation(report.entries, *of->number.slopes)).epsilon(0.1));
  }
}

TEST_CASE("a bound missed by nanometres costs no yield, and each constraint says what it costs") {
  json document = guide();
  document["tolerances"] = {{"width", "0.1 mm"}};
  document["tolerance_samples"] = {{"count", 40}};
  document["optimise"]["constraints"] = json::parse(R"([
    {"expression": "length", "max": "99.999988 mm"},
    {"expression": "width", "max": "30 mm"}])");
  const ToleranceReport report = study(document);
  CHECK(*report.goals[1].missed == 0);  // the length is 12 nm too much in every sample
  CHECK(report.goals[1].allowed == Approx(1e-4 * 0.099999988));
  CHECK(*report.goals[2].missed == Approx(0.5).margin(0.03));  // the wider half
  CHECK(*report.yield == Approx(1 - *report.goals[2].missed));
  CHECK_FALSE(report.goals[0].missed);                         // an objective has no bound
  document["optimise"]["constraints"][0]["max"] = "99.98 mm";  // 2e-4 of the bound
  CHECK(*study(document).goals[1].missed == 1);
  CHECK(*study(document).yield == 0);
}
