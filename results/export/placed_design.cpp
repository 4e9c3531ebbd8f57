#include <set>

#include "core/elements/solid/solid_stress.hpp"
#include "core/math/dual.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/mechanism/profile.hpp"
#include "results/export/measures.hpp"
#include "results/export/parts.hpp"

namespace flexopt {

namespace {

using PlaceKind = DrawnPoint::Kind;

template <class S>
S profile_value(const std::vector<S>& numbers, double s) {
  if (numbers.empty()) return S(1);
  const ProfileWeights weights = profile_weights(numbers.size(), s);
  S value(0);
  for (int k = 0; k < weights.count; ++k) value += weights.weight[k] * numbers[weights.first + k];
  return value;
}

/// visit(kind, whether inside, place) at the ends of a leaf, its fold, and in the middle of it or
/// of its first leg.
template <class S, class Visit>
void each_place_of_leaf(const LeafSpringT<S>& leaf, const Visit& visit) {
  const S first = leaf.fold ? leaf.fold->place : S(1);
  std::vector<S> stations{S(0), S(0.5 * first), S(1)};
  if (leaf.fold) stations.push_back(first);
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const bool inside = k == 1, fold = k == 3;
    const double part = value_of(stations[k]);
    const ArcPoint<S> at = leaf.middle(stations[k]);
    const Matrix3<S> local = at.axes();
    const Vector3<S> across = leaf.axes.col(1);
    const Vector3<S> normal = leaf.axes.col(0) * local(0, 2) + leaf.axes.col(2) * local(2, 2);
    const S x = leaf.length * at.x, z = leaf.length * at.z;
    const Vector3<S> middle = leaf.origin + leaf.axes.col(0) * x + leaf.axes.col(2) * z;
    const bool wire = leaf.section == Section::circular;
    const auto& thick = wire ? leaf.width_profile : leaf.thickness_profile;
    const S width = leaf.width * profile_value(leaf.width_profile, part),
            thickness = leaf.thickness * profile_value(thick, part);
    visit(PlaceKind::middle, inside, middle);
    for (const double side : {-0.5, 0.5}) {
      const S half_width = side * width, half_thickness = side * thickness;
      visit(wire ? PlaceKind::face : PlaceKind::rim, inside,
            Vector3<S>(middle + across * half_width));
      if (!fold)  // where faces have a corner
        visit(PlaceKind::face, inside, Vector3<S>(middle + normal * half_thickness));
    }
  }
}

/// Nodes of an elastic body at which its surface turns.
template <class S, class Body>
std::set<int> corner_nodes(const Body& body) {
  TriangleMesh mesh;
  if (!body.cells) return {};
  for (const Vector3<S>& node : body.nodes)
    mesh.points.emplace_back(value_of(node[0]), value_of(node[1]), value_of(node[2]));
  mesh.triangles = surface_triangles(*body.cells);
  std::set<int> nodes;
  for (const auto& ridge : mesh.ridges()) nodes.insert(ridge.begin(), ridge.end());
  return nodes;
}

/// visit(kind, owner, whether inside a leaf, place) in a fixed order.
template <class S, class Visit>
void each_place(const MechanismT<S>& mechanism, const Visit& visit) {
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    each_place_of_leaf(mechanism.leaves[i], [&](PlaceKind kind, bool inside, const Vector3<S>& at) {
      visit(kind, static_cast<int>(i), inside, at);
    });
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    if (!mechanism.bodies[b].box) continue;
    const BodyBoxT<S>& box = *mechanism.bodies[b].box;
    for (int corner = 0; corner < 8; ++corner) {
      Vector3<S> at = box.center;
      for (int k = 0; k < 3; ++k) at += box.half_edges.col(k) * S((corner >> k) & 1 ? 1 : -1);
      visit(PlaceKind::box, static_cast<int>(b), false, at);
    }
  }
  const auto place = [&](const Vector3<S>& at) { visit(PlaceKind::place, -1, false, at); };
  place(mechanism.bodies[mechanism.end_effector].reference);
  for (const auto& joint : mechanism.joints)
    if (!is_held(joint.type)) place(joint.place);
  int owner = static_cast<int>(mechanism.bodies.size());
  for (const auto& elastic : mechanism.elastic_bodies) {
    for (std::size_t a = 0; a < elastic.interfaces.size(); ++a) place(elastic.interface_place(a));
    for (const int node : corner_nodes<S>(elastic)) {
      const Vector3<S> turned = elastic.axes.lazyProduct(elastic.nodes[node]);
      visit(PlaceKind::box, owner, false, Vector3<S>(elastic.place + turned));
    }
    ++owner;
  }
  for (const auto& spring : mechanism.springs) {
    place(spring.place);
    if (!spring.matrix) place(spring.other_place);
  }
  visit(PlaceKind::origin, -1, false, Vector3<S>(Vector3<S>::Zero()));
}

