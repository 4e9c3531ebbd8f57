// Shards of a run and their merging, as a user does it.
#include "results/run/shard.hpp"

#include "optim/problem/line_log.hpp"
#include "results/files/json_text.hpp"
#include "tests/results/results_tests.hpp"

using namespace flexopt::test;

namespace {

/// Sampled tolerances and a map about a leaf.
OrderedJson leaf_around() {
  OrderedJson job = leaf_job();
  job["tolerances"] = OrderedJson::parse(R"({"thickness": "10 um", "length": "50 um"})");
  job["tolerance_samples"] = OrderedJson::parse(R"({"count": 5, "seed": 1})");
  job["maps"] = OrderedJson::parse(R"([{"parameters": [
      {"parameter": "thickness", "min": "0.2 mm", "max": "0.5 mm"},
      {"parameter": "length", "min": "70 mm", "max": "90 mm"}],
      "points": [3, 2], "quantities": [{"quantity": "drive_load", "over_stroke": "last"}]}])");
  return job;
}

struct Runs : Workplace {
  explicit Runs(const OrderedJson& job) { put("leaf.json", job); }
  /// shard.1, shard.2, …
  void shards(int of) {
    for (int k = 1; k <= of; ++k) {
      const Outcome one = run("run leaf.json --quiet --shard " + std::to_string(k) + "/" +
                              std::to_string(of) + " --out shard." + std::to_string(k));
      CAPTURE(one.err);
      REQUIRE(one.code == 0);
      REQUIRE_FALSE(has("shard." + std::to_string(k) + "/result.json"));
    }
  }
};

}  // namespace

TEST_CASE("a shard is one of so many") {
  const Shard shard = read_shard("3/16");
  CHECK(shard.number == 3);
  CHECK(shard.of == 16);
  for (const char* text : {"", "3", "3/", "/16", "0/16", "17/16", "3/16/2", "a/b", "3/0", "-1/4"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH(read_shard(text), Contains("expected NUMBER/OF"));
  }
}

TEST_CASE("numbers as an array of Slurm") {
  CHECK(array_text({}).empty());
  CHECK(array_text({4}) == "4");
  CHECK(array_text({1, 2, 3, 7, 9, 10}) == "1-3,7,9-10");
}

TEST_CASE("merged shards are the bytes of one run, in any order and again") {
  struct Kind {
    const char* name;
    OrderedJson job;
    std::vector<std::string> files;
  };
  const std::vector<Kind> kinds{
      {"compare", compared_leaf(), {"job.json", "evaluations.jsonl", "comparison.csv"}},
      {"optimise", optimised_leaf(), {"evaluations.jsonl", "result.json", "report.html"}},
      {"around", leaf_around(), {"result.json", "tolerances.csv", "maps.csv", "report.html"}}};
  for (const Kind& kind : kinds) {
    CAPTURE(kind.name);
    Runs runs(kind.job);
    const Outcome alone = runs.run("run leaf.json --quiet --out alone");
    CAPTURE(alone.err);
    REQUIRE(alone.code <= 1);
    runs.shards(3);
    for (const char* order : {"shard.3 shard.1 shard.2", "shard.1 shard.2 shard.3"}) {
      const Outcome merged = runs.run("merge --quiet --out merged " + std::string(order));
      CAPTURE(order, merged.err);
      CHECK(merged.code == alone.code);
      for (const std::string& file : kind.files) {
        CAPTURE(file);
        CHECK(runs.content("alone/" + file).size() > 20);
        CHECK(runs.content("merged/" + file) == runs.content("alone/" + file));
      }
      CHECK_FALSE(runs.has("merged/units.jsonl"));
    }
  }
}

TEST_CASE("a shard says how much of the work it is, and goes on where it stopped") {
  Runs runs(compared_leaf());
  const Outcome first = runs.run("run leaf.json --quiet --shard 2/4");
  CHECK(first.out == "3 of 12 evaluations\nshard 2 of 4: leaf.2-of-4.out\n");
  const std::string log = runs.content("leaf.2-of-4.out/evaluations.jsonl");
  const Outcome json = runs.run("run leaf.json --quiet --shard 2/4 --json");
  const OrderedJson said = OrderedJson::parse(json.out);
  CHECK(said["status"] == "shard");
  CHECK(said["of"] == 4);
  CHECK(said["loops"][0]["here"] == 3);
  CHECK(runs.content("leaf.2-of-4.out/evaluations.jsonl") == log);  // nothing is evaluated twice
  // half a line of a shard that was killed
  runs.put("leaf.2-of-4.out/evaluations.jsonl",
           log.substr(0, log.find('\n', log.find('\n') + 1) + 9));
  CHECK(runs.run("run leaf.json --quiet --shard 2/4").code == 0);
  CHECK(runs.content("leaf.2-of-4.out/evaluations.jsonl") == log);
}

TEST_CASE("what is missing is told, or computed") {
  Runs runs(compared_leaf());
  REQUIRE(runs.run("run leaf.json --quiet --out alone").code == 0);
  runs.shards(4);
  fs::remove_all(runs.path() / "shard.2");
  const Outcome told = runs.run("merge shard.1 shard.3 shard.4 --out merged");
  CHECK(told.code == 2);
  CHECK_THAT(told.err, Contains("shards 2 of 4") && Contains("--array=2"));
  CHECK_FALSE(runs.has("merged"));
  const Outcome computed = runs.run("merge shard.1 shard.3 shard.4 shard.3 --compute --out merged");
  CHECK(computed.code == 0);
  CHECK_THAT(computed.err, Contains("shard 3 is there twice") && Contains("9 from the log"));
  CHECK(runs.content("merged/evaluations.jsonl") == runs.content("alone/evaluations.jsonl"));
}

TEST_CASE("what does not belong together is refused") {
  Runs runs(compared_leaf());
  runs.shards(2);
  const auto refused = [&](const std::string& arguments, const std::string& why) {
    const Outcome outcome = runs.run(arguments);
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains(why));
  };
  refused("merge shard.1 nowhere --out merged", "no shard.json in it");
  refused("merge shard.1 shard.2 --out shard.1", "a shard is in this folder");
  refused("run leaf.json --shard 2/2 --out shard.1", "shard 1/2 is in this folder");
  refused("run leaf.json --shard 3/2", "expected NUMBER/OF");

  REQUIRE(runs.run("run leaf.json --quiet --out whole").code == 0);
  refused("run leaf.json --shard 1/2 --out whole", "a run that is no shard is in this folder");
  REQUIRE(runs.run("run leaf.json --quiet --shard 3/3 --out third").code == 0);
  refused("merge shard.1 third --out merged", "shard 3 of 3: expected one of 2");

  OrderedJson other = compared_leaf();
  other["stroke"]["to"] = "5 mm";
  runs.put("leaf.json", other);
  REQUIRE(runs.run("run leaf.json --quiet --shard 2/2 --out other").code == 0);
  refused("merge shard.1 other --out merged", "/stroke");
  CHECK_FALSE(runs.has("merged"));
}

