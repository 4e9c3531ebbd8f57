#include "results/export/view_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/mechanism/profile.hpp"

namespace flexopt {

namespace {

constexpr double head_length = 8, head_half = 2.4, tail = 14, lane = 19, gap = 3;  // px

/// What a dimension says: "length = 80 mm".
std::string words_of(const DrawnDimension& text) {
  return text.parameter + " = " + with_drawn_unit(text.value, text.unit);
}

DrawnDimension with_line(DrawnDimension text, std::vector<Point2> line) {
  text.line = std::move(line);
  return text;
}

/// An arrowhead with its tip there, pointing along.
void add_head(Picture& picture, const Point2& tip, const Point2& along) {
  const Point2 side(-along[1], along[0]);
  picture.area("head", {tip, tip - head_length * along + head_half * side,
                        tip - head_length * along - head_half * side});
}

/// Words that touch a point from the side of a direction, some pixels away.
DrawnLabel label_beyond(const std::string& words, const Point2& at, const Point2& direction,
                        double away) {
  const Point2 half = 0.5 * size_of_text(words, 12);
  return label_around(words, at + direction * (away + half.dot(direction.cwiseAbs())));
}

/// Keeps the candidate with the least conflict and cost of its own.
class Best {
 public:
  explicit Best(const Picture& there) : there_(&there) {}
  void offer(Picture candidate, double own_cost) {
    if (own_cost >= least_) return;
    const double cost = own_cost + conflict(candidate, *there_);
    if (cost >= least_) return;
    least_ = cost;
    picture_ = std::move(candidate);
  }
  const Picture& picture() const { return picture_; }

 private:
  const Picture* there_;
  Picture picture_;
  double least_ = std::numeric_limits<double>::infinity();
};

/// Adds dimensions, which come without their lines, and notes to a picture: each where it is least
/// in the way of what is drawn already.
class DimensionLines {
 public:
  explicit DimensionLines(Picture& picture) : picture_(&picture), outline_(picture.extent()) {}

  /// The distance of two points along a direction, a unit vector. Along an axis of the drawing
  /// (`outside`) the line stands beside all that was drawn at first. A distance too small for
  /// its arrows is pinched where it is.
  void length(const DrawnDimension& text, const Point2& a, const Point2& b, const Point2& along,
              bool outside) {
    if (std::abs((b - a).dot(along)) < 2 * head_length + 2)
      pinched(text, a, b, along);
    else
      beside(text, a, b, along, outside);
  }

  /// Dimension of the angle at `vertex` between the direction of an axis and the way to a point.
  void angle(const DrawnDimension& text, const Point2& vertex, const Point2& axis,
             const Point2& to) {
    const Point2 way = to - vertex;
    const double turn = std::atan2(axis[0] * way[1] - axis[1] * way[0], axis.dot(way));
    const double from = std::atan2(axis[1], axis[0]);
    const auto direction = [&](double part) {
      const double at = from + part * turn;
      return Point2(std::cos(at), std::sin(at));
    };
    Best best(*picture_);
    const double least =
        std::clamp(2.5 * head_length / std::abs(turn), 34.0, 120.0);  // for two heads
    for (int k = 0; k < 12; ++k) {
      const double radius = least + 10 * k;
      std::vector<Point2> arc;
      for (int i = 0; i <= 32; ++i) arc.push_back(vertex + radius * direction(i / 32.0));
      for (const double part : {0.5, 0.25, 0.75, 0.0, 1.0}) {
        Picture one;
        one.line("extension", {vertex, vertex + (radius + 8) * axis});
        if (way.norm() < radius)
          one.line("extension", {vertex, vertex + (radius + 8) * direction(1)});
        one.dimensions.push_back(with_line(text, arc));
        one.dimensions.back().vertex = vertex;
        const double bend = 0.5 * head_length / radius;
        for (const double end : {0.0, 1.0}) {
          const double sense = (end > 0.5 ? 1 : -1) * (turn < 0 ? -1 : 1);
          const double at = from + end * turn - sense * bend;
          add_head(one, arc[end > 0.5 ? 32 : 0], Point2(-std::sin(at), std::cos(at)) * sense);
        }
        const double beyond = part == 0 || part == 1 ? 12 : 3;
        one.labels.push_back(label_beyond(words_of(text), vertex + radius * direction(part),
                                          direction(part), beyond));
        best.offer(std::move(one), 2.0 * k + (part == 0.5 ? 0 : 1));
      }
    }
    picture_->append(best.picture());
  }

  /// Words beside a point, with a leader where they stand away from it.
  void note(const std::string& words, const Point2& at) {
    Best best(*picture_);
    for (int k = 0; k < 14; ++k)
      for (int turn = 0; turn < 8; ++turn) {
        const double angle = (turn + 0.5) * std::numbers::pi / 4;
        const Point2 out(std::cos(angle), -std::sin(angle));
        const double away = 7 + 9 * k;
        Picture one;
        if (k > 1) one.line("extension", {at + 5 * out, at + (away - 2) * out});
        one.labels.push_back(label_beyond(words, at, out, away - (k > 1 ? 0 : 4)));
        best.offer(std::move(one), 2.0 * k + 0.1 * turn);
      }
    picture_->append(best.picture());
  }

