#include "optim/solvers/parallel.hpp"
#include "tests/optim/optim_tests.hpp"

#include <atomic>
#include <stdexcept>
#include <string>

TEST_CASE("all work is done, and the first error by index comes out") {
  for (const int threads : {1, 3}) {
    std::atomic<int> done = 0;
    const auto work = [&](int i) {
      ++done;
      if (i % 10 == 7) throw std::runtime_error(std::to_string(i));
    };
    CHECK_THROWS_WITH(parallel_for(40, threads, work), "7");
    CHECK(done == 40);
  }
}

TEST_CASE("an interrupted loop begins no more work, whatever else went wrong") {
  for (const int threads : {1, 3}) {
    std::atomic<int> done = 0;
    const auto work = [&](int i) {
      ++done;
      if (i == 0) throw Interrupted{};
      throw std::runtime_error("another");
    };
    CHECK_THROWS_AS(parallel_for(10000, threads, work), Interrupted);
    if (threads == 1) CHECK(done == 1);
    CHECK(done < 10000);
  }
}

TEST_CASE("a loop tells how far it is, one at a time, and ends when told to") {
  for (const int threads : {1, 3}) {
    std::atomic<int> work = 0;
    int told = 0;
    parallel_for(
        40, threads, [&](int) { ++work; },
        [&](int done, int total) {
          CHECK(done == ++told);
          CHECK(total == 40);
        });
    CHECK(work == 40);
    CHECK(told == 40);
    const auto stop = [](int, int) { throw Interrupted{}; };
    work = 0;
    CHECK_THROWS_AS(parallel_for(
                        10000, threads, [&](int) { ++work; }, stop),
                    Interrupted);
    CHECK(work < 10000);
  }
}
