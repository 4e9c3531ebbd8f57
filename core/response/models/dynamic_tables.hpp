#pragma once
// Which leaves take their internal dynamics from tables.
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_element.hpp"

namespace flexopt {

/// States of leaves for each bent state of their tube from which on tables of the dynamics cost
/// less than condensing the full leaf at every state. Measured on the default mesh.
inline constexpr int states_that_pay = 10;

/// Makes them for the tubes among `leaves` where it pays. `points`: at so many points of the path
/// natural frequencies of as_modelled values are wanted.
void make_dynamic_tables(const std::vector<std::unique_ptr<LeafElement>>& leaves, int points);

}  // namespace flexopt
