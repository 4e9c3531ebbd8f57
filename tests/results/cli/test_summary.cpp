#include "results/cli/printed.hpp"
#include "tests/results/results_tests.hpp"

TEST_CASE("The summary of an evaluation shows the ends of the stroke in a designer's units") {
  const std::string text = summary_of(test::evaluated_hinge());
  CHECK_THAT(text, Contains("-20 deg") && Contains("20 deg") && Contains("0 deg"));
  CHECK_THAT(text, Contains("214 Hz"));
  CHECK_THAT(text, Contains("uz 3.1 N/um"));
  CHECK_THAT(text, Contains("320.7 MPa"));  // E t θ / L
}

TEST_CASE("The summary of an optimisation shows optimum, bounds and full accuracy") {
  const std::string text = summary_of(test::optimised_hinge());
  CHECK_THAT(text, Contains("0.35 mm") && Contains("45 deg"));
  CHECK_THAT(text, Contains("169.2 Hz") && Contains("168.9 Hz") && Contains("+0.178 %"));
  CHECK_THAT(text, Contains("449.99 MPa *") && Contains("<= 450 MPa"));
  CHECK_THAT(text, Contains("-1 N m .. 1 N m"));
}

TEST_CASE("The summary says why a number is missing, or no more than a lower bound") {
  RunRecord record = test::evaluated_hinge();
  record.job.request.buckling_load = "payload";
  record.job.request.capacity.directions[8] = true;  // -uz
  std::vector<PathPoint>& path = record.response.path;
  for (PathPoint& point : path) {
    point.buckling.emplace().drive_locked = {.at_least = 50, .reason = "no singular tangent"};
    point.load_capacity[8] = LoadCapacity{.value = 12, .reason = "a leaf is stretched"};
  }
  path.back().buckling->drive_locked = {.reason = "the branch ends"};
  const std::string text = summary_of(record);
  CHECK_THAT(text, Contains("buckling load factor") && Contains("> 50 "));
  CHECK_THAT(text, Contains("buckling load factor at stroke rz 20 deg: the branch ends\n"));
  CHECK_THAT(text, Contains("load capacity -uz at stroke rz -20 deg: a leaf is stretched\n"));
  CHECK_THAT(text, !Contains("no singular tangent"));
}
