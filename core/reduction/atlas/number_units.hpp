#pragma once
// Units in which errors of the numbers of an atlas count: what they do to the stiffness of a leaf,
// to its internal frequencies and motions.
#include <vector>

#include "core/reduction/atlas/coded_tables.hpp"
#include "core/reduction/atlas/tube_atlas.hpp"

namespace flexopt {

/// Units of the terms of the potentials. `values`: of each ray all bent states, the terms of
/// atlas_terms() × the shapes of shape_grid().
std::vector<NumberUnits> potential_units(const AtlasSettings& settings,
                                         const std::vector<std::vector<NumbersOfShapes>>& values);

/// Units of the numbers of the internal dynamics, in the order of table_numbers(), and of so many
/// numbers of the stations. `values`: as above.
struct DynamicsUnits {
  std::vector<NumberUnits> tables, stations;
};
DynamicsUnits dynamics_units(const AtlasSettings& settings,
                             const std::vector<std::vector<NumbersOfShapes>>& values,
                             Eigen::Index stations);

}  // namespace flexopt
