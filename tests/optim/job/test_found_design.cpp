// What the folder of a run is read as, the design that it found; and a job at that design.
#include "optim/job/found_design.hpp"

#include <catch2/catch.hpp>

#include "core/spec/spec_error.hpp"
#include "support/temporary_folder.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

const json design = json::parse(R"({"family": "leaf_spring", "material": {"density": 7800},
    "parameters": {"length": 0.1, "width": 0.02, "thickness": {"expression": "width/40"}}})");

json result_of(const json& optimum) {
  return {{"job", {{"job", optimum.is_null() ? "evaluate" : "optimise"}, {"design", design}}},
          {"optimum", optimum}};
}

FoundDesign found_in(const json& result, const json& job = {}) {
  const test::TemporaryFolder folder;
  test::put(folder / "result.json", result.dump());
  if (!job.is_null()) test::put(folder / "job.json", job.dump());
  return found_design(folder.path().string(), "--result");
}

}  // namespace

TEST_CASE("an evaluated design is its own result, an optimum goes before") {
  CHECK(found_in(result_of({})).parameters == ParameterValues{{"length", 0.1}, {"width", 0.02}});
  const FoundDesign found = found_in(result_of(
      {{"parameters", {{"length", 0.07}, {"thickness", 4e-4}, {"material.density", 7000.0}}}}));
  const json of = design_of(found);
  CHECK(of["parameters"]["length"] == 0.07);
  CHECK(of["parameters"]["width"] == 0.02);
  CHECK(of["parameters"]["thickness"] == design["parameters"]["thickness"]);  // stays a formula
  CHECK(of["material"]["density"] == 7000.0);
}

TEST_CASE("a job at a result has its numbers and options, but for those of the command line") {
  const json flat = {{"length", 0.1}, {"width", 0.02}, {"thickness", 4e-4}},
             wire = {{"section", "circular"}, {"length", 0.07}, {"thickness", 5e-4}};
  const auto job_of = [](const json& parameters) {
    return json{
        {"job", "evaluate"},
        {"design", {{"family", "leaf_spring"}, {"material", "stavax"}, {"parameters", parameters}}},
        {"stroke", {{"to", 0.001}}}};
  };
  const auto at_result = [&](const json& job, const json& run,
                             const std::vector<std::string>& overrides = {}) {
    const test::TemporaryFolder folder, own;
    test::put(own / "job.json", job_of(job).dump());
    test::put(folder / "result.json", json{{"job", document_of(parse_job(job_of(run)))}}.dump());
    return read_job_at((own / "job.json").string(), overrides, folder.path().string()).design;
  };
  const DesignSpec round = at_result(flat, wire), back = at_result(wire, flat);
  CHECK(round.choices.at("section") == "circular");
  CHECK(round.parameters ==
        ParameterValues{{"length", 0.07}, {"width", 5e-4}, {"thickness", 5e-4}});
  CHECK(back.choices.at("section") == "rectangular");
  CHECK(back.parameters == ParameterValues{{"length", 0.1}, {"width", 0.02}, {"thickness", 4e-4}});

  json other = flat;
  other["thickness"] = 3e-4;
  const auto thickness = [&](const std::string& set) {
    return at_result(flat, other, {set}).parameters.at("thickness");
  };
  CHECK(thickness("/design/parameters/length=0.08") == 3e-4);
  CHECK(thickness("/design/parameters/thickness=0.2 mm") == 2e-4);
  CHECK(thickness("/design/parameters=" + flat.dump()) == 4e-4);
  for (const char* option : {"/design/parameters/section", "/design/section"}) {
    const DesignSpec set = at_result(
        flat, wire, {option + std::string("=rectangular"), "/design/parameters/width=0.03"});
    CHECK(set.choices.at("section") == "rectangular");
    CHECK(set.parameters ==
          ParameterValues{{"length", 0.07}, {"width", 0.03}, {"thickness", 5e-4}});
  }
}

TEST_CASE("a search begins at the result, but for what the command line says") {
  json job = {{"job", "optimise"}, {"design", design}, {"stroke", {{"to", 0.001}}}};
  job["design"]["material"] = "stavax";
  job["design"]["parameters"]["thickness"] = 4e-4;
  job["optimise"] = {{"objective", {{"maximise", "support_stiffness.uz"}, {"over_stroke", "min"}}},
                     {"variables", json::array()}};
  for (const char* name : {"length", "width"})
    job["optimise"]["variables"].push_back({{"parameter", name}, {"min", 0.01}, {"max", 0.2}});
  const test::TemporaryFolder folder, own;
  test::put(own / "job.json", job.dump());
  test::put(folder / "result.json",
            result_of({{"parameters", {{"length", 0.07}, {"width", 0.03}}}}).dump());
  using Starts = std::vector<std::optional<double>>;
  const auto starts = [&](const std::string& set) {
    const Job at = read_job_at((own / "job.json").string(), {set}, folder.path().string());
    return Starts{at.optimise->variables[0].start, at.optimise->variables[1].start};
  };
  CHECK(starts("/name=x") == Starts{0.07, 0.03});
  CHECK(starts("/optimise/variables/1/start=0.05") == Starts{0.07, 0.05});
  CHECK(starts("/design/parameters/width=0.04") == Starts{0.07, 0.04});
}

TEST_CASE("a result may be larger than what users write") {
  json result = result_of({});
  result["shapes"] = std::string(std::size_t{17} << 20, 'x');
  CHECK(found_in(result).parameters.at("length") == 0.1);
}

TEST_CASE("a material of the job's own replaces that of the result") {
  const test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "run");
  test::put(folder.path() / "run/result.json", result_of({}).dump());
  FaultList faults;
  const json own = {{"youngs_modulus", 2e11}, {"shear_modulus", 8e10}};
  const json document = with_found_design(
      {{"design", {{"result", "run"}, {"material", own}, {"parameters", {{"width", 0.03}}}}}},
      folder.path().string(), faults);
  CHECK(faults.faults().empty());
  CHECK(document["design"]["material"] == own);
  CHECK(document["design"]["parameters"]["width"] == 0.03);
  CHECK(document["design"]["parameters"]["length"] == 0.1);
}

TEST_CASE("of ranked designs the best one is what was found") {
  json whole = result_of({});
  whole["ranking"] = {{{"rank", 1}, {"result", result_of({{"parameters", {{"length", 0.03}}}})}},
                      {{"rank", 2}, {"result", result_of({{"parameters", {{"length", 0.04}}}})}}};
  CHECK(found_in(whole).parameters.at("length") == 0.03);
  whole["ranking"] = json::array();
  CHECK_THROWS_WITH(found_in(whole), Contains("a design was ranked"));
}

TEST_CASE("what is no finished run of a design is refused") {
  CHECK_THROWS_WITH(found_in(json::array()), Contains("of no run"));
  CHECK_THROWS_WITH(found_in(result_of(json::object())), Contains("found a design"));
  CHECK_THROWS_WITH(found_in({{"job", {{"designs", json::array()}}}}), Contains("of one design"));
  const json result = result_of({});
  CHECK_NOTHROW(found_in(result, result["job"]));
  CHECK_THROWS_WITH(found_in(result, {{"job", "evaluate"}}), Contains("an earlier run"));
}
