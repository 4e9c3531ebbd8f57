#pragma once
// What the commands print.
#include <optional>
#include <string>
#include <vector>

#include "core/response/quantities.hpp"
#include "core/response/response.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/solvers/sharing.hpp"
#include "results/files/run_record.hpp"
#include "results/run/run.hpp"

namespace flexopt {

// A few lines about a run for the terminal.

std::string summary_of(const RunRecord& record);

// The few numbers of a path that its summary shows, in SI.

struct StrokeCell {
  std::optional<double> value;  ///< SI
  std::string direction;        ///< direction of the weakest of several; empty: there is one number
  bool at_least = false;        ///< where nothing ended its growth: what is borne at least
  std::string reason;           ///< why there is none, or a lower bound alone; empty: nothing known
};

struct StrokeRow {
  std::string label;         ///< as a designer says it
  std::string quantity;      ///< key in result.json: "max_stress", "drive_load.x"
  std::string unit;          ///< SI
  std::string absent = "-";  ///< shown where a point has no such number
  double largest = 0;  ///< largest of its kind on the whole path; beside it rounding noise is zero
  std::vector<StrokeCell> cells;  ///< a point each
};

/// Rows at the first, the unmoved and the last converged point, each once; strokes (or the load
/// factor) come first. No rows where no point converged.
std::vector<StrokeRow> stroke_table(const StrokeResponse& response, const DriveList& drives,
                                    const StrokeRequest& request);

// The table of quantities for the terminal.

/// A line for every row of the table, with the names that goals may use, SI units, what an
/// evaluation must compute for it, and what it is.
std::string describe_quantities(const DriveList& drives);

// What `flexopt run --json` prints: one object on stdout, whatever happens.

/// {"flexopt", "status", "message", "usable", "folder", "name", "job", "failed_expectations"} and
/// the summary's numbers in SI, as docs/terminal.md says. `record`: of a job that lists no designs,
/// else null.
void print_run(const WrittenRun& written, const std::string& folder, const RunRecord* record);

/// Prints the outcome of a shard: {"flexopt", "status": "shard", "usable": true, "folder", "shard",
/// "of", "loops"}.
void print_shard(const Shard& shard, const std::vector<SharedLoop>& loops,
                 const std::string& folder);

/// {"flexopt", "status": "wrong_input", "usable": false, "error": {"pointer", "value", "rule",
/// "message"}, "errors"}: the first fault, and all of them.
void print_wrong_input(const SpecError& error);
/// Prints an error that has no place in a job and no list of faults: a wrong command line, a bug.
void print_failure(const std::string& status, const std::string& message);

// Scripts that complete a command line in a shell.

/// Functions for bash, to be sourced (source <(flexopt completion bash)).
std::string bash_completion();
/// Completion for zsh: to be sourced, or as the file _flexopt in a folder of $fpath.
std::string zsh_completion();

}  // namespace flexopt
