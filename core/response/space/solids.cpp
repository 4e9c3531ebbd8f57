#include "core/response/space/solids.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/math/rotation.hpp"
#include "core/mechanism/arc.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt {
namespace {

constexpr int along_intervals = 20, across_intervals = 4;
constexpr int stations_along = along_intervals + 1, stations_across = across_intervals + 1;
constexpr int sample_step = 2;  // of the stations that inner_samples() takes
constexpr int surface_size = stations_along * stations_across;  // of one surface of a leaf

// Interpolation between equal intervals: a cubic in each, with the slopes that a parabola through
// three neighbours has. Values and derivatives of the weights of up to four stations.
struct Cubic {
  int first = 0, count = 0;
  std::array<double, 4> value{}, slope{}, curvature{};
};

Cubic cubic(int intervals, double s) {
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
    if (c.slope[static_cast<std::size_t>(k)] != 0)
      sum += at(c.first + k) * c.slope[static_cast<std::size_t>(k)];
  return sum;
}

double along_of(int i) { return static_cast<double>(i) / along_intervals; }
double across_of(int j) { return static_cast<double>(j) / across_intervals; }
int mid_index(int i, int j) { return i * stations_across + j; }

double half_of(const LeafSpring& leaf, double along) {
  return 0.5 * leaf.thickness * profile_at(leaf.thickness_profile, along);
}

// Factors of a profile that stays as it is have no rates.
double profile_rate(const std::vector<double>& rates, double along) {
  return rates.empty() ? 0 : profile_at(rates, along);
}

double half_rate_of(const LeafSpring& leaf, const LeafSpring& direction, double along) {
  return 0.5 * (direction.thickness * profile_at(leaf.thickness_profile, along) +
                leaf.thickness * profile_rate(direction.thickness_profile, along));
}

// Rate of v/|v|.
Vector3d unit_rate(const Vector3d& v, const Vector3d& rate) {
  const Vector3d n = v.normalized();
  return (rate - n * n.dot(rate)) / v.norm();
}

// The two unit vectors across a wire whose centre line runs along t.
struct WireAxes {
  Vector3d n, b;
};
WireAxes wire_section(const Vector3d& t, const Vector3d& reference) {
  const Vector3d e = t.normalized(), n = (reference - e * e.dot(reference)).normalized();
  return {n, e.cross(n)};
}
WireAxes wire_section_rate(const Vector3d& t, const Vector3d& reference, const Vector3d& rate) {
  const Vector3d e = t.normalized(), de = unit_rate(t, rate), v = reference - e * e.dot(reference),
                 dv = -de * e.dot(reference) - e * de.dot(reference), n = v.normalized(),
                 dn = unit_rate(v, dv);
  return {dn, de.cross(n) + e.cross(dn)};
}

// Of a point of a solid, along its leaf.
double along_leaf(const SolidPart& part, double along) {
  return part.begin + (part.end - part.begin) * along;
}

// What that changes by as the fold moves.
double along_leaf_rate(const SolidPart& part, const LeafSpring& leaf, const LeafSpring& direction,
                       double along) {
  const double fold = leaf.fold && direction.fold ? direction.fold->place : 0;
  return part.begin > 0 ? fold * (1 - along) : part.end < 1 ? fold * along : 0;
}

}  // namespace

std::vector<SolidPart> solid_parts(const Mechanism& mechanism) {
  std::vector<SolidPart> parts;
  for (int i = 0; i < static_cast<int>(mechanism.leaves.size()); ++i) {
    const auto& fold = mechanism.leaves[static_cast<std::size_t>(i)].fold;
    parts.push_back({.leaf = i, .end = fold ? fold->place : 1});
    if (fold) parts.push_back({.leaf = i, .begin = fold->place});
  }
  for (int b = 0; b < static_cast<int>(mechanism.bodies.size()); ++b)
    if (mechanism.bodies[static_cast<std::size_t>(b)].box) parts.push_back({.body = b});
  return parts;
}