TEST_CASE("two values of one evaluation are refused") {
  Runs runs(compared_leaf());
  runs.shards(2);
  fs::copy(runs.path() / "shard.1", runs.path() / "again");
  const fs::path file = runs.path() / "again/evaluations.jsonl";
  std::vector<std::string> lines = read_log_lines(file);
  REQUIRE(!lines.empty());
  const std::string before = "\"drive_load\":[";
  const auto at = lines.front().find(before);
  REQUIRE(at != std::string::npos);
  lines.front().insert(at + before.size(), "1");
  put(file, log_text(log_identity_of(file), lines));
  const Outcome outcome = runs.run("merge shard.1 shard.2 again --out merged");
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.err, Contains("expected the same values as in"));
  // what does not fit its checksum is no value
  std::string spoilt = runs.content("again/evaluations.jsonl");
  spoilt.erase(spoilt.find(before) + before.size(), 1);
  put(file, spoilt);
  const Outcome refused = runs.run("merge shard.1 shard.2 again --out merged");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("line 2: {") && Contains("checksum"));
}

TEST_CASE("a design file is found from wherever shards are merged") {
  OrderedJson job = compared_leaf();
  job["design"].erase("family");
  job["design"]["file"] = "leaf.design.json";
  Runs runs(job);
  runs.put("leaf.design.json", runs.run("designs --export leaf_spring").out);
  REQUIRE(runs.run("run leaf.json --quiet --out alone").code == 0);
  runs.shards(2);
  const std::string from = "'" + runs.path().string() + "/";
  const Outcome merged = run_program(
      "/", "merge --quiet " + from + "shard.1' " + from + "shard.2' --out " + from + "merged'");
  CAPTURE(merged.err);
  CHECK(merged.code == 0);
  CHECK(runs.content("merged/job.json") == runs.content("alone/job.json"));
  CHECK(runs.content("merged/evaluations.jsonl") == runs.content("alone/evaluations.jsonl"));
}

TEST_CASE("a job without independent work has no shards") {
  Runs runs(leaf_job());
  const Outcome outcome = runs.run("run leaf.json --shard 1/2");
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.err, Contains("no independent work to share"));
  CHECK_FALSE(runs.has("leaf.1-of-2.out"));
}
