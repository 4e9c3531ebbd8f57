#pragma once
// What `flexopt run --json` prints: one object on stdout, whatever happens.
#include <string>

#include "core/spec/spec_error.hpp"
#include "optim/numerics/sharing.hpp"
#include "results/files/run_record.hpp"
#include "results/run/run_files.hpp"

namespace flexopt {

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

}  // namespace flexopt
