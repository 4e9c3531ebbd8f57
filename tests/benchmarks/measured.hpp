#pragma once
#include <algorithm>
#include <ctime>
#include <functional>

namespace flexopt {

/// Processor time of a call, of all threads [s]: other work on the machine does not count.
inline double seconds(const std::function<void()>& call) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  call();
  return now() - start;
}

/// The least of so many calls.
inline double least_seconds(int runs, const std::function<void()>& call) {
  double least = 1e300;
  for (int k = 0; k < runs; ++k) least = std::min(least, seconds(call));
  return least;
}

}  // namespace flexopt
