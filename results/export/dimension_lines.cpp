#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "results/export/view_picture.hpp"

namespace flexopt {

namespace {

constexpr double head_length = 8, head_half = 2.4, tail = 14, lane = 19, gap = 3;  // px

std::string words_of(const DimensionText& text) {
  return text.parameter + " = " + with_drawn_unit(text.value, text.unit);
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

}  // namespace

std::string with_drawn_unit(double value, const std::string& unit) {
  if (unit == "m") return fmt::format("{:.4g} mm", 1e3 * value);
  if (unit == "rad") return fmt::format("{:.4g}°", value * 180 / std::numbers::pi);
  return unit == "1" ? fmt::format("{:.4g}", value) : fmt::format("{:.4g} {}", value, unit);
}

DrawnDimension DimensionLines::dimension(const DimensionText& text,
                                         std::vector<Point2> line) const {
  return {text.parameter, text.unit, text.value, scale_, std::move(line)};
}

void DimensionLines::length(const DimensionText& text, const Point2& a, const Point2& b,
                            const Point2& along, bool outside) {
  if (std::abs((b - a).dot(along)) < 2 * head_length + 2)
    pinched(text, a, b, along);
  else
    beside(text, a, b, along, outside);
}

void DimensionLines::beside(const DimensionText& text, const Point2& a, const Point2& b,
                            const Point2& along, bool outside) {
  const Point2 normal(-along[1], along[0]);
  Best best(*picture_);
  for (const double side : {1.0, -1.0})
    for (int k = 0; k < 16; ++k) {
      const Point2 out = side * normal;
      double level = std::max(out.dot(a), out.dot(b));
      if (outside)
        level =
            std::max(level, out.cwiseMax(0).dot(outline_.high) + out.cwiseMin(0).dot(outline_.low));
      const double place = level + 14 + lane * k;
      const Point2 p = a + out * (place - out.dot(a)), q = b + out * (place - out.dot(b));
      const Point2 way = (q - p).normalized();
      Picture one;
      one.dimensions.push_back(dimension(text, {p, q}));
      add_head(one, p, -way);
      add_head(one, q, way);
      for (const auto& [from, to] : {std::pair{a, p}, {b, q}})
        one.line("extension", {from + gap * out, to + 4 * out});
      one.labels.push_back(label_beyond(words_of(text), 0.5 * (p + q), out, 3));
      best.offer(std::move(one), 0.5 * k + (side < 0 ? 0.3 : 0) + 0.02 * (place - level));
    }
  picture_->append(best.picture());
}

void DimensionLines::pinched(const DimensionText& text, const Point2& a, const Point2& b,
                             const Point2& along) {
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
        one.dimensions.push_back(dimension(text, {a, bent}));
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

void DimensionLines::angle(const DimensionText& text, const Point2& vertex, const Point2& axis,
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
      one.dimensions.push_back(dimension(text, arc));
      one.dimensions.back().vertex = vertex;
      const double bend = 0.5 * head_length / radius;
      for (const double end : {0.0, 1.0}) {
        const double sense = (end > 0.5 ? 1 : -1) * (turn < 0 ? -1 : 1);
        const double at = from + end * turn - sense * bend;
        add_head(one, arc[end > 0.5 ? 32 : 0], Point2(-std::sin(at), std::cos(at)) * sense);
      }
      const double beyond = part == 0 || part == 1 ? 12 : 3;
      one.labels.push_back(
          label_beyond(words_of(text), vertex + radius * direction(part), direction(part), beyond));
      best.offer(std::move(one), 2.0 * k + (part == 0.5 ? 0 : 1));
    }
  }
  picture_->append(best.picture());
}

void DimensionLines::note(const std::string& words, const Point2& at) {
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

}  // namespace flexopt
