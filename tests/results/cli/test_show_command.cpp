// flexopt show: the page of a mechanism of which nothing was computed.
#include "optim/job/job.hpp"
#include "results/files/scene.hpp"
#include "results/run/run.hpp"
#include "tests/results/results_tests.hpp"

namespace {

std::string job_file(const std::string& name) {
  return FLEXOPT_SOURCE_DIR "/designs/jobs/" + name + ".json";
}

}  // namespace

TEST_CASE("show writes the page alone, named after the job, and prints where") {
  const test::Workplace folder;
  const test::Outcome shown = folder.run("show '" + job_file("parallel_guide") + "'");
  CHECK(shown.code == 0);
  CHECK(shown.err == "");
  CHECK(shown.out == "parallel_guide.show/report.html\n");
  CHECK(test::names_in(folder / "parallel_guide.show").size() == 1);
  const std::string page = folder.content("parallel_guide.show/report.html");
  CHECK_THAT(page, Contains("\"status\":\"undeflected\"") && Contains("leaf +y"));
  CHECK(folder.run("show '" + job_file("parallel_guide") + "' --out a/b").out ==
        "a/b/report.html\n");
  CHECK(folder.has("a/b/report.html"));
}

TEST_CASE("The scene of show has every part at its undeflected place") {
  const RunRecord record = undeflected(read_job(job_file("xy_stage")));
  const OrderedJson scene = make_scene(record);
  REQUIRE(scene["designs"].size() == 1);
  const OrderedJson& design = scene["designs"][0];
  CHECK(design["leaves"].size() == record.mechanism.leaves.size());
  CHECK(design["bodies"].size() == record.mechanism.bodies.size());
  CHECK(design["drives"].size() == 2);
  CHECK(design["frames"] == OrderedJson::array({0}));
  CHECK(design["modes"].is_null());
  REQUIRE(record.response.path[0].shapes.size() == record.mechanism.leaves.size());
  for (std::size_t k = 0; k < record.mechanism.leaves.size(); ++k) {
    const LeafShape& shape = record.response.path[0].shapes[k];
    REQUIRE(shape.undeflected.size() > 4);
    for (std::size_t i = 0; i < shape.undeflected.size(); ++i) {
      CHECK((shape.deflected[i] - shape.undeflected[i]).norm() < 1e-15);
      CHECK(shape.von_mises[i] < 0.1);  // Pa: rounding
    }
    // the mesh is as long as the leaf
    const Vector3d along =
        shape.undeflected[static_cast<std::size_t>(shape.points_along) - 1] - shape.undeflected[0];
    CHECK(along.norm() == Approx(record.mechanism.leaves[k].length));
  }
  const OrderedJson result = undeflected_result(record);
  CHECK(result["status"] == "undeflected");
  CHECK(result["path"].empty());
}

TEST_CASE("Loads of every case are shown, each case a drawing of its own") {
  const RunRecord record = undeflected(read_job(job_file("load_cases")));
  const OrderedJson scene = make_scene(record);
  REQUIRE(scene["designs"].size() == record.job.cases.size());
  std::size_t loads = 0;
  for (const auto& design : scene["designs"]) loads += design["loads"].size();
  CHECK(loads > 0);
  CHECK_FALSE(undeflected_result(record).contains("cases"));
}

TEST_CASE("A mechanism without equilibrium is shown, wrong input is not") {
  const test::Workplace folder;
  // a load far beyond buckling: run finds nothing, show does not look
  const std::string guide = "'" + job_file("parallel_guide") + "'",
                    load = " --set '/loads=[{\"force\": [\"-1e6 N\", 0, 0]}]'";
  CHECK(folder.run("run --quiet --set /expect=[] " + guide + load).code == 1);
  CHECK(folder.run("show " + guide + load).code == 0);
  const test::Outcome wrong =
      folder.run("show --out new " + guide + " --set /design/parameters/length=-1");
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Contains("/design/parameters/length"));
  CHECK_FALSE(folder.has("new"));
}

TEST_CASE("show --open starts xdg-open with the page, and says so where that fails") {
  const test::Workplace folder;
  fs::create_directory(folder / "bin");
  const auto install = [&](const char* last) {
    const fs::path program = folder / "bin/xdg-open";
    std::ofstream(program) << "#!/bin/sh\necho \"opens $1\"\n" << last << "\n";
    fs::permissions(program, fs::perms::owner_all);
  };
  const std::string arguments = "show --open '" + job_file("parallel_guide") + "'",
                    path = "PATH='" + (folder / "bin").string() + "':$PATH ";
  install("exit 0");
  const test::Outcome opened = folder.run(arguments, path);
  CHECK(opened.code == 0);
  CHECK(opened.out == "parallel_guide.show/report.html\nopens parallel_guide.show/report.html\n");
  install("exit 3");
  const test::Outcome failed = folder.run(arguments, path);
  CHECK(failed.code == 1);
  CHECK_THAT(failed.err, Contains("xdg-open did not open"));
}
