// The program refuses wrong input: exit code 2, the place and the rule on stderr, nothing written.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/binary.hpp"

namespace fs = std::filesystem;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

/// A folder of its own, removed at the end.
class Workplace {
 public:
  Workplace() : path_(fs::temp_directory_path() / ("flexopt_jobs_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Workplace() { fs::remove_all(path_); }

  fs::path operator/(const std::string& name) const { return path_ / name; }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return path_ / name;
  }

  /// Names of all there is, apart from the streams of the last run.
  std::vector<std::string> contents() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(path_))
      if (entry.path().extension() != ".stream") names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  fs::path path_;
};

struct Outcome {
  int code = 0;
  std::string output, errors;
};

std::string read(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

Outcome run(const Workplace& place, const std::string& arguments) {
  const fs::path out = place / "out.stream", err = place / "err.stream";
  const std::string command = "\"" + flexopt::test::binary() + "\" " + arguments + " >\"" +
                              out.string() + "\" 2>\"" + err.string() + "\" </dev/null";
  const int status = std::system(command.c_str());
  REQUIRE(WIFEXITED(status));
  return {WEXITSTATUS(status), read(out), read(err)};
}

std::string quoted(const fs::path& path) { return "\"" + path.string() + "\""; }

const json& table() {
  static const json cases = json::parse(read(FLEXOPT_SOURCE_DIR "/tests/jobs/wrong/cases.json"));
  return cases;
}

std::string base() { return table()["bases"]["evaluate"].dump(2); }

}  // namespace

TEST_CASE("every wrong job ends with exit code 2, place and rule, and writes nothing",
          "[jobs][slow]") {
  const Workplace place;
  int cases = 0;
  for (const json& item : table()["cases"]) {
    INFO(item["name"].get<std::string>());
    const json job = table()["bases"][item["base"].get<std::string>()].patch(item["patch"]);
    const fs::path file = place.write("job.json", job.dump(2));
    const Outcome outcome = run(place, "run " + quoted(file) + " --out " + quoted(place / "new"));
    CHECK(outcome.code == 2);
    CHECK(outcome.output.empty());
    CHECK_THAT(outcome.errors, Contains(item["pointer"].get<std::string>()));
    for (const json& part : item["says"])
      CHECK_THAT(outcome.errors, Contains(part.get<std::string>()));
    CHECK(place.contents() == std::vector<std::string>{"job.json"});
    ++cases;
  }
  CHECK(cases >= 40);
}

TEST_CASE("a job with several faults has a line for each, in the order of the file", "[jobs]") {
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
  const fs::path file = place.write("job.json", text);
  const std::string at = file.string() + ":";
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
  for (const std::string& command : {"validate " + quoted(file), "check-gradients " + quoted(file),
                                     "run " + quoted(file) + " --out " + quoted(place / "new")}) {
    INFO(command);
    const Outcome outcome = run(place, command + sets);
    CHECK(outcome.code == 2);
    CHECK(outcome.output.empty());
    std::vector<std::string> lines;
    std::istringstream stream(outcome.errors);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    INFO(outcome.errors);
    REQUIRE(lines.size() == expected.size() + 1);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK_THAT(lines[i], Catch::Matchers::StartsWith(expected[i][0]));
      CHECK_THAT(lines[i], Contains(expected[i][1]));
    }
    CHECK(lines.back() == "flexopt: 11 faults in the input; nothing was run");
    CHECK(place.contents() == std::vector<std::string>{"job.json"});
  }
}

TEST_CASE("every fault of a job reaches stderr with its place, and nothing is written", "[jobs]") {
  const Workplace place;
  for (const json& item : table()["several"]) {
    INFO(item["name"].get<std::string>());
    const json job = table()["bases"][item["base"].get<std::string>()].patch(item["patch"]);
    const fs::path file = place.write("job.json", job.dump(2));
    const Outcome outcome = run(place, "run " + quoted(file) + " --out " + quoted(place / "new"));
    CHECK(outcome.code == 2);
    CHECK(outcome.output.empty());
    for (const json& fault : item["faults"]) {
      CHECK_THAT(outcome.errors, Contains(": " + fault["pointer"].get<std::string>() + " = "));
      for (const json& part : fault["says"])
        CHECK_THAT(outcome.errors, Contains(part.get<std::string>()));
    }
    CHECK(place.contents() == std::vector<std::string>{"job.json"});
  }
}

TEST_CASE("of very many faults the first 50 are shown and the others counted", "[jobs]") {
  const Workplace place;
  json job = json::parse(base());
  job["loads"] = json::array();
  for (int i = 0; i < 60; ++i) job["loads"].push_back({{"force", {0, 0, "5 kg"}}});
  const Outcome outcome = run(place, "validate " + quoted(place.write("job.json", job.dump(2))));
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.errors, Contains("/loads/49/force/2") && Contains("... and 10 more") &&
                                 !Contains("/loads/50/"));
}

