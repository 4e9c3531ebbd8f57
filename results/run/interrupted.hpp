#pragma once
#include <filesystem>

#include "results/files/json_text.hpp"

namespace flexopt {

/// What job.json and evaluations.jsonl of an interrupted optimisation tell: status "interrupted",
/// the history and the best design so far, and no path. Throws SpecError where they tell nothing.
OrderedJson interrupted_result(const std::filesystem::path& folder);

}  // namespace flexopt
