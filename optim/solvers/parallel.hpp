#pragma once
// A loop over threads, and the clock.
#include <chrono>
#include <exception>
#include <functional>

namespace flexopt {

/// What work throws to end the loop at once.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "interrupted"; }
};

/// Called with the number of finished units, one call at a time, from any thread.
using LoopProgress = std::function<void(int done, int total)>;

/// work(0), …, work(count − 1) on up to `threads` threads, in any order; `progress` after each. The
/// first exception by index comes out, after all work has ended; those of `progress` count as of
/// the work. After Interrupted no more work is begun, and it comes out.
void parallel_for(int count, int threads, const std::function<void(int)>& work,
                  const LoopProgress& progress = {});

/// Seconds that have passed by the clock.
double seconds_since(std::chrono::steady_clock::time_point begin);

}  // namespace flexopt
