#include "core/mechanism/mobility.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/math/rotation.hpp"
#include "core/math/sparse_rank.hpp"
#include "core/mechanism/joint.hpp"

namespace flexopt {
namespace {

// What holds bodies: a leaf, an elastic body, a joint, or the held directions of a body.
struct Member {
  std::string name;
  std::array<int, 2> body{ground, ground};
};

// One condition on the motions (displacement over the longest leaf, rotation) of two bodies.
struct Condition {
  int member = 0;
  std::array<Vector6d, 2> gradient{Vector6d::Zero(), Vector6d::Zero()};
};

struct WholeLeaves {
  std::vector<LeafSpring> leaves;
  int links = 0;  ///< bodies between parts of a leaf, which are none of the mechanism's own
};

/// Whether a body has no mass and holds nothing but edges of leaves.
bool is_link(const Mechanism& mechanism, int b) {
  const auto holds = [b](const auto& tie) { return tie.body == b || tie.other == b; };
  const RigidBody& body = mechanism.bodies[b];
  return b != mechanism.end_effector && body.mass == 0 &&
         std::ranges::none_of(body.held, [](bool held) { return held; }) &&
         std::ranges::none_of(mechanism.elastic_bodies,
                              [&](const ElasticBody& elastic) {
                                return std::ranges::count(elastic.interfaces, b,
                                                          &ElasticInterface::body) > 0;
                              }) &&
         std::ranges::none_of(mechanism.joints, holds) &&
         std::ranges::none_of(mechanism.springs, holds) &&
         std::ranges::none_of(mechanism.drives, holds);
}

/// The leaves, where flat ones that follow each other in one line and plane with a link between
/// them, as the parts of a reinforced leaf do, are one.
WholeLeaves whole_leaves(const Mechanism& mechanism) {
  WholeLeaves whole{mechanism.leaves};
  std::vector<LeafSpring>& leaves = whole.leaves;
  const auto flat = [](const LeafSpring& leaf) {
    return leaf.section != Section::circular && !leaf.curve && !leaf.fold && !leaf.point;
  };
  for (int b = 0; b < static_cast<int>(mechanism.bodies.size()); ++b) {
    if (!is_link(mechanism, b)) continue;
    const auto first = std::ranges::find(leaves, b, &LeafSpring::tip),
               second = std::ranges::find(leaves, b, &LeafSpring::base);
    if (first == leaves.end() || second == leaves.end() || first == second ||
        std::ranges::count(leaves, b, &LeafSpring::tip) +
                std::ranges::count(leaves, b, &LeafSpring::base) >
            2 ||
        !flat(*first) || !flat(*second) ||
        (first->axes - second->axes).norm() > Mobility::tolerance ||
        (first->tip_middle() - second->origin).norm() > Mobility::tolerance * first->length)
      continue;
    first->name = first->name.substr(0, first->name.rfind('/'));
    first->tip = second->tip;
    first->length += second->length;
    leaves.erase(second);
    ++whole.links;
  }
  return whole;
}

class Conditions {
 public:
  Conditions(const Mechanism& mechanism, const std::vector<LeafSpring>& leaves)
      : mechanism_(&mechanism), length_(longest_leaf(mechanism)) {
    for (const LeafSpring& leaf : leaves) add(leaf);
    for (const ElasticBody& body : mechanism.elastic_bodies) add(body);
    for (const Joint& joint : mechanism.joints) add(joint);
    for (int b = 0; b < static_cast<int>(mechanism.bodies.size()); ++b) add_held(b);
  }

  /// The stroke of a drive stays as it is.
  void add(const Drive& drive) {
    const int m = member(drive.name, drive.body, drive.other);
    const Vector3d axis = drive.axes.col(index(drive.direction) % 3),
                   place = mechanism_->bodies[drive.body].reference;
    const auto motion = [&](int body) {
      return is_rotation(drive.direction) ? rotation(axis) : displacement(body, place, axis);
    };
    add(m, motion(drive.body), -motion(drive.other));
  }

  double length() const { return length_; }
  const std::vector<Member>& members() const { return members_; }
  const std::vector<Condition>& all() const { return conditions_; }

  /// Entries of the matrix; columns of the body `without` are left out.
  std::vector<SparseEntry> entries(int without) const {
    std::vector<SparseEntry> list;
    for (std::size_t i = 0; i < conditions_.size(); ++i) {
      const Condition& c = conditions_[i];
      for (int e = 0; e < 2; ++e) {
        const int b = members_[c.member].body[e];
        if (b < 0 || b == without) continue;
        for (int k = 0; k < 6; ++k)
          if (c.gradient[e][k] != 0)
            list.push_back({static_cast<int>(i), 6 * b + k, c.gradient[e][k]});
      }
    }
    return list;
  }