Solids::Solids(const Mechanism& mechanism, const LeafPlaces& places,
               const std::vector<BodyPlace>& bodies)
    : mechanism_(&mechanism) {
  for (const SolidPart& part : solid_parts(mechanism))
    if (part.leaf >= 0)
      add_leaf(part, places);
    else
      add_box(part, bodies[static_cast<std::size_t>(part.body)]);
  constexpr double overshoot = 0.01;  // of the interpolation between stations
  for (Solid& solid : solids_) {
    const int index = static_cast<int>(&solid - solids_.data());
    std::vector<Vector3d> points = solid.nodes;
    double beyond = 0;
    if (!is_leaf(index)) {
      points.clear();
      for (int k = 0; k < 8; ++k)
        points.push_back(
            place({index, {k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, k & 4 ? 1.0 : -1.0}}));
    } else if (is_wire(index)) {
      points.resize(stations_along);
      for (int i = 0; i < stations_along; ++i)
        beyond = std::max(beyond, half_of(leaf_of(index), along_of(i)));
    }
    solid.lowest = solid.highest = points.front();
    for (const Vector3d& p : points) {
      solid.lowest = solid.lowest.cwiseMin(p);
      solid.highest = solid.highest.cwiseMax(p);
    }
    if (is_leaf(index))
      beyond += overshoot * (solid.highest - solid.lowest).norm() / along_intervals;
    solid.lowest.array() -= beyond;
    solid.highest.array() += beyond;
  }
}

void Solids::add_leaf(const SolidPart& part, const LeafPlaces& places) {
  const int leaf = part.leaf;
  const LeafSpring& spring = mechanism_->leaves[static_cast<std::size_t>(leaf)];
  Solid& solid = solids_.emplace_back();
  solid.part = part;
  if (spring.section == Section::circular) {
    std::vector<std::array<double, 2>> points;
    for (int i = 0; i < stations_along; ++i) points.push_back({along_of(i), 0.5});
    std::vector<Vector3d> line = places(leaf, points);
    const Vector3d chord = (line.back() - line.front()).cwiseAbs();
    int least = 0;
    for (int k = 1; k < 3; ++k)
      if (chord[k] < chord[least]) least = k;
    solid.reference = Vector3d::Unit(least);
    std::vector<Vector3d> sides[2];
    for (int i = 0; i < stations_along; ++i) {
      const Vector3d t = station_slope(along_intervals, i, Vector3d(Vector3d::Zero()),
                                       [&](int k) { return line[static_cast<std::size_t>(k)]; });
      const WireAxes s = wire_section(t, solid.reference);
      sides[0].push_back(half_of(spring, along_of(i)) * s.n);
      sides[1].push_back(half_of(spring, along_of(i)) * s.b);
    }
    solid.nodes = std::move(line);
    for (const auto& side : sides) solid.nodes.insert(solid.nodes.end(), side.begin(), side.end());
    return;
  }
  std::vector<std::array<double, 2>> points;
  for (int i = 0; i < stations_along; ++i)
    for (int j = 0; j < stations_across; ++j)
      points.push_back({along_leaf(part, along_of(i)), across_of(j)});
  const std::vector<Vector3d> mid = places(leaf, points);
  solid.nodes.resize(2 * surface_size);
  for (int i = 0; i < stations_along; ++i)
    for (int j = 0; j < stations_across; ++j) {
      const auto at = [&](int a, int b) { return mid[static_cast<std::size_t>(mid_index(a, b))]; };
      const Vector3d along = station_slope(along_intervals, i, Vector3d(Vector3d::Zero()),
                                           [&](int k) { return at(k, j); }),
                     across = station_slope(across_intervals, j, Vector3d(Vector3d::Zero()),
                                            [&](int k) { return at(i, k); });
      const Vector3d n =
          along.cross(across).normalized() * half_of(spring, along_leaf(part, along_of(i)));
      const auto k = static_cast<std::size_t>(mid_index(i, j));
      solid.nodes[k] = mid[k] - n;
      solid.nodes[surface_size + k] = mid[k] + n;
    }
}

void Solids::add_box(const SolidPart& part, const BodyPlace& place) {
  const RigidBody& of = mechanism_->bodies[static_cast<std::size_t>(part.body)];
  Solid& solid = solids_.emplace_back();
  solid.part = part;
  solid.rotation = place.rotation;
  solid.nodes.push_back(place.position + place.rotation * (of.box->center - of.reference));
  for (int k = 0; k < 3; ++k) solid.nodes.push_back(place.rotation * of.box->half_edges.col(k));
}

