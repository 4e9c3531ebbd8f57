#include "optim/solvers/sharing.hpp"
#include "tests/optim/optim_tests.hpp"

#include <atomic>
#include <map>
#include <mutex>
#include <set>

namespace {

/// Workers whose other member answers in the same process.
class Pair : public Workers {
 public:
  bool leads() const override { return true; }
  int members() const override { return 2; }
  std::string ask(const std::string& question, const Answerer& here) override {
    {
      const std::lock_guard lock(mutex);
      questions.push_back(question);
      if (questions.size() == broken_at) throw WorkersLost("rank 1: gone");
    }
    return here(question);
  }
  void end_stage() override { ++stages; }
  void answer(const Answerer&) override {}
  void tell(const std::string&) override {}
  std::string hear() override { return {}; }
  void fail(const std::string&) override {}

  std::mutex mutex;
  std::vector<std::string> questions;
  std::size_t broken_at = 0;
  int stages = 0;
};

/// One that follows, and is asked once.
class Asked : public Pair {
 public:
  bool leads() const override { return false; }
  void answer(const Answerer& here) override { said = here("3 1 "); }
  std::string said;
};

std::string text_of(int unit) { return std::string(static_cast<std::size_t>(unit % 7), '\n'); }

}  // namespace

TEST_CASE("every unit is in one shard, and shards differ by one unit at most") {
  for (const int of : {1, 2, 3, 7, 16, 100})
    for (const int count : {0, 1, 15, 64, 257}) {
      std::vector<int> sizes;
      std::multiset<int> all;
      for (int number = 1; number <= of; ++number) {
        Sharing sharing(Shard{number, of});
        const std::vector<int> own = sharing.own("units", count);
        sizes.push_back(static_cast<int>(own.size()));
        all.insert(own.begin(), own.end());
      }
      CAPTURE(of, count);
      CHECK(static_cast<int>(all.size()) == count);
      CHECK(std::set<int>(all.begin(), all.end()).size() == all.size());
      const auto [least, most] = std::minmax_element(sizes.begin(), sizes.end());
      CHECK(*most - *least <= 1);
    }
}

TEST_CASE("what repeats along the units does not fall to one shard") {
  // designs with four models each, the first of which is the slow one, over eight shards
  for (int number = 1; number <= 8; ++number) {
    const Shard shard{number, 8};
    int slow = 0;
    for (int unit = 0; unit < 4 * 64; unit += 4) slow += shard.has(unit) ? 1 : 0;
    CHECK(slow == 8);
  }
}

TEST_CASE("workers do each unit once, and its texts come back as they are") {
  Pair workers;
  const Sharing sharing(workers);
  std::vector<int> units;
  for (int unit = 0; unit < 500; ++unit) units.push_back(3 * unit);
  std::mutex mutex;
  std::map<int, std::string> kept;
  sharing.run(units, 1, text_of, [&](int unit, const std::string& yield) {
    const std::lock_guard lock(mutex);
    CHECK(kept.emplace(unit, yield).second);
  });
  CHECK(kept.size() == units.size());
  for (const auto& [unit, yield] : kept) CHECK(yield == text_of(unit));
  CHECK(workers.stages == 1);
  CHECK(workers.questions.size() < units.size() / 4);  // quick units go several at a time
  CHECK(workers.questions.size() >= 8);
}

TEST_CASE("a worker that is lost ends the loop") {
  Pair workers;
  workers.broken_at = 3;
  std::vector<int> units(1000);
  std::atomic<std::size_t> done = 0;
  CHECK_THROWS_AS(Sharing(workers).run(units, 1, text_of, [&](int, const std::string&) { ++done; }),
                  WorkersLost);
  CHECK(done < units.size());  // how many questions were on their way depends on the machine
  CHECK(workers.stages == 0);
}

TEST_CASE("a process that follows works and keeps nothing") {
  Asked workers;
  const Sharing sharing(workers);
  CHECK(sharing.follows());
  CHECK_FALSE(sharing.complete());
  sharing.run({1, 2, 3, 4}, 1, text_of, [](int, const std::string&) { FAIL("kept"); });
  CHECK(workers.said == "3\n\n\n\n1\n\n");
}

TEST_CASE("threads keep workers busy") {
  Pair workers;
  CHECK(Sharing(workers).threads(1) == 2);
  CHECK(Sharing(workers).threads(6) == 6);
  CHECK(Sharing().threads(1) == 1);
}
