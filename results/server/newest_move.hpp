#pragma once
// One evaluation at a time, for the newest who asks: those who wait while another one runs give way
// to whoever comes after them.
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

namespace flexopt {

class NewestMove {
 public:
  /// Calls `work` when nothing else runs; returns nothing where a newer caller came before that.
  template <class Work>
  auto run(Work&& work) -> std::optional<decltype(work())> {
    if (!begin()) return std::nullopt;
    const End end{*this};
    return work();
  }

 private:
  struct End {
    NewestMove& of;
    ~End() { of.end(); }
  };
  bool begin();
  void end();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t newest_ = 0;
  bool running_ = false;
};

}  // namespace flexopt
