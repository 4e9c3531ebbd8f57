// Every wrong job is refused at the right place, with a rule that helps. The cases are data:
// tests/jobs/wrong/cases.json.
#include <fstream>
#include <set>

#include "core/spec/json_file.hpp"
#include "support/base_jobs.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

const json& table() {
  static const json cases = read_json_file(FLEXOPT_SOURCE_DIR "/tests/jobs/wrong/cases.json");
  return cases;
}

/// The refusal of the job of a case.
SpecError refused(const json& item) {
  const json job = table()["bases"][item["base"].get<std::string>()].patch(item["patch"]);
  return test::refusal_of([&] { parse_job(job); });
}

}  // namespace

TEST_CASE("every wrong job is refused with pointer, value, rule and what is allowed") {
  for (const json& base : table()["bases"]) REQUIRE_NOTHROW(parse_job(base));
  REQUIRE(table()["cases"].size() >= 40);
  std::set<std::string> names;
  for (const json& item : table()["cases"]) {
    const std::string name = item["name"];
    INFO(name);
    CHECK(names.insert(name).second);
    const SpecError error = refused(item);
    CHECK(error.faults().size() == 1);  // and no consequences
    CHECK(error.pointer() == item["pointer"]);
    for (const std::string part : item["says"]) CHECK_THAT(error.what(), Contains(part));
  }
}

TEST_CASE("all faults of a job are reported, and none that is only a consequence") {
  REQUIRE(table()["several"].size() >= 10);
  for (const json& item : table()["several"]) {
    const SpecError error = refused(item);
    INFO(item["name"].get<std::string>() << error.what());
    CHECK(error.faults().size() == item["faults"].size());
    for (const json& expected : item["faults"]) {
      const std::string pointer = expected["pointer"];
      INFO(pointer);
      const auto found = std::ranges::find(error.faults(), pointer, &Fault::pointer);
      REQUIRE(found != error.faults().end());
      for (const std::string part : expected["says"]) CHECK_THAT(found->text(), Contains(part));
    }
  }
}

TEST_CASE("no single change of a job's JSON escapes as anything but a SpecError", "[slow]") {
  const json junk =
      json::parse(R"([null, true, -1, 0, 1e300, 0.5, "", "x", "1 mm", "\u0000", [], {},
      [[]], [1, 2, 3], {"expression": "length"}, {"": 0}])");
  int refused = 0;
  for (const json& base : table()["bases"]) {
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
