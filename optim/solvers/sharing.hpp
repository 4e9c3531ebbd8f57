#pragma once
// Loops whose units of work are shared with other processes: with those that evaluate for this one
// (workers), or with those that do other parts of the same run (shards).
#include <exception>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "optim/solvers/parallel.hpp"

namespace flexopt {

/// One of `of` parts of a run, from 1, that never meet.
struct Shard {
  int number = 1, of = 1;
  /// Units are dealt in rows, each row one part further on than the one before, so that what
  /// repeats along the units does not fall to one part.
  bool has(int unit) const { return (unit + unit / of) % of == number - 1; }
};

/// Ends the run of a shard where it would need what the other shards do.
struct ShardEnds : std::exception {
  const char* what() const noexcept override { return "the end of a shard"; }
};

/// Ends the run of a member whose leader has ended its own.
struct WorkersDismissed : std::exception {
  const char* what() const noexcept override { return "dismissed"; }
};

/// Thrown when another member cannot go on; tells why.
struct WorkersLost : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What answers a question, in whichever process.
using Answerer = std::function<std::string(const std::string& question)>;

/// Processes that go through the same run. One leads it and keeps its files; the others answer what
/// it asks, stage by stage.
class Workers {
 public:
  virtual ~Workers() = default;
  virtual bool leads() const = 0;
  /// Number of members, including the leader.
  virtual int members() const = 0;

  /// Leader, from any thread: the answer of whoever is free first, another member or this process
  /// by `here`. Throws what `here` throws, and WorkersLost.
  virtual std::string ask(const std::string& question, const Answerer& here) = 0;
  /// Leader: ends the stage, so that the others return from `answer`.
  virtual void end_stage() = 0;
  /// The others: answers until the leader ends the stage. Throws WorkersDismissed where it ended
  /// all.
  virtual void answer(const Answerer& here) = 0;

  /// Leader: sends a text to all others.
  virtual void tell(const std::string& text) = 0;
  /// Other members: the next text of tell(). Throws WorkersDismissed.
  virtual std::string hear() = 0;
  /// Other members: tell the leader that this member cannot go on, and why.
  virtual void fail(const std::string& why) = 0;
};

/// Number of units of a loop that were to be done here.
struct SharedLoop {
  std::string what;
  int here = 0, all = 0;
};

/// How far a loop is.
struct LoopState {
  int done = 0, total = 0;
  int failed = 0, replayed = 0;  ///< numbers of those done; replayed: read from the log
};

/// A loop whose units yield lines of a log, from which an interrupted run resumes.
struct LoggedLoop {
  std::string what;
  int count = 0, threads = 1;
  /// Takes what is known of a unit: whether it failed. Nothing where it is to be done.
  std::function<std::optional<bool>(int unit)> known;
  std::function<std::string(int unit)> work;            ///< yields lines
  std::function<void(const std::string& lines)> keep;   ///< from then on the unit is known
  std::function<void(const LoopState&)> progress = {};  ///< one at a time, from any thread
};

/// How a run shares its units.
class Sharing {
 public:
  /// Shares with no other process.
  Sharing() = default;
  explicit Sharing(const Shard& shard) : shard_(shard) {}
  explicit Sharing(Workers& workers) : workers_(&workers) {}

  const std::optional<Shard>& shard() const { return shard_; }
  Workers* workers() const { return workers_; }
  /// Whether this process answers what a leader asks.
  bool follows() const { return workers_ && !workers_->leads(); }
  /// Whether all that a loop yields is known here once it has ended.
  bool complete() const { return !shard_ && !follows(); }
  /// Number of threads that keep the workers busy, or of those that there are.
  int threads(int of_this_process) const;
  /// The units among 0, …, count − 1 that this process does itself or has done for it.
  std::vector<int> own(const std::string& what, int count);

  /// `work` on these units: what it yields goes, in the process that keeps the run's files, to
  /// `keep`, from any thread. Workers get several units at once where they are quick. A process
  /// that follows works, and keeps nothing.
  void run(const std::vector<int>& units, int threads,
           const std::function<std::string(int unit)>& work,
           const std::function<void(int unit, const std::string& yield)>& keep) const;

  /// The units of the loop that are this process's and not known. `keep` and `known` are called one
  /// at a time. False where this process does not learn what all units yield.
  bool run(const LoggedLoop& loop);

  /// All loops shared so far.
  const std::vector<SharedLoop>& loops() const { return loops_; }

 private:
  std::optional<Shard> shard_;
  Workers* workers_ = nullptr;
  std::vector<SharedLoop> loops_;
};

}  // namespace flexopt
