#include "optim/studies/assembly_study.hpp"

#include "core/response/quantities.hpp"
#include "tests/optim/guide_job.hpp"

namespace {

json guide() {
  return test::guide_job(R"({
    "job": null, "end_effector": null, "optimise": null,
    "design": {"material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3,
                            "density": "7800 kg/m^3"}},
    "model": {"flexure": "beam", "mesh": [6, 2], "accuracy": "full"},
    "stroke": {"at": ["0.1 mm", "4 mm"]}, "frequencies": 0,
    "assembly_tolerances": {
      "edges": [{"leaf": "leaf +y", "end": "base", "turn": ["1 mrad", "2 mrad", 0]},
                {"leaf": "leaf -y", "end": "tip", "move": [0, 0, "0.1 mm"]}],
      "quantities": [{"quantity": "support_stiffness.uz", "over_stroke": "min"},
                     {"quantity": "drive_load", "over_stroke": "max_abs"}], "starts": 3}})");
}

AssemblyReport study(const json& document) {
  const Job job = parse_job(document);
  return study_assembly(job, job.design.parameters, job.model);
}

StrokeResponse with(const Job& job, const std::vector<AssemblyError>& errors) {
  StrokeRequest request = job.request;
  request.outputs = {Output::equilibrium, Output::stiffness};
  request.loads.assembly = errors;
  return evaluate_stroke(make_mechanism(job, job.design.parameters), job.model, request);
}

/// With errors at (x, y, z) of the box.
StrokeResponse placed(const Job& job, double x, double y, double z) {
  return with(job, {{0, 0, Vector3d::Zero(), {1e-3 * x, 2e-3 * y, 0}},
                    {1, 1, {0, 0, 1e-4 * z}, Vector3d::Zero()}});
}

double worst_in(const StrokeResponse& response, const Constraint& of) {
  std::optional<double> worst;
  for (const PathPoint& p : response.path) {
    const double value = *value_of(p, of.quantity);
    if (of.over_stroke == OverStroke::min)
      worst = std::min(worst.value_or(value), value);
    else
      worst = std::max(worst.value_or(0), std::abs(value));
  }
  return *worst;
}

}  // namespace

TEST_CASE("the worst errors of assembly are as bad as any of a grid") {
  const Job job = parse_job(guide());
  const AssemblyReport report = study(guide());
  INFO(report.message);
  REQUIRE(report.quantities.size() == 2);
  for (const WorstAssembly& found : report.quantities) {
    INFO(found.of.label << " " << found.reason);
    REQUIRE(found.worst);
    const double side = found.of.over_stroke == OverStroke::min ? -1 : 1;
    CHECK(side * *found.worst > side * found.nominal);
    CHECK(*found.worst == Approx(worst_in(with(job, found.misalignment), found.of)).epsilon(1e-9));
    for (const AssemblyError& e : found.misalignment)
      for (int i = 0; i < 3; ++i) {
        CHECK(std::abs(e.turn[i]) <= 2e-3 * (1 + 1e-12));
        CHECK(std::abs(e.move[i]) <= 1e-4 * (1 + 1e-12));
      }
    for (const double x : {-1.0, 0.0, 1.0})
      for (const double y : {-1.0, -0.5, 0.0, 0.5, 1.0})
        for (const double z : {-1.0, 0.0, 1.0}) {
          CAPTURE(x, y, z);
          CHECK(side * worst_in(placed(job, x, y, z), found.of) <=
                side * *found.worst * (1 + 1e-6 * side));
        }
  }
}

TEST_CASE("the worst errors of assembly are found of formulas of quantities, too") {
  json document = guide();
  document["assembly_tolerances"]["quantities"] = json::parse(R"([
    {"expression": "support_stiffness.uz/drive_stiffness*thickness", "over_stroke": "min"},
    {"quantity": "support_stiffness.uz", "over_stroke": "min"}])");
  const AssemblyReport report = study(document);
  const Job job = parse_job(document);
  const WorstAssembly &ratio = report.quantities.at(0), &plain = report.quantities.at(1);
  REQUIRE(ratio.worst);
  const auto worst_ratio = [](const StrokeResponse& response) {
    double least = 1e99;
    for (const PathPoint& p : response.path)
      least = std::min(least, *p.support_stiffness[2] / p.drive_stiffness * 0.5e-3);
    return least;
  };
  CHECK(ratio.nominal == Approx(worst_ratio(with(job, {}))).epsilon(1e-9));
  CHECK(*ratio.worst == Approx(worst_ratio(with(job, ratio.misalignment))).epsilon(1e-9));
  CHECK(*ratio.worst <= worst_ratio(with(job, plain.misalignment)) * (1 + 1e-9));
  CHECK(*ratio.worst < ratio.nominal);
}

