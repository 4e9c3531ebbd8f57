#pragma once
// Vibration modes of a whole mechanism of full leaves and their modal derivatives: equations (M2)
// and (M3) of core/reduction/modal/README.md, over all degrees of freedom.
#include <optional>

#include "core/equilibrium/system.hpp"
#include "core/mechanism/modal_inertia.hpp"

namespace flexopt {

/// Rows as in MechanismFactor: (displacement, spin) of the bodies, then the leaves' unknowns.
struct MechanismModes {
  VectorXd omega2;       ///< ascending [rad²/s²]
  MatrixXd modes;        ///< M-orthonormal
  MatrixXd derivatives;  ///< θij, column count · i + j
};

/// The lowest `count` modes, drive free, and θij: how mode i changes when the mechanism leaves its
/// equilibrium along mode j. The mass matrix turns with the bodies; with inertia kept its change
/// counts too. The system must be assembled, its leaves be FullLeaf, without joints. Nothing where
/// an iteration did not converge, or two of the modes share one frequency and inertia is kept.
std::optional<MechanismModes> mechanism_modes(System& system, int count,
                                              ModalInertia inertia = ModalInertia::left_out);

}  // namespace flexopt
