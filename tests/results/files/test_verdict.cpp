// The verdict on a run: failures first, then instability, numbers that are not believed, stress.
#include "results/files/result_parts.hpp"
#include "tests/results/results_tests.hpp"

namespace {

Verdict verdict_where(const std::function<void(RunRecord&)>& change) {
  RunRecord record = test::evaluated_hinge();
  record.status = "ok";
  change(record);
  return verdict_of(record);
}

}  // namespace

TEST_CASE("the most pressing word comes first") {
  const Verdict works = verdict_where([](RunRecord&) {});
  CHECK(works.word == "works");
  CHECK(works.tone == "good");
  const auto stressed_to = [](double share) {
    return [share](RunRecord& r) {
      for (PathPoint& p : r.response.path)
        if (p.max_stress) p.allowable_safety = StressSafety{2, *p.max_stress};
      r.response.path.back().allowable_safety->value = 1 / share;
    };
  };
  const auto stressed = stressed_to(1.24);
  const Verdict over = verdict_where(stressed);
  CHECK(over.word == "overstressed");
  CHECK(over.tone == "bad");
  CHECK_THAT(over.text, Contains("124 % of what the material allows, at "));
  const Verdict just_over = verdict_where(stressed_to(1.0006));
  CHECK(just_over.word == "overstressed");
  CHECK_THAT(just_over.text, Contains("100.1 % of what"));
  const Verdict below = verdict_where(stressed_to(0.9));
  CHECK(below.word == "works");
  CHECK_THAT(below.text, Contains("at most 90 % of what"));
  const auto doubted = [&](RunRecord& r) {
    stressed(r);
    r.status = "tolerance_not_met", r.message = "Off by 35 %.";
  };
  CHECK(verdict_where(doubted).word == "tolerance not met");
  const Verdict unstable = verdict_where([&](RunRecord& r) {
    doubted(r);
    for (PathPoint& p : r.response.path) p.stable = false;
  });
  CHECK(unstable.word == "unstable");
  CHECK_THAT(unstable.text, Contains("With the drive held it is unstable at ") &&
                                Contains("more points") && Contains("Off by 35 %."));
  const auto held_otherwise = [&](const auto& change) {
    return verdict_where([&](RunRecord& r) {
             r.response.path.front().stable = false;
             change(r.mechanism, r.job.request.loads);
           })
        .text;
  };
  CHECK_THAT(held_otherwise([](Mechanism& m, LoadCase& loads) {
               m.drives.push_back(m.drives[0]);
               m.drives[0].name = "x", m.drives[1].name = "y";
               loads.held.set(1);
             }),
             Contains("With the drive y alone held it is unstable at "));
  CHECK_THAT(held_otherwise([](Mechanism& m, LoadCase&) { m.drives.push_back(m.drives[0]); }),
             Contains("With the drives held it is unstable at "));
  CHECK_THAT(held_otherwise([](Mechanism&, LoadCase& loads) { loads.growing.resize(1); }),
             Contains("With the drive free it is unstable at load factor "));
  CHECK_THAT(held_otherwise([](Mechanism& m, LoadCase&) { m.drives.clear(); }),
             Contains("It is unstable at "));
  const Verdict twice = verdict_where([&](RunRecord& r) {
    r.message = "Of an equilibrium.";
    r.response.path.front().stable = r.response.path.back().stable = false;
  });
  CHECK(twice.word == "unstable");
  CHECK_THAT(twice.text, Contains(" and at 1 more point.") && !Contains("Of an equilibrium."));
  const Verdict failed = verdict_where([&](RunRecord& r) {
    doubted(r);
    for (PathPoint& p : r.response.path) p.stable = false;
    r.status = "no_equilibrium", r.message = "Two points.";
  });
  CHECK(failed.word == "no equilibrium");
  CHECK(failed.text == "Two points.");
}

TEST_CASE("an optimum is told with what was asked of it") {
  RunRecord record = test::optimised_hinge();
  record.status = "ok";
  const Verdict optimal = verdict_of(record);
  CHECK(optimal.word == "optimal");
  CHECK_THAT(optimal.text, Contains("arasitic frequency over the stroke") && Contains("169.2 Hz") &&
                               Contains("all requirements are met"));
  record.optimum->status = OptimumStatus::local;
  CHECK(verdict_of(record).tone == "warn");
  CHECK_THAT(verdict_of(record).text, Contains("try more starts"));
}

TEST_CASE("numbers are written as a designer reads them") {
  CHECK(quantity_text(0.0308, "m") == "30.8 mm");
  CHECK(quantity_text(3.1327e6, "N/m") == "3.1327 N/um");
  CHECK(quantity_text(3450, "N/m") == "3450 N/m");
  CHECK(quantity_text(0.7, "1") == "0.7");
  CHECK(quantity_text(4.5e8, "Pa", 3) == "450 MPa");
  const DriveList drive(Direction::uy);
  CHECK(extreme_name({.quantity = "parasitic_frequency", .over_stroke = OverStroke::min}, drive) ==
        "lowest parasitic frequency over the stroke");
  CHECK(extreme_name({.quantity = "max_stress"}, drive) ==
        "largest von Mises stress over the stroke");
  CHECK(extreme_name({.quantity = "drive_load", .over_stroke = OverStroke::max_abs}, drive) ==
        "largest size of the drive load over the stroke");
  CHECK(extreme_name({.quantity = "drive_load", .over_stroke = OverStroke::last}, drive) ==
        "drive load at the last point");
}
