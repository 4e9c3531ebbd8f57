#include "results/files/folder.hpp"
#include "results/files/scene.hpp"
#include "results/report/report.hpp"
#include "results/run/run.hpp"
#include "tests/results/results_tests.hpp"

TEST_CASE("A run leaves exactly its files") {
  const test::TemporaryFolder folder;
  write_job(folder.path(), test::optimised_hinge().job);
  write_run(folder.path(), test::optimised_hinge());
  CHECK(test::names_in(folder.path()) ==
        std::vector<std::string>{"history.csv", "job.json", "path.csv", "report.html",
                                 "result.json", "scene.json", "shape_000.vtu", "shape_001.vtu",
                                 "shape_002.vtu", "shape_003.vtu", "shape_004.vtu", "shapes.pvd",
                                 "timings.json"});
  const auto timings = OrderedJson::parse(test::content_of(folder.path() / "timings.json"));
  CHECK(timings["seconds"]["total"] == 0.125);
}

TEST_CASE("A run says why frequency derivatives are missing") {
  RunRecord record = test::evaluated_hinge();
  const std::string whole = record.message;
  CHECK(whole.find("no frequency derivatives") == std::string::npos);
  record.response.no_frequency_derivatives = "60 modes of 18 unknowns";
  conclude(record);
  CHECK(record.status == "ok");
  CHECK(record.message ==
        whole.substr(0, whole.size() - 1) + "; no frequency derivatives: 60 modes of 18 unknowns.");
}

TEST_CASE("A folder without a run, or with a broken one, is wrong input") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(read_result(folder.path() / "missing"), SpecError);
  CHECK_THROWS_AS(read_result(folder.path()), SpecError);
  write_file(folder.path() / "result.json", "{\"path\": [");
  CHECK_THROWS_AS(read_result(folder.path()), SpecError);
  write_file(folder.path() / "result.json", "[1]");
  CHECK_THROWS_AS(read_result(folder.path()), SpecError);
}
