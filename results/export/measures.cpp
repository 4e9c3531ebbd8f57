#include "results/export/measures.hpp"

#include <limits>
#include <numbers>

namespace flexopt {

namespace {

constexpr double no_measure = std::numeric_limits<double>::infinity();

struct Candidate {
  double cost = no_measure;
  ShownMeasure measure;
};

bool on_surface(const DrawnPoint& p) {
  return p.kind == DrawnPoint::Kind::middle || p.kind == DrawnPoint::Kind::rim;
}

/// Whether anybody would measure from one to the other.
bool is_pair(const DrawnPoint& a, const DrawnPoint& b) {
  using Kind = DrawnPoint::Kind;
  if (a.kind == Kind::face || b.kind == Kind::face || a.kind == Kind::box || b.kind == Kind::box)
    return a.kind == b.kind && a.owner == b.owner;
  if (on_surface(a) && on_surface(b) && a.owner == b.owner) return true;
  const auto inside = [](const DrawnPoint& p) { return on_surface(p) && p.inside; };
  return !inside(a) && !inside(b);
}

/// The parameters' lengths and angles between two points of a view.
class Search {
 public:
  Search(const PlacedDesign& design, const DrawnView& view) : design_(&design), view_(&view) {
    best_.resize(design.parameters.size());
    for (const DrawnPoint& p : design.points) {
      if (p.kind == DrawnPoint::Kind::origin) continue;
      room_.extend(view(p.at));
      nearest_ = std::max(nearest_, view.toward().dot(p.at));
    }
  }

  std::vector<Candidate> best() && {
    const auto& points = design_->points;
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = i + 1; j < points.size(); ++j) {
        const bool own = view_->leaves.empty() || (of_leaf(points[i]) && of_leaf(points[j]));
        if (own && is_pair(points[i], points[j])) look(points[i], points[j]);
      }
    return std::move(best_);
  }

 private:
  bool of_leaf(const DrawnPoint& p) const {
    return p.owner == view_->leaves.front() && p.kind != DrawnPoint::Kind::box;
  }

  void look(const DrawnPoint& a, const DrawnPoint& b) {
    const Eigen::Vector2d way = (*view_)(b.at - a.at);
    const double nothing = 1e-9 * design_->size;
    const bool level = std::abs(way[1]) < nothing, upright = std::abs(way[0]) < nothing;
    if (level && upright) return;
    if (!level && !upright) look_along(a, b, way, way.normalized(), ShownMeasure::Along::way);
    if (!upright) look_along(a, b, way, {1, 0}, ShownMeasure::Along::right);
    if (!level) look_along(a, b, way, {0, 1}, ShownMeasure::Along::up);
    if (!level && !upright && view_->leaves.empty()) look_at_angles(a, b, way);
  }

  void look_along(const DrawnPoint& a, const DrawnPoint& b, const Eigen::Vector2d& way,
                  const Eigen::Vector2d& direction, ShownMeasure::Along along) {
    const double sign = way.dot(direction) < 0 ? -1 : 1;
    const auto found = design_->parameter_of(sign * way.dot(direction), "m", [&](std::size_t k) {
      return sign * direction.dot((*view_)(b.rates[k] - a.rates[k]));
    });
    if (!found) return;
    const Eigen::Vector2d rest = way - direction * direction.dot(way);
    keep(*found, cost_of(a, b) + 1.5 * rest.norm() / design_->size,
         {*found, along, a.at, b.at, Eigen::Vector2d::Zero()});
  }

  void look_at_angles(const DrawnPoint& a, const DrawnPoint& b, const Eigen::Vector2d& way) {
    if (a.kind == DrawnPoint::Kind::face || a.kind == DrawnPoint::Kind::box) return;
    for (const bool back : {false, true}) {
      const DrawnPoint &from = back ? b : a, &to = back ? a : b;
      if (from.kind == DrawnPoint::Kind::rim) continue;
      const Eigen::Vector2d w = back ? Eigen::Vector2d(-way) : way;
      for (const Eigen::Vector2d& axis : {Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0),
                                          Eigen::Vector2d(0, 1), Eigen::Vector2d(0, -1)}) {
        const double dot = axis.dot(w), cross = axis[0] * w[1] - axis[1] * w[0];
        const double sign = cross < 0 ? -1 : 1;
        const auto found =
            design_->parameter_of(std::atan2(sign * cross, dot), "rad", [&](std::size_t k) {
              const Eigen::Vector2d r = (*view_)(to.rates[k] - from.rates[k]);
              return sign * (w[0] * r[1] - w[1] * r[0]) / w.squaredNorm();
            });
        if (found)
          keep(*found, cost_of(from, to) + 0.5 * (axis[0] <= 0) - 0.5 * w.norm() / design_->size,
               {*found, ShownMeasure::Along::angle, from.at, to.at, axis});
      }
    }
  }

  void keep(std::size_t parameter, double cost, const ShownMeasure& measure) {
    if (cost < best_[parameter].cost - 1e-9) best_[parameter] = {cost, measure};
  }

  /// Small between places that lie near each other in depth, on one leaf, near a border.
  double cost_of(const DrawnPoint& a, const DrawnPoint& b) const {
    using Kind = DrawnPoint::Kind;
    const double depth = a.kind == Kind::face ? 3 : 0.6;  // a face behind another is hidden
    double cost = depth * std::abs(view_->toward().dot(b.at - a.at)) / design_->size;
    if (a.owner < 0 || a.owner != b.owner) cost += 0.5;
    for (const DrawnPoint* p : {&a, &b}) {
      if (p->kind == Kind::place) cost += 0.2;
      if (p->kind == Kind::box) cost += (nearest_ - view_->toward().dot(p->at)) / design_->size;
      if (p->kind == Kind::origin) cost += 0.6;
      if (p->kind == Kind::face && !p->inside) cost += 0.1;
      if (p->kind != Kind::face && p->inside) cost += 0.3;
      const Eigen::Vector2d at = (*view_)(p->at);
      cost += 0.15 * std::min((at - room_.min()).minCoeff(), (room_.max() - at).minCoeff()) /
              design_->size;
    }
    return cost;
  }

