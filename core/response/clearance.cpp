#include "core/response/room_taken.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/response/solid_search.hpp"
#include "core/response/solids.hpp"

namespace flexopt {

namespace {

// A clamped edge: a line across the leaf.
struct Edge {
  int body;
  Vector3d middle, half;
  Vector3d outward;  ///< along the leaf, from it into the body
};

std::vector<Edge> clamped_edges(const LeafSpring& leaf, const SolidPart& part) {
  constexpr double step = 1e-3;  // along the leaf
  std::vector<Edge> edges;
  for (const double along : {0.0, 1.0}) {
    const int body = along == 0 ? leaf.base : leaf.tip;
    if (body == free_edge || along < part.begin || along > part.end) continue;
    const Vector3d middle = undeflected_place(leaf, along, 0.5),
                   inside = undeflected_place(leaf, std::abs(along - step), 0.5);
    const bool wire = leaf.section == Section::circular;
    edges.push_back(
        {body, middle,
         wire ? Vector3d(Vector3d::Zero()) : Vector3d(undeflected_place(leaf, along, 1) - middle),
         (middle - inside).normalized()});
  }
  return edges;
}

double distance(const Edge& a, const Edge& b) {
  const Vector3d between = a.middle - b.middle;
  const VectorXd at = local_minimum(
      [&](const VectorXd& u) {
        Eigen::Matrix<double, 3, 2> J;
        J << a.half, -b.half;
        const Vector3d d = between + J * Eigen::Vector2d(u);
        return LocalValue{0.5 * d.squaredNorm(), J.transpose() * d, J.transpose() * J};
      },
      VectorXd::Constant(2, -1), VectorXd::Constant(2, 1), VectorXd::Zero(2));
  return (between + a.half * at[0] - b.half * at[1]).norm();
}

// Whether two leaves are one piece at an edge, or may cross: folds and hubs, where their edges meet
// on one body, and the halves of a leaf on both sides of a rigid middle.
bool joined(const Mechanism& mechanism, const SolidPart& part_a, const SolidPart& part_b) {
  if (part_a.leaf == part_b.leaf) return true;  // legs of one leaf
  const LeafSpring &a = mechanism.leaves[part_a.leaf], &b = mechanism.leaves[part_b.leaf];
  if (a.may_cross || b.may_cross) return true;
  const double touch = 0.5 * (1 + 1e-6) * (a.thickness + b.thickness);
  for (const Edge& ea : clamped_edges(a, part_a))
    for (const Edge& eb : clamped_edges(b, part_b)) {
      if (ea.body != eb.body) continue;
      const Vector3d apart = eb.middle - ea.middle;
      const double far = apart.norm() - ea.half.norm() - eb.half.norm();
      if (far <= touch && distance(ea, eb) <= touch) return true;
      const bool in_line = ea.outward.cross(eb.outward).norm() < 1e-9 &&
                           ea.outward.cross(apart).norm() < 1e-9 * (a.length + b.length);
      if (in_line && ea.outward.dot(apart) > 0 && eb.outward.dot(apart) < 0) return true;
    }
  return false;
}

}  // namespace

namespace {

/// Whether the body holds the leaf, or is of one elastic body with what holds it.
bool holds(const Mechanism& mechanism, int body, const LeafSpring& leaf) {
  const auto of = [&](int holder) {
    return std::ranges::any_of(mechanism.elastic_bodies, [&](const ElasticBody& elastic) {
      const auto has = [&](int one) {
        return std::ranges::find(elastic.interfaces, one, &ElasticInterface::body) !=
               elastic.interfaces.end();
      };
      return has(holder) && has(body);
    });
  };
  return leaf.base == body || leaf.tip == body || of(leaf.base) || of(leaf.tip);
}

}  // namespace

std::vector<std::array<int, 2>> clearance_pairs(const Mechanism& mechanism) {
  std::vector<std::array<int, 2>> pairs;
  const std::vector<SolidPart> parts = solid_parts(mechanism);
  for (std::size_t i = 0; i < parts.size() && parts[i].leaf >= 0; ++i) {
    const LeafSpring& leaf = mechanism.leaves[parts[i].leaf];
    for (std::size_t j = i + 1; j < parts.size(); ++j) {
      if (parts[j].leaf >= 0 ? !joined(mechanism, parts[i], parts[j])
                             : !holds(mechanism, parts[j].body, leaf))
        pairs.push_back({static_cast<int>(i), static_cast<int>(j)});
    }
  }
  return pairs;
}

namespace {

double distance_of_bounds(const Solids& solids, int a, int b) {
  const Vector3d gap = (solids.lowest(a) - solids.highest(b))
                           .cwiseMax(solids.lowest(b) - solids.highest(a))
                           .cwiseMax(0);
  return gap.norm();
}

// Two points of a pair of solids, six coordinates.
using PairPoints = std::array<SolidPoint, 2>;

// Half the square of the distance over `size`.
LocalValue half_square(const Solids& solids, const PairPoints& pair, const VectorXd& u,
                       double size) {
  const Solids::Local a = solids.local({pair[0].solid, u.head<3>()}),
                      b = solids.local({pair[1].solid, u.tail<3>()});
  const Vector3d g = (a.place - b.place) / size;
  Eigen::Matrix<double, 3, 6> J;
  J << a.slopes / size, -b.slopes / size;
  LocalValue result{0.5 * g.squaredNorm(), J.transpose() * g, J.transpose() * J};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const auto k = static_cast<std::size_t>(symmetric_index(i, j));
      result.curvature(i, j) += g.dot(a.curvatures[k]) / size;
      result.curvature(3 + i, 3 + j) -= g.dot(b.curvatures[k]) / size;
    }
  return result;
}

// `inside`: leaves without their thickness.
PairPoints nearest_points(const Solids& solids, const PairPoints& start, double size, bool inside) {
  VectorXd lower(6), upper(6), u(6);
  for (int side = 0; side < 2; ++side) {
    const int solid = start[side].solid;
    lower.segment<3>(3 * side) = solids.lower(solid);
    upper.segment<3>(3 * side) = solids.upper(solid);
    u.segment<3>(3 * side) = start[side].at;
    if (!inside) continue;
    lower[3 * side + 2] = upper[3 * side + 2] = 0;
    if (solids.is_wire(solid)) lower[3 * side + 1] = upper[3 * side + 1] = 0;
  }
  u = local_minimum([&](const VectorXd& at) { return half_square(solids, start, at, size); }, lower,
                    upper, u);
  return {SolidPoint{start[0].solid, u.head<3>()}, SolidPoint{start[1].solid, u.tail<3>()}};
}

// Turns a point of a wire to the side that faces a place.
void turn_towards(const Solids& solids, const Vector3d& place, SolidPoint& point) {
  if (!solids.is_wire(point.solid)) return;
  point.at[2] = 1;
  double least = std::numeric_limits<double>::infinity(), angle = 0;
  for (int k = 0; k < 4; ++k) {
    point.at[1] = 0.5 * std::numbers::pi * k;
    if (const double d = (solids.place(point) - place).norm(); d < least)
      least = d, angle = point.at[1];
  }
  point.at[1] = angle;
}

struct Start {
  double distance = std::numeric_limits<double>::infinity();
  Vector3d a, b;
};

// The nearest samples in each of a few stretches along both.
std::vector<Start> starts_of(const std::vector<Solids::Sample>& a,
                             const std::vector<Solids::Sample>& b, bool leaf_a, bool leaf_b) {
  constexpr int stretches = 3;
  const auto stretch = [](const Solids::Sample& s, bool leaf) {
    return leaf ? std::min(stretches - 1, static_cast<int>(stretches * s.at[0])) : 0;
  };
  std::array<Start, stretches * stretches> nearest;
  for (const Solids::Sample& x : a) {
    const int row = stretches * stretch(x, leaf_a);
    for (const Solids::Sample& y : b) {
      Start& best = nearest[row + stretch(y, leaf_b)];
      if (const double d = (x.place - y.place).squaredNorm(); d < best.distance)
        best = {d, x.at, y.at};
    }
  }
  std::vector<Start> starts;
  for (Start& s : nearest)
    if (std::isfinite(s.distance)) {
      s.distance = std::sqrt(s.distance);
      starts.push_back(s);
    }
  std::ranges::stable_sort(starts, {}, &Start::distance);
  return starts;
}

Clearance at_points(const Solids& solids, const PairPoints& pair) {
  Clearance c;
  c.at = pair;
  for (std::size_t k = 0; k < 2; ++k) c.places[k] = solids.place(pair[k]);
  c.value = (c.places[0] - c.places[1]).norm();
  return c;
}

// Overlap of two leaves: distance of their middle surfaces, less both half thicknesses [m].
Clearance overlap_of(const Solids& solids, const PairPoints& pair, double size) {
  if (!solids.is_leaf(pair[0].solid) || !solids.is_leaf(pair[1].solid)) {
    Clearance c = at_points(solids, pair);
    c.value = 0;
    c.overlap = true;
    return c;
  }
  PairPoints inside = pair;
  for (SolidPoint& p : inside) p.at[2] = 0;
  Clearance c = at_points(solids, nearest_points(solids, inside, size, true));
  for (const SolidPoint& p : c.at) c.value -= solids.half_thickness(p.solid, p.at[0]);
  c.value = std::min(c.value, 0.0);
  c.overlap = true;
  return c;
}

Clearance clearance_of_pair(const Solids& solids, const std::array<int, 2>& pair,
                            const std::vector<Solids::Sample>& a,
                            const std::vector<Solids::Sample>& b, double size) {
  const double slack = 0.5 * (solids.spacing(pair[0]) + solids.spacing(pair[1]));
  std::optional<Clearance> best;
  for (const Start& start : starts_of(a, b, solids.is_leaf(pair[0]), solids.is_leaf(pair[1]))) {
    if (best && start.distance - slack > best->value) break;
    PairPoints points{SolidPoint{pair[0], start.a}, SolidPoint{pair[1], start.b}};
    const Vector3d place_a = solids.place(points[0]), place_b = solids.place(points[1]);
    turn_towards(solids, place_b, points[0]);
    turn_towards(solids, place_a, points[1]);
    const Clearance here = at_points(solids, nearest_points(solids, points, size, false));
    if (!best || here.value < best->value - equal_distance * size) best = here;
  }
  return best->value < equal_distance * size ? overlap_of(solids, best->at, size) : *best;
}

}  // namespace

