#pragma once
// What each command does. Each returns the exit code; wrong input is thrown as SpecError.
#include "optim/job/job.hpp"
#include "results/cli/command_line.hpp"

namespace flexopt {

inline constexpr int exit_usable = 0;      ///< done and usable
inline constexpr int exit_not_usable = 1;  ///< ran, but no equilibrium, infeasible, not converged
inline constexpr int exit_wrong_input = 2;
inline constexpr int exit_bug = 3;  ///< ours

/// Reads, checks and builds a job's mechanisms: all that can be wrong before a run.
Job checked_job(const CommandLine& line);

int run_job(const CommandLine& line);
int merge_shards(const CommandLine& line);
int validate_job(const CommandLine& line);
int describe_designs(const CommandLine& line);
int list_quantities(const CommandLine& line);
int expand_job(const CommandLine& line);
int print_schema(const CommandLine& line);
int check_gradients(const CommandLine& line);
int rewrite_report(const CommandLine& line);
int export_job(const CommandLine& line);
int make_atlas_file(const CommandLine& line);
int explore_job(const CommandLine& line);
int watch_run(const CommandLine& line);
int show_mechanism(const CommandLine& line);
int write_new_job(const CommandLine& line);
int print_completion(const CommandLine& line);

}  // namespace flexopt
