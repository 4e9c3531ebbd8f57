#include <nlohmann/json.hpp>

#include "results/files/folder.hpp"
#include "support/temporary_folder.hpp"
#include "tests/results/export/gallery.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

std::string refused(const std::string& job, const ExportPlace& place) {
  return test::complaint_of([&] { (void)make_exported(test::gallery_job(job), place); });
}

}  // namespace

TEST_CASE("A stroke is a quantity in the drive's unit") {
  CHECK(test::gallery("cross_hinge", {"10deg"}).strokes[0] == Approx(0.17453292519943295));
  CHECK(test::gallery("cross_hinge", {"10 deg"}).strokes[0] == Approx(0.17453292519943295));
  CHECK(test::gallery("cross_hinge", {"0.1"}).strokes[0] == Approx(0.1));
  CHECK(test::gallery("parallel_guide", {"5 mm"}).strokes[0] == Approx(0.005));
  CHECK(test::gallery("parallel_guide").undeflected);
  CHECK_FALSE(test::gallery("parallel_guide", {"0"}).undeflected);
  const Exported stage = test::gallery("tip_tilt_stage");
  const std::string first = stage.mechanism.drives[0].name;
  const Exported tilted = test::gallery("tip_tilt_stage", {first + "=1 mrad"});
  CHECK(tilted.strokes[0] == Approx(0.001));
  CHECK(tilted.strokes[1] == 0);
  CHECK_THAT(tilted.stroke_text(tilted.strokes), Contains(first + " = 0.001 rad"));
}

TEST_CASE("Strokes that the job does not have are refused") {
  const auto at = [](const std::vector<std::string>& texts) {
    return ExportPlace{.at = texts, .load_case = ""};
  };
  CHECK_THAT(refused("cross_hinge", at({"21 deg"})),
             Contains("--at") && Contains("from 0 to 0.34906585 rad"));
  CHECK_THAT(refused("cross_hinge", at({"-1 deg"})), Contains("from 0 to 0.34906585 rad"));
  CHECK_THAT(refused("cross_hinge", at({"1 mm"})), Contains("--at") && Contains("an angle"));
  CHECK_THAT(refused("cross_hinge", at({"1 deg", "2 deg"})), Contains("there is one drive"));
  CHECK_THAT(refused("tip_tilt_stage", at({"1 deg"})), Contains("expected NAME=STROKE"));
  CHECK_THAT(refused("tip_tilt_stage", at({"no=1 deg"})), Contains("expected NAME=STROKE"));
  CHECK_THAT(refused("cross_hinge", {.at = {}, .load_case = "lift"}), Contains("one load case"));
}

TEST_CASE("The place on a load path is a factor") {
  CHECK(test::gallery("cantilever", {"0.5"}).strokes[0] == 0.5);
  const std::string message = refused("cantilever", {.at = {"1.5"}, .load_case = ""});
  CHECK_THAT(message, Contains("expected load factor") && Contains("from 0 to 1"));
  CHECK_THAT(message, !Contains("1 1"));
}

TEST_CASE("A load case is exported by its name") {
  const Job job = test::gallery_job("load_cases");
  REQUIRE(job.cases.size() > 1);
  const std::string last = job.cases.back().name;
  const Exported exported = make_exported(job, {.at = {}, .load_case = last});
  CHECK(exported.request.loads.gravity == job.cases.back().request.loads.gravity);
  CHECK_THAT(refused("load_cases", {.at = {}, .load_case = "no"}), Contains(last));
}

TEST_CASE("No export leaves an elastic body out without a word") {
  Exported guide = test::elastic_guide();
  CHECK_THAT(dxf_contour(guide, nullptr).reason, Contains("elastic body end_effector"));
  CHECK_THAT(test::complaint_of([&] { (void)spacar_script(guide, guide.strokes); }),
             Contains("elastic body end_effector") && Contains("elastic body foot"));
  CHECK_THAT(test::complaint_of([&] { (void)step_file(guide, nullptr, true); }),
             Contains("--monolithic") && Contains("elastic bodies"));
  const test::TemporaryFolder folder;
  const auto notes = [&] {
    return write_exports(guide, {.formats = {"stl"}, .stem = "guide"}, folder.path()).notes;
  };
  CHECK(notes().empty());
  test::forget_mesh(guide.mechanism.elastic_bodies[1]);
  REQUIRE(notes().size() == 1);
  CHECK_THAT(notes()[0], Contains("elastic body foot is left out"));
}

TEST_CASE("Formats are read from a list") {
  CHECK(read_formats("stl,ccx") == std::vector<std::string>{"stl", "ccx"});
  CHECK_THROWS_WITH(read_formats("stl,obj"), Contains("obj") && Contains("ccx, "));
  CHECK_THROWS_WITH(read_formats(""), Contains("expected one of"));
  CHECK_THROWS_WITH(read_formats("stl,stl"), Contains("twice"));
}
