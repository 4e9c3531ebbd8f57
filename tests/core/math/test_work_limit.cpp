#include "core/math/work_limit.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "core/math/work_count.hpp"

using namespace flexopt;
using Catch::Matchers::Message;

namespace {

double now = 0;  // of the clock that the tests set
double set_clock() { return now; }

WorkLimits seconds(double most) { return {most, std::nullopt, set_clock}; }
WorkLimits iterations(int most) { return {std::nullopt, most, set_clock}; }

}  // namespace

TEST_CASE("without limits any work goes on") {
  for (int k = 0; k < 1000; ++k) count_iteration();
  check_work();
  const LimitedWork none({});
  for (int k = 0; k < 1000; ++k) count_iteration();
}

TEST_CASE("so many iterations are done, and not one more") {
  const LimitedWork work(iterations(3));
  for (int k = 0; k < 3; ++k) count_iteration();
  check_work();  // no iteration
  CHECK_THROWS_MATCHES(count_iteration(), WorkLimitReached,
                       Message("iteration limit: more than 3 Newton iterations"));
  CHECK_THROWS_AS(check_work(), WorkLimitReached);  // and so it stays
}

TEST_CASE("who is told of the work hears of every iteration, and of no look at the clock") {
  std::vector<int> told;
  const LimitedWork work({}, [&](int iterations) { told.push_back(iterations); });
  count_iteration();
  check_work();
  count_iteration();
  CHECK(told == std::vector<int>{1, 2});
}

TEST_CASE("the clock ends work at any look at it") {
  now = 100;
  const LimitedWork work(seconds(2.5));
  now = 102.5;
  count_iteration();
  check_work();
  now = 102.6;
  CHECK_THROWS_MATCHES(check_work(), WorkLimitReached, Message("time limit: more than 2.5 s"));
  CHECK_THROWS_AS(count_iteration(), WorkLimitReached);
}

TEST_CASE("limits end with their scope, and those around them count on") {
  const LimitedWork outer(iterations(2));
  count_iteration();
  {
    const LimitedWork inner(iterations(1));
    count_iteration();
    CHECK_THROWS_AS(count_iteration(), WorkLimitReached);
  }
  count_iteration();
  CHECK(outer.iterations() == 2);
  CHECK_THROWS_AS(count_iteration(), WorkLimitReached);
}

TEST_CASE("a thread knows its iterations, whatever limits them") {
  const long long before = counted_iterations();
  count_iteration();
  {
    const LimitedWork work(iterations(1));
    count_iteration();
    CHECK_THROWS_AS(count_iteration(), WorkLimitReached);
  }
  CHECK(counted_iterations() == before + 3);
}

TEST_CASE("the clock of every day goes forward") {
  const double begin = steady_seconds();
  CHECK(steady_seconds() >= begin);
}
