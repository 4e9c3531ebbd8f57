#include "core/mechanism/mechanism.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/math/decompositions.hpp"
#include "core/mechanism/drive.hpp"
#include "core/mechanism/fold_corner.hpp"
#include "core/mechanism/joint.hpp"
#include "core/mechanism/leaf_in_solid.hpp"
#include "core/mechanism/loose_direction.hpp"
#include "core/mechanism/profile.hpp"
#include "core/mechanism/spring.hpp"

namespace flexopt {
namespace {

/// A leaf, or a piece of it, as the box it fills, as wide and thick as the piece is anywhere.
struct Box {
  Vector3d middle, half;  ///< half sizes along the axes [m]
  Matrix3d axes;
  double sheet;  ///< half its height were it almost without thickness [m]
};

/// Bounding boxes of a leaf from base to tip: one for a flat leaf or leg, one for every few degrees
/// of an arc, one for every piece of a profile.
std::vector<Box> boxes_of(const LeafSpring& leaf) {
  constexpr double degrees = 4 * std::numbers::pi / 180;
  if (leaf.fold) {
    LeafSpring legs[2]{leaf, leaf};
    for (LeafSpring& leg : legs) leg.fold.reset();
    legs[0].length = leaf.length * leaf.fold->place;
    legs[1].length = leaf.length - legs[0].length;
    legs[1].origin = legs[0].tip_middle();
    legs[1].axes = leaf.edge_axes(1);
    return {boxes_of(legs[0]).front(), boxes_of(legs[1]).front()};
  }
  const int pieces =
      std::max(leaf.has_profile() ? profile_pieces : 1,
               static_cast<int>(std::ceil(std::abs(leaf.curve.value_or(0)) / degrees)));
  const auto largest = [&](const std::vector<double>& profile, int piece) {
    constexpr int parts = 4;
    double most = 0;
    for (int j = 0; j <= parts; ++j)
      most = std::max(most, profile_at(profile, (piece + static_cast<double>(j) / parts) / pieces));
    return most;
  };
  std::vector<Box> boxes;
  for (int k = 0; k < pieces; ++k) {
    const double w = leaf.width * largest(leaf.width_profile, k),
                 t = leaf.thickness * largest(leaf.thickness_profile, k);
    const auto at = [&](double s) {
      const ArcPoint<double> p = leaf.middle((k + s) / pieces);
      return Vector3d(leaf.length * Vector3d(p.x, 0, p.z));
    };
    const Vector3d start = at(0), end = at(1), middle = at(0.5);
    const Matrix3d turn = leaf.middle((k + 0.5) / pieces).axes();
    const double rise = (middle - 0.5 * (start + end)).norm();
    boxes.push_back({leaf.origin + leaf.axes * (0.25 * (start + end) + 0.5 * middle),
                     0.5 * Vector3d((end - start).norm(), w, t + rise), leaf.axes * turn,
                     5e-4 * leaf.thickness + 0.5 * rise});
  }
  return boxes;
}

/// Whether two boxes share volume: no plane separates them. The normals to try are the faces' and
/// the cross products of the edges (separating axis theorem). Boxes that only touch are apart.
bool intersect(const Box& a, const Box& b) {
  const Vector3d apart = b.middle - a.middle;
  const double touching = 1e-9 * (a.half.norm() + b.half.norm());
  const auto separates = [&](const Vector3d& normal) {
    const double length = normal.norm();
    if (length < 1e-6) return false;  // parallel edges: the faces' normals decide
    const double reach = (a.axes.transpose() * normal).cwiseAbs().dot(a.half) +
                         (b.axes.transpose() * normal).cwiseAbs().dot(b.half);
    return std::abs(apart.dot(normal)) > reach - touching * length;
  };
  for (int i = 0; i < 3; ++i) {
    if (separates(a.axes.col(i)) || separates(b.axes.col(i))) return false;
    for (int j = 0; j < 3; ++j)
      if (separates(a.axes.col(i).cross(b.axes.col(j)))) return false;
  }
  return true;
}

/// Whether two clamped edges lie on one line, a fold or leaves that meet in a hub, or have their
/// middles at one place of one body, as the links of a chain.
bool meet(const LeafSpring& a, bool a_tip, const LeafSpring& b, bool b_tip) {
  const Vector3d line = a.axes.col(1), other = b.axes.col(1),
                 between =
                     (b_tip ? b.tip_middle() : b.origin) - (a_tip ? a.tip_middle() : a.origin);
  const double near = 1e-6 * (a.length + b.length);
  const int body = a_tip ? a.tip : a.base;
  return (line.cross(other).norm() < 1e-6 && line.cross(between).norm() < near) ||
         (body != free_edge && body == (b_tip ? b.tip : b.base) && between.norm() < near);
}

/// Thins a leaf to a sheet, and shortens it at an edge: by a part of its thickness, and by what
/// lies beyond the plane through the edge's middle with this normal, at most `most`.
void draw_back(std::vector<Box>& boxes, const LeafSpring& leaf, bool tip, const Vector3d& normal,
               double most) {
  const auto end = [&]() -> Box& { return tip ? boxes.back() : boxes.front(); };
  const Vector3d beyond = end().axes.transpose() * normal;
  double step = std::min(most, end().half[1] * std::abs(beyond[1] / beyond[0])) +
                std::min(0.1 * leaf.thickness, 0.2 * end().half[0]);
  for (; step > 2 * end().half[0]; boxes.erase(tip ? boxes.end() - 1 : boxes.begin()))
    step -= 2 * end().half[0];
  end().half[0] -= 0.5 * step;
  end().middle += (tip ? -0.5 : 0.5) * step * end().axes.col(0);
  for (Box& each : boxes) each.half[2] = std::min(each.half[2], each.sheet);
}

/// Leaves that meet at their edges touch there with their thickness and overlap in a wedge, and
/// may: they are then tried as thin sheets that end before the plane that halves their angle. The
/// wedge takes at most a quarter of the shorter one.
bool intersect(const LeafSpring& a, const LeafSpring& b) {
  std::vector<Box> boxes_a = boxes_of(a), boxes_b = boxes_of(b);
  for (const bool a_tip : {false, true})
    for (const bool b_tip : {false, true})
      if (meet(a, a_tip, b, b_tip)) {
        const Vector3d normal = (a_tip ? -1 : 1) * a.edge_axes(a_tip).col(0) -
                                (b_tip ? -1 : 1) * b.edge_axes(b_tip).col(0);
        const double most = 0.25 * std::min(a.length, b.length);
        draw_back(boxes_a, a, a_tip, normal, most);
        draw_back(boxes_b, b, b_tip, normal, most);
      }
  for (const Box& box_a : boxes_a)
    for (const Box& box_b : boxes_b)
      if (intersect(box_a, box_b)) return true;
  return false;
}

Check check_profile(const LeafSpring& leaf) {
  for (const auto& [profile, of] :
       {std::pair{&leaf.width_profile, "width"}, std::pair{&leaf.thickness_profile, "thickness"}}) {
    if (!is_profile_size(profile->size()))
      return Because(fmt::format("{}: the profile of its {} has {} numbers; it takes none, 2 or {}",
                                 leaf.name, of, profile->size(), profile_stations().size()));
    const ProfileRange range = profile_range(*profile);
    // an end at zero is a rounding above it
    if (!(range.smallest > 1e-6 * range.largest) || !std::isfinite(range.largest))
      return Because(fmt::format("{}: its {} must be positive all along", leaf.name, of));
  }
  const double thinnest = leaf.thickness * profile_range(leaf.thickness_profile).smallest,
               widest = leaf.width * profile_range(leaf.width_profile).largest;
  if (!(thinnest < leaf.length)) return Because(leaf.name + ": it must be thinner than long");
  if (leaf.section == Section::rectangular && !(thinnest <= widest))
    return Because(leaf.name + ": it must not be thicker than wide");
  return {};
}

Check check_rules(const LeafSpring& leaf, int bodies) {
  const std::string& name = leaf.name;
  const auto known = [&](int body) { return body >= 0 && body < bodies; };
  if (leaf.base != ground && !known(leaf.base))
    return Because(fmt::format("{}: there is no body {}", name, leaf.base));
  if (leaf.tip != ground && leaf.tip != free_edge && !known(leaf.tip))
    return Because(fmt::format("{}: there is no body {}", name, leaf.tip));
  if (leaf.point) {
    if (!known(leaf.point->body))
      return Because(fmt::format("{}: there is no body {}", name, leaf.point->body));
    for (const double place : {leaf.point->along, leaf.point->across})
      if (!(place >= 0 && place <= 1)) return Because(name + ": its material point lies outside");
    if (leaf.point->spread_over_tip
            ? leaf.tip != free_edge
            : leaf.point->along <= 0 || (leaf.tip != free_edge && leaf.point->along >= 1))
      return Because(name + ": its material point lies on a held edge");
  } else {
    if (leaf.base == leaf.tip) return Because(name + ": both edges are held by the same body");
    if (leaf.tip == free_edge) return Because(name + ": its tip is free, yet nothing follows it");
  }
  if (!leaf.origin.allFinite() || !leaf.axes.allFinite())
    return Because(name + ": its place is not finite");
  for (const double size : {leaf.length, leaf.width, leaf.thickness})
    if (!(std::isfinite(size) && size > 0))
      return Because(name + ": length, width and thickness must be positive");
  if (leaf.section == Section::circular &&
      (std::abs(leaf.width - leaf.thickness) > 1e-9 * leaf.thickness ||
       leaf.width_profile != leaf.thickness_profile))
    return Because(name + ": the width of a circular section must be its thickness, the diameter");
  if (leaf.curve && !(std::abs(*leaf.curve) <= std::numbers::pi))
    return Because(name + ": its arc must not subtend more than half a turn");
  if (leaf.fold) {
    const LeafFold& fold = *leaf.fold;
    if (!(fold.place > 0 && fold.place < 1)) return Because(name + ": its fold line lies outside");
    if (!(std::abs(fold.angle) <= largest_fold))
      return Because(name + ": its legs must not lie on each other");
    if (leaf.curve || leaf.has_profile() || leaf.point || leaf.section == Section::circular ||
        leaf.tip == free_edge)
      return Because(
          name + ": a folded leaf is a flat one of one width and thickness, held at both edges");
    if (!(leaf.thickness < leaf.length * std::min(fold.place, 1 - fold.place)))
      return Because(name + ": each of its legs must be thinner than long");
    if (!(std::isfinite(fold.radius) && fold.radius >= 0))
      return Because(name + ": the radius of its fold must not be negative");
    if (!(2 * leaf.length * corner_reach(fold.angle, fold.radius, leaf.thickness / leaf.length) <
          leaf.length * std::min(fold.place, 1 - fold.place)))
      return Because(name + ": the corner of its fold must take less than half of each leg");
  }
  if (Check kept = check_profile(leaf); !kept) return kept;
  if (!are_right_handed(leaf.axes))
    return Because(name + ": its axes must be orthonormal and right-handed");
  return check_rules(leaf.material, name);
}

Check check_rules(const RigidBody& body) {
  if (!body.reference.allFinite() || !body.center_of_mass.allFinite())
    return Because(body.name + ": its place is not finite");
  if (!(std::isfinite(body.mass) && body.mass >= 0))
    return Because(body.name + ": mass must not be negative");
  if (!body.inertia.allFinite() ||
      (body.inertia - body.inertia.transpose()).norm() > 1e-9 * body.inertia.norm())
    return Because(body.name + ": inertia must be finite and symmetric");
  return {};
}

/// What joints and springs have in common: two bodies and a place.
template <class Tie>
Check check_tie(const Tie& tie, int bodies) {
  const auto known = [&](int body) { return body == ground || (body >= 0 && body < bodies); };
  for (const int body : {tie.body, tie.other})
    if (!known(body)) return Because(fmt::format("{}: there is no body {}", tie.name, body));
  if (tie.body == tie.other) return Because(tie.name + ": it ties a body to itself");
  if (!tie.place.allFinite()) return Because(tie.name + ": its place is not finite");
  return {};
}

Check check_rules(const Joint& joint, int bodies) {
  if (Check kept = check_tie(joint, bodies); !kept) return kept;
  const bool has_axis = joint.type == JointType::revolute || joint.type == JointType::prismatic ||
                        is_held(joint.type);
  if (is_held(joint.type) && (joint.body < 0 || joint.other != ground))
    return Because(joint.name + ": a body is held against the ground");
  if (has_axis && !(std::abs(joint.axis.norm() - 1) < 1e-9))
    return Because(joint.name + ": its axis must have the length one");
  return {};
}

/// The first two leaves that intersect and must not: those before it are tried against each leaf in
/// turn. Only leaves whose spheres overlap along one axis, that of the widest spread, are looked
/// at.
std::optional<std::pair<std::size_t, std::size_t>> intersecting(
    const std::vector<LeafSpring>& leaves) {
  struct Reach {
    double from, to;
    std::size_t leaf;
  };
  Vector3d least = Vector3d::Constant(1e300), most = -least;
  for (const LeafSpring& leaf : leaves) {
    least = least.cwiseMin(leaf.origin);
    most = most.cwiseMax(leaf.origin);
  }
  int axis = 0;
  (most - least).maxCoeff(&axis);
  std::vector<Reach> reaches;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    Reach reach{1e300, -1e300, i};
    for (const Box& box : boxes_of(leaves[i])) {
      const double radius = box.half.norm() * (1 + 1e-6);
      reach.from = std::min(reach.from, box.middle[axis] - radius);
      reach.to = std::max(reach.to, box.middle[axis] + radius);
    }
    reaches.push_back(reach);
  }
  std::ranges::sort(reaches, {}, &Reach::from);
  std::optional<std::pair<std::size_t, std::size_t>> first;
  for (std::size_t a = 0; a < reaches.size(); ++a)
    for (std::size_t b = a + 1; b < reaches.size() && reaches[b].from <= reaches[a].to; ++b) {
      const auto [j, i] = std::minmax(reaches[a].leaf, reaches[b].leaf);
      if (first && std::pair(i, j) >= *first) continue;
      if (leaves[i].may_cross || leaves[j].may_cross) continue;
      if (intersect(leaves[j], leaves[i])) first = {i, j};
    }
  return first;
}

/// Bodies that no chain of leaves, elastic bodies, joints and springs ties to the ground.
Check check_bodies(const Mechanism& mechanism) {
  const std::size_t bodies = mechanism.bodies.size();
  // what a body that is held holds; the ground is the last of the lists
  std::vector<std::vector<int>> holds(bodies + 1);
  const auto tie = [&](int from, int to) {
    if (to >= 0) holds[from < 0 ? bodies : static_cast<std::size_t>(from)].push_back(to);
  };
  for (const LeafSpring& leaf : mechanism.leaves) {
    if (leaf.tip != free_edge) {
      tie(leaf.base, leaf.tip);
      tie(leaf.tip, leaf.base);
    }
    if (!leaf.point) continue;
    tie(leaf.base, leaf.point->body);
    if (leaf.tip != free_edge) tie(leaf.tip, leaf.point->body);
  }
  const auto both = [&](int body, int other) {
    tie(body, other);
    tie(other, body);
  };
  for (const Joint& joint : mechanism.joints)
    if (!is_held(joint.type)) both(joint.body, joint.other);
  for (const Spring& spring : mechanism.springs) both(spring.body, spring.other);
  for (const ElasticBody& body : mechanism.elastic_bodies)
    for (const ElasticInterface& interface : body.interfaces)
      both(body.interfaces.front().body, interface.body);
  std::vector<bool> held(bodies, false);
  std::vector<std::size_t> reached{bodies};
  while (!reached.empty()) {
    const std::size_t from = reached.back();
    reached.pop_back();
    for (const int b : holds[from])
      if (const auto to = static_cast<std::size_t>(b); !held[to]) {
        held[to] = true;
        reached.push_back(to);
      }
  }
  for (std::size_t i = 0; i < held.size(); ++i)
    if (!held[i])
      return Because(fmt::format("{}: no leaf{}{}{} ties it to the ground",
                                 mechanism.bodies[i].name,
                                 mechanism.elastic_bodies.empty() ? "" : " and no elastic body",
                                 mechanism.joints.empty() ? "" : " and no joint",
                                 mechanism.springs.empty() ? "" : " and no spring"));
  return {};
}

}  // namespace

