#pragma once
// Finds the distance or angle of a design that a parameter is, and a view that shows it.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "designs/family.hpp"

namespace flexopt {

// A design at given numbers as a drawing sees it: places, and how each moves with each parameter.

struct DrawnPoint {
  enum class Kind {
    middle,  ///< in the middle of a leaf's width
    rim,     ///< on its free edge
    face,    ///< on a face
    box,     ///< corner of a body's box, or on a ridge of an elastic body
    place,   ///< O, a joint, an end of a spring, an interface of an elastic body
    origin
  };
  Kind kind = Kind::middle;
  int owner = -1;               ///< leaf; of a box the body, or behind all bodies the elastic one
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
  /// Whether a parameter is zero, its least value: what it measures is not there.
  bool is_absent(std::size_t parameter) const {
    return values[parameter] == 0 && parameters[parameter].min == 0;
  }
  /// The one parameter that a distance or an angle is: of its unit and its value, grows by one with
  /// it, stays as all others change that are not absent. rate(k): along parameter k. Nothing for
  /// other distances.
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
    if (std::abs(r) < equal_rates || is_absent(k)) continue;
    const double sign = values[k] < 0 ? -1 : 1;
    if (found || parameters[k].unit != unit || std::abs(r - sign) > equal_rates)
      return std::nullopt;
    if (std::abs(value - sign * values[k]) > equal_lengths * (unit == "m" ? size : 1))
      return std::nullopt;
    found = k;
  }
  return found;
}

/// The rates are exact. `nominal`: whose meshes elastic bodies have; empty: of this design. Throws
/// SpecError as Family::make.
PlacedDesign placed_design(const Family& family, const ParameterValues& values,
                           const FamilyChoices& choices, const ParameterValues& nominal = {});

// Dimensions and views.

/// A direction to look from: unit vectors to the right and upwards on the drawing.
struct DrawnView {
  std::string caption;
  Vector3d right, up;
  std::vector<int> leaves;  ///< that it shows alone; empty: all is shown

  bool shows_leaf(std::size_t leaf) const {
    return leaves.empty() || std::ranges::find(leaves, static_cast<int>(leaf)) != leaves.end();
  }
  Vector3d toward() const { return right.cross(up); }
  Eigen::Vector2d operator()(const Vector3d& v) const { return {right.dot(v), up.dot(v)}; }
};

/// The three plan views: from the front (x to the right, y up), from below and from the right,
/// arranged in third-angle projection.
const std::vector<DrawnView>& plan_views();

/// A dimension: the distance of two places as a view shows it, or the angle at `from` between a
/// direction of the view (of its axes, or of a leaf) and the way to `to`.
struct ShownMeasure {
  enum class Along { way, right, up, angle };
  std::size_t parameter = 0;  ///< place among PlacedDesign::parameters
  Along along = Along::way;
  Vector3d from, to;
  Eigen::Vector2d axis = Eigen::Vector2d::Zero();  ///< axis of an angle
  std::vector<Vector3d> guide = {};                ///< a thin line by which an angle is seen
};

struct MeasuredView {
  DrawnView view;
  std::vector<ShownMeasure> measures;
};

struct MeasuredDesign {
  std::vector<MeasuredView> views;   ///< the front first
  std::vector<std::size_t> without;  ///< lengths that move the geometry but are no distance in it
};

/// A distance is a parameter's if it has its value, grows by one with it and stays as all others
/// change: by the exact rates, so that dimensions which are equal by chance are told apart. Every
/// length gets one dimension, in as few views as show them all, and every angle to an axis of a
/// plan view or between leaves; leaves that none of the plan views shows in true size get a view of
/// their own.
MeasuredDesign measured_design(const PlacedDesign& design);

}  // namespace flexopt