std::optional<Clearance> clearance_of(const Solids& solids,
                                      const std::vector<std::array<int, 2>>& pairs) {
  if (pairs.empty()) return std::nullopt;
  const double size = longest_leaf(solids.mechanism());
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    order.push_back({distance_of_bounds(solids, pairs[k][0], pairs[k][1]), k});
  std::ranges::sort(order);
  std::map<int, std::vector<Solids::Sample>> samples;
  const auto samples_of = [&](int solid) -> const std::vector<Solids::Sample>& {
    auto& list = samples[solid];
    if (list.empty()) list = solids.inner_samples(solid);
    return list;
  };
  std::optional<Clearance> best;
  std::size_t at = 0;
  for (const auto& [bound, k] : order) {
    if (best && bound > std::max(best->value, 0.0)) break;
    const Clearance here =
        clearance_of_pair(solids, pairs[k], samples_of(pairs[k][0]), samples_of(pairs[k][1]), size);
    // the first pair counts where clearances are equal
    const double tolerance = equal_distance * size * (k < at ? -1 : 1);
    if (!best || here.value < best->value - tolerance) best = here, at = k;
  }
  for (std::size_t k = 0; k < 2; ++k) best->names[k] = solids.name(best->at[k].solid);
  return best;
}

VectorXd clearance_rate(const Solids& solids, const Clearance& clearance, const PlaceRates& rates) {
  const std::vector<Mechanism>& directions = *rates.directions;
  VectorXd rate = VectorXd::Zero(directions.size());
  const Vector3d between = clearance.places[0] - clearance.places[1];
  const bool leaves =
      solids.is_leaf(clearance.at[0].solid) && solids.is_leaf(clearance.at[1].solid);
  if (clearance.overlap && !leaves) return rate;
  if (const double apart = between.norm(); apart > 0)
    rate = (solids.place_rates(clearance.at[0], rates) - solids.place_rates(clearance.at[1], rates))
               .transpose() *
           (between / apart);
  if (clearance.overlap)
    for (const SolidPoint& p : clearance.at)
      for (Eigen::Index k = 0; k < rate.size(); ++k)
        rate[k] -= solids.half_thickness_rate(p.solid, p.at[0], directions[k]);
  return rate;
}

}  // namespace flexopt
