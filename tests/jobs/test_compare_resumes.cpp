// A batch that is killed and started again ends with the same bytes as one that ran through.

#include <algorithm>

#include "child.hpp"

using namespace child;

namespace {

constexpr int designs = 24, models = 2;

json job_document() {
  return json::parse(R"({
    "flexopt": 1, "name": "killed", "job": "compare",
    "design": {"family": "cross_hinge",
      "parameters": {"length": "60 mm", "width": "20 mm", "thickness": "0.3 mm", "gap": "2 mm"},
      "material": "stavax"},
    "end_effector": {"mass": "0.3 kg", "inertia": ["1e-4 kg m^2", "1e-4 kg m^2", "1e-4 kg m^2"]},
    "stroke": {"to": "20 deg", "points": 5}, "frequencies": 6,
    "samples": {"count": 24, "seed": 3, "vary": [
      {"parameter": "width", "min": "8 mm", "max": "60 mm", "scale": "log"},
      {"parameter": "thickness", "min": "0.15 mm", "max": "0.8 mm"}]},
    "models": [{"name": "default"}, {"name": "coarse", "mesh": [6, 2]}]
  })");
}

std::ptrdiff_t lines(const fs::path& file) {
  const std::string text = read(file);
  return std::count(text.begin(), text.end(), '\n');
}

/// The result without what the clock decides.
json without_clock(const fs::path& out) {
  json result = json::parse(read(out / "result.json"));
  for (json& model : result["comparison"]["models"])
    for (const char* key : {"speed_up", "speed_up_with_reduction"}) {
      REQUIRE(model[key].get<double>() > 0);
      model.erase(key);
    }
  return result;
}

}  // namespace

TEST_CASE("a batch killed and started again ends with the same bytes", "[slow]") {
  const Folder folder;
  const fs::path job = folder / "job.json";
  const fs::path through = folder / "through", killed = folder / "killed";
  REQUIRE(finished(start(job, job_document(), through, "1")) == 0);

  int kills = 0;
  for (const std::ptrdiff_t enough : {5, 20, 40}) {
    const pid_t child = start(job, killed, "2");
    for (int status = 0; lines(killed / "evaluations.jsonl") < enough;) {
      if (waitpid(child, &status, WNOHANG) == child) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (kill(child, SIGKILL) == 0) ++kills;
    finished(child);
    CHECK_FALSE(fs::exists(killed / "result.json"));
  }
  CHECK(kills == 3);
  CHECK(lines(killed / "evaluations.jsonl") < 1 + designs * (1 + models));
  REQUIRE(finished(start(job, killed, "2")) == 0);

  check_same(through, killed, {"job.json", "evaluations.jsonl", "comparison.csv"});
  CHECK(without_clock(killed) == without_clock(through));
  CHECK(lines(through / "evaluations.jsonl") == 1 + designs * (1 + models));
  CHECK(lines(through / "comparison.csv") == 1 + designs * models);
}
