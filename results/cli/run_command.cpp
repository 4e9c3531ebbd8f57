// `flexopt run`, alone, as a shard or with the processes of mpirun, and `flexopt merge`.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>

#include "optim/job/found_design.hpp"
#include "results/cli/command_line.hpp"
#include "results/cli/printed.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_json.hpp"
#include "results/run/progress.hpp"
#include "results/run/shard.hpp"

namespace flexopt {

namespace {

/// Ctrl-C in a run that can be resumed: one sentence, then the usual end. Only calls that a signal
/// handler may make.
extern "C" void say_how_to_resume(int signal) {
  constexpr char text[] =
      "\nflexopt: interrupted; the same command goes on from evaluations.jsonl\n";
  const auto ignored = ::write(STDERR_FILENO, text, sizeof text - 1);
  (void)ignored;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

using Clock = std::chrono::steady_clock;

/// A run from its checked job to its files and to what is printed of them.
int whole_run(const Job& job, const CommandLine& line, OutputFolder& folder,
              ProgressDisplay& progress, Clock::time_point begin, Sharing* sharing) {
  const auto end = [&](const WrittenRun& written, const RunRecord* record) {
    folder.keep();
    progress.clear();
    if (line.json)
      print_run(written, line.folder, record);
    else
      fmt::print("{}results: {}\n", record ? summary_of(*record) : listed_summary(*written.result),
                 line.folder);
    for (const std::string& failure : written.failed_expectations)
      put(stderr, fmt::format("flexopt: expected otherwise: {}\n", failure));
    return usable(*written.result) ? exit_usable : exit_not_usable;
  };
  const RunOptions options{folder.path(), line.threads, {}, sharing};
  if (!job.designs.empty()) {
    std::map<std::string, double> timings;
    OrderedJson result = run_listed_designs(job, options, progress, timings);
    timings["total"] = seconds_since(begin);
    const WrittenRun written = write_listed_designs(folder.path(), job, std::move(result), timings);
    return end(written, nullptr);
  }
  RunRecord record = run_any(job, options, progress);
  record.timings["total"] = seconds_since(begin);
  return end(write_run(folder.path(), record), &record);
}

std::filesystem::path job_folder(const CommandLine& line) {
  return std::filesystem::absolute(line.job).parent_path();
}

/// Carries out what a process does of a run that is shared; others have its results.
void take_part(const Job& job, const RunOptions& options, RunListener& listener) {
  std::map<std::string, double> timings;
  if (job.designs.empty())
    run_any(job, options, listener);
  else
    run_listed_designs(job, options, listener, timings);
}

/// A part of a run, which leaves its logs and shard.json.
int run_shard(const Job& job, const CommandLine& line, const Shard& shard, OutputFolder& folder,
              ProgressDisplay& progress) {
  check_shardable(job);
  begin_shard(folder.path(), job_folder(line), shard);
  Sharing sharing(shard);
  try {
    take_part(job, {folder.path(), line.threads, {}, &sharing}, progress);
  } catch (const ShardEnds&) {
  }
  end_shard(folder.path(), sharing);
  folder.keep();
  progress.clear();
  if (line.json) {
    print_shard(shard, sharing.loops(), line.folder);
    return exit_usable;
  }
  for (const SharedLoop& loop : sharing.loops())
    fmt::print("{} of {} {}\n", loop.here, loop.all, loop.what);
  fmt::print("shard {} of {}: {}\n", shard.number, shard.of, line.folder);
  return exit_usable;
}

/// A run writes the job as it was read into job.json of its folder: not over the user's own.
void check_own_job(const CommandLine& line) {
  const std::filesystem::path folder = line.folder;
  const bool of_a_run = exists(folder / "result.json") || exists(folder / "evaluations.jsonl");
  std::error_code error;
  if (!of_a_run && equivalent(folder / "job.json", line.job, error))
    throw SpecError("--out", line.folder,
                    "expected another folder: the run's job.json would replace the job itself");
}

/// A process of mpirun that answers what the first one asks.
int help_run(const CommandLine& line, Workers& workers) {
  try {
    const Job job = hear_job(workers);
    Sharing sharing(workers);
    Silent silent;
    take_part(job, {{}, line.threads, {}, &sharing}, silent);
  } catch (const WorkersDismissed&) {
  } catch (const std::exception& error) {
    workers.fail(error.what());
  }
  return exit_usable;
}

}  // namespace

int run_job(const CommandLine& line) {
  const auto begin = Clock::now();
  std::optional<Shard> shard;
  if (!line.shard.empty()) shard = read_shard(line.shard);
  if (shard && started_together() > 1)
    throw SpecError("--shard", line.shard,
                    "expected no shard under mpirun, which shares a run by itself");
  const std::unique_ptr<Workers> workers = join_workers();
  if (workers && !workers->leads()) return help_run(line, *workers);
  Job job = checked_job(line);
  if (line.rigid) job = beside_rigid(job);
  // expected numbers are those of the job as written, unless --set gives others
  const bool changed =
      !job.expect.empty() && !line.overrides.empty() &&
      std::ranges::none_of(line.overrides, [](const auto& s) { return s.starts_with("/expect"); });
  if (changed) job.expect.clear();
  check_own_job(line);
  OutputFolder folder(line.folder);  // goes away again if something is still wrong with the input
  ProgressDisplay progress(stderr, progress_style(stderr, line.quiet));
  for (const std::string& note : job.notes) progress.say("note: " + note);
  if (changed) progress.say("note: --set changed the job; its expected numbers are not checked");
  if (job.kind != JobKind::evaluate) std::signal(SIGINT, say_how_to_resume);
  if (shard) return run_shard(job, line, *shard, folder, progress);
  if (!workers) return whole_run(job, line, folder, progress, begin, nullptr);
  tell_job(*workers, job, job_folder(line));
  Sharing sharing(*workers);
  progress.say(fmt::format("shared by {} processes", workers->members()));
  try {
    return whole_run(job, line, folder, progress, begin, &sharing);
  } catch (const WorkersLost& error) {
    folder.keep();
    throw SpecError("mpirun", error.what(), "expected processes that can all carry out the job");
  }
}

int merge_shards(const CommandLine& line) {
  const auto begin = Clock::now();
  const std::vector<std::filesystem::path> folders(line.folders.begin(), line.folders.end());
  const FoundShards found = find_shards(folders);
  if (!found.missing.empty() && !line.compute)
    throw SpecError("merge", fmt::format("shards {} of {}", array_text(found.missing), found.of),
                    fmt::format("expected all of them, done: run them (of an array of Slurm: "
                                "--array={}), or merge with --compute, which evaluates here what "
                                "is missing",
                                array_text(found.missing)));
  if (std::filesystem::exists(std::filesystem::path(line.folder) / "shard.json"))
    throw SpecError("--out", line.folder, "a shard is in this folder: expected another folder");
  OutputFolder folder(line.folder);
  ProgressDisplay progress(stderr, progress_style(stderr, line.quiet));
  for (const std::string& note : found.notes) progress.say("note: " + note);
  merge_logs(found, folders, folder.path());
  folder.keep();  // from here on it is an interrupted run, which goes on
  Sharing with_nobody;
  return whole_run(found.job, line, folder, progress, begin, &with_nobody);
}

}  // namespace flexopt
