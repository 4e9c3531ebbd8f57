#pragma once
// A loop over threads.
#include <functional>

namespace flexopt {

/// work(0), …, work(count − 1) on up to `threads` threads, in any order. The first exception by
/// index comes out, after all work has ended.
void parallel_for(int count, int threads, const std::function<void(int)>& work);

}  // namespace flexopt
