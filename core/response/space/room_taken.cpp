#include "core/response/space/room_taken.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/math/rotation.hpp"
#include "core/mechanism/profile.hpp"
#include "core/response/space/minimise.hpp"

namespace flexopt {
namespace {

constexpr double equal = 1e-9;  // relative: of two that are nearer to each other the first counts

int symmetric_index(int i, int j) {
  if (i > j) std::swap(i, j);
  return i == 0 ? j : i == 1 ? 2 + j : 5;
}

// The point of a solid, from a start, that makes a function of its place least. `f` adds value,
// derivative and second derivative of the function to its arguments.
template <class F>
SolidPoint least_point(const Solids& solids, const SolidPoint& start, const F& f) {
  const int solid = start.solid;
  const VectorXd u = local_minimum(
      [&](const VectorXd& at) {
        const Solids::Local here = solids.local({solid, at});
        LocalValue result;
        Vector3d slope;
        Matrix3d curvature;
        f(here.place, result.value, slope, curvature);
        result.gradient = here.slopes.transpose() * slope;
        result.curvature = here.slopes.transpose() * curvature * here.slopes;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            result.curvature(i, j) +=
                slope.dot(here.curvatures[static_cast<std::size_t>(symmetric_index(i, j))]);
        return result;
      },
      solids.lower(solid), solids.upper(solid), start.at);
  return {solid, u};
}

// Of the solids whose bound lets them reach further than those before, the point that reaches
// furthest. `reach` of a place; `bound` of a solid; `f` as in least_point, of the negative reach.
using SamplesOfSolids = std::vector<std::vector<Solids::Sample>>;
template <class Reach, class Bound, class F>
SolidPoint furthest(const Solids& solids, const SamplesOfSolids& samples, double size,
                    const Reach& reach, const Bound& bound, const F& f) {
  SolidPoint best;
  double most = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < solids.count(); ++i) {
    if (best.solid >= 0 && bound(i) <= most + equal * size) continue;
    SolidPoint start{i};
    double of_sample = -std::numeric_limits<double>::infinity();
    for (const Solids::Sample& sample : samples[static_cast<std::size_t>(i)])
      if (const double here = reach(sample.place); here > of_sample)
        of_sample = here, start.at = sample.at;
    const SolidPoint point = least_point(solids, start, f);
    const double here = reach(solids.place(point));
    if (best.solid < 0 || here > most + equal * size) most = here, best = point;
  }
  return best;
}

Vector3d off_axis(const CylinderAxis& axis, const Vector3d& place) {
  const Vector3d from = place - axis.through;
  return from - axis.along * axis.along.dot(from);
}

double size_of(const Mechanism& mechanism) {
  double size = 0;
  for (const LeafSpring& leaf : mechanism.leaves) size = std::max(size, leaf.length);
  return size;
}

const Drive* turning_drive(const Mechanism& mechanism) {
  for (const Drive& drive : mechanism.drives)
    if (is_rotation(drive.direction)) return &drive;
  return nullptr;
}

}  // namespace

CylinderAxis cylinder_axis(const Mechanism& mechanism) {
  CylinderAxis axis;
  axis.through = mechanism.bodies[static_cast<std::size_t>(mechanism.end_effector)].reference;
  if (const Drive* drive = turning_drive(mechanism))
    axis.along = drive->axes.col(index(drive->direction) - 3);
  return axis;
}

Extents extents_of(const Solids& solids) {
  Extents extents;
  const double size = size_of(solids.mechanism());
  SamplesOfSolids samples;
  for (int i = 0; i < solids.count(); ++i) samples.push_back(solids.surface_samples(i));
  for (int side = 0; side < 2; ++side)
    for (int k = 0; k < 3; ++k) {
      const double sign = side == 0 ? -1 : 1;
      SolidPoint& at = extents.at[static_cast<std::size_t>(3 * side + k)];
      at = furthest(
          solids, samples, size, [&](const Vector3d& place) { return sign * place[k]; },
          [&](int i) { return side == 0 ? -solids.lowest(i)[k] : solids.highest(i)[k]; },
          [&](const Vector3d& place, double& value, Vector3d& slope, Matrix3d& curvature) {
            value = -sign * place[k];
            slope = -sign * Vector3d::Unit(k);
            curvature.setZero();
          });
      (side == 0 ? extents.low : extents.high)[k] = solids.place(at)[k];
    }
  const CylinderAxis axis = cylinder_axis(solids.mechanism());
  const Matrix3d across = Matrix3d::Identity() - axis.along * axis.along.transpose();
  extents.at[6] = furthest(
      solids, samples, size, [&](const Vector3d& place) { return off_axis(axis, place).norm(); },
      [&](int i) {
        double most = 0;
        for (int k = 0; k < 8; ++k) {
          Vector3d corner;
          for (int d = 0; d < 3; ++d)
            corner[d] = (k >> d & 1) != 0 ? solids.highest(i)[d] : solids.lowest(i)[d];
          most = std::max(most, off_axis(axis, corner).norm());
        }
        return most;
      },
      [&](const Vector3d& place, double& value, Vector3d& slope, Matrix3d& curvature) {
        const Vector3d r = off_axis(axis, place) / size;
        value = -0.5 * r.squaredNorm();
        slope = -r / size;
        curvature = -across / (size * size);
      });
  extents.radius = off_axis(axis, solids.place(extents.at[6])).norm();
  return extents;
}

