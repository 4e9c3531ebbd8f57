#include "optim/solvers/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <vector>

namespace flexopt {

void parallel_for(int count, int threads, const std::function<void(int)>& work,
                  const LoopProgress& progress) {
  std::mutex mutex;
  int done = 0;
  std::vector<std::exception_ptr> errors(std::max(count, 0));
  std::atomic<bool> interrupted = false;
  const auto guarded = [&](int i) {
    if (interrupted) return;
    try {
      work(i);
      if (!progress) return;
      const std::lock_guard lock(mutex);
      progress(++done, count);
    } catch (const Interrupted&) {
      interrupted = true;
    } catch (...) {
      errors[i] = std::current_exception();
    }
  };
  const int together = std::min(threads, count);
  if (together <= 1) {
    for (int i = 0; i < count; ++i) guarded(i);
  } else {
    // Allows as many threads as asked for, also beyond the processor's number: the caller decides.
    static const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 1024);
    // An arena of its own: a thread that waits here takes up no work of a loop around this one.
    tbb::task_arena arena(together);
    arena.execute([&] { tbb::parallel_for(0, count, guarded, tbb::simple_partitioner()); });
  }
  if (interrupted) throw Interrupted{};
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace flexopt
