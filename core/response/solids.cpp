#include "core/response/solids.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/mechanism/profile.hpp"
#include "core/response/solid_stations.hpp"

namespace flexopt {

std::vector<SolidPart> solid_parts(const Mechanism& mechanism) {
  std::vector<SolidPart> parts;
  for (int i = 0; i < static_cast<int>(mechanism.leaves.size()); ++i) {
    const auto& fold = mechanism.leaves[i].fold;
    parts.push_back({.leaf = i, .end = fold ? fold->place : 1});
    if (fold) parts.push_back({.leaf = i, .begin = fold->place});
  }
  for (int b = 0; b < static_cast<int>(mechanism.bodies.size()); ++b)
    if (mechanism.bodies[b].box) parts.push_back({.body = b});
  return parts;
}

Solids::Solids(const Mechanism& mechanism, const LeafPlaces& places,
               const std::vector<JointBody>& bodies)
    : mechanism_(&mechanism) {
  for (const SolidPart& part : solid_parts(mechanism))
    if (part.leaf >= 0)
      add_leaf(part, places);
    else
      add_box(part, bodies[part.body]);
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
  const LeafSpring& spring = mechanism_->leaves[leaf];
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
                                       [&](int k) { return line[k]; });
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
      const auto at = [&](int a, int b) { return mid[mid_index(a, b)]; };
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

void Solids::add_box(const SolidPart& part, const JointBody& place) {
  const RigidBody& of = mechanism_->bodies[part.body];
  Solid& solid = solids_.emplace_back();
  solid.part = part;
  solid.rotation = place.rotation;
  solid.nodes.push_back(place.position + place.rotation * (of.box->center - of.reference));
  for (int k = 0; k < 3; ++k) solid.nodes.push_back(place.rotation * of.box->half_edges.col(k));
}

Solids Solids::undeflected(const Mechanism& mechanism) {
  return {mechanism,
          [&](int leaf, const std::vector<std::array<double, 2>>& points) {
            std::vector<Vector3d> places;
            for (const auto& [along, across] : points)
              places.push_back(undeflected_place(mechanism.leaves[leaf], along, across));
            return places;
          },
          undeflected_bodies(mechanism)};
}

const std::string& Solids::name(int solid) const {
  return is_leaf(solid) ? leaf_of(solid).name : mechanism_->bodies[body_of_box(solid)].name;
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
  list.reserve(32);
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
  const Solid& solid = solids_[point.solid];
  Local local;
  local.curvatures.fill(Vector3d::Zero());
  for (const Weight& w : weights(point)) {
    const Vector3d& node = solid.nodes[w.node];
    local.place += w.value * node;
    local.slopes += node * w.slope.transpose();
    for (std::size_t k = 0; k < 6; ++k) local.curvatures[k] += w.curvature[k] * node;
  }
  return local;
}

std::vector<Solids::Sample> Solids::inner_samples(int solid) const {
  std::vector<Sample> samples;
  const std::vector<Vector3d>& nodes = solids_[solid].nodes;
  if (!is_leaf(solid)) return surface_samples(solid).samples;
  for (int i = 0; i < stations_along; i += sample_step) {
    if (is_wire(solid)) {
      samples.push_back({{along_of(i), 0, 0}, nodes[i]});
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

Solids::SampleGrid Solids::surface_samples(int solid) const {
  SampleGrid grid;
  const std::vector<Vector3d>& nodes = solids_[solid].nodes;
  const auto add = [&](const Vector3d& u) { grid.samples.push_back({u, place({solid, u})}); };
  if (!is_leaf(solid)) {
    grid.counts = {3, 3, 3};
    grid.steps = {1, 1, 1};
    for (const double z : {-1, 0, 1})
      for (const double y : {-1, 0, 1})
        for (const double x : {-1, 0, 1}) add({x, y, z});
  } else if (is_wire(solid)) {
    grid.counts = {1, stations_along, 4};
    grid.steps = {1.0 / along_intervals, 0.5 * std::numbers::pi, 0};
    for (int i = 0; i < stations_along; ++i)
      for (int k = 0; k < 4; ++k) add({along_of(i), 0.5 * std::numbers::pi * k, 1});
  } else {
    grid.counts = {2, stations_along, stations_across};
    grid.steps = {1.0 / along_intervals, 1.0 / across_intervals, 2};
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < stations_along; ++i)
        for (int j = 0; j < stations_across; ++j)
          grid.samples.push_back({{along_of(i), across_of(j), 2.0 * side - 1},
                                  nodes[side * surface_size + mid_index(i, j)]});
  }
  return grid;
}

}  // namespace flexopt
