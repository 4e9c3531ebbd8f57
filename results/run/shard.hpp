#pragma once
// Runs that are shared: as shards, whose parts are merged, or by the processes of mpirun.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "optim/job/job.hpp"
#include "optim/solvers/sharing.hpp"

namespace flexopt {

// Shards of a run: what a folder says of its own, and the union of their logs.

/// Shard from a text such as "3/16". Throws SpecError (pointer --shard).
Shard read_shard(const std::string& text);

/// Throws SpecError (pointer --shard) where a job has no work that shards can have parts of.
void check_shardable(const Job& job);

/// shard.json: which shard a folder holds, and whether it is done. Throws SpecError where the
/// folder holds another shard, or another run. `job_folder`: what files that the job names are
/// relative to.
void begin_shard(const std::filesystem::path& folder, const std::filesystem::path& job_folder,
                 const Shard& shard);
/// Ends a shard that `begin_shard` began.
void end_shard(const std::filesystem::path& folder, const Sharing& sharing);

/// What was found in the folders of shards.
struct FoundShards {
  Job job;
  int of = 1;
  std::vector<int> missing;        ///< not there, or not done
  std::vector<std::string> notes;  ///< a sentence each: shards that are there twice, or not done
};

/// Checks that the folders hold shards of one job, of this build and of one number of shards.
/// Throws SpecError that names the folder that does not belong to the first.
FoundShards find_shards(const std::vector<std::filesystem::path>& folders);

/// Writes the union of all logs, with those that `out` has, into it: from there the run of the job
/// goes on. The same evaluation twice is one; throws SpecError where the two have different values.
void merge_logs(const FoundShards& found, const std::vector<std::filesystem::path>& folders,
                const std::filesystem::path& out);

/// Text of numbers for an --array of Slurm: {1, 2, 3, 7} become "1-3,7".
std::string array_text(const std::vector<int>& numbers);

// Joins the processes that mpirun has started as workers.

/// How many processes the launcher of MPI says that it started; 0 where none did.
int started_together();

/// The workers of these processes; null where this process was started alone. MPI is in a library
/// of its own, flexopt_mpi.so, which nothing else loads. Throws SpecError where it is not there.
std::unique_ptr<Workers> join_workers();

/// Leader: tells the others the job, and the folder that files it names are relative to.
void tell_job(Workers& workers, const Job& job, const std::filesystem::path& job_folder);
/// The others: the job of the leader. Throws SpecError where that is another build of flexopt.
Job hear_job(Workers& workers);

}  // namespace flexopt