 private:
  int member(std::string name, int body, int other) {
    members_.push_back({std::move(name), {body, other}});
    return static_cast<int>(members_.size()) - 1;
  }

  // Displacement along `direction` of a material point of a body, or of the ground about the
  // origin.
  Vector6d displacement(int body, const Vector3d& place, const Vector3d& direction) const {
    const Vector3d arm = body < 0 ? place : place - mechanism_->bodies[body].reference;
    Vector6d g;
    g << direction, arm.cross(direction) / length_;
    return g;
  }
  static Vector6d rotation(const Vector3d& axis) {
    Vector6d g = Vector6d::Zero();
    g.tail<3>() = axis;
    return g;
  }
  void add(int member, const Vector6d& body, const Vector6d& other) {
    conditions_.push_back({member, {body, other}});
  }

  // The tip, seen from the base, does not move in the plane of a leaf; a wire keeps its length.
  void add(const LeafSpring& leaf) {
    const Vector3d along = leaf.axes.col(0), across = leaf.axes.col(1), normal = leaf.axes.col(2);
    const auto same_displacement = [&](int m, int body, const Vector3d& place,
                                       const Vector3d& direction) {
      add(m, displacement(body, place, direction), -displacement(leaf.base, place, direction));
    };
    const bool wire = leaf.section == Section::circular;
    if (leaf.fold && std::abs(std::sin(leaf.fold->angle)) > Mobility::tolerance) {
      // both legs together hold one direction: along their fold
      const int m = member(leaf.name, leaf.tip, leaf.base);
      same_displacement(m, leaf.tip, leaf.origin + along * (leaf.length * leaf.fold->place),
                        across);
      return;
    }
    if (leaf.tip != free_edge) {
      const int m = member(leaf.name, leaf.tip, leaf.base);
      same_displacement(m, leaf.tip, leaf.tip_middle(), along);
      if (!wire) {
        same_displacement(m, leaf.tip, leaf.tip_middle(), across);
        add(m, rotation(normal), -rotation(normal));
      }
    }
    if (leaf.point) {
      const int m = member(leaf.name, leaf.point->body, leaf.base);
      const Vector3d place = mechanism_->bodies[leaf.point->body].reference;
      same_displacement(m, leaf.point->body, place, along);
      if (!wire) same_displacement(m, leaf.point->body, place, across);
    }
  }

  // A frame that bends a little keeps its interfaces where they are. A hinge of degree 4 is like a
  // bushing: none of its directions is stiff beside the others.
  void add(const ElasticBody& body) {
    if (body.degree != ElasticDegree::linear) return;
    const int first = body.interfaces.front().body;
    for (std::size_t a = 1; a < body.interfaces.size(); ++a) {
      const int other = body.interfaces[a].body;
      if (other == first) continue;
      const int m = member(body.name, other, first);
      const Vector3d place = body.interface_place(a);
      for (int k = 0; k < 3; ++k) {
        const Vector3d axis = Vector3d::Unit(k);
        add(m, displacement(other, place, axis), -displacement(first, place, axis));
        add(m, rotation(axis), -rotation(axis));
      }
    }
  }

  void add(const Joint& joint) {
    const int m = member(joint.name, joint.body, joint.other);
    const JointConditions c = undeflected_conditions(*mechanism_, joint);
    const int lengths = size_of(joint.type).lengths;
    for (int k = 0; k < c.value.size(); ++k) {
      Vector6d body = c.gradient.row(k).head<6>(), other = c.gradient.row(k).tail<6>();
      for (Vector6d* g : {&body, &other})
        if (k < lengths)
          g->tail<3>() /= length_;
        else
          g->head<3>() *= length_;
      add(m, body, other);
    }
  }

  void add_held(int b) {
    const RigidBody& body = mechanism_->bodies[b];
    if (std::ranges::none_of(body.held, [](bool held) { return held; })) return;
    const int m = member(body.name + " (held)", b, ground);
    for (int d = 0; d < 6; ++d)
      if (body.held[d]) add(m, Vector6d::Unit(d), Vector6d::Zero());
  }

  const Mechanism* mechanism_;
  double length_;
  std::vector<Member> members_;
  std::vector<Condition> conditions_;
};

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "`" : i + 1 == names.size() ? " and `" : ", `") + names[i] + "`";
  return text;
}

