#pragma once
// The elastica, which slender leaves without Poisson's effect follow.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/equilibrium/stroke_path.hpp"

namespace flexopt {

/// A clamped leaf of length L along x under a dead transverse force of EI/L² at its tip, which
/// grows to ten times that, against Bisshopp and Drucker: elliptic integrals to 12 digits.
inline void check_elastica(System& system, double L, double tolerance) {
  struct Row {
    double load, w, u;
  };
  for (const Row& row : {Row{1, 0.3017207738, 0.0564332362834},
                         {2, 0.493457480397, 0.160641720825},
                         {5, 0.713791523612, 0.387628360724},
                         {10, 0.81060902488, 0.554995597754}}) {
    const Equilibrium e = step_load(system, {.constant = row.load}, {});
    REQUIRE(e.converged);
    const Vector3d d = system.pose(0).position - Vector3d(L, 0, 0);
    CAPTURE(row.load, d[1] / L - row.w, -d[0] / L - row.u);
    CHECK(std::abs(d[1] / L - row.w) < tolerance);
    CHECK(std::abs(-d[0] / L - row.u) < tolerance);
  }
}

}  // namespace flexopt
