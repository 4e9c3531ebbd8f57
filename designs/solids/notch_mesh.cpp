#include "designs/solids/notch_mesh.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/math/dual.hpp"
#include "designs/solids/mesh_plan.hpp"

namespace flexopt {

namespace {

bool has_two_segments(NotchContour contour) {
  return contour == NotchContour::corner_filleted || contour == NotchContour::v_shaped;
}

/// Slope angle of the flanks of a V whose ground is an arc: the line from (half_length, depth) that
/// touches the arc, (b − r) cos β − a sin β + r = 0.
template <class S>
S flank_angle(const NotchShapeT<S>& notch) {
  using std::asin, std::atan2, std::sqrt;
  const S above = notch.depth - notch.fillet;
  return atan2(above, notch.half_length) +
         asin(notch.fillet / sqrt(above * above + notch.half_length * notch.half_length));
}

/// A place of an arc that begins along x.
template <class S>
NotchPlaceT<S> arc_place(const S& radius, const S& angle) {
  using std::cos, std::sin;
  return {radius * sin(angle), radius * (1.0 - cos(angle))};
}

/// Boundaries of elements on a curved segment, 0 … 1: of 0.45 of the local thickness and 10° at
/// most where a quarter of the thinnest thickness is an element's `share`.
std::vector<double> contour_lines(const NotchShapeT<double>& notch, int segment, double share) {
  constexpr int samples = 2000;
  const double length = 1.8 * share, turn = 0.72 * share;
  std::vector<double> counted(samples + 1, 0.0);  // elements from the segment's start
  NotchPlaceT<double> last = notch_place(notch, segment, 0);
  double last_angle = 0;
  for (int i = 1; i <= samples; ++i) {
    const NotchPlaceT<double> next = notch_place(notch, segment, double(i) / samples);
    const double dx = next.x - last.x, dy = next.rise - last.rise, angle = std::atan2(dy, dx);
    const double size = length * (notch.thickness + last.rise + next.rise);
    counted[i] = counted[i - 1] +
                 std::max(std::hypot(dx, dy) / size, (i > 1 ? angle - last_angle : 0.0) / turn);
    last = next;
    last_angle = angle;
  }
  const int count = std::max(2, static_cast<int>(std::lround(counted.back())));
  std::vector<double> lines(count + 1, 0.0);
  for (int n = 1, i = 0; n < count; ++n) {
    const double wanted = counted.back() * n / count;
    while (counted[i + 1] < wanted) ++i;
    lines[n] = (i + (wanted - counted[i]) / (counted[i + 1] - counted[i])) / samples;
  }
  lines[count] = 1;
  return lines;
}

/// The place between two whose x is the mean of theirs: elements with their middles there are not
/// squeezed, even where the contour stands across.
double middle(const NotchShapeT<double>& notch, int segment, double low, double high) {
  const double x = (notch_place(notch, segment, low).x + notch_place(notch, segment, high).x) / 2;
  for (int halving = 0; halving < 60; ++halving) {
    const double at = (low + high) / 2;
    (notch_place(notch, segment, at).x < x ? low : high) = at;
  }
  return (low + high) / 2;
}

}  // namespace

template <class S>
NotchPlaceT<S> notch_place(const NotchShapeT<S>& notch, int segment, double at) {
  using std::atan2;
  const S &a = notch.half_length, &b = notch.depth, &r = notch.fillet;
  constexpr double right_angle = M_PI / 2;
  switch (notch.contour) {
    case NotchContour::circular:
      return arc_place(S((a * a + b * b) / (2.0 * b)), S(2.0 * at * atan2(b, a)));
    case NotchContour::elliptic:
      return {a * std::sin(at * right_angle), b * (1 - std::cos(at * right_angle))};
    case NotchContour::power:
      return {a * at, b * std::pow(at, notch.exponent)};
    case NotchContour::corner_filleted: {
      if (segment == 0) return {(a - r) * at, S(0.0)};
      NotchPlaceT<S> place = arc_place(r, S(at * right_angle));
      place.x += a - r;
      return place;
    }
    case NotchContour::v_shaped:
      break;
  }
  const S angle = flank_angle(notch);
  if (segment == 0) return arc_place(r, S(angle * at));
  const NotchPlaceT<S> start = arc_place(r, angle);
  return {start.x + (a - start.x) * at, start.rise + (b - start.rise) * at};
}
template NotchPlaceT<double> notch_place(const NotchShapeT<double>&, int, double);
template NotchPlaceT<Dual1> notch_place(const NotchShapeT<Dual1>&, int, double);

template <class S>
NotchPlaceT<S> notch_end(const NotchShapeT<S>& notch) {
  return {notch.half_length,
          notch.contour == NotchContour::corner_filleted ? notch.fillet : notch.depth};
}
template NotchPlaceT<double> notch_end(const NotchShapeT<double>&);
template NotchPlaceT<Dual1> notch_end(const NotchShapeT<Dual1>&);

Check check_notch(const NotchShapeT<double>& notch) {
  const double a = notch.half_length, b = notch.depth, r = notch.fillet;
  if (!(std::min({a, b, notch.thickness, notch.width}) > 0 && notch.end_length >= 0 && r >= 0))
    return Because("half length, depth, thickness and width of a notch must be positive");
  if (notch.contour == NotchContour::circular && b > a * (1 + 1e-9))
    return Because(
        fmt::format("a circular notch of half length {:g} m is at most as deep, not {:g} m", a, b));
  if (notch.contour == NotchContour::power && !(notch.exponent > 1))
    return Because(
        fmt::format("the exponent of a notch is {:g} and must be above 1", notch.exponent));
  if (notch.contour == NotchContour::corner_filleted && r > std::min(a, b) * (1 + 1e-9))
    return Because(fmt::format("the fillet of {:g} m is larger than half length or depth", r));
  if (notch.contour == NotchContour::v_shaped &&
      !(r > 0 && std::hypot(b - r, a) > r && r * std::sin(flank_angle(notch)) < a &&
        flank_angle(notch) < M_PI / 2))
    return Because(fmt::format("no flank from the edge of the V touches its fillet of {:g} m", r));
  if (notch.two_axes && notch.width <= 2 * b)
    return Because(fmt::format("the width of {:g} m is not above two depths", notch.width));
  return {};
}

std::vector<MeshLine> notch_lines(const NotchShapeT<double>& notch, double share, double growth) {
  const auto on_side = [](int side, int segment, double at) {
    return MeshLine{0, 0, at, side, segment};
  };
  std::vector<MeshLine> half;  // from the thinnest section to the end
  double start = 0;
  for (int segment = 0; segment <= int(has_two_segments(notch.contour)); ++segment) {
    const double end = notch_place(notch, segment, 1).x, length = end - start;
    if (length <= 1e-9 * notch.half_length) continue;
    std::vector<double> lines;
    if (notch.contour == NotchContour::corner_filleted && segment == 0) {
      const double size = 1.8 * share * notch.thickness;
      lines = graded_lines(length, length, size, std::max(size, notch.half_length / 4), growth);
      for (double& at : lines) at /= length;
    } else {
      lines = contour_lines(notch, segment, share);
    }
    for (std::size_t k = 0; k + 1 < lines.size(); ++k) {
      half.push_back(on_side(1, segment, lines[k]));
      half.push_back(on_side(1, segment, middle(notch, segment, lines[k], lines[k + 1])));
    }
    start = end;
  }
  std::vector<MeshLine> all;
  for (std::size_t k = half.size(); k-- > 1;)
    all.push_back(on_side(-1, half[k].segment, half[k].at));
  all.insert(all.end(), half.begin(), half.end());
  return all;
}

}  // namespace flexopt
