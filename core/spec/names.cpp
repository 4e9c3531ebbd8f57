#include "core/spec/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <numeric>

namespace flexopt {

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);  // distances of a's prefix to every prefix of b
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i) + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::optional<std::string> nearest_name(std::string_view name,
                                        const std::vector<std::string>& known) {
  constexpr std::size_t longest = 100;  // nobody meant a known name with more letters
  if (name.size() > longest) return std::nullopt;
  const auto lower = [](std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return result;
  };
  std::optional<std::string> best;
  int least = 0;
  for (const std::string& candidate : known) {
    const int distance = edit_distance(lower(name), lower(candidate));
    const int allowed =
        std::max(1, static_cast<int>(std::max(name.size(), candidate.size()) + 1) / 3);
    if (distance <= allowed && (!best || distance < least)) {
      best = candidate;
      least = distance;
    }
  }
  return best;
}

std::string known_names(std::string_view name, const std::vector<std::string>& known) {
  const std::optional<std::string> nearest = nearest_name(name, known);
  return fmt::format("{}known: {}", nearest ? fmt::format("did you mean '{}'? ", *nearest) : "",
                     fmt::join(known, ", "));
}

}  // namespace flexopt
