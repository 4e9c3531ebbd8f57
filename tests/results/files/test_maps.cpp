#include "results/files/result_parts.hpp"
#include "tests/results/results_tests.hpp"

namespace {

/// A map of two quantities over 3 × 2 designs; the last one failed.
RunRecord mapped() {
  RunRecord record = test::optimised_hinge();
  const auto& variables = record.job.optimise->variables;
  REQUIRE(variables.size() >= 2);
  MapSpec map;
  map.parameters = {variables[0], variables[1]};
  map.points = {3, 2};
  map.quantities = {
      {"max_stress", "", OverStroke::max, {}, {}, "max_stress max over stroke", "", {}},
      {"", "2*length", OverStroke::first, {}, {}, "2*length", "", {}}};
  record.job.maps = {map};
  ResponseMap found;
  found.parameters = {std::vector<double>{1, 2, 3}, std::vector<double>{10, 20}};
  found.quantities = {{1e8, 2e8, 3e8, 4e8, 5e8, {}}, {1.0, 2.0, 3.0, 4.0, 5.0, {}}};
  found.margin = {0.1, 0.2, 0.3, -0.4, -0.5, {}};
  found.held = {1.5, 12.5};
  found.failed = 1;
  found.first_failure = "length = 3: no equilibrium";
  record.maps = {found};
  return record;
}

}  // namespace

TEST_CASE("a map is rows of the first parameter, null where a design has no value") {
  const RunRecord record = mapped();
  const OrderedJson map = make_result(record)["maps"][0];
  const Variable& first = record.job.optimise->variables[0];
  CHECK(unlike(map["parameters"], {{{"parameter", first.parameter},
                                    {"values", {1, 2, 3}},
                                    {"start", first.start.value_or(1.5)}},
                                   {{"held", 12.5}}}) == "");
  CHECK(unlike_text(map, R"({
    "quantities": [{"quantity": "max_stress", "over_stroke": "max", "unit": "Pa",
                    "values": [[1e8, 2e8], [3e8, 4e8], [5e8, null]]},
                   {"expression": "2*length", "unit": "SI"}],
    "margin": [[0.1, 0.2], [0.3, -0.4], [-0.5, null]], "failed": 1,
    "first_failure": "length = 3: no equilibrium"})") == "");
  CHECK_FALSE(make_result(test::optimised_hinge()).contains("maps"));
}

TEST_CASE("maps.csv has a row for each design and quantity, and goes when there are no maps") {
  const test::TemporaryFolder folder;
  const RunRecord record = mapped();
  write_maps_csv(folder.path(), record);
  const std::string text = test::content_of(folder.path() / "maps.csv");
  CHECK(std::count(text.begin(), text.end(), '\n') == 1 + 2 * 6);
  const std::string first = record.job.optimise->variables[0].parameter,
                    second = record.job.optimise->variables[1].parameter;
  CHECK(text.find("0," + first + ",2," + second +
                  ",20,max_stress max over stroke,Pa,400000000,-0.4") != std::string::npos);
  CHECK(text.find("0," + first + ",3," + second + ",20,2*length,SI,,\n") != std::string::npos);
  write_maps_csv(folder.path(), test::optimised_hinge());
  CHECK_FALSE(std::filesystem::exists(folder.path() / "maps.csv"));
}
