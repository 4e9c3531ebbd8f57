// The program refuses wrong input: exit code 2, the place and the rule on stderr, nothing written.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/program.hpp"

using namespace flexopt::test;
namespace fs = std::filesystem;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

const json& table() {
  static const json cases =
      json::parse(content_of(FLEXOPT_SOURCE_DIR "/tests/jobs/wrong/cases.json"));
  return cases;
}

/// The document of a case, run: refused, and nothing written.
std::string refused(const Workplace& place, const json& item) {
  place.put("job.json", table()["bases"][item["base"].get<std::string>()].patch(item["patch"]));
  const Outcome outcome = place.run("run job.json --out new");
  CHECK(outcome.code == 2);
  CHECK(outcome.out.empty());
  CHECK(place.names() == std::vector<std::string>{"job.json"});
  return outcome.err;
}

}  // namespace

TEST_CASE("every wrong job ends with exit code 2, places and rules, and writes nothing", "[slow]") {
  const Workplace place;
  REQUIRE(table()["cases"].size() >= 40);
  for (const char* list : {"cases", "several"})
    for (const json& item : table()[list]) {
      INFO(item["name"].get<std::string>());
      const std::string errors = refused(place, item);
      for (const json& fault : item.value("faults", json::array({item}))) {
        const std::string pointer = fault["pointer"];
        CHECK_THAT(errors, Contains(item.contains("faults") ? ": " + pointer + " = " : pointer));
        for (const std::string part : fault["says"]) CHECK_THAT(errors, Contains(part));
      }
    }
}

TEST_CASE("a job with several faults has a line for each, in the order of the file") {
  const Workplace place;
  const std::string text = R"({
  "flexopt": 1, "name": "guide", "jop": "evaluate",
  "design": {
    "family": "parallel_guide",
    "parameters": {"length": "100 N", "width": "30 mm",
                   "thicknes": "0.5 mm", "spacing": "60 mm"},
    "material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3,
                 "density": "7800 kg/m^3", "density": "7900 kg/m^3"}
  },
  "end_effector": {"mass": -1},
  "stroke": {"from": 0, "points": 3},
  "loads": [{"force": [0, 0, "5 kg"]}],
  "model": {"accuracy": "fulll", "degree": 6},
  "frequencies": 4
})";
  place.put("job.json", text);
  const std::string at = "job.json:";
  const std::vector<std::vector<std::string>> expected{
      {at + "2:34: /jop = \"evaluate\"", "did you mean 'job'"},
      {at + "5:30: /design/parameters/length = \"100 N\"", "a length"},
      {at + "6:20: /design/parameters/thicknes = \"0.5 mm\"", "did you mean 'thickness'"},
      {at + "8:44: /design/material/density", "stands twice in one object, in line 8"},
      {at + "10:28: /end_effector/mass = -1", "0 <= value"},
      {at + "11:13: /stroke/to = nothing", "it is required"},
      {at + "12:30: /loads/0/force/2 = \"5 kg\"", "a force"},
      {at + "13:25: /model/accuracy = \"fulll\"", "did you mean 'full'"},
      {at + "13:44: /model/degree = 6", "5 or 7"},
      {"--set: /frequencies = \"many\"", "a whole number"},
      {"--set: /parasitic/skip/0 = \"leafs\"", "did you mean 'leaf'"}};
  const std::string sets = " --set /frequencies=many --set '/parasitic={\"skip\": [\"leafs\"]}'";
  for (const std::string command :
       {"validate job.json", "check-gradients job.json", "run job.json --out new"}) {
    INFO(command);
    const Outcome outcome = place.run(command + sets);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    std::vector<std::string> lines;
    std::istringstream stream(outcome.err);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    INFO(outcome.err);
    REQUIRE(lines.size() == expected.size() + 1);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK_THAT(lines[i], Catch::Matchers::StartsWith(expected[i][0]));
      CHECK_THAT(lines[i], Contains(expected[i][1]));
    }
    CHECK(lines.back() == "flexopt: 11 faults in the input; nothing was run");
    CHECK(place.names() == std::vector<std::string>{"job.json"});
  }
}

