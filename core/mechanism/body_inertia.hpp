#pragma once
// What the inertia of a body can be.
#include <optional>
#include <string>

#include "core/math/types.hpp"

namespace flexopt {

/// Why no body has an inertia.
struct InertiaFault {
  std::string place;  ///< "/2/0" of the entry that is wrong; empty: of the whole
  std::string value, rule;
  bool of_sum = false;  ///< I3 > I1 + I2 alone, as of those who think in a plane: [0, 0, I]
};

/// What is wrong with an inertia about the centre of mass [kg m²]; nothing if it is sound. The
/// inertia of a real body is symmetric to rounding, with principal values 0 ≤ I1 ≤ I2 ≤ I3 ≤ I1 +
/// I2.
std::optional<InertiaFault> inertia_fault(const Matrix3d& inertia);

}  // namespace flexopt
