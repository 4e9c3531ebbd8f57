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
