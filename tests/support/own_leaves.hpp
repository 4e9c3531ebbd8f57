#pragma once
// Random mechanisms of one body on leaves of all kinds, each direction of the body free, held or
// driven, and how far two models of one agree.
#include <string>
#include <vector>

#include "core/response/response.hpp"

namespace flexopt {

struct OwnLeaves {
  Mechanism mechanism;
  ModelOptions model;
  StrokeRequest request;
  std::string what;  ///< a line of its kinds, sizes, directions and stroke
};

/// The same for the same seed. One to three leaves from the ground to the body, flat, curved or
/// tapered plates, beams and wires, along the axes or anyhow; of six directions at least one
/// driven, by 0.5 to 30 thicknesses; three points along a straight way from rest. Every third has a
/// dead load.
OwnLeaves own_leaves(unsigned seed);

/// Where two answers differ.
struct Disagreement {
  std::string number;  ///< "drive_load.1"
  std::size_t point = 0;
  double found = 0, expected = 0;
  /// To the largest of |expected|, a hundredth of the path's largest and, of compliances with the
  /// drives held, a thousandth of what they are with them free.
  double relative = 0;
};

/// The largest of all loads, stiffnesses and compliances of points that both have found.
Disagreement largest_disagreement(const StrokeResponse& found, const StrokeResponse& expected);

}  // namespace flexopt