/// visit(leaf, place, direction into the leaf) in the order of PlacedDesign::legs.
template <class S, class Visit>
void each_leg(const MechanismT<S>& mechanism, const Visit& visit) {
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const LeafSpringT<S>& leaf = mechanism.leaves[i];
    const auto visit_at = [&](const ArcPoint<S>& at, double sign) {
      const S x = leaf.length * at.x, z = leaf.length * at.z;
      const S cosine = sign * at.cosine, sine = sign * at.sine;
      visit(static_cast<int>(i),
            Vector3<S>(leaf.origin + leaf.axes.col(0) * x + leaf.axes.col(2) * z),
            Vector3<S>(leaf.axes.col(0) * cosine + leaf.axes.col(2) * sine));
    };
    visit_at(leaf.middle(S(0)), 1);
    visit_at(leaf.middle(S(1)), -1);
    if (!leaf.fold) continue;
    visit_at(leaf.middle(leaf.fold->place), -1);
    visit_at(leg_point<S>(leaf.fold->place, leaf.fold->angle, leaf.fold->place), 1);
  }
}

Vector3d derivative_of(const Vector3<Dual1>& v) {
  return v.unaryExpr([](const Dual1& x) { return x.derivatives[0]; });
}

/// The mechanism with its rate as derivatives.
MechanismT<Dual1> moving(const Mechanism& mechanism, const Mechanism& rate) {
  std::vector<double> rates;
  each_number(rate, [&](const double& x) { rates.push_back(x); });
  auto moved = with_numbers<Dual1>(mechanism, [](double x) { return Dual1(x); });
  std::size_t i = 0;
  each_number(moved, [&](Dual1& x) { x.derivatives[0] = rates[i++]; });
  return moved;
}

}  // namespace

bool PlacedDesign::moves(std::size_t parameter) const {
  return std::ranges::any_of(
      points, [&](const DrawnPoint& point) { return point.rates[parameter].norm() > 1e-9; });
}

PlacedDesign placed_design(const Family& family, const ParameterValues& values,
                           const FamilyChoices& choices, const ParameterValues& nominal) {
  PlacedDesign design;
  const Material& material = materials().front().material;  // nothing drawn depends on it
  design.mechanism = family.make(values, choices, material, {}, nominal);
  std::vector<std::string> names;
  for (const Parameter& p : family.parameters)
    if (std::ranges::find(family.counts, p.name) == family.counts.end()) {
      design.parameters.push_back(p);
      design.values.push_back(values.at(p.name));
      names.push_back(p.name);
    }
  Eigen::AlignedBox3d box;
  each_place(design.mechanism, [&](PlaceKind kind, int owner, bool inside, const Vector3d& at) {
    design.points.push_back({kind, owner, inside, at, {}});
    if (kind != PlaceKind::origin) box.extend(at);
  });
  design.size = box.diagonal().norm();
  each_leg(design.mechanism, [&](int leaf, const Vector3d& at, const Vector3d& along) {
    design.legs.push_back({leaf, at, along, {}});
  });
  for (const MechanismDirection& along :
       family.directions(values, choices, material, {}, names, nominal)) {
    const MechanismT<Dual1> moved = moving(design.mechanism, along.rate);
    std::size_t k = 0;
    each_place(moved, [&](PlaceKind, int, bool, const Vector3<Dual1>& at) {
      design.points[k++].rates.push_back(derivative_of(at));
    });
    k = 0;
    each_leg(moved, [&](int, const Vector3<Dual1>&, const Vector3<Dual1>& way) {
      design.legs[k++].rates.push_back(derivative_of(way));
    });
  }
  return design;
}

}  // namespace flexopt
