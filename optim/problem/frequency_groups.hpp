#pragma once
// Frequencies that may change places: their ranks have kinks where they meet, their mean has none.
#include <cstddef>
#include <optional>
#include <vector>

#include "core/response/quantities.hpp"

namespace flexopt {

using MaybeNumbers = std::vector<std::optional<double>>;

/// Members of a run of frequencies that may meet: places in the list of all numbers, at one point.
using FrequencyGroup = std::vector<std::size_t>;

/// Groups of those quantities among `names` (numbers from `first` on) that may meet within a step
/// of a parameter; `slopes`: derivatives along it.
std::vector<FrequencyGroup> groups_of(const std::vector<Quantity>& names, const MaybeNumbers& here,
                                      const MaybeNumbers& slopes, std::size_t first, double step);

/// Replaces each member of a group by the root of the mean of their squares, which is smooth.
void average_values(const std::vector<FrequencyGroup>& groups, std::vector<double>& values);

/// Replaces the slope of each member of a group by the derivative of the group's average.
void average_slopes(const std::vector<FrequencyGroup>& groups, const MaybeNumbers& here,
                    MaybeNumbers& slopes);

/// Rank in its list of frequencies, from the name of the quantity.
int rank_of(const Quantity& frequency);

}  // namespace flexopt
