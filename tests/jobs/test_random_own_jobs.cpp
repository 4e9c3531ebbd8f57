// Random mechanisms of their own: what the program says is "ok" is the same found in another way.
// Many thousands of them are looked at by the benchmark random_own_jobs, by all laws.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "optim/job/job.hpp"
#include "support/changed_jobs.hpp"
#include "support/compared_runs.hpp"
#include "support/differences.hpp"
#include "support/random_jobs.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

constexpr int count = 300;

unsigned long long seed_of(int k) { return first_quick_job + static_cast<unsigned long long>(k); }

void look_at(int first, int last) {
  int ok = 0, looked_at = 0;
  for (int k = first; k < last; ++k) {
    const Differences found = differences_of(random_own_job(seed_of(k)), seed_of(k), Laws::quick);
    CAPTURE(k, found.status, found.message);
    CHECK(found.status != "refused");
    ok += found.status == "ok";
    for (const Difference& d : found.laws) {
      looked_at += d.end == Difference::End::kept;
      if (d.end != Difference::End::broken) continue;
      CAPTURE(d.law, d.error);
      FAIL_CHECK(d.what);
    }
  }
  // the sample is one of working mechanisms, and the laws are about them
  CHECK(ok > (last - first) * 7 / 10);
  CHECK(looked_at > 2 * (last - first));
}

}  // namespace

TEST_CASE("a rotation that is all but held has no support stiffness") {
  // held at the first point and, as the body turns about another axis, no longer at the second
  const auto [seed, direction] =
      GENERATE(std::pair{227817ULL, Direction::ry}, std::pair{230062ULL, Direction::rx});
  const auto d = static_cast<std::size_t>(index(direction));
  for (const char* accuracy : {"reduced", "full"}) {
    CAPTURE(seed, accuracy);
    json job = random_own_job(seed);
    job["model"]["accuracy"] = accuracy;
    const Run done = run(job);
    REQUIRE(done.record.status == "ok");
    const std::vector<PathPoint>& path = done.record.response.path;
    CHECK_FALSE(path[0].support_stiffness[d]);
    CHECK(path[0].support_stiffness[5]);
    CHECK(path[1].support_stiffness[d]);
  }
}

TEST_CASE("a number of a random mechanism is the same found in another way", "[slow]") {
  look_at(0, 30);
}

TEST_CASE("numbers of 300 random mechanisms are the same found in another way", "[slow]") {
  look_at(30, count);
}

TEST_CASE("random mechanisms of their own have all that a mechanism may have") {
  std::map<std::string, int> kinds;
  for (int seed = 0; seed < 120; ++seed) {
    const json job = random_own_job(static_cast<unsigned long long>(seed));
    const json& m = job["design"]["mechanism"];
    for (const char* key : {"loads", "gravity", "temperature", "assembly"})
      kinds[key] += job.contains(key);
    for (const char* list : {"joints", "springs", "frames"})
      kinds[list] += m.contains(list) && !m[list].empty();
    for (const json& leaf : m["leaves"]) {
      for (const char* key : {"curve", "fold", "diameter", "reinforcement", "material"})
        kinds[key] += leaf.contains(key);
      for (const char* size : {"width", "thickness"})
        if (leaf.contains(size))
          kinds[std::string("profile of ") + size] += !leaf[size].is_number();
    }
    for (const json& body : m["bodies"]) {
      kinds["massless"] += !body.contains("mass") && body["name"] != "end_effector";
      if (body.contains("held")) ++kinds["held " + std::to_string(body["held"].size())];
    }
    const json drives = drives_of(job);
    ++kinds[std::to_string(drives.size()) + " drives"];
    for (const json& drive : drives) {
      kinds["relative drive"] += drive.contains("other");
      kinds["rotation"] += drive["direction"].get<std::string>()[0] == 'r';
    }
    ++kinds[std::to_string(std::min<std::size_t>(m["bodies"].size(), 4)) + " bodies"];
  }
  const json all = json::parse(R"(["loads", "gravity", "temperature", "assembly", "joints",
      "springs", "frames", "curve", "fold", "diameter", "reinforcement", "material",
      "profile of width", "profile of thickness", "massless", "held 1", "held 2", "held 3",
      "held 4", "held 5", "1 drives", "2 drives", "3 drives", "4 drives", "relative drive",
      "rotation", "1 bodies", "2 bodies", "3 bodies", "4 bodies"])");
  for (const std::string kind : all) {
    CAPTURE(kind);
    CHECK(kinds[kind] >= 3);
  }
}
