#pragma once
// Loops without a log of their own (sampled designs, maps) in a run that is shared.
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "optim/numerics/sharing.hpp"
#include "optim/problem/line_log.hpp"

namespace flexopt {

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
  Sharing& sharing_;
  std::map<std::pair<std::string, int>, nlohmann::json> known_;
  LineLog log_;
};

/// "name 1f2e3d4c5b6a7988": of a loop that depends on what the text says.
std::string loop_name(const std::string& name, const std::string& depends_on);

}  // namespace flexopt
