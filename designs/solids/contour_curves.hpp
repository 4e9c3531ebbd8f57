#pragma once
// Contours of plates as lines and arcs of circles.
#include "core/math/dual.hpp"
#include "designs/solids/solid_shape.hpp"

namespace flexopt {

template <class S>
using Point2 = Eigen::Matrix<S, 2, 1>;

/// A line, or an arc about `center`.
template <class S>
struct CurveT {
  Point2<S> from, to;
  bool is_arc = false;
  Point2<S> center = Point2<S>::Zero();
  S radius = S(0.0), start = S(0.0), sweep = S(0.0);  ///< angles [rad]; sweep < 0: clockwise
  double left = 1;  ///< share that fillets at its ends have left; not positive: they do not fit

  Point2<S> at(double u) const;       ///< 0 ≤ u ≤ 1, in proportion to the length along it
  Point2<S> tangent(double u) const;  ///< of length 1
  double length() const;
};

/// The outline, the windows, the holes, one after the other. A fillet comes before the curve that
/// begins at its corner.
template <class S>
struct ContoursT {
  std::vector<CurveT<S>> curves;
  std::vector<int> first;  ///< curve of each contour; last: the number of curves

  int contours() const { return static_cast<int>(first.size()) - 1; }
  /// The curve that goes on where curve c of contour k ends.
  int after(int k, int c) const { return c + 1 < first[k + 1] ? c + 1 : first[k]; }
};
template <class S>
ContoursT<S> contours_of(const PlateShapeT<S>& plate);

/// Tells of arcs through three points of a line, of fillets that do not fit, of corners that are
/// sharper than 10° and of contours that cross each other or themselves.
Check check_contours(const ContoursT<double>& contours, std::size_t windows);

/// A chord of a curve.
struct Chord {
  Point2<double> from, to;
  int curve;
};
std::vector<Chord> chords_of(const ContoursT<double>& contours);
/// Whether two chords have a point in common.
bool touch(const Chord& a, const Chord& b);
/// Whether a place lies within the closed lines of these chords, an odd number of times.
bool is_inside(const std::vector<Chord>& chords, const Point2<double>& place);

}  // namespace flexopt
