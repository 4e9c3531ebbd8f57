#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"
#include "results/files/folder.hpp"
#include "results/files/scene.hpp"
#include "results/report/report.hpp"
#include "results/run/run.hpp"
#include "support/fixture.hpp"

using namespace flexopt;
namespace fs = std::filesystem;

TEST_CASE("A run leaves exactly its files", "[results][run]") {
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

TEST_CASE("The same run gives the same bytes, timings apart", "[results][run]") {
  const test::TemporaryFolder a, b;
  RunRecord record = test::optimised_hinge();
  write_run(a.path(), record);
  record.timings["total"] = 99;
  write_run(b.path(), record);
  for (const std::string& name : test::names_in(a.path())) {
    CAPTURE(name);
    const bool same = test::content_of(a.path() / name) == test::content_of(b.path() / name);
    CHECK(same == (name != "timings.json"));
  }
}

TEST_CASE("The report made again from the folder is the report of the run", "[results][run]") {
  const test::TemporaryFolder folder;
  const RunRecord record = test::optimised_hinge();
  write_job(folder.path(), record.job);
  write_run(folder.path(), record);
  const std::string first = test::content_of(folder.path() / "report.html");
  fs::remove(folder.path() / "report.html");
  write_report(folder.path(), read_result(folder.path()), read_scene(folder.path()));
  CHECK((test::content_of(folder.path() / "report.html") == first));
}

TEST_CASE("A run says why frequency derivatives are missing", "[results][run]") {
  RunRecord record = test::evaluated_hinge();
  const std::string whole = record.message;
  CHECK(whole.find("no frequency derivatives") == std::string::npos);
  record.response.no_frequency_derivatives = "60 modes of 18 unknowns";
  conclude(record);
  CHECK(record.status == "ok");
  CHECK(record.message ==
        whole.substr(0, whole.size() - 1) + "; no frequency derivatives: 60 modes of 18 unknowns.");
}

TEST_CASE("A failed expectation is in the result file", "[results][run]") {
  const test::TemporaryFolder folder;
  RunRecord record = test::evaluated_hinge();
  record.job.expect = {{"/path/4/drive_load", 1e3, 1, "wrong on purpose"}};
  const WrittenRun written = write_run(folder.path(), record);
  CHECK(written.failed_expectations.size() == 1);
  const auto result = OrderedJson::parse(test::content_of(folder.path() / "result.json"));
  CHECK(result["status"] == "expectation_failed");
  CHECK(result["expectations"][0]["ok"] == false);
}

TEST_CASE("A folder without a run, or with a broken one, is wrong input", "[results][run]") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(read_result(folder.path() / "missing"), SpecError);
  CHECK_THROWS_AS(read_result(folder.path()), SpecError);
  write_file(folder.path() / "result.json", "{\"path\": [");
  CHECK_THROWS_AS(read_result(folder.path()), SpecError);
  write_file(folder.path() / "result.json", "[1]");
  CHECK_THROWS_AS(read_result(folder.path()), SpecError);
}
