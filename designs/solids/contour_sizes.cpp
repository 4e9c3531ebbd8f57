#include "designs/solids/contour_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace flexopt {

namespace {

/// Length of a ray to the first chord that faces it, of a curve that is no neighbour of its own.
double wall_along(const Point2<double>& from, const Point2<double>& way,
                  const std::vector<Chord>& chords, const std::array<int, 3>& neighbours,
                  const CurveT<double>& own) {
  double wall = std::numeric_limits<double>::infinity();
  for (const auto& [p, q, curve] : chords) {
    const bool is_own = curve == neighbours[1];
    if (curve == neighbours[0] || curve == neighbours[2] || (is_own && !own.is_arc)) continue;
    const Point2<double> d = q - p, r = p - from;
    const double det = way[0] * d[1] - way[1] * d[0];
    if (std::abs(det) < 0.5 * d.norm()) continue;
    const double along = (r[0] * d[1] - r[1] * d[0]) / det;
    const double share = (r[0] * way[1] - r[1] * way[0]) / det;
    if (share >= 0 && share <= 1 && along > (is_own ? own.radius : 0)) wall = std::min(wall, along);
  }
  return wall;
}

}  // namespace

void PlaneSizes::follow(const ContoursT<double>& contours, const std::vector<Chord>& lines) {
  std::vector<Chord> chords = chords_of(contours);
  for (int k = 0; k < contours.contours(); ++k) {
    double area = 0;  // of the chords, to the left
    for (const auto& [p, q, curve] : chords)
      if (curve >= contours.first[k] && curve < contours.first[k + 1])
        area += p[0] * q[1] - p[1] * q[0];
    const double inwards = (area > 0) == (k == 0) ? 1 : -1;  // left or right
    int before = contours.first[k + 1] - 1;
    for (int c = contours.first[k]; c < contours.first[k + 1]; before = c++) {
      const auto& curve = contours.curves[c];
      const double arc = 2 * std::sin(std::numbers::pi / 16) * curve.radius;
      constexpr int samples = 24;
      for (int s = 0; s < samples; ++s) {
        const double u = (s + 0.5) / samples;
        const Point2<double> place = curve.at(u), t = curve.tangent(u);
        const Point2<double> way(-inwards * t[1], inwards * t[0]);
        const double wall =
            wall_along(place, way, chords, {before, c, contours.after(k, c)}, curve);
        const double size = curve.is_arc ? std::min(arc, wall / 3) : wall / 3;
        if (size >= largest_) continue;
        add({place, size});
        if (wall / 3 < largest_) add({place + wall * way, wall / 3});
      }
    }
  }
  chords.insert(chords.end(), lines.begin(), lines.end());
  for (const auto& [p, q, own] : lines)
    for (int s = 0; s < 12; ++s)
      for (const double side : {-1.0, 1.0}) {
        const Point2<double> t = (q - p).normalized(), way(-side * t[1], side * t[0]);
        const Point2<double> place = p + (s + 0.5) / 12 * (q - p);
        const double gap = wall_along(place, way, chords, {own, own, own}, {});
        if (gap >= largest_) continue;
        add({place, gap});
        add({place + gap * way, gap});
      }
}

void PlaneSizes::finish(double coarsening) {
  coarsening_ = coarsening;
  largest_ *= coarsening;
  for (Source& source : sources_) source.size *= coarsening;
  std::stable_sort(sources_.begin(), sources_.end(),
                   [](const Source& a, const Source& b) { return a.size < b.size; });
  std::vector<Source> all;
  all.swap(sources_);
  for (const Source& source : all)
    if (at(source.place) > 1.02 * source.size) sources_.push_back(source);
}

double PlaneSizes::at(const Point2<double>& place) const {
  double size = largest_;
  for (const Source& source : sources_)
    size = std::min(size, source.size + slope_ * (place - source.place).norm());
  return size;
}

std::vector<double> PlaneSizes::divided(const CurveT<double>& curve) const {
  const double length = curve.length();
  constexpr int steps = 400;
  std::vector<double> count(steps + 1, 0.0);  // elements up to a step
  for (int s = 0; s < steps; ++s)
    count[s + 1] = count[s] + length / steps / at(curve.at((s + 0.5) / steps));
  const double fewest =
      curve.is_arc ? std::abs(curve.sweep) * 8 / std::numbers::pi / coarsening_ - 1e-6 : 1;
  const int n = std::max(1, static_cast<int>(std::ceil(std::max(fewest, count[steps] - 0.3))));
  std::vector<double> ends(n + 1, 0.0);
  for (int i = 1, s = 0; i < n; ++i) {
    const double wanted = count[steps] * i / n;
    while (count[s + 1] < wanted) ++s;
    ends[i] = (s + (wanted - count[s]) / (count[s + 1] - count[s])) / steps;
  }
  ends[n] = 1;
  return ends;
}

}  // namespace flexopt