Solids Solids::undeflected(const Mechanism& mechanism) {
  std::vector<BodyPlace> bodies;
  for (const RigidBody& body : mechanism.bodies)
    bodies.push_back({body.reference, Matrix3d::Identity()});
  return {mechanism,
          [&](int leaf, const std::vector<std::array<double, 2>>& points) {
            std::vector<Vector3d> places;
            for (const auto& [along, across] : points)
              places.push_back(undeflected_place(mechanism.leaves[static_cast<std::size_t>(leaf)],
                                                 along, across));
            return places;
          },
          bodies};
}

const std::string& Solids::name(int solid) const {
  return is_leaf(solid) ? leaf_of(solid).name
                        : mechanism_->bodies[static_cast<std::size_t>(body_of_box(solid))].name;
}

Vector3d Solids::middle_place(int leaf, double along, double across) const {
  const auto of_leaf = [&](const Solid& solid) {
    return solid.part.leaf == leaf && along <= solid.part.end;
  };
  const auto found = std::ranges::find_if(solids_, of_leaf);
  assert(found != solids_.end());
  const int solid = static_cast<int>(found - solids_.begin());
  const auto [begin, end] = std::pair(found->part.begin, found->part.end);
  return place({solid, {(along - begin) / (end - begin), is_wire(solid) ? 0 : across, 0}});
}

double Solids::spacing(int solid) const {
  if (!is_leaf(solid)) return (highest(solid) - lowest(solid)).norm() / 2;
  const LeafSpring& leaf = leaf_of(solid);
  const double length = (part(solid).end - part(solid).begin) * leaf.length,
               width = is_wire(solid) ? 0 : leaf.width * profile_range(leaf.width_profile).largest;
  return sample_step * std::hypot(length / along_intervals, width / across_intervals) +
         leaf.thickness * profile_range(leaf.thickness_profile).largest;
}

double Solids::half_thickness(int solid, double along) const {
  return half_of(leaf_of(solid), along_leaf(part(solid), along));
}

// Folded leaves, whose legs end where a parameter may move the fold, have one thickness.
double Solids::half_thickness_rate(int solid, double along, const Mechanism& direction) const {
  return half_rate_of(leaf_of(solid), direction.leaves[static_cast<std::size_t>(part(solid).leaf)],
                      along_leaf(part(solid), along));
}

Vector3d Solids::lower(int solid) const {
  if (!is_leaf(solid)) return {-1, -1, -1};
  return is_wire(solid) ? Vector3d(0, -4 * std::numbers::pi, 1) : Vector3d(0, 0, -1);
}

Vector3d Solids::upper(int solid) const {
  if (!is_leaf(solid)) return {1, 1, 1};
  return is_wire(solid) ? Vector3d(1, 4 * std::numbers::pi, 1) : Vector3d(1, 1, 1);
}

std::vector<Solids::Weight> Solids::weights(const SolidPoint& point) const {
  std::vector<Weight> list;
  const Vector3d& u = point.at;
  if (!is_leaf(point.solid)) {
    list.push_back({0, 1});
    for (int k = 0; k < 3; ++k) list.push_back({k + 1, u[k], Vector3d::Unit(k)});
    return list;
  }
  const Cubic a = cubic(along_intervals, u[0]);
  if (is_wire(point.solid)) {
    const double c = u[2] * std::cos(u[1]), s = u[2] * std::sin(u[1]);
    for (std::size_t i = 0; i < static_cast<std::size_t>(a.count); ++i) {
      const int station = a.first + static_cast<int>(i);
      list.push_back({station, a.value[i], {a.slope[i], 0, 0}, {a.curvature[i]}});
      list.push_back({stations_along + station,
                      a.value[i] * c,
                      {a.slope[i] * c, -a.value[i] * s, 0},
                      {a.curvature[i] * c, -a.slope[i] * s, 0, -a.value[i] * c}});
      list.push_back({2 * stations_along + station,
                      a.value[i] * s,
                      {a.slope[i] * s, a.value[i] * c, 0},
                      {a.curvature[i] * s, a.slope[i] * c, 0, -a.value[i] * s}});
    }
    return list;
  }
  const Cubic b = cubic(across_intervals, u[1]);
  for (int side = 0; side < 2; ++side) {
    const double h = side == 0 ? -0.5 : 0.5, v = 0.5 + h * u[2];
    for (std::size_t i = 0; i < static_cast<std::size_t>(a.count); ++i)
      for (std::size_t j = 0; j < static_cast<std::size_t>(b.count); ++j)
        list.push_back({side * surface_size +
                            mid_index(a.first + static_cast<int>(i), b.first + static_cast<int>(j)),
                        a.value[i] * b.value[j] * v,
                        {a.slope[i] * b.value[j] * v, a.value[i] * b.slope[j] * v,
                         a.value[i] * b.value[j] * h},
                        {a.curvature[i] * b.value[j] * v, a.slope[i] * b.slope[j] * v,
                         a.slope[i] * b.value[j] * h, a.value[i] * b.curvature[j] * v,
                         a.value[i] * b.slope[j] * h, 0}});
  }
  return list;
}

