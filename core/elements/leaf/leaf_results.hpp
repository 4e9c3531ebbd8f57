#pragma once
// What a leaf tells of itself at an equilibrium. Plain data.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// What a notch multiplies the stresses of a section with: their mean over the thickness, and what
/// differs from it.
struct NotchFactors {
  double membrane = 1, bending = 1;
};
/// Of the base edge and of the tip edge; nothing where the edge has no notch or is free.
using ClampFactors = std::array<std::optional<NotchFactors>, 2>;

struct StressPeak {
  double value = 0;                      ///< von Mises [Pa]
  int leaf = 0;                          ///< index in the mechanism
  double along = 0, across = 0;          ///< place on the leaf, each in [0, 1]
  Vector3d position = Vector3d::Zero();  ///< deflected place [m]
  bool on_positive_normal = true;        ///< which surface
  int segment = 0;                       ///< of a leaf that consists of segments
  NotchFactors notch;                    ///< that the value has in it
  double per_membrane = 0,
         per_bending =
             0;  ///< derivatives of the value by these factors, where there is a notch [Pa]
};

/// A peak of segment i of n equal ones, as one of the whole leaf.
inline StressPeak peak_of_leaf(StressPeak of_segment, int i, int n) {
  of_segment.segment = i;
  of_segment.along = (i + of_segment.along) / n;
  return of_segment;
}

/// Which model a leaf was evaluated with at a point, and why.
struct LeafReport {
  std::string model;   ///< "tube", "linear_craig_bampton", "full"
  std::string reason;  ///< why not the default; empty otherwise
  double check = 0;    ///< relative correction of the condensed full leaf; 0 if not made
  /// Where the coefficients of a tube come from: "built" or "atlas"; of other models empty.
  std::string source = {};
  int degree = 0;  ///< of the potential of a tube; of other models 0
  /// Evaluated at full accuracy, or its frequencies, because its own model was not believed.
  bool replaced = false;
};

/// Deformed mid-surface of a leaf on its mesh, points along first.
struct LeafShape {
  int points_along = 0, points_across = 0;
  std::vector<Vector3d> undeflected, deflected;  ///< [m]
  std::vector<double> von_mises;                 ///< larger of both surfaces [Pa]
};

}  // namespace flexopt
