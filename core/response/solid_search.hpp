#pragma once
// What the searches for extents and for clearances share.
#include <algorithm>
#include <utility>

#include "core/response/minimise.hpp"
#include "core/response/solids.hpp"

namespace flexopt {

/// Relative difference below which two values are equal; the first one counts then.
inline constexpr double equal_distance = 1e-9;

/// Place of the second derivative (i, j) in Solids::Local::curvatures.
inline int symmetric_index(int i, int j) {
  if (i > j) std::swap(i, j);
  return i == 0 ? j : i == 1 ? 2 + j : 5;
}

}  // namespace flexopt
