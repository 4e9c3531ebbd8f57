#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

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

TEST_CASE("broken JSON is refused with line and column") {
  CHECK_THAT(parse_complaint("{\n  \"a\": 1,\n"), Contains("job.json") && Contains("line 3"));
  CHECK_THAT(parse_complaint("{\"a\": 1,}"), Contains("line 1, column 9"));
  CHECK_THAT(parse_complaint("{\"a\": 1,}"), Catch::Matchers::StartsWith("job.json:1:9: not JSON"));
  CHECK_THAT(parse_complaint("[1,\n,2]"), Catch::Matchers::StartsWith("job.json:2:1: not JSON"));
  CHECK_THAT(parse_complaint("[1,\n  1e999]"),
             Catch::Matchers::StartsWith("job.json:2:3: not JSON"));
  CHECK_THAT(parse_complaint("{\"a\": 1} x"), Contains("line 1"));
  CHECK_THAT(parse_complaint("{\"a\": NaN}"), Contains("line 1"));
  CHECK_THAT(parse_complaint("{\"a\": 1e999}"), Contains("out of range") || Contains("overflow"));
  CHECK_THAT(parse_complaint("{\"a\": 1 // one\n}"), Contains("line 1"));
  CHECK_THAT(parse_complaint("{\"a\": \"\xff\"}"), Contains("UTF-8"));
  CHECK_THAT(parse_complaint(" \n"), Contains("empty"));
}

TEST_CASE("a key that stands twice in one object is refused") {
  CHECK_THAT(parse_complaint(R"({"a": 1, "b": {"c": 1, "c": 2}})"), Contains("\"c\" stands twice"));
  CHECK(parse_json(R"({"a": {"a": 1}, "b": [{"a": 1}, {"a": 2}]})", "").size() == 2);
}

TEST_CASE("a key that stands twice is refused with both its lines") {
  const JsonText text{"{\n  \"a\": 1,\n  \"b\": [{\"c\": 1,\n\n     \"c\": 2}],\n  \"a\": 3}",
                      "job.json"};
  std::vector<Fault> faults;
  const json document = parse_json(text, faults);
  CHECK(document == json::parse(R"({"a": 3, "b": [{"c": 2}]})"));
  REQUIRE(faults.size() == 2);
  CHECK(faults[0].pointer == "/b/0/c");
  CHECK(faults[0].line == 5);
  CHECK(faults[0].column == 6);
  CHECK_THAT(faults[0].text(), Contains("job.json:5:6: /b/0/c = 2; ") && Contains("lines 3 and 5"));
  CHECK(faults[1].pointer == "/a");
  CHECK_THAT(faults[1].text(), Contains("job.json:6:3: /a") && Contains("lines 2 and 6"));
}

TEST_CASE("every value is found at its line and column") {
  // keys with escapes and quotes, letters of several bytes, nested lists, numbers of all forms
  const std::string text =
      "\xEF\xBB\xBF{\"a\\\"b\": \"x\\\\\",\n"
      "  \"\xC3\xBC/\xE2\x82\xAC~\" : [ -1.5e+3,[true,{ \"k\":null }],\r\n"
      "\t[[]] , \"\xF0\x9F\x98\x80\\u00e9 ]}\", 7],\n"
      "\n"
      "\"empty\":{},\"last\":false}";
  const json document = json::parse(text);
  struct Case {
    const char* pointer;
    int line, column;
  };
  for (const Case& c : {Case{"", 1, 1},
                        {"/a\"b", 1, 10},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0", 2, 12},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0/0", 2, 14},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0/1", 2, 22},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0/1/0", 2, 23},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0/1/1", 2, 28},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0/1/1/k", 2, 34},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0/2", 3, 2},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0/2/0", 3, 3},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0/3", 3, 9},
                        {"/\xC3\xBC~1\xE2\x82\xAC~0/4", 3, 23},
                        {"/empty", 5, 9},
                        {"/empty/missing/part", 5, 9},
                        {"/last", 5, 19}}) {
    INFO(c.pointer);
    std::vector<Fault> faults{{.pointer = c.pointer, .value = "", .rule = ""}};
    locate(faults, {text, "job.json"}, {});
    CHECK(faults[0].source == "job.json");
    CHECK(faults[0].line == c.line);
    CHECK(faults[0].column == c.column);
  }
}

