// Estimated errors as a user meets them: result.json, path.csv, what is chosen, exit codes.
#include "results/files/json_text.hpp"
#include "tests/results/results_tests.hpp"

namespace {

OrderedJson guide_job() {
  return OrderedJson::parse(R"({
    "flexopt": 1, "name": "guide", "job": "evaluate",
    "design": {"family": "parallel_guide",
               "parameters": {"length": "100 mm", "width": "30 mm", "thickness": "0.5 mm",
                              "spacing": "60 mm"},
               "material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3,
                            "density": "7800 kg/m^3"}},
    "end_effector": {"mass": "0.5 kg", "inertia": ["4e-4 kg m^2", "4e-4 kg m^2", "4e-4 kg m^2"]},
    "stroke": {"to": "10 mm", "points": 3}, "frequencies": 3})");
}

/// Exit code of a run of the job, its result, and what it says meanwhile.
struct Ran {
  int code = -1;
  OrderedJson result;
  std::string csv, err;
};
Ran run(const OrderedJson& job) {
  const test::Workplace folder;
  folder.put("job.json", job);
  const test::Outcome outcome = folder.run("run job.json");
  CAPTURE(outcome.err);
  REQUIRE(folder.has("job.out/result.json"));
  return {outcome.code, folder.json("job.out/result.json"), folder.content("job.out/path.csv"),
          outcome.err};
}

}  // namespace

TEST_CASE("estimates stand beside the numbers and change none of them") {
  OrderedJson job = guide_job();
  const Ran plain = run(job);
  job["model"] = {{"estimate", true}};
  Ran estimated = run(job);
  CHECK(plain.code == 0);
  CHECK(estimated.code == 0);
  CHECK_FALSE(plain.result["path"][1].contains("estimated_error"));
  CHECK_FALSE(plain.result.contains("accuracy"));
  CHECK_THAT(plain.csv, !Contains("estimated_error"));
  CHECK_THAT(estimated.csv, Contains("estimated_error.drive_load [N]") &&
                                Contains("estimated_error.frequencies.drive_locked.0 [Hz]"));
  for (OrderedJson& point : estimated.result["path"]) {
    const OrderedJson errors = point["estimated_error"];
    for (const char* of : {"relative", "absolute"}) {
      CHECK(errors[of]["support_stiffness"].size() == point["support_stiffness"].size());
      CHECK(errors[of]["frequencies"]["drive_free"].size() == 3);
      CHECK(errors[of]["displacement"].size() == 3);
      CHECK(errors[of]["compliance"]["drive_locked"].size() == 6);
      CHECK(errors[of]["principal_stiffness"]["translations"].size() ==
            point["principal_stiffness"]["translations"].size());
      CHECK(errors[of]["clearance"].is_null());
      CHECK(errors[of]["envelope"].is_null());
    }
    const double uz = point["support_stiffness"]["uz"],
                 relative = errors["relative"]["support_stiffness"]["uz"];
    CHECK(relative > 1e-5);
    CHECK(relative < 0.02);
    CHECK(errors["absolute"]["support_stiffness"]["uz"].get<double>() == Approx(uz * relative));
    point.erase("estimated_error");
  }
  CHECK(estimated.result["path"] == plain.result["path"]);
  const OrderedJson& largest = estimated.result["accuracy"]["largest"];
  CHECK(largest["relative"].get<double>() > 0);
  CHECK(estimated.result["message"].get<std::string>().find("largest estimated error") !=
        std::string::npos);
}

TEST_CASE("auto says what it chose and why, and ends with 1 where nothing is enough", "[slow]") {
  OrderedJson job = guide_job();
  job["model"] = {{"accuracy", "auto"}, {"tolerance", 0.02}};
  const Ran easy = run(job);
  CHECK(easy.code == 0);
  const OrderedJson& accuracy = easy.result["accuracy"];
  CHECK(unlike_text(easy.result, R"({"accuracy": {"met": true, "accuracy": "reduced"},
      "job": {"model": {"accuracy": "auto", "tolerance": 0.02}}})") == "");
  CHECK(accuracy["largest"]["relative"].get<double>() <= 0.02);
  CHECK(accuracy["tried"].size() == 1);

  job["frequencies"] = 0;
  job["stroke"] = {{"to", "1 mm"}, {"points", 2}};
  job["model"] = {{"accuracy", "auto"}, {"tolerance", 1e-7}, {"mesh", {29, 12}}};
  const Ran hard = run(job);
  CHECK(hard.code == 1);
  CHECK_THAT(hard.err, Contains("reduced leaves on 29 x 12 elements: off by"));
  CHECK(unlike_text(hard.result,
                    R"({"status": "tolerance_not_met", "accuracy": {"met": false}})") == "");
  CHECK_THAT(hard.result["message"].get<std::string>(), Contains("no mesh"));
  CHECK(hard.result["path"][1]["drive_load"].is_number());
}

TEST_CASE("a result whose estimate is beyond the limit is not ok") {
  OrderedJson job = guide_job();
  job["frequencies"] = 0;
  job["stroke"]["points"] = 2;
  job["model"] = {{"estimate", true}};
  const Ran believed = run(job);
  CHECK(believed.code == 0);
  const double largest = believed.result["accuracy"]["largest"]["relative"];
  REQUIRE(largest > 0);
  job["model"]["largest_estimate"] = 0.9 * largest;
  const Ran beyond = run(job);
  CHECK(beyond.code == 1);
  CHECK(beyond.result["status"] == "estimate_beyond_limit");
  CHECK_THAT(beyond.result["message"].get<std::string>(), Contains("Not believed"));
  CHECK(beyond.result["path"] == believed.result["path"]);
}

TEST_CASE("an optimisation has estimates at its optimum") {
  OrderedJson job = guide_job();
  job["job"] = "optimise";
  job["stroke"]["points"] = 2;
  job["frequencies"] = 0;
  job["model"] = {{"accuracy", "auto"}, {"tolerance", 0.05}};
  job["optimise"] = OrderedJson::parse(R"({
    "variables": [{"parameter": "thickness", "min": "0.3 mm", "max": "0.6 mm"}],
    "objective": {"maximise": "support_stiffness.uz", "over_stroke": "min"},
    "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "max": "10 N"}],
    "algorithm": {"library": "nlopt", "name": "LD_SLSQP"}})");
  const Ran ran = run(job);
  CHECK(ran.code == 0);
  CHECK(ran.result["accuracy"]["met"] == true);
  CHECK_THAT(ran.result["message"].get<std::string>(), Contains("of the optimum"));
  for (const OrderedJson& point : ran.result["path"])
    CHECK(point["estimated_error"]["relative"]["support_stiffness"]["uz"].get<double>() > 0);
}