bool are_right_handed(const Matrix3d& axes) {
  return (axes.transpose() * axes - Matrix3d::Identity()).norm() <= 1e-9 && axes.determinant() > 0;
}

Check check_rules(const Material& m, const std::string& where) {
  const bool stiff = std::isfinite(m.youngs_modulus) && m.youngs_modulus > 0;
  if (!stiff) return Because(where + ": Young's modulus must be positive");
  if (!(std::isfinite(m.poissons_ratio) && m.poissons_ratio > -1))
    return Because(where + ": Poisson's ratio must satisfy -1 < nu (<= 0.5 for plates)");
  if (!(std::isfinite(m.density) && m.density > 0))
    return Because(where + ": density must be positive");
  return {};
}

double longest_leaf(const Mechanism& mechanism) {
  double length = 0;
  for (const LeafSpring& leaf : mechanism.leaves) length = std::max(length, leaf.length);
  for (const ElasticBody& body : mechanism.elastic_bodies)
    if (mechanism.leaves.empty()) length = std::max(length, extent(body));
  return length;
}

Check check_rules(const Spring& spring, int bodies) {
  const std::string& name = spring.name;
  if (Check kept = check_tie(spring, bodies); !kept) return kept;
  if (spring.matrix) {
    const Matrix6d& K = *spring.matrix;
    if (!K.allFinite() || (K - K.transpose()).norm() > 1e-9 * K.norm())
      return Because(name + ": its matrix must be finite and symmetric");
    // unit diagonal: translations and rotations differ by many orders of magnitude
    if ((K.diagonal().array() < 0).any())
      return Because(name + ": its matrix must not be negative");
    const double none = 1e-12 * K.diagonal().maxCoeff();
    VectorXd s(6);
    for (int i = 0; i < 6; ++i) {
      s[i] = K(i, i) > 0 ? 1 / std::sqrt(K(i, i)) : 0;
      if (K(i, i) == 0 && K.row(i).cwiseAbs().maxCoeff() > none)
        return Because(name + ": its matrix must be positive semidefinite");
    }
    if (symmetric_eigenvalues(s.asDiagonal() * K * s.asDiagonal()).minCoeff() < -1e-9)
      return Because(name + ": its matrix must be positive semidefinite");
    return {};
  }
  if (!spring.other_place.allFinite()) return Because(name + ": its place is not finite");
  if (!(built_length(spring) > 1e-9 * (spring.place.norm() + spring.other_place.norm())))
    return Because(name + ": its two ends coincide");
  for (std::size_t i = 0; i < spring.line.size(); ++i) {
    const auto& [length, force] = spring.line[i];
    const double before = i == 0 ? 0 : spring.line[i - 1][0];
    if (!(std::isfinite(length) && std::isfinite(force) && length > before))
      return Because(name + ": the lengths of its line must ascend from above zero");
  }
  if (spring.line.size() == 1) return Because(name + ": its line needs two lengths or more");
  if (!(std::isfinite(spring.stiffness) && spring.stiffness >= 0))
    return Because(name + ": its stiffness must not be negative");
  if (!(std::isfinite(spring.free_length) && spring.free_length >= 0))
    return Because(name + ": its free length must not be negative");
  return {};
}

