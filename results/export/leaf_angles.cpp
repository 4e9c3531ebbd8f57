#include <cmath>
#include <numbers>

#include "results/export/measures.hpp"

namespace flexopt {

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double smallest = 0.5 * degree;     ///< that anybody could see
constexpr double by_tangents = 100 * degree;  ///< an arc beyond has its tangents meet far away
constexpr double in_plane = 1e-9;

/// An angle between two directions, and how it is drawn.
struct LegAngle {
  const DrawnLeg *first = nullptr, *second = nullptr;
  double sign = 1;  ///< −1: the angle of an arc, between the directions of going on
  double value = 0;
  Vector3d vertex, from, to;  ///< `from`: the direction that the dimension begins at
  std::vector<Vector3d> guide;
};

double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Derivative of the angle between two legs [rad per unit of the parameter]. The tangents are unit
/// vectors, so they change at right angles to themselves.
double rate_of(const LegAngle& angle, std::size_t parameter) {
  const Vector3d a = angle.first->along, b = angle.sign * angle.second->along,
                 da = angle.first->rates[parameter],
                 db = angle.sign * angle.second->rates[parameter];
  const double cosine_rate = da.dot(b) + a.dot(db);
  return -cosine_rate / std::sin(angle.value);  // d cos v = −sin v dv
}

/// Angle of an arc between its end tangents, drawn where they meet or at the centre of the circle.
LegAngle of_arc(const DrawnLeg& base, const DrawnLeg& tip) {
  LegAngle arc{.first = &base, .second = &tip, .sign = -1};
  const Vector3d chord = tip.at - base.at, onwards = -tip.along;
  arc.value = angle_between(base.along, onwards);
  if (arc.value < by_tangents) {
    const double way = 0.5 * chord.norm() / std::cos(0.5 * arc.value);
    arc.vertex = base.at + way * base.along;
    arc.from = base.along;
  } else {
    const double radius = 0.5 * chord.norm() / std::sin(0.5 * arc.value);
    const Vector3d inwards = (chord - base.along * base.along.dot(chord)).normalized();
    arc.vertex = base.at + radius * inwards;
    arc.from = -inwards;
  }
  arc.to = tip.at;
  arc.guide = {base.at, arc.vertex, tip.at};
  return arc;
}

std::vector<LegAngle> angles_of(const PlacedDesign& design) {
  std::vector<LegAngle> angles;
  const auto& legs = design.legs;
  for (std::size_t i = 0; i < legs.size(); ++i)
    for (std::size_t j = i + 1; j < legs.size(); ++j) {
      const DrawnLeg &a = legs[i], &b = legs[j];
      const LeafSpring& leaf = design.mechanism.leaves[static_cast<std::size_t>(a.leaf)];
      if (a.leaf == b.leaf && leaf.curve) {
        angles.push_back(of_arc(a, b));
      } else if ((a.at - b.at).norm() < in_plane * design.size) {
        const double reach =
            b.leaf == a.leaf ? leaf.length * (1 - leaf.fold->place)
                             : design.mechanism.leaves[static_cast<std::size_t>(b.leaf)].chord();
        angles.push_back({.first = &a,
                          .second = &b,
                          .sign = 1,
                          .value = angle_between(a.along, b.along),
                          .vertex = a.at,
                          .from = a.along,
                          .to = a.at + reach * b.along,
                          .guide = {}});
      }
    }
  std::erase_if(angles, [](const LegAngle& a) {
    return a.value < smallest || a.value > std::numbers::pi - smallest;
  });
  return angles;
}

bool shows(const DrawnView& view, const LegAngle& angle, double size) {
  return view.shows_leaf(static_cast<std::size_t>(angle.first->leaf)) &&
         view.shows_leaf(static_cast<std::size_t>(angle.second->leaf)) &&
         std::abs(view.toward().dot(angle.from)) < in_plane &&
         std::abs(view.toward().dot(angle.to - angle.vertex)) < in_plane * size;
}

/// View along the width of the leaves that enclose the angle.
DrawnView own_view(const Mechanism& mechanism, const LegAngle& angle) {
  const int a = angle.first->leaf, b = angle.second->leaf;
  const auto name = [&](int leaf) { return mechanism.leaves[static_cast<std::size_t>(leaf)].name; };
  const Vector3d right = -angle.first->along, way = angle.second->along;
  const Vector3d up = (way - right * right.dot(way)).normalized();
  if (a == b) return {name(a) + ", on edge", right, up, {a}};
  return {name(a) + " and " + name(b) + ", on edge", right, up, {a, b}};
}

}  // namespace

bool measure_between_legs(const PlacedDesign& design, std::size_t parameter, MeasuredDesign& all) {
  std::vector<LegAngle> found;
  for (LegAngle& angle : angles_of(design))
    if (design.parameter_of(angle.value, "rad", [&](std::size_t k) { return rate_of(angle, k); }) ==
        parameter)
      found.push_back(std::move(angle));
  const auto add = [&](const LegAngle& angle, MeasuredView& to) {
    const Eigen::Vector2d axis = to.view(angle.from).normalized();
    to.measures.push_back(
        {parameter, ShownMeasure::Along::angle, angle.vertex, angle.to, axis, angle.guide});
    return true;
  };
  for (MeasuredView& one : all.views)
    for (const LegAngle& angle : found)
      if (shows(one.view, angle, design.size)) return add(angle, one);
  if (found.empty()) return false;
  all.views.push_back({own_view(design.mechanism, found.front()), {}});
  return add(found.front(), all.views.back());
}

}  // namespace flexopt