TEST_CASE("at the critical scale something is critical, and nothing short of it") {
  json document = guide();
  json& box = document["assembly_tolerances"];
  box.erase("quantities");
  box["stiffness_share"] = 0.8;
  const Job job = parse_job(document);
  const AssemblyReport report = study(document);
  REQUIRE(report.critical);
  const CriticalAssembly& found = *report.critical;
  INFO(found.text);
  CHECK(found.limit == "stiffness");
  const StrokeResponse plain = with(job, {});
  const auto least_share = [&](const StrokeResponse& r) {
    double least = 1e9;
    for (std::size_t k = 0; k < r.path.size(); ++k)
      for (std::size_t d = 0; d < 6; ++d)
        if (r.path[k].support_stiffness[d])
          least = std::min(least,
                           *r.path[k].support_stiffness[d] / *plain.path[k].support_stiffness[d]);
    return least;
  };
  CHECK(least_share(with(job, found.misalignment)) == Approx(0.8).epsilon(1e-5));
  const double s = 0.999 * found.scale;
  for (const double x : {-1.0, 0.0, 1.0})
    for (const double y : {-1.0, 0.0, 1.0})
      for (const double z : {-1.0, 0.0, 1.0})
        CHECK(least_share(placed(job, s * x, s * y, s * z)) > 0.8);
  box["largest_scale"] = 0.01;
  const AssemblyReport none = study(document);
  REQUIRE(none.critical);
  CHECK(none.critical->limit == "none");
  CHECK(none.critical->scale == 0.01);
}

TEST_CASE("a limit of paths ends the study with the worst so far, and every path is told") {
  json document = guide();
  document["assembly_tolerances"]["stiffness_share"] = 0.8;
  const int all = most_paths(parse_job(document));
  document["assembly_tolerances"]["max_paths"] = 12;
  const Job job = parse_job(document);
  CHECK(all > 1000);
  CHECK(most_paths(job) == 12);
  std::vector<int> told;
  const AssemblyReport report = study_assembly(job, job.design.parameters, job.model,
                                               [&](int paths) { told.push_back(paths); });
  REQUIRE(told.size() == 12);
  for (int k = 0; k < 12; ++k) CHECK(told[k] == k);
  REQUIRE(report.quantities.size() == 2);
  const WorstAssembly &first = report.quantities[0], &second = report.quantities[1];
  REQUIRE(first.worst);
  CHECK(*first.worst < first.nominal);
  CHECK(*first.worst == Approx(worst_in(with(job, first.misalignment), first.of)).epsilon(1e-9));
  CHECK(first.reason == "ended by its limit of 12 paths");
  CHECK_FALSE(second.worst);
  CHECK(second.reason == first.reason);
  REQUIRE(report.critical);
  CHECK(report.critical->limit == "none");
  CHECK(report.critical->scale == 0);
  CHECK_THAT(report.critical->text, Contains("ended by its limit of 12 paths"));
}

TEST_CASE("a guide that is turned loses the drive stiffness that solids lose", "[slow]") {
  json document = guide();
  document["model"] = json::object();
  document["stroke"] = {{"at", {"0.1 mm"}}};
  json& box = document["assembly_tolerances"];
  box["edges"] = {{{"leaf", "leaf +y"}, {"end", "base"}, {"turn", {0, "1 mrad", 0}}}};
  box.erase("quantities");
  // CalculiX, tests/literature/calculix_surroundings.json: 0.15748 N as designed, 0.14589 N at 2
  // mrad
  box["drive_load_change"] = 1 - 0.14589 / 0.15748;
  const AssemblyReport report = study(document);
  REQUIRE(report.critical);
  INFO(report.critical->text);
  CHECK(report.critical->limit == "drive_load");
  CHECK(report.critical->scale == Approx(2).epsilon(0.01));
}

TEST_CASE("over load cases the worst of them counts, at its own worst errors", "[slow]") {
  json all = guide();
  all["assembly_tolerances"]["edges"].erase(1);
  all["assembly_tolerances"]["quantities"].push_back(
      {{"quantity", "drive_load"}, {"over_stroke", "max_abs"}, {"case", "pulled"}});
  all["assembly_tolerances"]["stiffness_share"] = 0.97;
  all["cases"] = json::parse(R"({
    "pressed": {"loads": [{"force": ["-60 N", 0, 0]}], "stroke": {"at": ["0.1 mm", "1 mm", "5 mm"]}},
    "pulled": {"loads": [{"force": ["40 N", 0, 0]}]}})");
  const AssemblyReport both = study(all);
  INFO(both.message);
  REQUIRE(both.quantities.size() == 3);
  std::vector<AssemblyReport> each;
  for (const char* name : {"pressed", "pulled"}) {
    json one = all;
    one.update(all["cases"][name]);
    one.erase("cases");
    one["assembly_tolerances"]["quantities"].erase(2);
    each.push_back(study(one));
    REQUIRE(each.back().quantities.size() == 2);
  }
  const WorstAssembly &uz = both.quantities[0], &load = both.quantities[1];
  CHECK(uz.place.load_case == 0);  // pressed leaves are the softer ones, and go farther
  CHECK(uz.place.point == 2);
  CHECK(*uz.worst == Approx(*each[0].quantities[0].worst).epsilon(1e-7));
  CHECK(*uz.worst < *each[1].quantities[0].worst * (1 - 1e-3));
  CHECK(uz.nominal == each[0].quantities[0].nominal);
  const double loads[] = {*each[0].quantities[1].worst, *each[1].quantities[1].worst};
  CHECK(*load.worst == Approx(std::max(loads[0], loads[1])).epsilon(1e-7));
  CHECK(load.place.load_case == (loads[0] > loads[1] ? 0 : 1));
  CHECK(both.quantities[2].place.load_case == 1);
  CHECK(*both.quantities[2].worst == Approx(loads[1]).epsilon(1e-7));
  REQUIRE(both.critical);
  CHECK(both.critical->scale ==
        Approx(std::min(each[0].critical->scale, each[1].critical->scale)).epsilon(1e-3));
}
