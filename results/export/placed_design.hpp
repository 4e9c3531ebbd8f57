#pragma once
// A design at given numbers as a drawing sees it: places, and how each moves with each parameter.
#include <cmath>
#include <optional>
#include <string>
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
  bool inside = false;          ///< neither at an end of a leaf nor at a fold
  Vector3d at;                  ///< [m]
  std::vector<Vector3d> rates;  ///< along each parameter [m per its SI unit]
};

/// A leaf where it begins or ends, or one of its legs at the fold.
struct DrawnLeg {
  int leaf = 0;
  Vector3d at;                  ///< [m]
  Vector3d along;               ///< unit vector, from there into the leaf
  std::vector<Vector3d> rates;  ///< rates of `along` with each parameter [per its SI unit]
};

struct PlacedDesign {
  Mechanism mechanism;
  std::vector<Parameter> parameters;  ///< all but counts; points have a rate for each
  std::vector<double> values;         ///< values of these
  std::vector<DrawnPoint> points;
  std::vector<DrawnLeg> legs;  ///< base and tip of each leaf, then both sides of its fold
  double size = 0;             ///< diagonal of the box around the points [m]

  /// Whether any point moves along the parameter.
  bool moves(std::size_t parameter) const;
  /// The one parameter that a distance or an angle is: of its unit and its value, grows by one with
  /// it, stays as all others change. rate(k): along parameter k. Nothing for other distances.
  template <class Rate>
  std::optional<std::size_t> parameter_of(double value, const std::string& unit,
                                          const Rate& rate) const;
};

template <class Rate>
std::optional<std::size_t> PlacedDesign::parameter_of(double value, const std::string& unit,
                                                      const Rate& rate) const {
  // what rounding leaves of a rate, and of a length over the size of the design
  constexpr double equal_rates = 1e-7, equal_lengths = 1e-9;
  std::optional<std::size_t> found;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const double r = rate(k);
    if (std::abs(r) < equal_rates) continue;
    const double sign = values[k] < 0 ? -1 : 1;
    if (found || parameters[k].unit != unit || std::abs(r - sign) > equal_rates)
      return std::nullopt;
    if (std::abs(value - sign * values[k]) > equal_lengths * (unit == "m" ? size : 1))
      return std::nullopt;
    found = k;
  }
  return found;
}

/// The rates are exact. Throws SpecError as Family::make.
PlacedDesign placed_design(const Family& family, const ParameterValues& values,
                           const FamilyChoices& choices);

}  // namespace flexopt
