#pragma once
// Which model a leaf needs: estimated errors of the cheaper ones. beams.md, "Beam or plate".
#include <optional>
#include <string>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

struct LeafValidity {
  double aspect = 0;          ///< L/w
  double flatness = 0;        ///< w²/(L t): how soon bending flattens the section
  double warping_length = 0;  ///< √(E C_w / G J) [m]: how far a clamped end stiffens torsion
  /// Estimated relative errors of the support stiffness of a beam (largest over a large stroke).
  double beam_free_warping = 0, beam = 0;
  /// Estimated relative error of the plate: its bending in the plane, equation (E9). Nothing where
  /// there is no plate: a wire, or a Poisson's ratio above a half.
  std::optional<double> plate;
  double beam_drive = 0;  ///< of the drive stiffness of a beam: the anticlastic bending it lacks
  std::string needed;  ///< "beam", "beam_with_warping" or "plate": the cheapest within `accepted`
  static constexpr double accepted = 0.05;
};

LeafValidity leaf_validity(const LeafSpring& leaf);

}  // namespace flexopt