 private:
  void beside(const DrawnDimension& text, const Point2& a, const Point2& b, const Point2& along,
              bool outside) {
    const Point2 normal(-along[1], along[0]);
    Best best(*picture_);
    for (const double side : {1.0, -1.0})
      for (int k = 0; k < 16; ++k) {
        const Point2 out = side * normal;
        double level = std::max(out.dot(a), out.dot(b));
        if (outside)
          level = std::max(
              level, out.cwiseMax(0).dot(outline_.max()) + out.cwiseMin(0).dot(outline_.min()));
        const double place = level + 14 + lane * k;
        const Point2 p = a + out * (place - out.dot(a)), q = b + out * (place - out.dot(b));
        const Point2 way = (q - p).normalized();
        Picture one;
        one.dimensions.push_back(with_line(text, {p, q}));
        add_head(one, p, -way);
        add_head(one, q, way);
        for (const auto& [from, to] : {std::pair{a, p}, {b, q}})
          one.line("extension", {from + gap * out, to + 4 * out});
        one.labels.push_back(label_beyond(words_of(text), 0.5 * (p + q), out, 3));
        best.offer(std::move(one), 0.5 * k + (side < 0 ? 0.3 : 0) + 0.02 * (place - level));
      }
    picture_->append(best.picture());
  }

  void pinched(const DrawnDimension& text, const Point2& a, const Point2& b, const Point2& along) {
    const double sign = (b - a).dot(along) < 0 ? -1 : 1;
    const Point2 way = sign * along, across(-way[1], way[0]);
    Best best(*picture_);
    const Point2 bent = b + across * across.dot(a - b);  // as seen from a
    const std::string words = words_of(text);
    for (const double side : {1.0, -1.0})
      for (int k = 0; k < 24; ++k)
        for (const double sideways : {0.0, 1.0, -1.0}) {
          const Point2 &near = side > 0 ? bent : a, &far = side > 0 ? a : bent;
          const Point2 out = side * way;
          const Point2 end = near + out * (tail + 7 * k);
          Picture one;
          one.dimensions.push_back(with_line(text, {a, bent}));
          add_head(one, near, -out);
          add_head(one, far, out);
          one.line("extension", {near + out * head_length, end});
          one.line("extension", {far - out * head_length, far - out * tail});
          if ((bent - b).norm() > 1) one.line("extension", {b, bent});
          Point2 beyond = out;
          double away = 2;
          if (sideways != 0) {  // a shelf for the words, level
            beyond = {sideways, 0};
            if (std::abs(out[0]) > 0.9) continue;
            one.line("extension", {end, end + 8 * beyond});
            away = 10;
          }
          one.labels.push_back(label_beyond(words, end, beyond, away));
          best.offer(std::move(one), 0.6 * k + (sideways != 0 ? 1 : 0) + (side < 0 ? 0.2 : 0));
        }
    picture_->append(best.picture());
  }

  Picture* picture_;
  Box2 outline_;  ///< outline of what was drawn at first
};

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
  axes.move(Point2(box.min()[0] - own.min()[0], box.max()[1] + 14 - own.min()[1]));
  picture.append(axes);
}

/// Adds arrows, straight or round, at the reference points of what is driven.
void add_drives(const PlacedDesign& design, const Projection& on, DimensionLines& lines,
                Picture& picture) {
  for (const Drive& drive : design.mechanism.drives) {
    if (drive.body < 0) continue;
    const Vector3d at = design.mechanism.bodies[drive.body].reference;
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
    lines.note(
        drive.name.empty() ? std::string(direction_names[index(drive.direction)]) : drive.name,
        end + 4 * along);
  }
}

void add_center(const PlacedDesign& design, const Projection& on, DimensionLines& lines,
                Picture& picture) {
  const Point2 o = on(design.mechanism.bodies[design.mechanism.end_effector].reference);
  picture.circle("center", o, 3.5);
  lines.note("O", o);
}

DrawnDimension text_of(const PlacedDesign& design, std::size_t parameter, double scale) {
  const Parameter& p = design.parameters[parameter];
  return {p.name, p.unit, design.values[parameter], scale};
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
    const DrawnDimension text = text_of(design, m.parameter, on.scale);
    if (m.along == ShownMeasure::Along::angle) {
      std::vector<Point2> guide;
      for (const Vector3d& place : m.guide) guide.push_back(on(place));
      if (!guide.empty()) picture.line("extension", std::move(guide));
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
  DimensionLines lines(picture);
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
  if (view.view.leaves.empty()) add_axes(on, picture);
  const std::string& words = view.view.caption;
  const Box2 box = picture.extent();
  const Point2 at = view.view.leaves.empty()
                        ? Point2(box.min()[0] + 46, box.max()[1] - size_of_text(words, 11)[1])
                        : Point2(box.min()[0], box.max()[1] + 10);
  picture.labels.push_back(label_at(words, at, 11, "quiet"));
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
  DimensionLines lines(picture);
  add_center(design, on, lines, picture);
  add_drives(design, on, lines, picture);
  picture.parts.push_back({"slanting", picture.extent()});
  add_axes(on, picture);
  return picture;
}

Point2 room_of(const PlacedDesign& design, const DrawnView& view) {
  Picture picture;
  add_parts(design.mechanism, {view, 1e6}, picture);
  return picture.extent().sizes() / 1e6;
}

void add_note(const std::string& words, const Point2& at, Picture& picture) {
  DimensionLines(picture).note(words, at);
}

std::string with_drawn_unit(double value, const std::string& unit) {
  if (unit == "m") return fmt::format("{:.4g} mm", 1e3 * value);
  if (unit == "rad") return fmt::format("{:.4g}°", value * 180 / std::numbers::pi);
  return unit == "1" ? fmt::format("{:.4g}", value) : fmt::format("{:.4g} {}", value, unit);
}

}  // namespace flexopt
