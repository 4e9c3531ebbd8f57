#pragma once
// A loop over threads.
#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace flexopt {

/// work(0), …, work(count − 1) on up to `threads` threads. The first exception by index comes out,
/// after all work has ended.
template <class Work>
void parallel_for(int count, int threads, Work&& work) {
  std::vector<std::exception_ptr> errors(static_cast<std::size_t>(std::max(count, 0)));
  std::atomic<int> next{0};
  const auto loop = [&] {
    for (int i = next++; i < count; i = next++) try {
        work(i);
      } catch (...) {
        errors[static_cast<std::size_t>(i)] = std::current_exception();
      }
  };
  std::vector<std::jthread> others;
  for (int t = 1; t < std::min(threads, count); ++t) others.emplace_back(loop);
  loop();
  others.clear();  // joins
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace flexopt
