#pragma once
// A job that lists designs: each is a run of its own in a folder of its own, and one more result
// has them all.
#include <filesystem>
#include <map>
#include <string>

#include "results/run/progress.hpp"
#include "results/run/run_files.hpp"

namespace flexopt {

/// Runs one design after the other as a job of its own; one that fails does not stop the others.
/// Each leaves all files of a run in its folder, from which an interrupted one goes on. Adds the
/// total of each to `timings`. Throws as run_optimisation does. `sharing` as there; of a shard and
/// of a process that follows there is no result.
OrderedJson run_listed_designs(const Job& job, const std::filesystem::path& folder, int threads,
                               RunListener& listener, std::map<std::string, double>& timings,
                               Sharing* sharing = nullptr);

/// job.json has been written: ranking.csv, timings.json, report.html and, last of all, result.json.
WrittenRun write_listed_designs(const std::filesystem::path& folder, const Job& job,
                                OrderedJson result, const std::map<std::string, double>& timings);

/// What the folders of the designs hold so far.
OrderedJson interrupted_designs(const Job& job, const std::filesystem::path& folder);

}  // namespace flexopt
