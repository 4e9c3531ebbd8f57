#include "results/files/json_text.hpp"
#include "tests/results/results_tests.hpp"

#include <limits>

TEST_CASE("JSON text reads back to the same numbers, keys in the order of writing") {
  OrderedJson document;
  document["z"] = 0.1;
  document["a"] = {1.0 / 3, -5e-324, 1.7976931348623157e308, 0, -17};
  document["text"] = "ü \"quoted\"\n";
  document["deep"] = {{"matrix", {{1.5, 2}, {3, 4}}}, {"none", nullptr}, {"yes", true}};
  const std::string text = json_text(document);
  CHECK(OrderedJson::parse(text) == document);
  CHECK(text.find("\"z\"") < text.find("\"a\""));
  CHECK(text.back() == '\n');
  CHECK(text.find("0.1,") != std::string::npos);  // the shortest form
}

TEST_CASE("an array of numbers stands on one line, of whatever length") {
  OrderedJson document;
  for (int i = 0; i < 60; ++i) document["row"].push_back(i + 0.25);
  document["matrix"] = {{1, 2}, {3, 4}};
  std::istringstream lines(json_text(document));
  bool found = false;
  for (std::string line; std::getline(lines, line);)
    found = found ||
            (line.find("0.25") != std::string::npos && line.find("59.25") != std::string::npos);
  CHECK(found);
  CHECK(json_text(document).find("[1, 2]") != std::string::npos);
}

TEST_CASE("separators on a line are followed by a blank, those inside of strings stay") {
  const OrderedJson document{{"a,b", "c:\"d,e\\"}, {"f", -1}, {"g", nullptr}};
  CHECK(json_text(document) == R"({"a,b": "c:\"d,e\\", "f": -1, "g": null})"
                               "\n");
  CHECK(json_text(OrderedJson::array()) == "[]\n");
  CHECK(json_text(OrderedJson::object()) == "{}\n");
}

TEST_CASE("text that is no UTF-8 is repaired, not thrown over") {
  const std::string text = json_text(OrderedJson{{"name", "caf\xe9"}});
  CHECK(OrderedJson::parse(text)["name"].get<std::string>().substr(0, 3) == "caf");
}

TEST_CASE("numbers that are not finite become null, and are named by their pointers") {
  OrderedJson document{{"a", 1.0}, {"path", {{{"x", std::nan("")}}, {{"x", 2.0}}}}};
  document["b"] = std::numeric_limits<double>::infinity();
  const std::vector<std::string> replaced = remove_non_finite(document);
  CHECK(replaced == std::vector<std::string>{"/path/0/x", "/b"});
  CHECK(document["path"][0]["x"].is_null());
  CHECK(document["path"][1]["x"] == 2.0);
  CHECK(document["b"].is_null());
  CHECK(document["a"] == 1.0);
}
