#include "core/mechanism/body_inertia.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/math/decompositions.hpp"

namespace flexopt {

std::optional<InertiaFault> inertia_fault(const Matrix3d& inertia) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j)
      if (std::abs(inertia(i, j) - inertia(j, i)) > 1e-9 * inertia.cwiseAbs().maxCoeff())
        return InertiaFault{
            fmt::format("/{}/{}", i, j), fmt::format("{:g} kg m^2", inertia(i, j)),
            fmt::format("an inertia is symmetric: expected {:g} kg m^2 as in row {}", inertia(j, i),
                        j)};
  const Vector3d principal = symmetric_eigenvalues(0.5 * (inertia + inertia.transpose()));
  const double rounding = 1e-9 * principal.cwiseAbs().maxCoeff();
  const std::string values = fmt::format("principal values {:g}, {:g}, {:g} kg m^2", principal[0],
                                         principal[1], principal[2]);
  if (principal[0] < -rounding) return InertiaFault{"", values, "expected none below zero"};
  if (principal[2] > principal[0] + principal[1] + rounding)
    return InertiaFault{"", values, "no body has these: each is at most the sum of the other two",
                        true};
  return std::nullopt;
}

}  // namespace flexopt
