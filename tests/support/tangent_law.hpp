#pragma once
// The residual of a mechanism is the derivative of its energy, the tangent that of the residual.
#include <catch2/catch.hpp>

#include "core/equilibrium/stroke_path.hpp"

namespace flexopt::test {

/// Residual of the bodies once they are moved and the leaves have settled between them.
inline VectorXd settled(System& system, const VectorXd& motion) {
  system.move(motion);
  for (int k = 0; k < 10; ++k) {
    system.assemble();
    system.move(VectorXd::Zero(system.size()));
  }
  system.assemble();
  return system.internal_force() - system.load();
}

/// By moving the system there and back.
inline void check_tangent(System& system) {
  (void)settled(system, VectorXd::Zero(system.size()));
  const MatrixXd D = system.residual_tangent().dense(), T = system.tangent().dense();
  CHECK((T - T.transpose()).norm() < 1e-9 * T.norm());
  const auto energy = [&] { return system.energy() + system.load_energy(); };
  for (int k = 0; k < system.size(); ++k) {
    INFO("coordinate " << k);
    const double d = k % 6 < 3 ? 1e-8 : 1e-6;  // the axial stiffness changes within microns
    const VectorXd along = VectorXd::Unit(system.size(), k), up = settled(system, d * along);
    const double above = energy();
    const VectorXd down = settled(system, -2 * d * along);
    const double below = energy();
    const VectorXd here = settled(system, d * along);
    CHECK(((up - down) / (2 * d) - D.col(k)).norm() < 1e-4 * D.col(k).norm());
    CHECK((above - below) / (2 * d) == Approx(here[k]).epsilon(1e-4).margin(1e-4));
  }
}

}  // namespace flexopt::test