// Body and direction in which a self-stress acts: what the member of its last condition does to one
// of its bodies, as a force or else a moment.
Redundancy redundancy(const Mechanism& mechanism, const Conditions& conditions,
                      const std::vector<std::pair<int, double>>& stress) {
  constexpr double nothing = 1e-6;
  const auto& members = conditions.members();
  std::map<int, std::array<Vector6d, 2>> loads;  // of every member on its bodies
  for (const auto& [k, factor] : stress) {
    const Condition& c = conditions.all()[k];
    auto& load = loads
                     .try_emplace(c.member, std::array{Vector6d(Vector6d::Zero()),
                                                       Vector6d(Vector6d::Zero())})
                     .first->second;
    for (int e = 0; e < 2; ++e) load[e] += factor * c.gradient[e];
  }
  const int last = conditions.all()[stress.back().first].member;
  double largest = 0;
  for (const auto& [m, load] : loads)
    for (const Vector6d& l : load) largest = std::max(largest, l.norm());

  Redundancy r;
  for (const auto& [m, load] : loads)
    if (std::max(load[0].norm(), load[1].norm()) >= nothing * largest) {
      const std::string& name = members[m].name;
      if (std::ranges::find(r.shared_by, name) == r.shared_by.end()) r.shared_by.push_back(name);
    }
  const Member& own = members[last];
  const int side = own.body[0] >= 0 ? 0 : 1, body = own.body[side];
  const Vector6d& load = loads.at(last)[side];
  r.body = body < 0 ? "ground" : mechanism.bodies[body].name;
  const bool turns = load.head<3>().norm() <= nothing * load.norm();
  r.axis = (turns ? load.tail<3>() : load.head<3>()).normalized();
  Eigen::Index k = 0;
  r.axis.cwiseAbs().maxCoeff(&k);
  if (r.axis[k] < 0) r.axis = -r.axis;
  r.axis += Vector3d::Zero();  // 0 for -0
  r.direction = static_cast<Direction>(k + (turns ? 3 : 0));
  const std::string direction = (turns ? "about " : "along ") + described(r.axis);
  if (r.shared_by.size() == 1)
    r.text = fmt::format("{} is held at both ends {}", listed(r.shared_by), direction);
  else
    r.text = fmt::format("{} of `{}` {} is held {}, by {}", turns ? "rotation" : "displacement",
                         r.body, direction, r.shared_by.size() == 2 ? "twice" : "once too often",
                         listed(r.shared_by));
  return r;
}

}  // namespace

Mobility mobility(const Mechanism& mechanism) {
  Mobility result;
  const WholeLeaves whole = whole_leaves(mechanism);
  const int coordinates = 6 * static_cast<int>(mechanism.bodies.size());
  const Conditions conditions(mechanism, whole.leaves);
  const int count = static_cast<int>(conditions.all().size());
  const DependentRows all =
      dependent_rows(count, coordinates, conditions.entries(ground), Mobility::tolerance);
  result.degrees_of_freedom = coordinates - 6 * whole.links - all.rank;
  result.overconstraints = count - all.rank;
  // motions of all bodies less those that leave the end-effector where it is
  result.end_effector_degrees_of_freedom =
      6 - all.rank +
      rank_of(count, coordinates, conditions.entries(mechanism.end_effector), Mobility::tolerance);
  for (const auto& sum : all.sums)
    result.redundant.push_back(redundancy(mechanism, conditions, sum));
  return result;
}

// All drives are tried at once: a dependent condition is a sum of the independent ones in one way
// only, so that the sum for a drive that leaves and joints hold contains no other drive.
std::vector<HeldDrive> held_drives(const Mechanism& mechanism) {
  constexpr double nothing = 1e-6;
  Mechanism holding = mechanism;
  std::erase_if(holding.leaves, [](const LeafSpring& leaf) { return leaf.curve.has_value(); });
  std::vector<HeldDrive> held;
  if (holding.leaves.empty() && holding.elastic_bodies.empty()) return held;
  Conditions conditions(holding, holding.leaves);
  const int first = static_cast<int>(conditions.all().size());  // condition of a drive
  for (const Drive& drive : mechanism.drives) conditions.add(drive);
  const DependentRows rows = dependent_rows(static_cast<int>(conditions.all().size()),
                                            6 * static_cast<int>(mechanism.bodies.size()),
                                            conditions.entries(ground), Mobility::tolerance);
  for (const auto& sum : rows.sums) {
    HeldDrive own{sum.back().first - first, {}};
    bool alone = own.drive >= 0;
    for (std::size_t i = 0; i + 1 < sum.size(); ++i) {
      const auto& [k, factor] = sum[i];
      if (std::abs(factor) <= nothing) continue;
      alone &= k < first;
      const std::string& name = conditions.members()[conditions.all()[k].member].name;
      if (std::ranges::find(own.held_by, name) == own.held_by.end()) own.held_by.push_back(name);
    }
    if (alone) held.push_back(std::move(own));
  }
  return held;
}

}  // namespace flexopt
