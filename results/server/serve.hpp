#pragma once
// The two pages that are served: a design whose numbers can be moved, and a run that goes on.
#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>

#include "optim/job/job.hpp"
#include "results/run/run_files.hpp"

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

}  // namespace flexopt
