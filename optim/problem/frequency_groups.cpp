#include <cmath>

#include "optim/problem/gradient_checker.hpp"

namespace flexopt {

std::vector<FrequencyGroup> groups_of(const std::vector<Quantity>& names, const MaybeNumbers& here,
                                      const MaybeNumbers& slopes, std::size_t first, double step) {
  std::vector<FrequencyGroup> groups;
  double reach = 0;
  std::string list;
  for (std::size_t q = 0; q < names.size(); ++q) {
    if (!names[q].name.starts_with("frequencies.")) continue;
    const std::string of = names[q].name.substr(0, names[q].name.rfind('.'));
    if (!here[first + q] || !slopes[first + q]) continue;
    const double f = *here[first + q], by = 2 * step * std::abs(*slopes[first + q]) + 1e-6 * f;
    if (of != list || f - by > reach) groups.emplace_back();
    reach = of != list ? f + by : std::max(reach, f + by);
    list = of;
    groups.back().push_back(first + q);
  }
  std::erase_if(groups, [](const FrequencyGroup& g) { return g.size() < 2; });
  return groups;
}

void average_values(const std::vector<FrequencyGroup>& groups, std::vector<double>& values) {
  for (const FrequencyGroup& g : groups) {
    double squares = 0;
    for (const std::size_t i : g) squares += values[i] * values[i];
    for (const std::size_t i : g) values[i] = std::sqrt(squares / static_cast<double>(g.size()));
  }
}

void average_slopes(const std::vector<FrequencyGroup>& groups, const MaybeNumbers& here,
                    MaybeNumbers& slopes) {
  for (const FrequencyGroup& g : groups) {
    double squares = 0, change = 0;
    for (const std::size_t i : g) {
      squares += *here[i] * *here[i];
      change += *here[i] * *slopes[i];
    }
    for (const std::size_t i : g)
      slopes[i] = change / std::sqrt(squares * static_cast<double>(g.size()));
  }
}

int rank_of(const Quantity& frequency) {
  return std::stoi(frequency.name.substr(frequency.name.rfind('.') + 1));
}

}  // namespace flexopt