TEST_CASE("what is no job file ends with exit code 2 and its name", "[jobs]") {
  const Workplace place;
  const std::string whole = base();
  const auto refused = [&](const std::string& name, const std::string& says) {
    const auto before = place.contents();
    for (const char* command : {"run", "validate"}) {
      INFO(command << " " << name);
      const std::string out =
          std::string(command) == "run" ? " --out " + quoted(place / "new") : "";
      const Outcome outcome = run(place, std::string(command) + " " + quoted(place / name) + out);
      CHECK(outcome.code == 2);
      CHECK_THAT(outcome.errors, Contains(name) && Contains(says));
      CHECK(place.contents() == before);
    }
  };
  place.write("truncated.json", whole.substr(0, whole.size() / 2));
  place.write("empty.json", "");
  place.write("comment.json", "// a job\n" + whole);
  place.write("twice.json", "{\"flexopt\": 1, \"flexopt\": 1}");
  place.write("deep.json", std::string(100000, '['));
  place.write("bytes.json", std::string("\x7f\x45\x4c\x46\0\1\2", 7));
  fs::create_directory(place / "folder.json");
  refused("truncated.json", "line ");
  refused("empty.json", "empty");
  refused("comment.json", "line 1, column 1");
  refused("twice.json", "stands twice");
  refused("deep.json", "nested deeper");
  refused("bytes.json", "line 1");
  refused("folder.json", "folder");
  refused("missing.json", "no such file");
}

TEST_CASE("an output folder that cannot be written ends with exit code 2", "[jobs]") {
  const Workplace place;
  const fs::path job = place.write("job.json", base());
  const fs::path file = place.write("file", "in the way");
  for (const fs::path& out : {file, file / "below"}) {
    INFO(out.string());
    const Outcome outcome = run(place, "run " + quoted(job) + " --out " + quoted(out));
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.errors, Contains(out.string()));
    CHECK(read(file) == "in the way");
  }
  CHECK(run(place, "run " + quoted(job) + " --out /proc/flexopt.out").code == 2);
  CHECK(place.contents() == std::vector<std::string>{"file", "job.json"});
}

TEST_CASE("a wrong command line ends with exit code 2", "[jobs]") {
  const Workplace place;
  const std::string job = quoted(place.write("job.json", base()));
  for (const std::string& arguments : std::vector<std::string>{
           "", "fly", "run", "run " + job + " --oot x", "run " + job + " --threads 0",
           "run " + job + " --threads many", "validate", "designs no_family",
           "validate " + job + " --set stroke=1", "validate " + job + " --set /stroke/to",
           "validate " + job + " --set /strok/to=1", "validate " + job + " --set /stroke/to=1N"}) {
    INFO(arguments);
    const Outcome outcome = run(place, arguments);
    CHECK(outcome.code == 2);
    CHECK_FALSE(outcome.errors.empty());
  }
  CHECK(place.contents() == std::vector<std::string>{"job.json"});
}

TEST_CASE("a right job is valid, also with overrides", "[jobs]") {
  const Workplace place;
  const std::string job = quoted(place.write("job.json", base()));
  CHECK(run(place, "validate " + job).code == 0);
  CHECK(run(place, "validate " + job + " --set '/stroke/to=3 mm' --set /model/mesh=[4,2]").code ==
        0);
  CHECK(run(place, "schema").code == 0);
  CHECK(json::parse(run(place, "schema").output)["type"] == "object");
  CHECK(run(place, "designs cross_hinge").code == 0);
}

TEST_CASE("a stroke out of reach ends with exit code 1 and the points that converged", "[jobs]") {
  const Workplace place;
  const fs::path job = place.write("job.json", base());
  // no 100 mm leaf reaches 150 mm to its side
  const Outcome outcome = run(place, "run " + quoted(job) + " --out " + quoted(place / "out") +
                                         " --set '/stroke/to=150 mm' --set /stroke/points=16");
  CHECK(outcome.code == 1);
  const json result = json::parse(read(place / "out" / "result.json"));
  CHECK(result["status"] != "ok");
  REQUIRE(result["path"].size() == 16);
  CHECK(result["path"][0]["status"] == "converged");
  CHECK(result["path"][3]["status"] == "converged");
  CHECK(result["path"][15]["status"] != "converged");
}

TEST_CASE("a wrong design file is refused with its own file, line and column", "[jobs]") {
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
  const fs::path file = place.write("stage.json", design);
  const Outcome wrong = run(place, "validate " + file.string());
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.errors, Contains("stage.json:8:") && Contains("/leaves/0/thickness = ") &&
                               Contains("expected a length"));
  std::string text = design;
  text.replace(text.find("0.3 s"), 5, "0.3 mm");
  place.write("stage.json", text);
  place.write("job.json", R"({"flexopt": 1, "design": {"file": "stage.json",
    "material": "stavax"}, "stroke": {"to": "1 mm"}})");
  const Outcome loose = run(place, "run " + (place / "job.json").string());
  CHECK(loose.code == 2);
  CHECK_THAT(loose.errors, Contains("stage.json:7:") && Contains("did you mean 'end_effector'") &&
                               Contains("copy i = 0"));
  text.replace(text.find("end_efector"), 11, "end_effector");
  place.write("stage.json", text);
  CHECK(run(place, "validate " + file.string()).code == 0);
  CHECK(run(place, "validate " + (place / "job.json").string()).code == 0);
  const Outcome flat = run(place, "expand " + (place / "job.json").string());
  CHECK(flat.code == 0);
  CHECK_THAT(flat.output, Contains("\"leaf 1\"") && !Contains("repeat"));
  CHECK(place.contents() == std::vector<std::string>{"job.json", "stage.json"});
}
