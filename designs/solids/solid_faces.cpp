#include "designs/solids/solid_faces.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/math/dual.hpp"

namespace flexopt {
namespace {

/// A vector along an axis.
template <class S>
Vector3<S> along_axis(int axis, const S& length) {
  Vector3<S> v = Vector3<S>::Zero();
  v[axis] = length;
  return v;
}

/// The two faces of a cuboid about the origin across an axis.
template <class S>
void add_pair(const std::array<S, 3>& lengths, int axis, std::vector<FlatFaceT<S>>& faces) {
  const auto half = [&](int k) {
    return along_axis<S>(k % 3, lengths[static_cast<std::size_t>(k % 3)] * 0.5);
  };
  for (const double side : {1.0, -1.0})
    faces.push_back({Vector3<S>(half(axis) * S(side)), along_axis<S>(axis, S(side)), half(axis + 1),
                     half(axis + 2)});
}

template <class S>
std::vector<FlatFaceT<S>> faces_of(const BoxShapeT<S>& box) {
  std::vector<FlatFaceT<S>> faces;
  for (int axis = 0; axis < 3; ++axis) add_pair(box.lengths, axis, faces);
  return faces;
}

template <class S>
std::vector<FlatFaceT<S>> faces_of(const NotchShapeT<S>& notch) {
  std::vector<FlatFaceT<S>> faces;
  add_pair<S>({(notch.half_length + notch.end_length) * 2.0, notch.thickness + notch.depth * 2.0,
               notch.width},
              0, faces);
  return faces;
}

/// Twice the area that it goes round counter-clockwise; arcs count by the place they go through.
template <class S>
double turning(const ContourT<S>& contour) {
  double area = 0;
  std::array<S, 2> last = contour.back().at;
  const auto go = [&](const std::array<S, 2>& to) {
    area += value_of(last[0]) * value_of(to[1]) - value_of(last[1]) * value_of(to[0]);
    last = to;
  };
  for (const ContourCornerT<S>& corner : contour) {
    if (corner.through) go(*corner.through);
    go(corner.at);
  }
  return area;
}

/// `out`: 1 of the outline, −1 of a window.
template <class S>
void add_walls(const ContourT<S>& contour, const S& thickness, double out,
               std::vector<FlatFaceT<S>>& faces) {
  const double side = turning(contour) > 0 ? out : -out;
  for (std::size_t i = 0; i < contour.size(); ++i) {
    const ContourCornerT<S>&from = contour[(i + contour.size() - 1) % contour.size()],
          &to = contour[i];
    if (to.through) continue;
    const Vector3<S> way(to.at[0] - from.at[0], to.at[1] - from.at[1], S(0));
    const S length = way.norm();
    if (!(value_of(length) > 0)) continue;
    faces.push_back({Vector3<S>((from.at[0] + to.at[0]) * 0.5, (from.at[1] + to.at[1]) * 0.5, S(0)),
                     Vector3<S>(way[1] / length * side, -way[0] / length * side, S(0)),
                     Vector3<S>(way * S(0.5)), along_axis<S>(2, thickness * 0.5),
                     value_of(from.fillet) == 0 && value_of(to.fillet) == 0});
  }
}

template <class S>
std::vector<FlatFaceT<S>> faces_of(const PlateShapeT<S>& plate) {
  std::vector<FlatFaceT<S>> faces;
  std::array<S, 2> low = plate.outline.front().at, high = low;
  const auto reach = [&](const std::array<S, 2>& at) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (value_of(at[k]) < value_of(low[k])) low[k] = at[k];
      if (value_of(at[k]) > value_of(high[k])) high[k] = at[k];
    }
  };
  for (const ContourCornerT<S>& corner : plate.outline) {
    reach(corner.at);
    if (corner.through) reach(*corner.through);
  }
  const Vector3<S> middle((low[0] + high[0]) * 0.5, (low[1] + high[1]) * 0.5, S(0));
  add_pair<S>({high[0] - low[0], high[1] - low[1], plate.thickness}, 2, faces);
  for (FlatFaceT<S>& face : faces) {
    face.center += middle;
    face.whole = plate.outline.size() == 4 && plate.windows.empty() && plate.holes.empty() &&
                 std::abs(std::abs(turning(plate.outline)) -
                          8 * value_of(face.half_u.norm()) * value_of(face.half_v.norm())) <
                     1e-9 * std::abs(turning(plate.outline)) &&
                 std::ranges::all_of(plate.outline, [](const ContourCornerT<S>& corner) {
                   return !corner.through && value_of(corner.fillet) == 0;
                 });
  }
  add_walls(plate.outline, plate.thickness, 1, faces);
  for (const ContourT<S>& window : plate.windows) add_walls(window, plate.thickness, -1, faces);
  return faces;
}

}  // namespace

template <class S>
bool FlatFaceT<S>::holds(const Vector3<S>& place, double within) const {
  const auto inside = [&](const Vector3<S>& half) {
    const double length = value_of(S(half.norm()));
    return std::abs(value_of(S((place - center).dot(half)))) / length <= length + within;
  };
  return inside(half_u) && inside(half_v);
}

template <class S>
std::vector<FlatFaceT<S>> flat_faces(const SolidShapeT<S>& shape) {
  return std::visit([](const auto& of) { return faces_of<S>(of); }, shape);
}

template <class S>
double extent(const std::vector<FlatFaceT<S>>& faces) {
  double longest = 0;
  for (const FlatFaceT<S>& face : faces)
    longest = 2 * std::max({longest / 2, value_of(S(face.half_u.norm())),
                            value_of(S(face.half_v.norm()))});
  return longest;
}

template struct FlatFaceT<double>;
template struct FlatFaceT<Dual1>;
template std::vector<FlatFaceT<double>> flat_faces(const SolidShapeT<double>&);
template std::vector<FlatFaceT<Dual1>> flat_faces(const SolidShapeT<Dual1>&);
template double extent(const std::vector<FlatFaceT<double>>&);
template double extent(const std::vector<FlatFaceT<Dual1>>&);

}  // namespace flexopt
