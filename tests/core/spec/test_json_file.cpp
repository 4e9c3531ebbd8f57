#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

std::string complaint_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const SpecError& error) {
    return error.what();
  }
  return "accepted";
}

std::string parse_complaint(const std::string& text) {
  return complaint_of([&] { parse_json(text, "job.json"); });
}

std::string override_complaint(json document, const std::string& assignment) {
  return complaint_of([&] { apply_override(document, assignment); });
}

}  // namespace

TEST_CASE("broken JSON is refused with line and column", "[spec][json]") {
  CHECK_THAT(parse_complaint("{\n  \"a\": 1,\n"), Contains("job.json") && Contains("line 3"));
  CHECK_THAT(parse_complaint("{\"a\": 1,}"), Contains("line 1, column 9"));
  CHECK_THAT(parse_complaint("{\"a\": 1} x"), Contains("line 1"));
  CHECK_THAT(parse_complaint("{\"a\": NaN}"), Contains("line 1"));
  CHECK_THAT(parse_complaint("{\"a\": 1e999}"), Contains("out of range") || Contains("overflow"));
  CHECK_THAT(parse_complaint("{\"a\": 1 // one\n}"), Contains("line 1"));
  CHECK_THAT(parse_complaint("{\"a\": \"\xff\"}"), Contains("UTF-8"));
  CHECK_THAT(parse_complaint(" \n"), Contains("empty"));
}

TEST_CASE("a key that stands twice in one object is refused", "[spec][json]") {
  CHECK_THAT(parse_complaint(R"({"a": 1, "b": {"c": 1, "c": 2}})"), Contains("\"c\" stands twice"));
  CHECK(parse_json(R"({"a": {"a": 1}, "b": [{"a": 1}, {"a": 2}]})", "").size() == 2);
}

TEST_CASE("bottomless nesting is refused", "[spec][json]") {
  CHECK_THAT(parse_complaint(std::string(100000, '[')), Contains("nested deeper than 32"));
  CHECK_THAT(parse_complaint(std::string(40, '[') + std::string(40, ']')), Contains("nested"));
}

TEST_CASE("a path that is no readable file is refused by name", "[spec][json]") {
  const auto folder = std::filesystem::temp_directory_path() / "flexopt_test_json_file";
  std::filesystem::create_directories(folder);
  CHECK_THAT(complaint_of([&] { read_json_file(folder.string()); }),
             Contains(folder.string()) && Contains("folder"));
  CHECK_THAT(complaint_of([&] { read_json_file((folder / "none.json").string()); }),
             Contains("no such file"));
  CHECK_THAT(complaint_of([&] { read_json_file("/dev/zero"); }), Contains("larger than"));
  const auto file = folder / "good.json";
  std::ofstream(file) << R"({"a": [1, 2]})";
  CHECK(read_json_file(file.string()) == json::parse(R"({"a": [1, 2]})"));
  std::filesystem::remove_all(folder);
}

TEST_CASE("an override replaces, adds and appends", "[spec][json]") {
  json document = json::parse(R"({"stroke": {"to": 1}, "loads": [{"force": [0, 0, 0]}]})");
  apply_override(document, "/stroke/to=20 mm");
  apply_override(document, "/stroke/points=5");
  apply_override(document, "/loads/0/force/2=-3.5");
  apply_override(document, "/loads/-={\"moment\": [0, 0, \"1 N m\"]}");
  apply_override(document, "/model/accuracy=full");
  apply_override(document, "/name=a=b");
  CHECK(document == json::parse(R"({"stroke": {"to": "20 mm", "points": 5},
      "loads": [{"force": [0, 0, -3.5]}, {"moment": [0, 0, "1 N m"]}],
      "model": {"accuracy": "full"}, "name": "a=b"})"));
}

TEST_CASE("an override that leads nowhere is refused", "[spec][json]") {
  const json document = json::parse(R"({"stroke": {"to": 1}, "loads": []})");
  CHECK_THAT(override_complaint(document, "stroke/to=1"), Contains("/pointer=value"));
  CHECK_THAT(override_complaint(document, "/stroke/to"), Contains("/pointer=value"));
  CHECK_THAT(override_complaint(document, "/stroke/to/x=1"), Contains("no parts"));
  CHECK_THAT(override_complaint(document, "/loads/0/force=1"), Contains("0 elements"));
  CHECK_THAT(override_complaint(document, "/loads/x=1"), Contains("0 elements"));
  CHECK_THAT(override_complaint(document, "/a~2=1"), Contains("JSON pointer"));
  CHECK_THAT(override_complaint(document, "/name=\xff"), Contains("UTF-8"));
  CHECK_THAT(override_complaint(document, R"(/model={"mesh": 1, "mesh": 2})"), Contains("twice"));
}

TEST_CASE("a long value is shown short and whole in UTF-8", "[spec][json]") {
  const std::string text = shown(json(std::string(100, 'x') + "\xff"));
  CHECK(text.size() <= 80);
  std::string umlauts;
  for (int i = 0; i < 100; ++i) umlauts += "ü";
  CHECK_NOTHROW(json(shown(json(umlauts))).dump());
}
