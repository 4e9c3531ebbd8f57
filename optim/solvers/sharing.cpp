#include "optim/solvers/sharing.hpp"

#include <algorithm>
#include <iterator>
#include <mutex>
#include <sstream>

namespace flexopt {
namespace {

/// What one message asks for takes about as long [s]: longer than the message by far, and what is
/// lost with a process.
constexpr double worth_a_message = 0.2;

/// "SIZE\nTEXT", one after the other.
std::string packed(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += std::to_string(text.size()) + "\n" + text;
  return all;
}

std::vector<std::string> unpacked(const std::string& all) {
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = all.find('\n', at);
    const std::size_t size = std::stoul(all.substr(at, end - at));
    texts.push_back(all.substr(end + 1, size));
    at = end + 1 + size;
  }
  return texts;
}

std::string words(const std::vector<int>& units) {
  std::string all;
  for (const int unit : units) all += std::to_string(unit) + " ";
  return all;
}

/// Does what one message asks for.
Answerer answerer(int threads, const std::function<std::string(int)>& work) {
  return [threads, &work](const std::string& question) {
    std::istringstream stream(question);
    std::vector<int> units;
    for (int unit = 0; stream >> unit;) units.push_back(unit);
    std::vector<std::string> yields(units.size());
    parallel_for(static_cast<int>(units.size()), threads,
                 [&](int i) { yields[i] = work(units[i]); });
    return packed(yields);
  };
}

/// Units as they are handed out: few at a time at first and towards the end.
class Hand {
 public:
  Hand(const std::vector<int>& units, int members, int threads)
      : units_(units), members_(members), least_(threads) {}

  std::vector<int> next() {
    const std::lock_guard lock(mutex_);
    const int left = static_cast<int>(units_.size()) - given_;
    const int even = left / (4 * members_);
    const int worth = seconds_ > 0 ? static_cast<int>(worth_a_message * done_ / seconds_) : 1;
    const int count = std::min(left, std::max(least_, std::min(even, worth)));
    const auto first = units_.begin() + given_;
    given_ += count;
    return {first, first + count};
  }
  void done(std::size_t units, double seconds) {
    const std::lock_guard lock(mutex_);
    done_ += static_cast<double>(units);
    seconds_ += seconds;
  }
  void stop() {
    const std::lock_guard lock(mutex_);
    given_ = static_cast<int>(units_.size());
  }

 private:
  const std::vector<int>& units_;
  int members_, least_, given_ = 0;
  double done_ = 0, seconds_ = 0;
  std::mutex mutex_;
};

}  // namespace

int Sharing::threads(int of_this_process) const {
  return workers_ ? std::max(of_this_process, workers_->members()) : of_this_process;
}

std::vector<int> Sharing::own(const std::string& what, int count) {
  std::vector<int> units;
  for (int unit = 0; unit < count; ++unit)
    if (!shard_ || shard_->has(unit)) units.push_back(unit);
  loops_.push_back({what, static_cast<int>(units.size()), count});
  return units;
}

void Sharing::run(const std::vector<int>& units, int threads,
                  const std::function<std::string(int)>& work,
                  const std::function<void(int, const std::string&)>& keep) const {
  if (follows()) return workers_->answer(answerer(threads, work));
  if (!workers_)
    return parallel_for(static_cast<int>(units.size()), threads, [&](int i) {
      const int unit = units[i];
      keep(unit, work(unit));
    });
  const Answerer here = answerer(threads, work);
  Hand hand(units, workers_->members(), threads);
  const auto conversation = [&](int) {
    try {
      for (std::vector<int> some = hand.next(); !some.empty(); some = hand.next()) {
        const auto begin = std::chrono::steady_clock::now();
        const std::vector<std::string> yields = unpacked(workers_->ask(words(some), here));
        hand.done(some.size(), seconds_since(begin));
        for (std::size_t i = 0; i < some.size(); ++i) keep(some[i], yields.at(i));
      }
    } catch (...) {
      hand.stop();
      throw;
    }
  };
  parallel_for(workers_->members(), workers_->members(), conversation);
  workers_->end_stage();
}

bool Sharing::run(const LoggedLoop& loop) {
  LoopState state;
  const std::vector<int> units = own(loop.what, loop.count);
  state.total = static_cast<int>(units.size());
  const auto is_known = [&](int unit) {
    const std::optional<bool> failed = loop.known(unit);
    if (failed) ++state.done, state.failed += *failed;
    return failed.has_value();
  };
  std::vector<int> open;
  std::ranges::remove_copy_if(units, std::back_inserter(open), is_known);
  state.replayed = state.done;
  if (loop.progress) loop.progress(state);
  std::mutex mutex;
  run(open, loop.threads, loop.work, [&](int unit, const std::string& lines) {
    const std::lock_guard lock(mutex);
    loop.keep(lines);
    is_known(unit);
    if (loop.progress) loop.progress(state);
  });
  return complete();
}

}  // namespace flexopt
