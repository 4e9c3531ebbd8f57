#include "designs/solids/contour_curves.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace flexopt {

namespace {

constexpr double full_turn = 2 * std::numbers::pi;

template <class S>
S length_of(const Point2<S>& a) {
  using std::sqrt;
  return sqrt(a[0] * a[0] + a[1] * a[1]);
}
template <class S>
S cross_of(const Point2<S>& a, const Point2<S>& b) {
  return a[0] * b[1] - a[1] * b[0];
}
template <class S>
S angle_of(const Point2<S>& a) {
  using std::atan2;
  return atan2(a[1], a[0]);
}
template <class S>
Point2<S> point_of(const std::array<S, 2>& a) {
  return {a[0], a[1]};
}

/// The way from one angle to another, 0 … 2π to the left or 0 … −2π.
template <class S>
S turned(const S& from, const S& to, bool to_the_left) {
  S turn = to - from;
  while (value_of(turn) < 0) turn += full_turn;
  while (value_of(turn) >= full_turn) turn -= full_turn;
  if (!to_the_left && value_of(turn) > 0) turn -= full_turn;
  return turn;
}

template <class S>
CurveT<S> arc_between(const Point2<S>& from, const Point2<S>& to, const Point2<S>& center,
                      const S& radius, bool to_the_left) {
  CurveT<S> arc{from, to, true, center, radius};
  arc.start = angle_of<S>(from - center);
  arc.sweep = turned<S>(arc.start, angle_of<S>(to - center), to_the_left);
  return arc;
}

template <class S>
CurveT<S> arc_through(const Point2<S>& from, const Point2<S>& through, const Point2<S>& to) {
  // The centre c from `from`: 2 c·a = a·a, 2 c·b = b·b.
  const Point2<S> a = through - from, b = to - from;
  const S aa = a[0] * a[0] + a[1] * a[1], bb = b[0] * b[0] + b[1] * b[1], area = cross_of(a, b);
  const S factor = S(0.5) / area;
  const Point2<S> c((aa * b[1] - bb * a[1]) * factor, (bb * a[0] - aa * b[0]) * factor);
  return arc_between<S>(from, to, from + c, length_of(c), value_of(area) > 0);
}

/// Distance of a place to the left of the line or circle of a curve, and its gradient.
template <class S>
std::pair<S, Point2<S>> left_of(const CurveT<S>& curve, const Point2<S>& x) {
  if (curve.is_arc) {
    const Point2<S> d = x - curve.center;
    const S r = length_of(d), side = S(value_of(curve.sweep) > 0 ? -1.0 : 1.0);
    return {side * (r - curve.radius), Point2<S>(d[0] * side / r, d[1] * side / r)};
  }
  const Point2<S> t = curve.tangent(0), normal(-t[1], t[0]), d = x - curve.from;
  return {normal[0] * d[0] + normal[1] * d[1], normal};
}

/// Cuts off what lies before the point, or behind it.
template <class S>
void shorten(CurveT<S>& curve, const Point2<S>& point, bool at_end) {
  double left;
  if (curve.is_arc) {
    const double before = value_of(curve.sweep);
    const S angle = angle_of<S>(point - curve.center);
    const S cut = at_end ? turned<S>(angle, curve.start + curve.sweep, before > 0)
                         : turned<S>(curve.start, angle, before > 0);
    curve.sweep -= cut;
    if (!at_end) curve.start += cut;
    left = value_of(curve.sweep) / before;
  } else {
    const Point2<S> d = curve.to - curve.from,
                    rest = at_end ? point - curve.from : curve.to - point;
    left = value_of(d[0] * rest[0] + d[1] * rest[1]) / value_of(d[0] * d[0] + d[1] * d[1]);
  }
  (at_end ? curve.to : curve.from) = point;
  curve.left = left > 0 ? std::min(left, curve.left) : 0;
}

/// The rounding of the corner between two curves, which it shortens: its centre has the distance
/// `radius` to both, on the side that the corner turns to.
template <class S>
CurveT<S> round_corner(CurveT<S>& before, CurveT<S>& after, const S& radius) {
  const Point2<S> corner = after.from, s = before.tangent(1), t = after.tangent(0);
  const bool to_the_left = value_of(cross_of(s, t)) > 0;
  const S distance = to_the_left ? radius : -radius;
  const S shift = distance / (S(1.0) + s[0] * t[0] + s[1] * t[1]);
  Point2<S> center(corner[0] - (s[1] + t[1]) * shift, corner[1] + (s[0] + t[0]) * shift);
  double miss = 1;
  // Newton: exact at once between two lines. One step more makes the derivatives exact.
  for (int step = 0; step < 30; ++step) {
    const auto [d1, n1] = left_of(before, center);
    const auto [d2, n2] = left_of(after, center);
    const S r1 = distance - d1, r2 = distance - d2, det = cross_of(n1, n2);
    miss = std::max(std::abs(value_of(r1)), std::abs(value_of(r2))) / value_of(radius);
    center[0] += (r1 * n2[1] - r2 * n1[1]) / det;
    center[1] += (r2 * n1[0] - r1 * n2[0]) / det;
    if (miss < 1e-13 && step > 1) break;
  }
  const auto foot = [&](const CurveT<S>& curve) {
    const auto [d, n] = left_of(curve, center);
    return Point2<S>(center[0] - d * n[0], center[1] - d * n[1]);
  };
  const Point2<S> from = foot(before), to = foot(after);
  shorten(before, from, true);
  shorten(after, to, false);
  if (!(miss < 1e-9)) after.left = 0;
  return arc_between<S>(from, to, center, radius, to_the_left);
}

template <class S>
void add_contour(const ContourT<S>& contour, ContoursT<S>& all) {
  const std::size_t n = contour.size();
  std::vector<CurveT<S>> sides(n);
  for (std::size_t c = 0; c < n; ++c) {
    const auto& next = contour[(c + 1) % n];
    const Point2<S> from = point_of(contour[c].at), to = point_of(next.at);
    sides[c] =
        next.through ? arc_through<S>(from, point_of(*next.through), to) : CurveT<S>{from, to};
  }
  std::vector<CurveT<S>> roundings(n);
  for (std::size_t c = 0; c < n; ++c)
    if (value_of(contour[c].fillet) > 0)
      roundings[c] = round_corner(sides[(c + n - 1) % n], sides[c], contour[c].fillet);
  for (std::size_t c = 0; c < n; ++c) {
    if (value_of(contour[c].fillet) > 0) all.curves.push_back(roundings[c]);
    all.curves.push_back(sides[c]);
  }
}

std::string name_of(int contour, std::size_t windows) {
  const int w = contour - 1, h = w - static_cast<int>(windows);
  return w < 0 ? "outline" : h < 0 ? fmt::format("windows[{}]", w) : fmt::format("holes[{}]", h);
}

std::string in_mm(const Point2<double>& place) {
  return fmt::format("({:.6g}, {:.6g})", 1e3 * place[0], 1e3 * place[1]);
}
std::string near(const Point2<double>& place) { return "near " + in_mm(place) + " mm"; }
std::string name_of(const CurveT<double>& curve) {
  return fmt::format("the {} from {} to {} mm", curve.is_arc ? "arc" : "line", in_mm(curve.from),
                     in_mm(curve.to));
}

/// Which side of a → b the place is on: > 0 to the left.
double side_of(const Point2<double>& a, const Point2<double>& b, const Point2<double>& place) {
  return cross_of<double>(b - a, place - a);
}

Check check_curves(const ContoursT<double>& contours, std::size_t windows) {
  for (int k = 0; k < contours.contours(); ++k) {
    const std::string name = name_of(k, windows);
    if (k <= static_cast<int>(windows) && contours.first[k + 1] - contours.first[k] < 2)
      return Because(fmt::format("{} has fewer than two corners", name));
    for (int c = contours.first[k]; c < contours.first[k + 1]; ++c) {
      const auto& curve = contours.curves[c];
      if (!(curve.left > 1e-6) && std::isfinite(curve.radius))
        return Because(fmt::format("{}: a fillet {} does not fit", name, near(curve.from)));
      if (!std::isfinite(curve.radius) || !(curve.length() > 0) ||
          curve.radius > 1e5 * curve.length())
        return Because(
            fmt::format("{}: two corners {} are the same point, or an arc goes through "
                        "three points of a line",
                        name, near(curve.from)));
    }
    for (int c = contours.first[k]; c < contours.first[k + 1]; ++c) {
      const auto& next = contours.curves[contours.after(k, c)];
      if (contours.curves[c].tangent(1).dot(next.tangent(0)) < -std::cos(std::numbers::pi / 18))
        return Because(
            fmt::format("{}: the corner {} is sharper than 10 degrees", name, near(next.from)));
    }
  }
  return {};
}

}  // namespace