TEST_CASE("of very many faults the first 50 are shown and the others counted") {
  const Workplace place;
  json job = table()["bases"]["evaluate"];
  job["loads"] = json::array();
  for (int i = 0; i < 60; ++i) job["loads"].push_back({{"force", {0, 0, "5 kg"}}});
  place.put("job.json", job);
  const Outcome outcome = place.run("validate job.json");
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.err, Contains("/loads/49/force/2") && Contains("... and 10 more") &&
                              !Contains("/loads/50/"));
}

TEST_CASE("what is no job file ends with exit code 2 and its name") {
  const Workplace place;
  const std::string whole = table()["bases"]["evaluate"].dump(2);
  struct Row {
    const char *name, *says;
    json content;  // null: there is no file to write
  };
  fs::create_directory(place / "folder.json");
  for (const Row& row : {Row{"truncated.json", "line ", whole.substr(0, whole.size() / 2)},
                         {"empty.json", "empty", ""},
                         {"comment.json", "line 1, column 1", "// a job\n" + whole},
                         {"twice.json", "stands twice", "{\"flexopt\": 1, \"flexopt\": 1}"},
                         {"deep.json", "nested deeper", std::string(100000, '[')},
                         {"bytes.json", "line 1", std::string("\x7f\x45\x4c\x46\0\1\2", 7)},
                         {"folder.json", "folder", nullptr},
                         {"missing.json", "no such file", nullptr}}) {
    if (row.content.is_string()) place.put(row.name, row.content.get<std::string>());
    const auto before = place.names();
    for (const std::string command : {"run --out new ", "validate "}) {
      INFO(command << row.name);
      const Outcome outcome = place.run(command + row.name);
      CHECK(outcome.code == 2);
      CHECK_THAT(outcome.err, Contains(row.name) && Contains(row.says));
      CHECK(place.names() == before);
    }
  }
}

TEST_CASE("a wrong design file is refused with its own file, line and column") {
  const Workplace place;
  const char* design = R"({
  "flexopt_design": 1,
  "parameters": {"length": {"unit": "m", "default": "80 mm"}},
  "bodies": [{"name": "end_effector", "at": ["length", 0, 0]}],
  "leaves": [{"name": "leaf {i}", "repeat": {"i": [0, 1]},
              "base": {"body": "ground", "at": [0, "10 mm*i", 0]},
              "tip": {"body": "end_efector", "at": ["length", "10 mm*i", 0]},
              "across": [0, 0, 1], "width": "20 mm", "thickness": "0.3 s"}],
  "drive": {"direction": "uy"}
})";
  place.put("stage.json", design);
  const Outcome wrong = place.run("validate stage.json");
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Contains("stage.json:8:") && Contains("/leaves/0/thickness = ") &&
                            Contains("expected a length"));
  std::string text = design;
  text.replace(text.find("0.3 s"), 5, "0.3 mm");
  place.put("stage.json", text);
  place.put("job.json", R"({"flexopt": 1, "design": {"file": "stage.json",
    "material": "stavax"}, "stroke": {"to": "1 mm"}})");
  const Outcome loose = place.run("run job.json");
  CHECK(loose.code == 2);
  CHECK_THAT(loose.err, Contains("stage.json:7:") && Contains("did you mean 'end_effector'") &&
                            Contains("copy i = 0"));
  text.replace(text.find("end_efector"), 11, "end_effector");
  place.put("stage.json", text);
  CHECK(place.run("validate stage.json").code == 0);
  CHECK(place.run("validate job.json").code == 0);
  const Outcome flat = place.run("expand job.json");
  CHECK(flat.code == 0);
  CHECK_THAT(flat.out, Contains("\"leaf 1\"") && !Contains("repeat"));
  CHECK(place.names() == std::vector<std::string>{"job.json", "stage.json"});
}
