#pragma once
// The stations that a leaf or wire is interpolated between, and its section there: what the places
// of solids and their rates share. Equation (S19) of core/response/README.md.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/profile.hpp"
#include "core/response/solids.hpp"

namespace flexopt {

inline constexpr int along_intervals = 20, across_intervals = 4;
inline constexpr int stations_along = along_intervals + 1, stations_across = across_intervals + 1;
inline constexpr int sample_step = 2;  // of the stations that inner_samples() takes
inline constexpr int surface_size = stations_along * stations_across;  // of one surface of a leaf

// Interpolation between equal intervals: a cubic in each, with the slopes that a parabola through
// three neighbours has. Values and derivatives of the weights of up to four stations.
struct Cubic {
  int first = 0, count = 0;
  std::array<double, 4> value{}, slope{}, curvature{};
};

inline Cubic cubic(int intervals, double s) {
  const double place = s * intervals;
  const int i = std::clamp(static_cast<int>(std::floor(place)), 0, intervals - 1);
  const double t = place - i;
  Cubic c;
  c.first = std::max(0, i - 1);
  c.count = std::min(intervals, i + 2) - c.first + 1;
  const auto add = [&](int station, double by, const std::array<double, 3>& f) {
    const auto k = static_cast<std::size_t>(station - c.first);
    c.value[k] += by * f[0];
    c.slope[k] += by * f[1] * intervals;
    c.curvature[k] += by * f[2] * intervals * intervals;
  };
  const auto add_slope = [&](int station, const std::array<double, 3>& f) {
    if (station == 0) {
      add(0, -1.5, f), add(1, 2, f), add(2, -0.5, f);
    } else if (station == intervals) {
      add(station, 1.5, f), add(station - 1, -2, f), add(station - 2, 0.5, f);
    } else {
      add(station + 1, 0.5, f), add(station - 1, -0.5, f);
    }
  };
  add(i, 1, {1 + t * t * (2 * t - 3), 6 * t * (t - 1), 12 * t - 6});
  add(i + 1, 1, {t * t * (3 - 2 * t), 6 * t * (1 - t), 6 - 12 * t});
  add_slope(i, {t * (1 - t) * (1 - t), (1 - t) * (1 - 3 * t), 6 * t - 4});
  add_slope(i + 1, {t * t * (t - 1), t * (3 * t - 2), 6 * t - 2});
  return c;
}

// The slope at a station as the interpolation has it, from values at stations; a zero of its kind
// comes first.
template <class Value, class At>
Value station_slope(int intervals, int station, Value sum, const At& at) {
  const Cubic c = cubic(intervals, static_cast<double>(station) / intervals);
  for (int k = 0; k < c.count; ++k)
    if (c.slope[k] != 0) sum += at(c.first + k) * c.slope[k];
  return sum;
}

inline double along_of(int i) { return static_cast<double>(i) / along_intervals; }
inline double across_of(int j) { return static_cast<double>(j) / across_intervals; }
inline int mid_index(int i, int j) { return i * stations_across + j; }

inline double half_of(const LeafSpring& leaf, double along) {
  return 0.5 * leaf.thickness * profile_at(leaf.thickness_profile, along);
}

// The two unit vectors across a wire whose centre line runs along t.
struct WireAxes {
  Vector3d n, b;
};
inline WireAxes wire_section(const Vector3d& t, const Vector3d& reference) {
  const Vector3d e = t.normalized(), n = (reference - e * e.dot(reference)).normalized();
  return {n, e.cross(n)};
}

// Coordinate along the leaf of a point of one of its solids.
inline double along_leaf(const SolidPart& part, double along) {
  return part.begin + (part.end - part.begin) * along;
}

}  // namespace flexopt