TEST_CASE("the line and column of each value are those of its own text") {
  json document =
      json::parse(R"({"a": [1, {"b": [[], {}, "q\"[{", [2, [3.5, null]]]}], "z": "\n"})");
  const std::string text = document.dump(3);
  std::vector<std::string> lines{""};
  for (const char c : text)
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += c;
  const json flat = document.flatten();
  for (const auto& [pointer, leaf] : flat.items()) {
    INFO(pointer);
    std::vector<Fault> faults{{.pointer = pointer, .value = "", .rule = ""}};
    locate(faults, {text, "f"}, {});
    const std::string rest = lines.at(faults[0].line - 1).substr(faults[0].column - 1);
    const json& value = document.at(json::json_pointer(pointer));
    CHECK_THAT(rest, Catch::Matchers::StartsWith(value.dump()));
  }
}

TEST_CASE("faults are sorted by place, those of --set last and without a line") {
  const JsonText text{"{\"b\": 1,\n \"a\": {\"c\": 2}}", "job.json"};
  std::vector<Fault> faults{{.pointer = "/a/c", .value = "2", .rule = "r"},
                            {.pointer = "/new/x", .value = "3", .rule = "r"},
                            {.pointer = "/a/none", .value = "nothing", .rule = "r"},
                            {.pointer = "/b", .value = "1", .rule = "r", .of_key = true},
                            {.pointer = "/b", .value = "1", .rule = "r"}};
  locate(faults, text, {"/new"});
  std::string all;
  for (const Fault& fault : faults) all += fault.text() + "\n";
  CHECK(all ==
        "job.json:1:2: /b = 1; r\njob.json:1:7: /b = 1; r\n"
        "job.json:2:7: /a/none = nothing; r\njob.json:2:13: /a/c = 2; r\n"
        "--set: /new/x = 3; r\n");
}

TEST_CASE("bottomless nesting is refused") {
  CHECK_THAT(parse_complaint(std::string(100000, '[')), Contains("nested deeper than 32"));
  CHECK_THAT(parse_complaint(std::string(40, '[') + std::string(40, ']')), Contains("nested"));
}

TEST_CASE("a path that is no readable file is refused by name") {
  const auto folder = std::filesystem::temp_directory_path() / "flexopt_test_json_file";
  std::filesystem::create_directories(folder);
  CHECK_THAT(complaint_of([&] { read_text(folder.string()); }),
             Contains(folder.string()) && Contains("folder"));
  CHECK_THAT(complaint_of([&] { read_text((folder / "none.json").string()); }),
             Contains("no such file"));
  CHECK_THAT(complaint_of([&] { read_text("/dev/zero"); }), Contains("larger than"));
  const auto file = folder / "good.json";
  std::ofstream(file) << R"({"a": [1, 2]})";
  CHECK(read_text(file.string()).text == R"({"a": [1, 2]})");
  std::filesystem::remove_all(folder);
}

TEST_CASE("an override replaces, adds and appends") {
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

TEST_CASE("an override names the outermost value that is new") {
  json document = json::parse(R"({"stroke": {"to": 1}, "loads": [{"force": [0, 0, 0]}]})");
  CHECK(apply_override(document, "/stroke/to=2") == "/stroke/to");
  CHECK(apply_override(document, "/loads/-={}") == "/loads/1");
  CHECK(apply_override(document, "/model/a/b=1") == "/model");
  CHECK(apply_override(document, "/model/a/c=1") == "/model/a/c");
  CHECK(apply_override(document, "/loads/0/x~1y=1") == "/loads/0/x~1y");
}

TEST_CASE("an override that leads nowhere is refused") {
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

TEST_CASE("a long value is shown short and whole in UTF-8") {
  const std::string text = shown(json(std::string(100, 'x') + "\xff"));
  CHECK(text.size() <= 80);
  std::string umlauts;
  for (int i = 0; i < 100; ++i) umlauts += "ü";
  CHECK_NOTHROW(json(shown(json(umlauts))).dump());
}
