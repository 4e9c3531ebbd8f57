#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "optim/problem/evaluation_record.hpp"
#include "optim/problem/line_log.hpp"
#include "results/run/run_files.hpp"

namespace flexopt {

/// The evaluations of a log that may still grow: each line is read once.
class GrowingLog {
 public:
  /// All whole records of evaluations.jsonl so far; the last line may be torn. Unlike the
  /// optimiser's own reader this takes a log of any version and leaves the file alone. Begins anew
  /// where another file has taken its place. Throws SpecError where a line is no evaluation or does
  /// not fit its checksum.
  const std::vector<EvaluationRecord>& read(const std::filesystem::path& file);

 private:
  std::filesystem::path file_;
  std::uint64_t inode_ = 0;
  std::size_t read_ = 0;  ///< bytes of whole lines
  CheckedLines lines_;
  std::vector<EvaluationRecord> records_;
};

/// What job.json and evaluations.jsonl of an unfinished run tell: status "interrupted", the history
/// and the best design so far, and no path; the scene has the evaluations. Throws SpecError where
/// they tell nothing.
/// `log`: what was read of it before, if anything.
ShownRun interrupted_run(const std::filesystem::path& folder, GrowingLog& log);

}  // namespace flexopt