MatrixXd extent_rates(const Solids& solids, const Extents& extents, const PlaceRates& rates) {
  const auto count = static_cast<Eigen::Index>(rates.directions->size());
  MatrixXd result(7, count);
  for (int k = 0; k < 6; ++k)
    result.row(k) = solids.place_rates(extents.at[static_cast<std::size_t>(k)], rates).row(k % 3);
  const Mechanism& mechanism = solids.mechanism();
  const CylinderAxis axis = cylinder_axis(mechanism);
  const Vector3d place = solids.place(extents.at[6]), r = off_axis(axis, place),
                 away = r.norm() > 0 ? Vector3d(r.normalized()) : Vector3d(Vector3d::Zero());
  const MatrixXd moves = solids.place_rates(extents.at[6], rates);
  for (Eigen::Index p = 0; p < count; ++p) {
    const Mechanism& d = (*rates.directions)[static_cast<std::size_t>(p)];
    const Vector3d through = d.bodies[static_cast<std::size_t>(mechanism.end_effector)].reference;
    Vector3d turns = Vector3d::Zero();
    if (const Drive* drive = turning_drive(mechanism)) {
      const auto i = static_cast<std::size_t>(drive - mechanism.drives.data());
      turns = d.drives[i].axes.col(index(drive->direction) - 3);
    }
    result(6, p) = away.dot(Vector3d(moves.col(p)) - through) -
                   axis.along.dot(place - axis.through) * away.dot(turns);
  }
  return result;
}

namespace {

// The states that reach furthest: low x, y, z, high x, y, z, radius.
std::array<std::size_t, 7> furthest_states(const std::vector<const Extents*>& states) {
  std::array<std::size_t, 7> of{};
  for (std::size_t i = 1; i < states.size(); ++i) {
    const auto further = [&](std::size_t k, double a, double b) {
      if (a > b + equal * std::abs(b)) of[k] = i;
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      further(k, -states[i]->low[axis], -states[of[k]]->low[axis]);
      further(3 + k, states[i]->high[axis], states[of[3 + k]]->high[axis]);
    }
    further(6, states[i]->radius, states[of[6]]->radius);
  }
  return of;
}

}  // namespace

Envelope envelope_of(const std::vector<const Extents*>& states) {
  const auto of = furthest_states(states);
  Envelope envelope;
  for (int k = 0; k < 3; ++k)
    envelope.box[k] = states[of[static_cast<std::size_t>(3 + k)]]->high[k] -
                      states[of[static_cast<std::size_t>(k)]]->low[k];
  envelope.cylinder = 2 * states[of[6]]->radius;
  return envelope;
}

MatrixXd envelope_rates(const std::vector<const Extents*>& states,
                        const std::vector<const MatrixXd*>& rates) {
  const auto of = furthest_states(states);
  MatrixXd result(4, rates.front()->cols());
  for (int k = 0; k < 3; ++k)
    result.row(k) = rates[of[static_cast<std::size_t>(3 + k)]]->row(3 + k) -
                    rates[of[static_cast<std::size_t>(k)]]->row(k);
  result.row(3) = 2 * rates[of[6]]->row(6);
  return result;
}

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

// Whether two leaves are one piece at an edge: folds and hubs, where their edges meet on one body,
// and the halves of a leaf on both sides of a rigid middle.
bool joined(const Mechanism& mechanism, const SolidPart& part_a, const SolidPart& part_b) {
  if (part_a.leaf == part_b.leaf) return true;  // legs of one leaf
  const LeafSpring &a = mechanism.leaves[static_cast<std::size_t>(part_a.leaf)],
                   &b = mechanism.leaves[static_cast<std::size_t>(part_b.leaf)];
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

std::vector<std::array<int, 2>> clearance_pairs(const Mechanism& mechanism) {
  std::vector<std::array<int, 2>> pairs;
  const std::vector<SolidPart> parts = solid_parts(mechanism);
  for (std::size_t i = 0; i < parts.size() && parts[i].leaf >= 0; ++i) {
    const LeafSpring& leaf = mechanism.leaves[static_cast<std::size_t>(parts[i].leaf)];
    for (std::size_t j = i + 1; j < parts.size(); ++j) {
      const bool held = leaf.base == parts[j].body || leaf.tip == parts[j].body;
      if (parts[j].leaf >= 0 ? !joined(mechanism, parts[i], parts[j]) : !held)
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

// Two points of a pair, six coordinates.
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
    const int solid = start[static_cast<std::size_t>(side)].solid;
    lower.segment<3>(3 * side) = solids.lower(solid);
    upper.segment<3>(3 * side) = solids.upper(solid);
    u.segment<3>(3 * side) = start[static_cast<std::size_t>(side)].at;
    if (!inside) continue;
    lower[3 * side + 2] = upper[3 * side + 2] = 0;
    if (solids.is_wire(solid)) lower[3 * side + 1] = upper[3 * side + 1] = 0;
  }
  u = local_minimum([&](const VectorXd& at) { return half_square(solids, start, at, size); }, lower,
                    upper, u);
  return {SolidPoint{start[0].solid, u.head<3>()}, SolidPoint{start[1].solid, u.tail<3>()}};
}

// The side of a wire that looks at a place.
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
      Start& best = nearest[static_cast<std::size_t>(row + stretch(y, leaf_b))];
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

// Of leaves that overlap: how far their middle surfaces are apart, less than both halves of the
// thickness.
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
    if (!best || here.value < best->value - equal * size) best = here;
  }
  return best->value < equal * size ? overlap_of(solids, best->at, size) : *best;
}

}  // namespace

