#pragma once
// The two pages that are served: a design whose numbers can be moved, and a run that goes on.
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "optim/job/job.hpp"
#include "results/files/json_text.hpp"
#include "results/run/run.hpp"

namespace flexopt {

/// Is told the page's address once it can be opened.
using SayAddress = std::function<void(const std::string& address)>;

/// Serves the page of a job until Ctrl-C. Throws SpecError for a port that is taken, and for a job
/// without a design to look at. Nothing is written to disk.
void serve_explorer(const Job& job, int port, const SayAddress& say);

/// Serves the page of the run in a folder until Ctrl-C. Throws SpecError for a port that is taken,
/// and where there is no such folder. Nothing is written to disk.
void serve_watch(const std::filesystem::path& folder, int port, const SayAddress& say);

// The folder of a run as something to look at while the run goes on. Reads alone.

class WatchedRun {
 public:
  /// Throws SpecError unless it is a folder.
  explicit WatchedRun(std::filesystem::path folder);

  /// JSON for the page. `since`: the version that it shows, or nothing.
  ///     {"version", "age", "unchanged": true}                 nothing new
  ///     {"version", "age", "waiting": message}                nothing to show yet
  ///     {"version", "age", "finished", "result", "scene"}     what the report shows
  /// `age`: seconds since the run last wrote, or null. Of an unfinished run the status of the
  /// result is "running". A record that is half written is left out. Thread-safe.
  std::string state(const std::string& since);

 private:
  void look();

  std::filesystem::path folder_;
  std::mutex mutex_;
  GrowingLog log_;
  std::string version_, shown_;  ///< version of the last look; what follows "age"
  std::filesystem::file_time_type written_ = std::filesystem::file_time_type::min();
  std::chrono::steady_clock::time_point next_look_;
};

/// What a request {"since": version} says. Throws SpecError for anything else.
std::string read_since(const std::string& body);

// The numbers of a job that may be moved, and their ranges.

/// A number of a design that can be moved, SI.
struct Slider {
  std::string name, unit, meaning;
  double value = 0;  ///< the job's
  double min = 0, max = 0;
  bool whole = false;  ///< a number of things
};

/// Sliders of a job: the variables of an optimisation with their bounds, or every parameter of an
/// evaluated design that is a number, from half to twice its value, as far as the design allows it.
/// A parameter that is zero goes to both sides as far as half the largest parameter of its unit,
/// or, where all of these are zero, through its whole range. Throws SpecError for a job that has no
/// single design to show, or nothing to move.
std::vector<Slider> sliders_of(const Job& job);

/// {"parameters": {"length": 0.04, …}}, SI; those that are not named keep the job's value. Throws
/// SpecError for anything else: other names, other values than numbers, numbers out of range.
ParameterValues read_move(const std::string& body, const std::vector<Slider>& sliders);

// A job as something to try numbers on: a move of its sliders → what the page shows.

class Explorer {
 public:
  /// Throws as sliders_of does.
  explicit Explorer(Job job);

  const Job& job() const { return job_; }
  const std::vector<Slider>& sliders() const { return sliders_; }
  /// What the page needs of them: [{"name", "unit", "meaning", "value", "min", "max", "whole"}].
  OrderedJson slider_table() const;

  /// The design with these numbers, evaluated as a run of a job "evaluate" does it but for maps and
  /// tolerances:
  ///     {"ok": true, "seconds", "result", "scene", "goals"}
  /// `goals` are objective and constraints of an optimisation, without what tolerances do to them:
  /// {"label", "role", "sense" or "min", "max", "met", "value", "unit", "as"}. Where the design
  /// breaks a rule or has no equilibrium: {"ok": false, "seconds", "message"}. Thread-safe.
  OrderedJson evaluate(const ParameterValues& values) const;

  /// The job file with these numbers.
  std::string job_text(const ParameterValues& values) const;

 private:
  Job job_;
  std::vector<Slider> sliders_;
};

/// One evaluation at a time, for the newest who asks: those who wait while another one runs give
/// way to whoever comes after them.
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