template <class S>
Point2<S> CurveT<S>::at(double u) const {
  using std::cos, std::sin;
  if (!is_arc) return {from[0] * (1 - u) + to[0] * u, from[1] * (1 - u) + to[1] * u};
  const S angle = start + sweep * u;
  return {center[0] + radius * cos(angle), center[1] + radius * sin(angle)};
}

template <class S>
Point2<S> CurveT<S>::tangent(double u) const {
  using std::cos, std::sin;
  if (is_arc) {
    const S angle = start + sweep * u, sign = S(value_of(sweep) > 0 ? 1.0 : -1.0);
    return {-sign * sin(angle), sign * cos(angle)};
  }
  const Point2<S> d = to - from;
  const S l = length_of(d);
  return {d[0] / l, d[1] / l};
}

template <class S>
double CurveT<S>::length() const {
  return is_arc ? value_of(radius) * std::abs(value_of(sweep)) : value_of(length_of<S>(to - from));
}

template <class S>
ContoursT<S> contours_of(const PlateShapeT<S>& plate) {
  ContoursT<S> all;
  all.first.push_back(0);
  const auto close = [&] { all.first.push_back(static_cast<int>(all.curves.size())); };
  add_contour(plate.outline, all);
  close();
  for (const auto& window : plate.windows) {
    add_contour(window, all);
    close();
  }
  for (const auto& hole : plate.holes) {
    const Point2<S> center = point_of(hole.center), from(center[0] + hole.radius, center[1]);
    CurveT<S> circle{from, from, true, center, hole.radius};
    circle.sweep = S(full_turn);
    all.curves.push_back(circle);
    close();
  }
  return all;
}

