// Every wrong job is refused at the right place, with a rule that helps. The cases are data:
// tests/jobs/wrong/cases.json.
#include <catch2/catch.hpp>
#include <fstream>
#include <set>

#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;

TEST_CASE("every wrong job is refused with pointer, value, rule and what is allowed",
          "[optim][job]") {
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
      CHECK(error.pointer() == item["pointer"]);
      for (const json& part : item["says"])
        CHECK_THAT(error.what(), Contains(part.get<std::string>()));
    }
  }
}

TEST_CASE("no single change of a job's JSON escapes as anything but a SpecError", "[optim][job]") {
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