Solids::Local Solids::local(const SolidPoint& point) const {
  const Solid& solid = solids_[static_cast<std::size_t>(point.solid)];
  Local local;
  local.curvatures.fill(Vector3d::Zero());
  for (const Weight& w : weights(point)) {
    const Vector3d& node = solid.nodes[static_cast<std::size_t>(w.node)];
    local.place += w.value * node;
    local.slopes += node * w.slope.transpose();
    for (std::size_t k = 0; k < 6; ++k) local.curvatures[k] += w.curvature[k] * node;
  }
  return local;
}

std::vector<Solids::Sample> Solids::inner_samples(int solid) const {
  std::vector<Sample> samples;
  const std::vector<Vector3d>& nodes = solids_[static_cast<std::size_t>(solid)].nodes;
  if (!is_leaf(solid)) return surface_samples(solid);
  for (int i = 0; i < stations_along; i += sample_step) {
    if (is_wire(solid)) {
      samples.push_back({{along_of(i), 0, 0}, nodes[static_cast<std::size_t>(i)]});
      continue;
    }
    for (int j = 0; j < stations_across; j += sample_step) {
      const auto k = static_cast<std::size_t>(mid_index(i, j));
      samples.push_back(
          {{along_of(i), across_of(j), 0}, 0.5 * (nodes[k] + nodes[surface_size + k])});
    }
  }
  return samples;
}

std::vector<Solids::Sample> Solids::surface_samples(int solid) const {
  std::vector<Sample> samples;
  const std::vector<Vector3d>& nodes = solids_[static_cast<std::size_t>(solid)].nodes;
  const auto add = [&](const Vector3d& u) { samples.push_back({u, place({solid, u})}); };
  if (!is_leaf(solid)) {
    for (const double z : {-1, 0, 1})
      for (const double y : {-1, 0, 1})
        for (const double x : {-1, 0, 1}) add({x, y, z});
  } else if (is_wire(solid)) {
    for (int i = 0; i < stations_along; ++i)
      for (int k = 0; k < 4; ++k) add({along_of(i), 0.5 * std::numbers::pi * k, 1});
  } else {
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < stations_along; ++i)
        for (int j = 0; j < stations_across; ++j)
          samples.push_back(
              {{along_of(i), across_of(j), 2.0 * side - 1},
               nodes[static_cast<std::size_t>(side * surface_size + mid_index(i, j))]});
  }
  return samples;
}

