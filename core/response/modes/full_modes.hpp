#pragma once
// Eigenpairs of the whole mechanism, leaf interiors included, to rounding.
#include <optional>
#include <vector>

#include "core/response/modes/mechanism_factor.hpp"
#include "core/response/response.hpp"

namespace flexopt {

struct FullModes {
  int converged = 0;        ///< so many were asked for, the lowest; the others are guards
  VectorXd lambda;          ///< squares of the frequencies, ascending
  MatrixXd phi;             ///< M-orthonormal
  std::vector<Mode> modes;  ///< those listed: all that were asked for, or fewer
  /// The leaves have no motions of their own: they follow the bodies by their static shapes.
  bool static_shapes = false;
};

struct FullModeLists {
  FullModes free, locked;
};

/// Whether modes have Mode::motion, which tells them apart.
enum class ModeMotions { no, yes };

/// The lowest `free` modes with the drive free and `locked` ones with the drive held, from one
/// Krylov space, or from all motions where these are few. Nothing where the iteration fails.
std::optional<FullModeLists> full_modes(const MechanismFactor& factor, int free, int locked,
                                        ModeMotions motions = ModeMotions::yes);

/// Modes without internal motions of the leaves (`leaf_modes: 0`): as many as the bodies have.
FullModeLists static_modes(const MechanismFactor& factor, int free, int locked);

/// Modes of all unknowns of the mechanism, in the shares of natural_frequencies().
std::vector<Mode> classified_modes(const MechanismFactor& factor, bool drive_locked,
                                   const VectorXd& lambda, const MatrixXd& phi,
                                   const MatrixXd& M_phi, ModeMotions motions = ModeMotions::yes);

}  // namespace flexopt
