#pragma once
// Runs a checked job and returns the record of its run.
#include <filesystem>
#include <map>
#include <string>

#include "optim/solvers/sharing.hpp"
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"
#include "results/run/progress.hpp"
#include "results/run/run_files.hpp"

namespace flexopt {

/// All leave job.json in the folder before they start; an empty path: nothing is written at all.
/// `sharing`: with whom work is shared; null: with nobody. What a process that follows a leader
/// gets means nothing, nor does what a shard gets; a shard ends with ShardEnds where it would need
/// the others. `along`: of which parameters exact derivatives are wanted too (ThroughFormulas), of
/// a path that is then differentiable; none: of none.
RunRecord run_evaluation(const Job& job, const std::filesystem::path& folder, int threads,
                         RunListener& listener, const std::vector<std::string>& along = {},
                         Sharing* sharing = nullptr);

/// Appends to evaluations.jsonl in the folder, and goes on from the one it finds there. Throws
/// SpecError where an interrupted run of another job stands in the way.
RunRecord run_optimisation(const Job& job, const std::filesystem::path& folder, int threads,
                           RunListener& listener, Sharing* sharing = nullptr);

/// Runs a comparison with full accuracy; arguments and errors as of run_optimisation().
RunRecord run_comparison(const Job& job, const std::filesystem::path& folder, int threads,
                         RunListener& listener, Sharing* sharing = nullptr);

/// The one of these that the job asks for.
RunRecord run_any(const Job& job, const std::filesystem::path& folder, int threads,
                  RunListener& listener, const std::vector<std::string>& along = {},
                  Sharing* sharing = nullptr);

// A mechanism as it was designed, of which nothing has been computed.

/// The record of a job's mechanism with one point, undeflected, that has nothing but the shapes of
/// its leaves; a point for each load case, since these differ in what acts. No equilibrium is
/// looked for. Throws SpecError for a job that lists designs.
RunRecord undeflected(const Job& job);

/// Result for the page of an undeflected mechanism: the status is "undeflected" and there is no
/// path.
OrderedJson undeflected_result(const RunRecord& record);

// A job that lists designs: each is a run of its own in a folder of its own, and one more result
// has them all.

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