  const PlacedDesign* design_;
  const DrawnView* view_;
  std::vector<Candidate> best_;
  Eigen::AlignedBox2d room_;                                   ///< of all points
  double nearest_ = -std::numeric_limits<double>::infinity();  ///< of all points, to the eye
};

using Candidates = std::vector<std::vector<Candidate>>;  ///< for each view and parameter

std::size_t cheapest_view(const Candidates& found, unsigned views, std::size_t parameter) {
  std::size_t best = found.size();
  for (std::size_t v = 0; v < found.size(); ++v)
    if ((views >> v & 1) != 0 && found[v][parameter].cost < no_measure &&
        (best == found.size() || found[v][parameter].cost < found[best][parameter].cost))
      best = v;
  return best;
}

/// The plan views, as bits, that show most for the least; the front is among them.
unsigned chosen_views(const Candidates& found) {
  constexpr double of_view = 1.2, of_missing = 20;
  unsigned best = 1;
  double least = no_measure;
  for (unsigned views = 1; views < 1u << found.size(); views += 2) {
    double cost = 0;
    for (std::size_t v = 0; v < found.size(); ++v) cost += (views >> v & 1) != 0 ? of_view : 0;
    for (std::size_t k = 0; k < found.front().size(); ++k) {
      const std::size_t v = cheapest_view(found, views, k);
      cost += v == found.size() ? of_missing : found[v][k].cost;
    }
    if (cost < least - 1e-9) {
      least = cost;
      best = views;
    }
  }
  return best;
}

/// A leaf laid flat, and seen along its width.
std::vector<DrawnView> views_of_leaf(const Mechanism& mechanism, int leaf) {
  const LeafSpring& own = mechanism.leaves[leaf];
  return {{own.name + ", laid flat", own.axes.col(0), own.axes.col(1), {leaf}},
          {own.name + ", on edge", own.axes.col(0), own.axes.col(2), {leaf}}};
}

/// Measures what the plan views do not show on a leaf alone; true where one shows it.
bool measure_on_leaf(const PlacedDesign& design, std::size_t parameter, MeasuredDesign& all) {
  for (MeasuredView& one : all.views) {
    if (one.view.leaves.size() != 1) continue;
    const Candidate found = Search(design, one.view).best()[parameter];
    if (found.cost == no_measure) continue;
    one.measures.push_back(found.measure);
    return true;
  }
  for (int leaf = 0; leaf < static_cast<int>(design.mechanism.leaves.size()); ++leaf)
    for (const DrawnView& view : views_of_leaf(design.mechanism, leaf)) {
      const Candidate found = Search(design, view).best()[parameter];
      if (found.cost == no_measure) continue;
      all.views.push_back({view, {found.measure}});
      return true;
    }
  return false;
}

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
      const LeafSpring& leaf = design.mechanism.leaves[a.leaf];
      if (a.leaf == b.leaf && leaf.curve) {
        angles.push_back(of_arc(a, b));
      } else if ((a.at - b.at).norm() < in_plane * design.size) {
        const double reach = b.leaf == a.leaf ? leaf.length * (1 - leaf.fold->place)
                                              : design.mechanism.leaves[b.leaf].chord();
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
  const auto name = [&](int leaf) { return mechanism.leaves[leaf].name; };
  const Vector3d right = -angle.first->along, way = angle.second->along;
  const Vector3d up = (way - right * right.dot(way)).normalized();
  if (a == b) return {name(a) + ", on edge", right, up, {a}};
  return {name(a) + " and " + name(b) + ", on edge", right, up, {a, b}};
}

/// Looks for a parameter among the angles that an arc subtends and those between leaves which meet
/// at an edge or a fold; false where it is none of them. Its dimension goes into a view of `all`
/// that shows the angle in true size, else into a new one of these leaves alone. An arc up to 100°
/// is measured between the tangents at its ends, a longer one at its centre.
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

}  // namespace

const std::vector<DrawnView>& plan_views() {
  static const std::vector<DrawnView> views{
      {"front", Vector3d::UnitX(), Vector3d::UnitY(), {}},
      {"from below", Vector3d::UnitX(), Vector3d::UnitZ(), {}},
      {"from the right", -Vector3d::UnitZ(), Vector3d::UnitY(), {}}};
  return views;
}

MeasuredDesign measured_design(const PlacedDesign& design) {
  Candidates found;
  for (const DrawnView& view : plan_views()) found.push_back(Search(design, view).best());
  const unsigned views = chosen_views(found);
  MeasuredDesign all;
  std::vector<std::size_t> place(found.size());
  for (std::size_t v = 0; v < found.size(); ++v) {
    if ((views >> v & 1) == 0) continue;
    place[v] = all.views.size();
    all.views.push_back({plan_views()[v], {}});
  }
  for (std::size_t k = 0; k < design.parameters.size(); ++k) {
    const std::size_t v = cheapest_view(found, views, k);
    if (v < found.size())
      all.views[place[v]].measures.push_back(found[v][k].measure);
    else if (design.parameters[k].unit == "m" && design.moves(k) && !design.is_absent(k) &&
             !measure_on_leaf(design, k, all))
      all.without.push_back(k);
    else if (design.parameters[k].unit == "rad")
      measure_between_legs(design, k, all);
  }
  return all;
}

}  // namespace flexopt
