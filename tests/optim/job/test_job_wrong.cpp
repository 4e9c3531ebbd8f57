// Every wrong job is refused at the right place, with a rule that helps. The cases are data:
// tests/jobs/wrong/cases.json.
#include <fstream>
#include <random>
#include <set>

#include "core/spec/json_file.hpp"
#include "support/base_jobs.hpp"
#include "tests/optim/optim_tests.hpp"

TEST_CASE("every wrong job is refused with pointer, value, rule and what is allowed") {
  const json table = read_json_file(FLEXOPT_SOURCE_DIR "/tests/jobs/wrong/cases.json");
  for (const json& base : table["bases"]) REQUIRE_NOTHROW(parse_job(base));
  REQUIRE(table["cases"].size() >= 40);
  std::set<std::string> names;
  for (const json& item : table["cases"]) {
    const std::string name = item["name"];
    INFO(name);
    CHECK(names.insert(name).second);
    const json job = table["bases"][item["base"].get<std::string>()].patch(item["patch"]);
    try {
      parse_job(job);
      FAIL_CHECK("accepted");
    } catch (const SpecError& error) {
      CHECK(error.faults().size() == 1);  // and no consequences
      CHECK(error.pointer() == item["pointer"]);
      for (const json& part : item["says"])
        CHECK_THAT(error.what(), Contains(part.get<std::string>()));
    }
  }
}

TEST_CASE("all faults of a job are reported, and none that is only a consequence") {
  const json table = read_json_file(FLEXOPT_SOURCE_DIR "/tests/jobs/wrong/cases.json");
  REQUIRE(table["several"].size() >= 10);
  for (const json& item : table["several"]) {
    INFO(item["name"].get<std::string>());
    const json job = table["bases"][item["base"].get<std::string>()].patch(item["patch"]);
    try {
      parse_job(job);
      FAIL_CHECK("accepted");
    } catch (const SpecError& error) {
      INFO(error.what());
      CHECK(error.faults().size() == item["faults"].size());
      for (const json& expected : item["faults"]) {
        INFO(expected["pointer"].get<std::string>());
        const auto found = std::ranges::find(error.faults(), expected["pointer"].get<std::string>(),
                                             &Fault::pointer);
        REQUIRE(found != error.faults().end());
        for (const json& part : expected["says"])
          CHECK_THAT(found->text(), Contains(part.get<std::string>()));
      }
    }
  }
}

TEST_CASE("no two changes of a job's JSON escape as anything but a SpecError", "[slow]") {
  const json table = read_json_file(FLEXOPT_SOURCE_DIR "/tests/jobs/wrong/cases.json");
  const json junk = json::parse(R"([null, true, -1, 0, 1e300, "x", "1 mm", [], {}, [[]],
      {"expression": "length"}, "length/2"])");
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) { return random() % n; };
  int refused = 0;
  for (const json& base : table["bases"]) {
    std::vector<std::string> paths;
    const json flat = base.flatten();
    for (const auto& [path, leaf] : flat.items()) paths.push_back(path);
    for (int trial = 0; trial < 1500; ++trial) {
      json job = base;
      for (int change = 0; change < 2; ++change) {
        json::json_pointer at(paths[below(paths.size())]);
        for (std::size_t up = below(3); up > 0 && !at.parent_pointer().empty(); --up) at.pop_back();
        if (!job.contains(at)) continue;
        if (below(3) == 0 && job[at.parent_pointer()].is_object())
          job[at.parent_pointer()].erase(at.back());
        else
          job[at] = junk[below(junk.size())];
      }
      INFO(job.dump());
      try {
        parse_job(job);
      } catch (const SpecError& error) {
        ++refused;
        for (const Fault& fault : error.faults()) CHECK_FALSE(fault.rule.empty());
      }
    }
  }
  CHECK(refused > 2000);
}

TEST_CASE("no single change of a job's JSON escapes as anything but a SpecError", "[slow]") {
  const json table = read_json_file(FLEXOPT_SOURCE_DIR "/tests/jobs/wrong/cases.json");
  const json junk =
      json::parse(R"([null, true, -1, 0, 1e300, 0.5, "", "x", "1 mm", "\u0000", [], {},
      [[]], [1, 2, 3], {"expression": "length"}, {"": 0}])");
  int refused = 0;
  for (const json& base : table["bases"]) {
    const json flat = base.flatten();
    for (const auto& [path, leaf] : flat.items())
      for (json::json_pointer at(path); !at.empty(); at.pop_back())  // the value and what holds it
        for (const json& value : junk) {
          json job = base;
          job[at] = value;
          INFO(at.to_string() << " = " << value);
          try {
            parse_job(job);
          } catch (const SpecError& error) {
            ++refused;
            CHECK_FALSE(error.rule().empty());
          }
        }
  }
  CHECK(refused > 1000);
}
