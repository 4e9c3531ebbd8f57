#include "results/export/measures.hpp"

#include <cmath>
#include <limits>

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
    for (const DrawnPoint& p : design.points)
      if (p.kind != DrawnPoint::Kind::origin) {
        low_ = low_.cwiseMin(view(p.at));
        high_ = high_.cwiseMax(view(p.at));
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
      if (p->kind == Kind::origin) cost += 0.6;
      if (p->kind == Kind::face && !p->inside) cost += 0.1;
      if (p->kind != Kind::face && p->inside) cost += 0.3;
      const Eigen::Vector2d at = (*view_)(p->at);
      cost += 0.15 * std::min((at - low_).minCoeff(), (high_ - at).minCoeff()) / design_->size;
    }
    return cost;
  }

  const PlacedDesign* design_;
  const DrawnView* view_;
  std::vector<Candidate> best_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(no_measure),
                  high_ = Eigen::Vector2d::Constant(-no_measure);
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
  const LeafSpring& own = mechanism.leaves[static_cast<std::size_t>(leaf)];
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
    else if (design.parameters[k].unit == "m" && design.moves(k) &&
             !measure_on_leaf(design, k, all))
      all.without.push_back(k);
    else if (design.parameters[k].unit == "rad")
      measure_between_legs(design, k, all);
  }
  return all;
}

}  // namespace flexopt