std::optional<Clearance> clearance_of(const Solids& solids,
                                      const std::vector<std::array<int, 2>>& pairs) {
  if (pairs.empty()) return std::nullopt;
  const double size = size_of(solids.mechanism());
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
    // of equal ones the first pair
    const double tolerance = equal * size * (k < at ? -1 : 1);
    if (!best || here.value < best->value - tolerance) best = here, at = k;
  }
  for (std::size_t k = 0; k < 2; ++k) best->names[k] = solids.name(best->at[k].solid);
  return best;
}

VectorXd clearance_rate(const Solids& solids, const Clearance& clearance, const PlaceRates& rates) {
  const std::vector<Mechanism>& directions = *rates.directions;
  VectorXd rate = VectorXd::Zero(static_cast<Eigen::Index>(directions.size()));
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
        rate[k] -=
            solids.half_thickness_rate(p.solid, p.at[0], directions[static_cast<std::size_t>(k)]);
  return rate;
}

namespace {

struct MassStation {
  double along, weight;
};

// Gauss's rule in equal pieces: exact for products of profiles.
std::vector<MassStation> mass_stations(const LeafSpring& leaf) {
  constexpr std::array<double, 3> x{0.2386191860831969, 0.6612093864662645, 0.9324695142031521},
      w{0.4679139345726910, 0.3607615730481386, 0.1713244923791704};
  const bool smooth = leaf.width_profile.size() <= 2 && leaf.thickness_profile.size() <= 2;
  const int pieces = smooth ? 4 : profile_pieces;
  std::vector<MassStation> stations;
  for (int i = 0; i < pieces; ++i)
    for (std::size_t k = 0; k < x.size(); ++k)
      for (const double side : {-1.0, 1.0})
        stations.push_back({(i + 0.5 * (1 + side * x[k])) / pieces, 0.5 * w[k] / pieces});
  return stations;
}

// Mass of a leaf; its rates along the directions are added to `sum`.
double mass_of_leaf(const Mechanism& mechanism, std::size_t i,
                    const std::vector<Mechanism>& directions, VectorXd* sum) {
  const LeafSpring& leaf = mechanism.leaves[i];
  const bool wire = leaf.section == Section::circular;
  const double shape = wire ? std::numbers::pi / 4 : 1.0;
  const std::vector<double>& across = wire ? leaf.thickness_profile : leaf.width_profile;
  const double reference = wire ? leaf.thickness : leaf.width;
  const auto rate_of = [](const std::vector<double>& profile, double s) {
    return profile.empty() ? 0 : profile_at(profile, s);
  };
  double mass = 0;
  for (const MassStation& at : mass_stations(leaf)) {
    const double length = leaf.length, pw = profile_at(across, at.along),
                 pt = profile_at(leaf.thickness_profile, at.along), width = reference * pw,
                 thickness = leaf.thickness * pt, share = shape * at.weight * leaf.material.density;
    mass += share * width * thickness * length;
    for (std::size_t p = 0; p < directions.size(); ++p) {
      const LeafSpring& d = directions[p].leaves[i];
      const double dw = (wire ? d.thickness : d.width) * pw +
                        reference * rate_of(wire ? d.thickness_profile : d.width_profile, at.along),
                   dt = d.thickness * pt + leaf.thickness * rate_of(d.thickness_profile, at.along),
                   dl = d.length;
      (*sum)[static_cast<Eigen::Index>(p)] +=
          share * (dw * thickness * length + width * dt * length + width * thickness * dl) +
          shape * at.weight * d.material.density * width * thickness * length;
    }
  }
  return mass;
}

}  // namespace

double leaf_mass(const Mechanism& mechanism) {
  double mass = 0;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    mass += mass_of_leaf(mechanism, i, {}, nullptr);
  return mass;
}

VectorXd leaf_mass_rate(const Mechanism& mechanism, const std::vector<Mechanism>& directions) {
  VectorXd sum = VectorXd::Zero(static_cast<Eigen::Index>(directions.size()));
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    mass_of_leaf(mechanism, i, directions, &sum);
  return sum;
}

}  // namespace flexopt
