#pragma once
// What a leaf tells of itself at an equilibrium. Plain data.
#include <string>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

struct StressPeak {
  double value = 0;                      ///< von Mises [Pa]
  int leaf = 0;                          ///< index in the mechanism
  double along = 0, across = 0;          ///< place on the leaf, each in [0, 1]
  Vector3d position = Vector3d::Zero();  ///< deflected place [m]
  bool on_positive_normal = true;        ///< which surface
  int segment = 0;                       ///< of a leaf that consists of segments
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
};

/// Deformed mid-surface of a leaf on its mesh, points along first.
struct LeafShape {
  int points_along = 0, points_across = 0;
  std::vector<Vector3d> undeflected, deflected;  ///< [m]
  std::vector<double> von_mises;                 ///< larger of both surfaces [Pa]
};

}  // namespace flexopt