MatrixXd Solids::node_rates(const Solid& solid, int node, const PlaceRates& rates,
                            std::map<int, MatrixXd>& known) const {
  const std::vector<Mechanism>& directions = *rates.directions;
  const auto count = static_cast<Eigen::Index>(directions.size());
  const SolidPart& part = solid.part;
  if (part.body >= 0) {
    const RigidBody& body = mechanism_->bodies[static_cast<std::size_t>(part.body)];
    const BodyPlaceRate& of = rates.bodies[static_cast<std::size_t>(part.body)];
    // an edge turns with the body; the middle is on an arm of its reference point
    const Matrix3d& rotation = solid.rotation;
    MatrixXd result(3, count);
    for (Eigen::Index p = 0; p < count; ++p) {
      const RigidBody& d =
          directions[static_cast<std::size_t>(p)].bodies[static_cast<std::size_t>(part.body)];
      const Vector3d spin = of.spin.col(p);
      if (node == 0)
        result.col(p) = Vector3d(of.position.col(p)) +
                        spin.cross(rotation * (body.box->center - body.reference)) +
                        rotation * (d.box->center - d.reference);
      else
        result.col(p) = spin.cross(rotation * body.box->half_edges.col(node - 1)) +
                        rotation * d.box->half_edges.col(node - 1);
    }
    return result;
  }
  const auto index = static_cast<std::size_t>(part.leaf);
  const LeafSpring& leaf = mechanism_->leaves[index];
  const bool wire = leaf.section == Section::circular;
  const int kind = node / (wire ? stations_along : surface_size),
            station = node % (wire ? stations_along : surface_size),
            i = wire ? station : station / stations_across,
            j = wire ? 0 : station % stations_across;
  const auto mid = [&](int a, int b) -> const MatrixXd& {
    MatrixXd& rate = known[mid_index(a, b)];
    if (rate.size() > 0) return rate;
    VectorXd along_rates;
    if (leaf.fold) {
      along_rates.resize(count);
      for (Eigen::Index p = 0; p < count; ++p)
        along_rates[p] = along_leaf_rate(
            part, leaf, directions[static_cast<std::size_t>(p)].leaves[index], along_of(a));
    }
    rate = rates.leaf(part.leaf, along_leaf(part, along_of(a)), wire ? 0.5 : across_of(b),
                      along_rates);
    return rate;
  };
  if (wire && kind == 0) return mid(i, 0);
  const auto mid_place = [&](int a, int b) -> Vector3d {
    if (wire) return solid.nodes[static_cast<std::size_t>(a)];
    const auto k = static_cast<std::size_t>(mid_index(a, b));
    return 0.5 * (solid.nodes[k] + solid.nodes[surface_size + k]);
  };
  const MatrixXd none = MatrixXd::Zero(3, count);
  const Vector3d along = station_slope(along_intervals, i, Vector3d(Vector3d::Zero()),
                                       [&](int k) { return mid_place(k, j); });
  const MatrixXd along_rate =
      station_slope(along_intervals, i, none, [&](int k) -> const MatrixXd& { return mid(k, j); });
  const double half = half_of(leaf, along_leaf(part, along_of(i)));
  const auto half_rate = [&](Eigen::Index p) {
    return half_rate_of(leaf, directions[static_cast<std::size_t>(p)].leaves[index],
                        along_leaf(part, along_of(i)));
  };
  MatrixXd result(3, count);
  if (wire) {
    const WireAxes s = wire_section(along, solid.reference);
    for (Eigen::Index p = 0; p < count; ++p) {
      const WireAxes ds = wire_section_rate(along, solid.reference, along_rate.col(p));
      result.col(p) = kind == 1 ? Vector3d(half_rate(p) * s.n + half * ds.n)
                                : Vector3d(half_rate(p) * s.b + half * ds.b);
    }
    return result;
  }
  const Vector3d across = station_slope(across_intervals, j, Vector3d(Vector3d::Zero()),
                                        [&](int k) { return mid_place(i, k); });
  const MatrixXd across_rate =
      station_slope(across_intervals, j, none, [&](int k) -> const MatrixXd& { return mid(i, k); });
  const Vector3d v = along.cross(across), n = v.normalized();
  const double side = kind == 0 ? -1 : 1;
  for (Eigen::Index p = 0; p < count; ++p) {
    const Vector3d da = along_rate.col(p), dc = across_rate.col(p);
    result.col(p) =
        Vector3d(mid(i, j).col(p)) +
        side * (half_rate(p) * n + half * unit_rate(v, da.cross(across) + along.cross(dc)));
  }
  return result;
}

MatrixXd Solids::sum_of_rates(int solid, const std::vector<std::pair<int, double>>& weights,
                              const PlaceRates& rates) const {
  std::map<int, MatrixXd> known;
  MatrixXd result = MatrixXd::Zero(3, static_cast<Eigen::Index>(rates.directions->size()));
  for (const auto& [node, weight] : weights)
    if (weight != 0)
      result += weight * node_rates(solids_[static_cast<std::size_t>(solid)], node, rates, known);
  return result;
}

