// Load cases of a job: what they inherit, and what goals may say of them.
#include "optim/job/job_sections.hpp"
#include "support/base_jobs.hpp"
#include "support/temporary_folder.hpp"
#include "tests/optim/guide_job.hpp"

namespace {

json document() {
  return test::guide_job(R"({
    "end_effector": null, "frequencies": null,
    "stroke": {"to": "5 mm", "points": 3}, "gravity": [0, 0, "-9.81 m/s^2"],
    "loads": [{"name": "payload", "force": [0, 0, "-5 N"]}],
    "cases": {
      "up": {"loads": [{"name": "payload", "force": ["-40 N", 0, 0]}]},
      "pulled": {"load_path": {"force": [0, "20 N", 0], "points": 4}, "gravity": [0, 0, 0]},
      "as_it_is": {}},
    "optimise": {"objective": {"maximise": "support_stiffness.uz"}, "algorithm": null,
      "constraints": [{"quantity": "max_stress", "max": "400 MPa"},
                      {"quantity": "drive_load", "max": "9 N", "case": "up"}]}})");
}

}  // namespace

TEST_CASE("a load case has the job's own of all that it does not name") {
  const Job job = parse_job(document());
  REQUIRE(job.cases.size() == 3);
  CHECK(job.cases[0].name == "as_it_is");
  CHECK(job.cases[1].name == "pulled");
  CHECK(job.cases[2].name == "up");
  const StrokeRequest &plain = job.cases[0].request, &pulled = job.cases[1].request,
                      &up = job.cases[2].request;
  CHECK(plain.points == std::vector<double>{0, 0.0025, 0.005});
  CHECK(plain.loads.constant[0].force == Vector3d(0, 0, -5));
  CHECK(plain.loads.gravity == Vector3d(0, 0, -9.81));
  CHECK(pulled.points.size() == 4);
  CHECK_FALSE(pulled.loads.driven());
  CHECK(pulled.loads.gravity == Vector3d::Zero());
  CHECK(pulled.loads.constant[0].force == Vector3d(0, 0, -5));
  CHECK(up.points == plain.points);
  CHECK(up.loads.constant[0].force == Vector3d(-40, 0, 0));
  CHECK(up.loads.gravity == Vector3d(0, 0, -9.81));
  CHECK(job.request.points == plain.points);  // that of the first case
}

TEST_CASE("a job with load cases, as read, reads as the same job") {
  const Job job = parse_job(document()), again = parse_job(document_of(job));
  CHECK(document_of(again) == document_of(job));
  REQUIRE(again.cases.size() == job.cases.size());
  for (std::size_t k = 0; k < job.cases.size(); ++k) {
    CHECK(again.cases[k].request.points == job.cases[k].request.points);
    CHECK(again.cases[k].request.loads.constant[0].force ==
          job.cases[k].request.loads.constant[0].force);
  }
  CHECK(document_of(job).at("cases").at(2).at("name") == "up");
  CHECK_FALSE(document_of(job).at("cases").at(2).contains("gravity"));
}

TEST_CASE("what no load case uses is checked, and a note says so") {
  json all = document();
  for (auto& [name, own] : all["cases"].items()) own["gravity"] = {0, 0, 1};
  const Job job = parse_job(all);
  REQUIRE_FALSE(job.notes.empty());
  CHECK_THAT(job.notes.back(), Contains("No load case uses the job's own gravity"));
  all["gravity"] = {0, 0, "1 kg"};
  CHECK(test::refusal_of([&] { parse_job(all); }).pointer() == "/gravity/2");
}

TEST_CASE("a fault that only some load cases find in what they share names them") {
  json all = document();
  all["buckling"] = {{"load", "payload"}};
  all["cases"]["up"]["loads"][0]["name"] = "weight";
  const SpecError error = test::refusal_of([&] { parse_job(all); });
  CHECK(error.pointer() == "/buckling/load");
  CHECK_THAT(error.rule(), Contains("in the load case \"up\""));
}

TEST_CASE("a goal that names a load case asks nothing of the others") {
  json all = document();
  all["cases"]["up"]["buckling"] = {{"load", "payload"}};
  all["optimise"]["constraints"].push_back(
      {{"quantity", "buckling_load_factor"}, {"min", 2}, {"case", "up"}});
  const Job job = parse_job(all);
  CHECK(job.optimise->constraints[2].load_case == "up");
  CHECK(job.optimise->constraints[2].label == "buckling_load_factor min over stroke, case up");
  all["optimise"]["constraints"][2].erase("case");
  CHECK_THROWS_AS(parse_job(all), SpecError);
}

TEST_CASE("load cases come in the order of the job, as its file, a list or the result has it") {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "job.json").string();
  nlohmann::ordered_json text = base_job("evaluate");
  const std::vector<std::string> names{"x +3 mm, y/2", "b", "50 %", "a", "\u00b5"};
  for (const std::string& name : names) text["cases"][name] = nlohmann::ordered_json::object();
  text["cases"]["50 %"]["gravity"] = {0, 0, 1};
  test::put(file, text.dump());
  const auto names_of = [](const Job& job) {
    std::vector<std::string> found;
    for (const JobCase& one : job.cases) found.push_back(one.name);
    return found;
  };
  const Job job = read_job(file);
  CHECK(names_of(job) == names);
  CHECK(names_of(parse_job(document_of(job))) == names);
  CHECK(job.cases[2].request.loads.gravity == Vector3d(0, 0, 1));
  json list = text;
  list["cases"] = {{{"name", "b"}}, {{"name", "a"}, {"gravity", {0, 0, "1 m"}}}};
  try {
    parse_job(list);
    FAIL("a wrong unit");
  } catch (const SpecError& error) {
    CHECK(error.pointer() == "/cases/1/gravity/2");
  }
}

TEST_CASE("a job has up to 500 load cases") {
  json document = base_job("evaluate");
  for (int k = 0; k < 500; ++k)
    document["cases"].push_back({{"name", "case " + std::to_string(k)}});
  CHECK(parse_job(document).cases.size() == 500);
  document["cases"].push_back({{"name", "one more"}});
  CHECK_THROWS_AS(parse_job(document), SpecError);
}
