#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"
#include "results/files/result_json.hpp"
#include "results/run/run.hpp"
#include "results/server/serve.hpp"
#include "support/leaf_job.hpp"

using namespace flexopt;
using Catch::Contains;
using nlohmann::json;

namespace {

json leaf() { return test::leaf_job(); }

json optimised() {
  json job = leaf();
  job["job"] = "optimise";
  job["optimise"] = json::parse(R"({
    "variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "0.6 mm"}],
    "objective": {"maximise": "support_stiffness.uz", "over_stroke": "min"},
    "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "max": "1 N"},
                    {"expression": "length/width", "min": 3, "max": 5}]})");
  return job;
}

}  // namespace

TEST_CASE("A moved design has the numbers of a run of the job with these values",
          "[results][server]") {
  const Explorer explorer(parse_job(leaf()));
  const OrderedJson answer = explorer.evaluate({{"thickness", 0.5e-3}, {"length", 0.07}});
  REQUIRE(answer["ok"] == true);
  CHECK(answer["seconds"] > 0);
  CHECK(answer["goals"].empty());
  CHECK(answer["scene"]["designs"].size() == 1);

  json same = leaf();
  same["design"]["parameters"]["thickness"] = "0.5 mm";
  same["design"]["parameters"]["length"] = "70 mm";
  Silent nobody;
  const OrderedJson run = make_result(run_any(parse_job(same), {}, nobody));
  CHECK(answer["result"]["path"] == run["path"]);
  CHECK(answer["result"]["job"] == run["job"]);
  CHECK(answer["result"]["path"] != explorer.evaluate({})["result"]["path"]);
}

TEST_CASE("Goals of an optimisation are judged at the moved design", "[results][server]") {
  const Explorer explorer(parse_job(optimised()));
  const OrderedJson thin = explorer.evaluate({{"thickness", 0.2e-3}}),
                    thick = explorer.evaluate({{"thickness", 0.6e-3}});
  REQUIRE(thin["goals"].size() == 3);
  CHECK(thin["goals"][0]["label"] == "support_stiffness.uz min over stroke");
  CHECK(thin["goals"][0]["role"] == "objective");
  CHECK(thin["goals"][0]["unit"] == "N/m");
  double least = 1e300, load = 0;
  for (const auto& point : thick["result"]["path"]) {
    least = std::min(least, point["support_stiffness"]["uz"].get<double>());
    load = std::max(load, std::abs(point["drive_load"].get<double>()));
  }
  CHECK(thick["goals"][0]["value"].get<double>() == Approx(least).epsilon(1e-12));
  CHECK(thick["goals"][1]["value"].get<double>() == Approx(load).epsilon(1e-12));
  CHECK(thick["goals"][1]["max"] == 1.0);
  CHECK(thick["goals"][1]["min"].is_null());
  CHECK(thin["goals"][1]["met"] == (thin["goals"][1]["value"].get<double>() <= 1));
  CHECK(thick["goals"][1]["met"] == (load <= 1));
  CHECK(thin["goals"][1]["met"] != thick["goals"][1]["met"]);  // 0.1 N and 2.7 N
  CHECK(thin["goals"][2]["value"] == 4.0);
  CHECK(thin["goals"][2]["met"] == true);
}

TEST_CASE("A broken rule is told, and so is a stroke that is not reached", "[results][server]") {
  const Explorer explorer(parse_job(leaf()));
  const OrderedJson wrong = explorer.evaluate({{"width", 0.01}, {"thickness", 0.6e-3}});
  CHECK(wrong["ok"] == true);
  json far = leaf();
  far["stroke"]["to"] = "75 mm";
  const OrderedJson lost = Explorer(parse_job(far)).evaluate({{"length", 0.04}});
  CHECK(lost["ok"] == false);
  CHECK_FALSE(lost.contains("result"));
  CHECK_FALSE(lost["message"].get<std::string>().empty());
  json hinge = leaf();
  hinge["design"]["parameters"]["width"] = {{"expression", "0.02 + 0*length"}};
  hinge["design"]["parameters"]["thickness"] = {{"expression", "(length - 0.05)/100"}};
  const OrderedJson broken = Explorer(parse_job(hinge)).evaluate({{"length", 0.045}});
  CHECK(broken["ok"] == false);
  CHECK_THAT(broken["message"].get<std::string>(), Contains("/design/parameters/thickness"));
}

TEST_CASE("The job that is written is one that a run takes", "[results][server]") {
  const Explorer explorer(parse_job(optimised()));
  const std::string text = explorer.job_text({{"thickness", 0.45e-3}});
  const Job job = parse_job(json::parse(text));
  CHECK(job.kind == JobKind::optimise);
  CHECK(job.design.parameters.at("thickness") == 0.45e-3);
  CHECK(*job.optimise->variables[0].start == 0.45e-3);
  CHECK(text.ends_with("}\n"));
}
