#pragma once
// evaluations.jsonl: every evaluated design, one line each, from which an interrupted run resumes.
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "optim/problem/design_problem.hpp"
#include "optim/problem/evaluation_record.hpp"
#include "optim/problem/line_log.hpp"
#include "optim/solvers/sharing.hpp"

namespace flexopt {

struct LoggedEvaluation {
  EvaluationRecord record;
  DesignValues values;
  bool gradient_asked = false;  ///< although there may be none
};

/// Name of a stage in the log and in history.csv. `stage_named` throws std::runtime_error for other
/// names.
std::string name_of(Stage stage);
Stage stage_named(const std::string& name);

/// The record in a line of a log, of any version. Throws where the line is no evaluation.
EvaluationRecord record_of(const nlohmann::json& line);

/// A matrix by its rows, as logs and workers hand it on, and back.
std::vector<std::vector<double>> rows_of(const MatrixXd& matrix);
MatrixXd matrix_of(const nlohmann::json& rows);

/// What of a job decides the values of its designs and the path of its optimisation: all but name,
/// expectations, and how many starts, evaluations and screened designs there may be; and the
/// atlases of its models.
nlohmann::json log_identity(const Job& job, const std::string& version);

class EvaluationLog {
 public:
  /// Opens or creates the file and reads what it holds; refuses others' as LineLog does. Without a
  /// path it keeps nothing on disk.
  explicit EvaluationLog(const Job& job, const std::filesystem::path& path = {},
                         const std::string& version = {}, bool overwrite = false);

  /// The evaluation of these exact variables by an earlier run, or null. Evaluations with and
  /// without gradient are kept apart: their values may differ in the last digits.
  const LoggedEvaluation* find(const Variables& variables, bool full, bool gradient) const;
  int loaded() const { return static_cast<int>(loaded_.size()); }

  /// Adds a line and flushes it. Thread-safe.
  void append(const LoggedEvaluation& evaluation);

  /// Brings the file into the order stage, start, number, whatever threads wrote it; lines of
  /// earlier runs that were not asked for this time stay at the end.
  void finish(const std::vector<LoggedEvaluation>& evaluations);

 private:
  struct Key {
    bool full = false, gradient = false;
    Variables variables;
    auto operator<=>(const Key&) const = default;
  };
  Key key_of(const LoggedEvaluation& evaluation) const;
  void read(const std::string& line);

  const Job& job_;
  std::vector<LoggedEvaluation> loaded_;
  std::map<Key, std::size_t> index_;
  LineLog lines_;
};

// Loops without a log of their own (sampled designs, maps) in a run that is shared.

/// What units of these loops yield is kept in units.jsonl, a line each: ["loop", unit, yield].
class SharedUnits {
 public:
  /// Opens or creates the log and reads what it holds; refuses others' as LineLog does. An empty
  /// path, of a process that keeps no files: none.
  SharedUnits(Sharing& sharing, const Job& job, const std::filesystem::path& log,
              const std::string& version);

  /// Units 0, …, count − 1 of a loop, by whom the run is shared with: `work` yields JSON, `keep`
  /// takes it, one unit at a time. What the log has is kept without work. The name tells loops
  /// apart that yield other numbers. False where this process does not learn what all units yield.
  bool run(const std::string& loop, int count, int threads, const LoopProgress& progress,
           const std::function<nlohmann::ordered_json(int unit)>& work,
           const std::function<void(int unit, const nlohmann::json& yield)>& keep);

 private:
  void read(const std::string& line);

  Sharing& sharing_;
  std::map<std::pair<std::string, int>, nlohmann::json> known_;
  LineLog log_;
};

/// Units 0, …, count − 1 of a loop, into a list of as many yields: shared, as JSON, or where
/// `shared` is null by threads of this process alone. False where this process does not learn what
/// all units yield.
template <class Yield, class Work>
bool run_units(SharedUnits* shared, const std::string& loop, int threads,
               const LoopProgress& progress, std::vector<Yield>& yields, const Work& work) {
  const auto count = static_cast<int>(yields.size());
  if (shared)
    return shared->run(
        loop, count, threads, progress,
        [&](int unit) { return nlohmann::ordered_json(work(unit)); },
        [&](int unit, const nlohmann::json& yield) { yields[unit] = yield.get<Yield>(); });
  parallel_for(
      count, threads, [&](int unit) { yields[unit] = work(unit); }, progress);
  return true;
}

/// "name 1f2e3d4c5b6a7988": of a loop that depends on what the text says.
std::string loop_name(const std::string& name, const std::string& depends_on);

}  // namespace flexopt
