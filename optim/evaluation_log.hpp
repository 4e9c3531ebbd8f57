#pragma once
// evaluations.jsonl: every evaluated design, one line each, from which an interrupted run resumes.
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "optim/design_problem.hpp"
#include "optim/optimum.hpp"

namespace flexopt {

struct LoggedEvaluation {
  EvaluationRecord record;
  DesignValues values;
};

/// What of a job decides the values of its designs and the path of its optimisation: all but name,
/// expectations, and how many starts and evaluations there may be.
nlohmann::json log_identity(const Job& job, const std::string& version);

class EvaluationLog {
 public:
  /// Without a file nothing is kept on disk.
  explicit EvaluationLog(const Job& job) : job_(job) {}

  /// Opens or creates the file. Reads what it holds; a last line that was cut off is removed.
  /// Throws SpecError when it is the log of another job (the rule names the first difference) or no
  /// log, unless `overwrite` starts it anew.
  EvaluationLog(const Job& job, const std::filesystem::path& path, const std::string& version,
                bool overwrite);

  /// The values of these exact variables from an earlier run, or null.
  const DesignValues* find(const Variables& variables) const;
  int loaded() const { return static_cast<int>(loaded_.size()); }

  /// Adds a line and flushes it. Thread-safe.
  void append(const LoggedEvaluation& evaluation);

  /// Brings the file into the order start, number, whatever threads wrote it; lines of earlier runs
  /// that were not asked for this time stay at the end.
  void finish(const std::vector<LoggedEvaluation>& evaluations);

 private:
  void read(bool overwrite);

  const Job& job_;
  std::filesystem::path path_;
  std::string header_;
  std::ofstream out_;
  std::mutex mutex_;
  std::vector<LoggedEvaluation> loaded_;
  std::map<Variables, std::size_t> index_;
};

}  // namespace flexopt
