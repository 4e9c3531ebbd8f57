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
/// Notch factors of the base edge and of the tip edge; nothing where the edge has no notch or is
/// free.
using ClampFactors = std::array<std::optional<NotchFactors>, 2>;

/// Stresses of the section at a place, in the axes along and across the leaf [Pa]: σ11, σ22, σ12 of
/// the mean over the thickness, then what bending and twist add on the side of the normal and take
/// away on the other one. Of a wire the surface is its outline, and "across" that along it: one
/// side is the place at `across` with z ≥ 0, the other one is opposite.
using SectionStress = Vector6d;

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
  SectionStress section = SectionStress::Zero();  ///< without the notch
  double across_section = 0;  ///< "across" of the place whose SectionStress that is
  /// The elastic body it is in, and the node of its mesh; what is said of a leaf then means
  /// nothing. Else −1.
  int elastic_body = -1, node = -1;
};

/// A place where the stresses of the section are read, on both surfaces; or those of a node.
struct StressPlace {
  double along = 0, across = 0;  ///< each in [0, 1]
  int segment = 0;               ///< of a leaf that consists of segments
  int node = -1;                 ///< of the mesh of an elastic body
};

/// Which model a leaf was evaluated with at a point, and why.
struct LeafReport {
  std::string model;   ///< "tube", "linear_craig_bampton", "full"
  std::string reason;  ///< why not the default; empty otherwise
  double check = 0;    ///< relative correction of the condensed full leaf; 0 if not made
  /// Source of the coefficients of a tube: "built" or "atlas"; empty for other models.
  std::string source = {};
  int degree = 0;  ///< of the potential of a tube; of other models 0
  /// The leaf, or its frequencies, was evaluated at full accuracy, because its own model was not
  /// accurate enough.
  bool replaced = false;
};

/// Deformed mid-surface of a leaf on its mesh, points along first.
struct LeafShape {
  int points_along = 0, points_across = 0;
  std::vector<Vector3d> undeflected, deflected;  ///< [m]
  std::vector<double> von_mises;                 ///< larger of both surfaces [Pa]
};

}  // namespace flexopt
