#pragma once
// What reads texts from outside, one function each. It answers or refuses in words; anything else
// ends the program.
#include <string>
#include <string_view>
#include <vector>

namespace flexopt::fuzz {

struct Target {
  std::string name;  ///< also of its folder in the corpus
  void (*run)(std::string_view text);
};

/// Formulas, units, --set and requests: readers that need nothing of the mechanics.
const std::vector<Target>& text_targets();
/// Jobs, design files, logs, and these.
const std::vector<Target>& targets();

}  // namespace flexopt::fuzz
