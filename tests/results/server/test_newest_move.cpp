#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "results/server/serve.hpp"

using namespace flexopt;
using namespace std::chrono_literals;

TEST_CASE("Of those who wait the newest alone has its turn", "[results][server]") {
  NewestMove newest;
  std::atomic<bool> started = false, go_on = false;
  std::atomic<int> at_once = 0, most = 0;
  const auto work = [&](int value) {
    most = std::max(most.load(), ++at_once);
    std::this_thread::sleep_for(1ms);
    --at_once;
    return value;
  };
  std::optional<int> first;
  std::thread running([&] {
    first = newest.run([&] {
      started = true;
      while (!go_on) std::this_thread::sleep_for(1ms);
      return work(0);
    });
  });
  while (!started) std::this_thread::sleep_for(1ms);
  constexpr int count = 8;
  std::vector<std::optional<int>> got(count + 1);
  std::vector<std::thread> waiting;
  std::atomic<int> returned = 0;
  const auto wait = [&](int k) {
    waiting.emplace_back([&, k] {
      got[static_cast<std::size_t>(k)] = newest.run([&] { return work(k); });
      ++returned;
    });
  };
  // All but one give way while the first still runs, and that one does to whoever comes last.
  for (int k = 0; k < count; ++k) wait(k);
  while (returned < count - 1) std::this_thread::sleep_for(1ms);
  wait(count);
  while (returned < count) std::this_thread::sleep_for(1ms);
  go_on = true;
  for (std::thread& one : waiting) one.join();
  running.join();
  CHECK(first == 0);
  for (int k = 0; k < count; ++k) CHECK_FALSE(got[static_cast<std::size_t>(k)]);
  CHECK(got.back() == count);
  CHECK(most == 1);
}

TEST_CASE("Work that throws leaves the turn to the next", "[results][server]") {
  NewestMove newest;
  CHECK_THROWS_AS(newest.run([]() -> int { throw std::runtime_error("no"); }), std::runtime_error);
  CHECK(newest.run([] { return 3; }) == 3);
}
