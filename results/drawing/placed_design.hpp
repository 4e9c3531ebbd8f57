#pragma once
// A design at given numbers as a drawing sees it: places, and how each moves with each parameter.
#include <vector>

#include "designs/family.hpp"

namespace flexopt {

struct DrawnPoint {
  enum class Kind {
    middle,  ///< in the middle of a leaf's width
    rim,     ///< on its free edge
    face,    ///< on a face
    box,     ///< corner of a body's box
    place,   ///< O, a joint, an end of a spring
    origin
  };
  Kind kind = Kind::middle;
  int owner = -1;               ///< leaf; of a box the body
  bool inside = false;          ///< of a leaf: neither at an end nor at a fold
  Vector3d at;                  ///< [m]
  std::vector<Vector3d> rates;  ///< along each parameter [m per its SI unit]
};

struct PlacedDesign {
  Mechanism mechanism;
  std::vector<Parameter> parameters;  ///< all but counts; points have a rate for each
  std::vector<double> values;         ///< of these
  std::vector<DrawnPoint> points;
  double size = 0;  ///< diagonal of the box around the points [m]

  /// Whether any point moves along the parameter.
  bool moves(std::size_t parameter) const;
};

/// The rates are exact. Throws SpecError as Family::make.
PlacedDesign placed_design(const Family& family, const ParameterValues& values,
                           const FamilyChoices& choices);

}  // namespace flexopt
