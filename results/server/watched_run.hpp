#pragma once
// The folder of a run as something to look at while the run goes on. Reads alone.
#include <chrono>
#include <filesystem>
#include <mutex>
#include <string>

#include "results/run/run_files.hpp"

namespace flexopt {

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
