#include "tests/results/results_tests.hpp"

namespace {

OrderedJson small_result() {
  return {{"status", "ok"}, {"message", ""}, {"path", {{{"drive_load", 33.44}, {"max", nullptr}}}}};
}

}  // namespace

TEST_CASE("An expected number within its tolerance is reported as such") {
  OrderedJson result = small_result();
  CHECK(check_expectations({{"/path/0/drive_load", 33.4, 0.05, "hand"}}, result).empty());
  CHECK(result["status"] == "ok");
  CHECK(result["expectations"][0]["ok"] == true);
  CHECK(result["expectations"][0]["value"] == 33.44);
}

TEST_CASE("A number that differs makes the run unusable and says by how much") {
  OrderedJson result = small_result();
  const auto failed = check_expectations({{"/path/0/drive_load", 33.44, 1e-9, "hand"},
                                          {"/path/0/drive_load", 33.3, 0.05, "hand"},
                                          {"/path/7/drive_load", 1, 1, ""},
                                          {"/path/0/max", 1, 1, ""},
                                          {"no pointer", 1, 1, ""}},
                                         result);
  REQUIRE(failed.size() == 4);
  CHECK(failed[0] == "/path/0/drive_load = 33.44, expected 33.3 ± 0.05 (hand)");
  CHECK(failed[1] == "/path/7/drive_load is not in the result");
  CHECK(failed[2] == "/path/0/max is null, not a number");
  CHECK(result["status"] == "expectation_failed");
  CHECK(result["expectations"].size() == 5);
  CHECK(result["expectations"][2]["value"].is_null());
}

TEST_CASE("A run that failed anyway keeps its own status") {
  OrderedJson result = small_result();
  result["status"] = "infeasible";
  check_expectations({{"/path/0/drive_load", 0, 0, ""}}, result);
  CHECK(result["status"] == "infeasible");
}