MatrixXd Solids::place_rates(const SolidPoint& point, const PlaceRates& rates) const {
  std::vector<std::pair<int, double>> values;
  for (const Weight& w : weights(point)) values.push_back({w.node, w.value});
  return sum_of_rates(point.solid, values, rates);
}

MatrixXd Solids::slope_rates(const SolidPoint& point, const PlaceRates& rates) const {
  std::vector<std::pair<int, double>> values;
  for (const Weight& w : weights(point)) values.push_back({w.node, w.slope[0]});
  return sum_of_rates(point.solid, values, rates);
}

namespace {
/// Place of the middle line in leaf axes over the length, and its rate with the angle of the arc.
struct MiddlePlace {
  Vector3d place, rate, slope;
};
MiddlePlace middle_place(const LeafSpring& leaf, const LeafSpring& direction, double along) {
  if (leaf.fold && along > leaf.fold->place) {
    const LeafFold rate = direction.fold.value_or(LeafFold{});
    const ArcPoint<Dual1> leg = leg_point<Dual1>({leaf.fold->place, {rate.place}},
                                                 {leaf.fold->angle, {rate.angle}}, Dual1(along));
    return {{leg.x.value, 0, leg.z.value},
            {leg.x.derivatives[0], 0, leg.z.derivatives[0]},
            {leg.cosine.value, 0, leg.sine.value}};
  }
  if (!leaf.curve) return {along * Vector3d::UnitX(), Vector3d::Zero(), Vector3d::UnitX()};
  const ArcPoint<Dual1> arc =
      arc_point(Dual1(*leaf.curve, {direction.curve.value_or(0)}), Dual1(along));
  return {{arc.x.value, 0, arc.z.value},
          {arc.x.derivatives[0], 0, arc.z.derivatives[0]},
          {arc.cosine.value, 0, arc.sine.value}};
}
}  // namespace

Vector3d undeflected_place(const LeafSpring& leaf, double along, double across) {
  return leaf.origin + leaf.axes * (middle_place(leaf, leaf, along).place * leaf.length) +
         leaf.axes.col(1) * ((across - 0.5) * leaf.width * profile_at(leaf.width_profile, along));
}

Vector3d undeflected_place_rate(const LeafSpring& leaf, const LeafSpring& direction, double along,
                                double across, double along_rate) {
  const double width = leaf.width * profile_at(leaf.width_profile, along),
               width_rate = direction.width * profile_at(leaf.width_profile, along) +
                            leaf.width * profile_rate(direction.width_profile, along);
  const auto [place, held, slope] = middle_place(leaf, direction, along);
  const Vector3d rate = held + along_rate * slope;
  return direction.origin + direction.axes * (place * leaf.length) +
         leaf.axes * (place * direction.length + rate * leaf.length) +
         direction.axes.col(1) * ((across - 0.5) * width) +
         leaf.axes.col(1) * ((across - 0.5) * width_rate);
}

PlaceRates undeflected_rates(const Mechanism& mechanism, const std::vector<Mechanism>& directions) {
  PlaceRates rates;
  rates.directions = &directions;
  const auto count = static_cast<Eigen::Index>(directions.size());
  rates.leaf = [&mechanism, &directions, count](int leaf, double along, double across,
                                                const VectorXd& along_rates) {
    MatrixXd result(3, count);
    const auto i = static_cast<std::size_t>(leaf);
    for (Eigen::Index p = 0; p < count; ++p)
      result.col(p) = undeflected_place_rate(
          mechanism.leaves[i], directions[static_cast<std::size_t>(p)].leaves[i], along, across,
          along_rates.size() > 0 ? along_rates[p] : 0);
    return result;
  };
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    BodyPlaceRate rate{MatrixXd(3, count), MatrixXd::Zero(3, count)};
    for (Eigen::Index p = 0; p < count; ++p)
      rate.position.col(p) = directions[static_cast<std::size_t>(p)].bodies[b].reference;
    rates.bodies.push_back(std::move(rate));
  }
  return rates;
}

}  // namespace flexopt
