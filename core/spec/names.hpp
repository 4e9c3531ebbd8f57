#pragma once
// Names a user may have meant.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace flexopt {

/// Levenshtein distance: insertions, deletions and replacements that turn `a` into `b`.
int edit_distance(std::string_view a, std::string_view b);

/// The known name closest to `name`, if it is close enough to be a slip: at most a third of the
/// letters wrong, case aside.
std::optional<std::string> nearest_name(std::string_view name,
                                        const std::vector<std::string>& known);

/// "did you mean 'length'? Known: length, width", the first part only where a name is near.
std::string known_names(std::string_view name, const std::vector<std::string>& known);

/// The names of the items of a list.
template <class List>
std::vector<std::string> names_in(const List& list) {
  std::vector<std::string> names;
  for (const auto& item : list) names.emplace_back(item.name);
  return names;
}

}  // namespace flexopt
