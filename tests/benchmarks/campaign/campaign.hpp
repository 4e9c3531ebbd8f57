#pragma once
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace flexopt {

/// How seeds ended, a JSON object each.
using SeedLines = std::map<int, nlohmann::json>;

/// The lines of logs, of each seed the last; one whose end was not written is left out.
SeedLines read_logs(const std::vector<std::string>& files);

/// Seeds that are looked at in processes of their own, ten in each: a seed that crashes, or takes
/// too long, costs its process and is counted.
struct Campaign {
  int first = 0, count = 0;
  /// A file to which every seed adds a line as it ends; seeds that are in it are not run again.
  std::string log = {};
  int processes = 1;          ///< at a time
  unsigned most_seconds = 0;  ///< of the processor, for a seed; 0: as many as it takes
  std::function<nlohmann::json(int seed)> line_of;
  std::function<void(const nlohmann::json& line)> print_findings;
};

/// The lines of all its seeds. Each has its "seed"; of one that did not end "status" is "crashed"
/// or "too long" and "crashed" says so.
SeedLines run(const Campaign& campaign);

}  // namespace flexopt
