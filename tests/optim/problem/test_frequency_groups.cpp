#include "designs/family.hpp"
#include "optim/problem/gradient_checker.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

/// The quantities of a guide that are `drive_load` and the first four locked frequencies.
std::vector<Quantity> some_quantities() {
  std::vector<Quantity> some;
  for (Quantity& q : quantities(find_family("parallel_guide", "").drives))
    if (q.name == "drive_load" ||
        (q.name.starts_with("frequencies.drive_locked.") && rank_of(q) < 4))
      some.push_back(std::move(q));
  return some;
}

}  // namespace

TEST_CASE("frequencies that may meet within a step are a group, others are alone") {
  const std::vector<Quantity> names = some_quantities();
  REQUIRE(names.size() == 5);
  REQUIRE(names.front().name == "drive_load");
  // of a second point: the numbers begin behind those of the first
  const MaybeNumbers here{0, 0, 0, 0, 0, 7, 50, 100, 100.5, 200},
      still{0, 0, 0, 0, 0, 1, 0, 0, 0, 0}, moving{0, 0, 0, 0, 0, 1, 0, 40, 0, 0};
  CHECK(groups_of(names, here, still, 5, 0.01).empty());
  const auto groups = groups_of(names, here, moving, 5, 0.01);
  REQUIRE(groups.size() == 1);
  CHECK(groups[0] == FrequencyGroup{7, 8});
  MaybeNumbers without = moving;
  without[8].reset();
  CHECK(groups_of(names, here, without, 5, 0.01).empty());
}

TEST_CASE("the mean of a group has the slope of its derivative, whatever the ranks") {
  const std::vector<FrequencyGroup> groups{{1, 2}};
  // two frequencies that cross at x = 0
  const auto at = [&](double x) {
    std::vector<double> values{5, std::min(3 + x, 3 - 2 * x), std::max(3 + x, 3 - 2 * x)};
    average_values(groups, values);
    return values;
  };
  const std::vector<double> here = at(0);
  CHECK(here[0] == 5);
  CHECK(here[1] == Approx(3).epsilon(1e-15));
  CHECK(here[2] == here[1]);
  constexpr double h = 1e-6;
  const double slope = (at(h)[1] - at(-h)[1]) / (2 * h);
  MaybeNumbers slopes{7, 1, -2};
  average_slopes(groups, {5, 3, 3}, slopes);
  CHECK(*slopes[0] == 7);
  CHECK(*slopes[1] == Approx(slope).epsilon(1e-8));
  CHECK(*slopes[2] == *slopes[1]);
}
