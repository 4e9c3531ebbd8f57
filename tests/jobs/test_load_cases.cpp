// The program runs jobs with several load cases and with tolerances: each case has the numbers of
// a job with this case alone, and a run that was killed ends with the same bytes.
#include <sstream>

#include "child.hpp"

using namespace child;

namespace {

json job_document() {
  return json::parse(R"({
    "flexopt": 1, "name": "two attitudes", "job": "evaluate",
    "design": {"family": "parallel_guide", "parameters": {"length": "100 mm", "width": "30 mm",
               "thickness": "0.4 mm", "spacing": "60 mm"}, "material": "stavax"},
    "end_effector": {"mass": "0.5 kg"},
    "stroke": {"to": "5 mm", "points": 3}, "frequencies": 2,
    "cases": {
      "hanging": {"loads": [{"force": ["40 N", 0, 0]}]},
      "pulled": {"load_path": {"force": [0, "2 N", 0], "points": 2}},
      "standing": {"loads": [{"force": ["-40 N", 0, 0]}], "stroke": {"to": "8 mm", "points": 2}}},
    "optimise": {
      "variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "1 mm"}],
      "objective": {"maximise": "support_stiffness.uz"},
      "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "max": "9 N",
                       "case": "hanging"}],
      "algorithm": {"library": "nlopt", "name": "LD_SLSQP"}, "starts": 2},
    "tolerances": {"thickness": "10 um"}, "tolerance_samples": {"count": 10}})");
}

int run(const Folder& place, const std::string& name, const json& document) {
  return finished(start(place / (name + ".json"), document, place / name, "2"));
}

json result_of(const Folder& place, const std::string& name) {
  return json::parse(read(place / name / "result.json"));
}

}  // namespace

TEST_CASE("each load case has the result of a job with this case alone", "[slow]") {
  const Folder place;
  REQUIRE(run(place, "all", job_document()) == 0);
  const json all = result_of(place, "all");
  CHECK(all["case"] == "hanging");
  CHECK(all["path"] == all["cases"]["hanging"]["path"]);
  REQUIRE(all["cases"].size() == 3);
  std::size_t rows = 0;
  for (const auto& [name, own] : all["cases"].items()) {
    INFO(name);
    json document = job_document();
    const json keys = document["cases"][name];
    for (const char* key : {"cases", "tolerances", "tolerance_samples", "optimise"})
      document.erase(key);
    if (keys.contains("load_path")) document.erase("stroke");
    for (const auto& [key, value] : keys.items()) document[key] = value;
    REQUIRE(run(place, name, document) == 0);
    const json one = result_of(place, name);
    for (const char* key :
         {"status", "message", "units", "quantities", "path", "frequency_derivatives", "shapes"})
      CHECK(own.value(key, json()) == one.value(key, json()));
    rows += one["path"].size();
    CHECK(fs::exists(place / "all" / "cases" / name / "shapes.pvd"));
  }
  // the largest drive load of all, and where it is
  const json& largest = all["extremes"]["drive_load"]["largest"];
  CHECK(largest["value"] == all["cases"][largest["case"].get<std::string>()]["path"]
                               [largest["point"].get<std::size_t>()]["drive_load"]);
  std::istringstream csv(read(place / "all" / "path.csv"));
  std::string line;
  std::getline(csv, line);
  CHECK(line.starts_with("case,stroke [m],stroke [1],status,"));
  std::size_t counted = 0;
  while (std::getline(csv, line)) ++counted;
  CHECK(counted == rows);
  // the tolerances of a job that does not search look at the goals of its section "optimise"
  const json& tolerances = all["tolerances"];
  REQUIRE(tolerances["goals"].size() == 2);
  CHECK(tolerances["goals"][1]["decisive"]["case"] == "hanging");
  CHECK(tolerances["cases"]["standing"]["path"].size() == 2);
  CHECK(tolerances["samples"]["count"] == 10);
  CHECK(tolerances["room"]["scale"].get<double>() > 0);
  CHECK(fs::exists(place / "all" / "tolerances.csv"));
}

TEST_CASE("an optimisation over load cases that was cut short ends with the same bytes", "[slow]") {
  const Folder place;
  json document = job_document();
  document["job"] = "optimise";
  REQUIRE(run(place, "whole", document) == 0);
  const fs::path whole = place / "whole", cut = place / "cut";
  const json result = result_of(place, "whole");
  CHECK(result["optimum"]["goal"]["decisive"]["case"].is_string());
  CHECK(result["optimum"]["constraints"][0]["case"] == "hanging");
  CHECK(result["optimum"]["verified"]["cases"]["standing"]["path"].size() == 2);
  // heading and some evaluations, the last line torn
  fs::create_directories(cut);
  const std::string log = read(whole / "evaluations.jsonl");
  REQUIRE(log.size() > 400);
  std::ofstream(cut / "evaluations.jsonl", std::ios::binary) << log.substr(0, log.size() / 2);
  fs::copy_file(whole / "job.json", cut / "job.json");
  REQUIRE(run(place, "cut", document) == 0);
  check_same(whole, cut,
             {"result.json", "path.csv", "history.csv", "tolerances.csv", "evaluations.jsonl"});
}

TEST_CASE("load cases keep the job's order, and any name has a folder of its own", "[slow]") {
  const Folder place;
  json document = job_document();
  for (const char* key : {"tolerances", "tolerance_samples", "optimise", "frequencies"})
    document.erase(key);
  document["stroke"]["points"] = 2;
  document["cases"] = {{{"name", "x +1 mm, y/2"}}, {{"name", ".a"}, {"gravity", {0, 0, 1}}}};
  REQUIRE(run(place, "named", document) == 0);
  const auto result = nlohmann::ordered_json::parse(read(place / "named" / "result.json"));
  std::vector<std::string> names;
  for (const auto& [name, own] : result["cases"].items()) names.push_back(name);
  CHECK(names == std::vector<std::string>{"x +1 mm, y/2", ".a"});
  CHECK(result["case"] == "x +1 mm, y/2");
  CHECK(fs::exists(place / "named/cases/x +1 mm, y%2F2/shapes.pvd"));
  CHECK(fs::exists(place / "named/cases/%2Ea/shapes.pvd"));
}
