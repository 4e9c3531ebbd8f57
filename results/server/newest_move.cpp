#include "results/server/newest_move.hpp"

namespace flexopt {

bool NewestMove::begin() {
  std::unique_lock lock(mutex_);
  const std::uint64_t own = ++newest_;
  changed_.notify_all();
  changed_.wait(lock, [&] { return !running_ || newest_ != own; });
  if (newest_ != own) return false;
  running_ = true;
  return true;
}

void NewestMove::end() {
  const std::lock_guard lock(mutex_);
  running_ = false;
  changed_.notify_all();
}

}  // namespace flexopt