Check check_rules(const Mechanism& mechanism) {
  const int bodies = static_cast<int>(mechanism.bodies.size());
  if (mechanism.end_effector < 0 || mechanism.end_effector >= bodies)
    return Because(
        fmt::format("there is no body {} to be the end-effector", mechanism.end_effector));
  if (Check kept = check_drives(mechanism); !kept) return kept;
  if (mechanism.leaves.empty() && mechanism.elastic_bodies.empty())
    return Because("there are no leaves");
  for (const RigidBody& body : mechanism.bodies)
    if (Check kept = check_rules(body); !kept) return kept;
  for (const LeafSpring& leaf : mechanism.leaves)
    if (Check kept = check_rules(leaf, bodies); !kept) return kept;
  for (const ElasticBody& body : mechanism.elastic_bodies)
    if (Check kept = check_rules(body, bodies); !kept) return kept;
  for (const Joint& joint : mechanism.joints)
    if (Check kept = check_rules(joint, bodies); !kept) return kept;
  for (const Spring& spring : mechanism.springs)
    if (Check kept = check_rules(spring, bodies); !kept) return kept;
  if (Check kept = check_bodies(mechanism); !kept) return kept;
  if (Check kept = check_joints(mechanism); !kept) return kept;
  if (const auto pair = intersecting(mechanism.leaves))
    return Because(
        fmt::format("{} and {} intersect when undeflected; leaves with \"may_cross\" may",
                    mechanism.leaves[pair->second].name, mechanism.leaves[pair->first].name));
  if (Check kept = check_leaves_outside(mechanism); !kept) return kept;
  return check_directions(mechanism);
}

}  // namespace flexopt
