#include "results/export/view_picture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mechanism/profile.hpp"

namespace flexopt {

namespace {

/// Axes of the view in its lower left corner.
void add_axes(const Projection& on, Picture& picture) {
  const Box2 box = picture.extent();
  Picture axes;
  const char* names[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    const Point2 way = 26 / on.scale * on(Vector3d::Unit(k));
    if (way.norm() < 4) continue;
    axes.line("axis", {{0, 0}, way});
    const Point2 along = way.normalized(), side(-along[1], along[0]);
    axes.area("axishead", {way, way - 6 * along + 2 * side, way - 6 * along - 2 * side});
    axes.labels.push_back(label_around(names[k], way + 9 * along));
  }
  const Box2 own = axes.extent();
  axes.move(Point2(box.low[0] - own.low[0], box.high[1] + 14 - own.low[1]));
  picture.append(axes);
}

void add_caption(const std::string& words, Picture& picture) {
  const Box2 box = picture.extent();
  picture.labels.push_back(
      label_at(words, {box.low[0] + 46, box.high[1] - size_of_text(words, 11)[1]}, 11, "quiet"));
}

/// Adds arrows, straight or round, at the reference points of what is driven.
void add_drives(const PlacedDesign& design, const Projection& on, DimensionLines& lines,
                Picture& picture) {
  for (const Drive& drive : design.mechanism.drives) {
    if (drive.body < 0) continue;
    const Vector3d at = design.mechanism.bodies[static_cast<std::size_t>(drive.body)].reference;
    const Vector3d axis = drive.axes.col(index(drive.direction) % 3);
    const Point2 o = on(at);
    std::vector<Point2> path;
    if (is_rotation(drive.direction)) {
      if (std::abs(on.view.toward().dot(axis)) < 0.3) continue;
      const Vector3d u = axis.unitOrthogonal(), v = axis.cross(u);
      for (int i = 0; i <= 40; ++i) {
        const double turn = (-0.6 + 1.2 * i / 40.0) * std::numbers::pi / 2 * 1.6;
        path.push_back(o + 22 / on.scale * (on.way(std::cos(turn) * u + std::sin(turn) * v)));
      }
    } else {
      const Point2 way = on.way(axis) / on.scale;
      if (way.norm() < 0.3) continue;
      path = {o + 9 * way, o + 40 * way};
    }
    const Point2 end = path.back(), along = (end - path[path.size() - 2]).normalized(),
                 side(-along[1], along[0]);
    picture.line("drive", path);
    picture.area("drivehead",
                 {end + 7 * along, end - 3 * along + 4.5 * side, end - 3 * along - 4.5 * side});
    lines.note(drive.name.empty()
                   ? std::string(direction_names[static_cast<std::size_t>(index(drive.direction))])
                   : drive.name,
               end + 4 * along);
  }
}

void add_center(const PlacedDesign& design, const Projection& on, DimensionLines& lines,
                Picture& picture) {
  const Point2 o = on(
      design.mechanism.bodies[static_cast<std::size_t>(design.mechanism.end_effector)].reference);
  picture.circle("center", o, 3.5);
  lines.note("O", o);
}

DimensionText text_of(const PlacedDesign& design, std::size_t parameter) {
  const Parameter& p = design.parameters[parameter];
  return {p.name, p.unit, design.values[parameter]};
}

void add_guide(const ShownMeasure& measure, const Projection& on, Picture& picture) {
  std::vector<Point2> line;
  for (const Vector3d& place : measure.guide) line.push_back(on(place));
  if (!line.empty()) picture.line("extension", std::move(line));
}

/// Adds the dimensions, short ones first: they stand nearest.
void add_measures(const PlacedDesign& design, const MeasuredView& view, const Projection& on,
                  DimensionLines& lines, Picture& picture) {
  std::vector<ShownMeasure> measures = view.measures;
  const auto rank = [&](const ShownMeasure& m) {
    return m.along == ShownMeasure::Along::angle ? 1e300 : std::abs(design.values[m.parameter]);
  };
  std::ranges::stable_sort(measures, {}, rank);
  for (const ShownMeasure& m : measures) {
    const Point2 a = on(m.from), b = on(m.to);
    const DimensionText text = text_of(design, m.parameter);
    if (m.along == ShownMeasure::Along::angle) {
      add_guide(m, on, picture);
      lines.angle(text, a, {m.axis[0], -m.axis[1]}, b);
    } else if (m.along == ShownMeasure::Along::way) {
      lines.length(text, a, b, (b - a).normalized(), false);
    } else {
      const Point2 axis = Point2::Unit(m.along == ShownMeasure::Along::right ? 0 : 1);
      lines.length(text, a, b, axis, true);
    }
  }
}

/// View direction from the upper right in front, chosen so that no leaf is seen on edge.
Vector3d slant(const Mechanism& mechanism) {
  Vector3d best = Vector3d::Zero();
  double most = -1;
  for (const Vector3d& way : {Vector3d(0.5, 0.45, 0.74), Vector3d(0.65, 0.3, 0.7),
                              Vector3d(0.35, 0.6, 0.72), Vector3d(0.75, 0.45, 0.48)}) {
    double least = 0.3;  // enough
    for (const LeafSpring& leaf : mechanism.leaves)
      if (leaf.section != Section::circular)
        least = std::min(least, std::abs(leaf.axes.col(2).dot(way.normalized())));
    if (least > most + 1e-9) {
      most = least;
      best = way.normalized();
    }
  }
  return best;
}

}  // namespace

Picture view_picture(const PlacedDesign& design, const MeasuredView& view, double scale) {
  const Projection on{view.view, scale};
  Picture picture;
  add_parts(design.mechanism, on, picture);
  DimensionLines lines(picture, scale);
  if (view.view.leaves.empty()) {
    add_center(design, on, lines, picture);
    add_drives(design, on, lines, picture);
  }
  for (const ShownMeasure& m : view.measures)
    for (const Vector3d& end : {m.from, m.to})
      if (end.isZero(0) && view.view.leaves.empty()) {
        const Point2 o = on(end);
        picture.line("extension", {o - Point2(8, 0), o + Point2(8, 0)});
        picture.line("extension", {o - Point2(0, 8), o + Point2(0, 8)});
      }
  add_measures(design, view, on, lines, picture);
  if (view.view.leaves.empty()) {
    add_axes(on, picture);
    add_caption(view.view.caption, picture);
  } else {
    const Box2 box = picture.extent();
    picture.labels.push_back(
        label_at(view.view.caption, {box.low[0], box.high[1] + 10}, 11, "quiet"));
  }
  return picture;
}

Picture slanting_picture(const PlacedDesign& design, double largest) {
  const Vector3d toward = slant(design.mechanism);
  const Vector3d right = Vector3d::UnitY().cross(toward).normalized();
  const DrawnView view{"", right, toward.cross(right), {}};
  const double scale = largest / room_of(design, view).maxCoeff();
  const Projection on{view, scale};
  Picture picture;
  add_solid_parts(design.mechanism, on, picture);
  DimensionLines lines(picture, scale);
  add_center(design, on, lines, picture);
  add_drives(design, on, lines, picture);
  picture.parts.push_back({"slanting", picture.extent()});
  add_axes(on, picture);
  return picture;
}

Point2 room_of(const PlacedDesign& design, const DrawnView& view) {
  Picture picture;
  add_parts(design.mechanism, {view, 1e6}, picture);
  return picture.extent().size() / 1e6;
}

}  // namespace flexopt
