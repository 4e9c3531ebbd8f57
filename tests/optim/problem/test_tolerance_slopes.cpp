#include "optim/problem/robust_goals.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

const std::vector<Tolerance> entries{
    {"a", ToleranceSpread::uniform, {{"x", 0.3}}},
    {"offset", ToleranceSpread::normal, {{"x", 0.6}, {"y", -0.6}}},
};

}  // namespace

TEST_CASE("parameters that deviate together add with their factors") {
  const MatrixXd changes = tolerance_changes(entries, {"x", "y"}, {{"x", 5}, {"y", 7}});
  const VectorXd slopes = changes.transpose() * (VectorXd(2) << 2, 5).finished();
  CHECK(slopes[0] == Approx(0.6));
  CHECK(slopes[1] == Approx(1.2 - 3.0));
  CHECK(farthest(slopes) == Approx(2.4));
  // uniform: limit / sqrt 3; normal: limit / 3
  CHECK(standard_deviation(entries, slopes) ==
        Approx(std::sqrt(0.36 / 3 + 1.8 * 1.8 / 9)).epsilon(1e-14));
  const VectorXd shares = variance_shares(entries, slopes);
  CHECK(shares.sum() == Approx(1));
  CHECK(shares[0] == Approx(0.12 / (0.12 + 0.36)));
  CHECK(variance_shares(entries, VectorXd::Zero(2)).sum() == 0);
}

TEST_CASE("a tolerance in percent is one of the size that the parameter has") {
  const std::vector<Tolerance> two{
      {"both", ToleranceSpread::uniform, {{"x", 0.03, true}, {"y", -0.03, true}}}};
  const MatrixXd changes = tolerance_changes(two, {"y", "x", "z"}, {{"x", 5}, {"y", -7}, {"z", 1}});
  CHECK(changes(1, 0) == Approx(0.15));
  CHECK(changes(0, 0) == Approx(-0.21));
  CHECK(changes(2, 0) == 0);
}
