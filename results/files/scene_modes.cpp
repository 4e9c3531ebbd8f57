#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "results/files/scene.hpp"

namespace flexopt {

namespace {

constexpr double full_scale = 32767;

/// Motion of all mesh points and of the bodies, the largest of the points one.
struct Shape {
  VectorXd points, bodies;
};

/// Whether every leaf's motion is known, or follows from that of its two edges.
bool tells_all(const Mechanism& mechanism, const Mode& mode) {
  for (std::size_t k = 0; k < mode.leaf_motion.size(); ++k)
    if (mode.leaf_motion[k].size() == 0 && mechanism.leaves[k].tip == free_edge) return false;
  return true;
}

Shape shape_of(const Mode& mode, const Mechanism& mechanism, const PathPoint& point,
               std::size_t points) {
  Shape shape{VectorXd::Zero(static_cast<Eigen::Index>(3 * points)), mode.body_motion};
  Eigen::Index begin = 0;
  for (std::size_t k = 0; k < mode.leaf_motion.size(); ++k) {
    const VectorXd own = mode.leaf_motion[k].size() > 0
                             ? mode.leaf_motion[k]
                             : cubic_leaf_motion(mechanism, k, point, mode.body_motion);
    if (begin + own.size() > shape.points.size()) break;
    shape.points.segment(begin, own.size()) = own;
    begin += own.size();
  }
  double largest = 0;
  for (Eigen::Index i = 0; i + 2 < shape.points.size(); i += 3)
    largest = std::max(largest, shape.points.segment<3>(i).norm());
  if (largest > 0) {
    shape.points /= largest;
    shape.bodies /= largest;
  }
  return shape;
}

constexpr double least_likeness = 0.3;

double likeness(const VectorXd& a, const VectorXd& b) {
  const Eigen::Index rows = std::min(a.size(), b.size());
  const double size = a.head(rows).squaredNorm() * b.head(rows).squaredNorm();
  if (size <= 0) return 0;
  const double product = a.head(rows).dot(b.head(rows));
  return product * product / size;
}

struct Pair {
  double likeness;
  std::size_t before, now;
};

}  // namespace

std::vector<double> places_along(const LeafShape& shape) {
  std::vector<double> places{0};
  for (int i = 1; i < shape.points_along; ++i)
    places.push_back(places.back() + (shape.undeflected[static_cast<std::size_t>(i)] -
                                      shape.undeflected[static_cast<std::size_t>(i - 1)])
                                         .norm());
  for (double& s : places) s /= std::max(places.back(), 1e-300);
  return places;
}

VectorXd cubic_leaf_motion(const Mechanism& mechanism, std::size_t leaf, const PathPoint& point,
                           const VectorXd& body_motion) {
  const LeafShape& shape = point.shapes[leaf];
  const LeafSpring& of = mechanism.leaves[leaf];
  const int along = shape.points_along, across = shape.points_across;
  const auto at = [&](int i, int j) -> const Vector3d& { return shape.deflected[j * along + i]; };
  struct Edge {
    Vector3d shift = Vector3d::Zero(), spin = Vector3d::Zero(), reference = Vector3d::Zero();
  };
  const auto edge = [&](int body) {
    if (body < 0) return Edge{};
    return Edge{body_motion.segment<3>(6 * body), body_motion.segment<3>(6 * body + 3),
                mechanism.bodies[static_cast<std::size_t>(body)].reference +
                    point.bodies[static_cast<std::size_t>(body)].displacement};
  };
  const Edge base = edge(of.base), tip = edge(of.tip == free_edge ? of.base : of.tip);
  VectorXd motion(3 * along * across);
  const std::vector<double> places = places_along(shape);
  for (int j = 0; j < across; ++j) {
    const Vector3d &first = at(0, j), &last = at(along - 1, j);
    const Vector3d u0 = base.shift + base.spin.cross(first - base.reference),
                   u1 = tip.shift + tip.spin.cross(last - tip.reference),
                   w0 = base.spin.cross(Vector3d(last - first)),
                   w1 = tip.spin.cross(Vector3d(last - first));
    for (int i = 0; i < along; ++i) {
      const double s = places[static_cast<std::size_t>(i)], r = 1 - s;
      motion.segment<3>(3 * (j * along + i)) =
          (1 + 2 * s) * r * r * u0 + s * s * (3 - 2 * s) * u1 + s * r * r * w0 - s * s * r * w1;
    }
  }
  return motion;
}

OrderedJson modes_json(const Mechanism& mechanism, const std::vector<PathPoint>& path,
                       const std::vector<std::size_t>& frames, std::size_t points) {
  std::size_t locked = 0, free = 0;
  for (const std::size_t f : frames) {
    locked = std::max(locked, path[f].modes_locked.size());
    free = std::max(free, path[f].modes_free.size());
  }
  const std::size_t bodies = mechanism.bodies.size(), modes = locked + free;
  std::vector<std::int16_t> leaf_values;
  std::vector<float> body_values;
  std::vector<VectorXd> before(modes);
  bool any = false;
  for (const std::size_t f : frames)
    for (std::size_t m = 0; m < modes; ++m) {
      const std::vector<Mode>& list = m < locked ? path[f].modes_locked : path[f].modes_free;
      const std::size_t k = m < locked ? m : m - locked;
      Shape shape{VectorXd::Zero(static_cast<Eigen::Index>(3 * points)),
                  VectorXd::Zero(static_cast<Eigen::Index>(6 * bodies))};
      if (k < list.size() && list[k].body_motion.size() == shape.bodies.size() &&
          tells_all(mechanism, list[k])) {
        shape = shape_of(list[k], mechanism, path[f], points);
        any = true;
      }
      if (before[m].size() > 0 && before[m].dot(shape.points) < 0) {
        shape.points *= -1;
        shape.bodies *= -1;
      }
      for (const double x : shape.points)
        leaf_values.push_back(static_cast<std::int16_t>(std::lround(full_scale * x)));
      for (const double x : shape.bodies) body_values.push_back(static_cast<float>(x));
      before[m] = std::move(shape.points);
    }
  if (!any) return nullptr;
  return {{"frames", frames},
          {"locked", locked},
          {"free", free},
          {"leaves", packed_rows(leaf_values, {frames.size(), modes, points, 3})},
          {"bodies", packed_floats(body_values, {frames.size(), modes, bodies, 6})}};
}

std::vector<std::vector<int>> mode_branches(const std::vector<PathPoint>& path, DriveState drive) {
  std::vector<std::vector<int>> branches(path.size());
  const std::vector<Mode>* before = nullptr;
  const std::vector<int>* known = nullptr;
  int count = 0;
  for (std::size_t p = 0; p < path.size(); ++p) {
    const std::vector<Mode>& now =
        drive == DriveState::locked ? path[p].modes_locked : path[p].modes_free;
    if (now.empty()) continue;
    std::vector<int>& own = branches[p];
    own.assign(now.size(), -1);
    std::vector<Pair> pairs;
    for (std::size_t i = 0; before && i < before->size(); ++i)
      for (std::size_t k = 0; k < now.size(); ++k)
        if (const double c = likeness((*before)[i].motion, now[k].motion); c > least_likeness)
          pairs.push_back({c, i, k});
    std::ranges::stable_sort(pairs, std::greater<>(), &Pair::likeness);
    std::vector<bool> taken(before ? before->size() : 0, false);
    for (const Pair& pair : pairs)
      if (own[pair.now] < 0 && !taken[pair.before]) {
        own[pair.now] = (*known)[pair.before];
        taken[pair.before] = true;
      }
    for (int& branch : own)
      if (branch < 0) branch = count++;
    before = &now;
    known = &own;
  }
  return branches;
}

}  // namespace flexopt