std::vector<Chord> chords_of(const ContoursT<double>& contours) {
  std::vector<Chord> chords;
  for (std::size_t c = 0; c < contours.curves.size(); ++c) {
    const auto& curve = contours.curves[c];
    const int n = curve.is_arc ? static_cast<int>(std::ceil(std::abs(curve.sweep) / 0.06)) : 1;
    Point2<double> from = curve.from;
    for (int i = 1; i <= n; ++i) {
      const Point2<double> to = i < n ? curve.at(double(i) / n) : curve.to;
      chords.push_back({from, to, static_cast<int>(c)});
      from = to;
    }
  }
  return chords;
}

bool touch(const Chord& a, const Chord& b) {
  for (int d = 0; d < 2; ++d)
    if (std::max(a.from[d], a.to[d]) < std::min(b.from[d], b.to[d]) ||
        std::max(b.from[d], b.to[d]) < std::min(a.from[d], a.to[d]))
      return false;
  const auto apart = [](const Chord& line, const Chord& of) {
    const double s = side_of(line.from, line.to, of.from), t = side_of(line.from, line.to, of.to);
    return (s > 0 && t > 0) || (s < 0 && t < 0);
  };
  return !apart(a, b) && !apart(b, a);
}

bool is_inside(const std::vector<Chord>& chords, const Point2<double>& place) {
  bool inside = false;
  for (const auto& [from, to, curve] : chords)
    if ((from[1] > place[1]) != (to[1] > place[1]) &&
        (side_of(from, to, place) > 0) == (to[1] > from[1]))
      inside = !inside;
  return inside;
}

Check check_contours(const ContoursT<double>& contours, std::size_t windows) {
  if (const Check check = check_curves(contours, windows); !check) return check;
  const std::vector<Chord> chords = chords_of(contours);
  const auto contour_of = [&](int curve) {
    const auto next = std::upper_bound(contours.first.begin(), contours.first.end(), curve);
    return static_cast<int>(next - contours.first.begin()) - 1;
  };
  for (std::size_t i = 0; i < chords.size(); ++i)
    for (std::size_t j = i + 1; j < chords.size(); ++j) {
      const auto &a = chords[i], &b = chords[j];
      // the end of one is the beginning of the other
      if (a.to == b.from || b.to == a.from || !touch(a, b)) continue;
      return Because(
          fmt::format("{} and {} cross or touch: {} and {}", name_of(contour_of(a.curve), windows),
                      name_of(contour_of(b.curve), windows), name_of(contours.curves[a.curve]),
                      name_of(contours.curves[b.curve])));
    }
  for (int k = 0; k < contours.contours(); ++k) {
    std::vector<Chord> others;
    for (const Chord& chord : chords)
      if (contour_of(chord.curve) != k) others.push_back(chord);
    // The outline is in nothing, all others in the outline alone.
    if (is_inside(others, contours.curves[contours.first[k]].from) == (k > 0)) continue;
    return Because(
        k ? fmt::format("{} lies outside the outline or inside another", name_of(k, windows))
          : std::string("the outline lies inside a window or a hole"));
  }
  return {};
}

template struct CurveT<double>;
template struct CurveT<Dual1>;
template ContoursT<double> contours_of(const PlateShapeT<double>&);
template ContoursT<Dual1> contours_of(const PlateShapeT<Dual1>&);

}  // namespace flexopt
