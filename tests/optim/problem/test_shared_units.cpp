#include "optim/problem/evaluation_log.hpp"
#include "support/leaf_job.hpp"
#include "tests/optim/optim_tests.hpp"

using namespace flexopt::test;

namespace {

/// Whether all is known, what was kept, and how many units were worked on.
struct Ran {
  bool complete = false;
  std::map<int, double> kept;
  int worked = 0;
};

Ran run(Sharing sharing, const Job& job, const std::filesystem::path& log,
        const std::string& loop = "squares 1") {
  Ran ran;
  SharedUnits units(sharing, job, log, "a");
  const auto work = [&](int unit) {
    ++ran.worked;
    return OrderedJson(0.1 * unit * unit);
  };
  const auto keep = [&](int unit, const json& yield) { ran.kept[unit] = yield.get<double>(); };
  ran.complete = units.run(loop, 10, 1, {}, work, keep);
  return ran;
}

}  // namespace

TEST_CASE("units of shards make the whole, which is worked on once") {
  const TemporaryFolder folder;
  const Job job = parse_job(json::parse(leaf_job().dump()));
  const auto log = folder.path() / "units.jsonl";
  const Ran first = run(Sharing(Shard{1, 2}), job, log);
  CHECK_FALSE(first.complete);
  CHECK(first.worked == 5);
  // of one file here; merge_logs makes it of several
  const Ran second = run(Sharing(Shard{2, 2}), job, log);
  CHECK(second.worked == 5);
  const Ran whole = run(Sharing(), job, log);
  CHECK(whole.complete);
  CHECK(whole.worked == 0);
  REQUIRE(whole.kept.size() == 10);
  for (const auto& [unit, value] : whole.kept) CHECK(value == 0.1 * unit * unit);
  CHECK(run(Sharing(), job, log, "squares 2").worked == 10);
}

TEST_CASE("a unit whose yield was changed on the disk is refused") {
  const TemporaryFolder folder;
  const Job job = parse_job(json::parse(leaf_job().dump()));
  const auto log = folder.path() / "units.jsonl";
  run(Sharing(), job, log);
  std::string text = content_of(log);
  const std::size_t at = text.find("[\"squares 1\",5,2.5");
  REQUIRE(at != std::string::npos);
  text[at + 15] = '3';
  put(log, text);
  CHECK_THROWS_WITH(run(Sharing(), job, log),
                    Contains("units.jsonl") && Contains("line 7: [\"squares 1\",5,3.5"));
}

TEST_CASE("units of another job are refused") {
  const TemporaryFolder folder;
  OrderedJson document = leaf_job();
  const auto log = folder.path() / "units.jsonl";
  run(Sharing(), parse_job(json::parse(document.dump())), log);
  document["stroke"]["to"] = "5 mm";
  CHECK_THROWS_WITH(run(Sharing(), parse_job(json::parse(document.dump())), log),
                    Contains("/job/stroke"));
}

TEST_CASE("a loop's name follows from what it depends on") {
  CHECK(loop_name("maps", "a") == loop_name("maps", "a"));
  CHECK(loop_name("maps", "a") != loop_name("maps", "b"));
  CHECK(loop_name("maps", "a").starts_with("maps "));
}
