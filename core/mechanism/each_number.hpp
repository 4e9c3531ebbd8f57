#pragma once
// One visitor over all numbers of a mechanism. Its rates, its zeros, its copy in another scalar and
// the names of material and payload follow from it.
#include <cassert>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// visit(name, number) for each number of a material.
template <class Material, class Visit>
void each_material_number(Material& material, const Visit& visit) {
  visit(std::string_view("youngs_modulus"), material.youngs_modulus);
  visit(std::string_view("poissons_ratio"), material.poissons_ratio);
  visit(std::string_view("density"), material.density);
}

/// visit(name, number) for mass, centre of mass and inertia of a body. An inertia off the diagonal
/// has two places: its name comes twice.
template <class Body, class Visit>
void each_payload_number(Body& body, const Visit& visit) {
  constexpr std::string_view center[] = {"center_of_mass.x", "center_of_mass.y",
                                         "center_of_mass.z"};
  constexpr std::string_view inertia[] = {"inertia.xx", "inertia.xy", "inertia.xz",
                                          "inertia.yy", "inertia.yz", "inertia.zz"};
  visit(std::string_view("mass"), body.mass);
  for (int i = 0; i < 3; ++i) visit(center[i], body.center_of_mass[i]);
  for (int i = 0, k = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j, ++k) {
      visit(inertia[k], body.inertia(i, j));
      if (i != j) visit(inertia[k], body.inertia(j, i));
    }
}

/// visit(number) for each number of a drive's actuator.
template <class Drive, class Visit>
void each_actuator_number(Drive& drive, const Visit& visit) {
  if (drive.voice_coil) {
    visit(drive.voice_coil->motor_constant);
    visit(drive.voice_coil->resistance);
  }
  if (drive.piezo) {
    visit(drive.piezo->free_stroke);
    visit(drive.piezo->blocking_force);
  }
}

/// visit(number) for every number of the mechanism that a design may change.
template <class Mechanism, class Visit>
void each_number(Mechanism& mechanism, const Visit& visit) {
  const auto entries = [&](auto& matrix) {
    for (int i = 0; i < static_cast<int>(matrix.size()); ++i) visit(*(matrix.data() + i));
  };
  const auto named = [&](std::string_view, auto& number) { visit(number); };
  for (auto& body : mechanism.bodies) {
    entries(body.reference);
    each_payload_number(body, named);
    if (body.box) {
      entries(body.box->center);
      entries(body.box->half_edges);
    }
  }
  for (auto& leaf : mechanism.leaves) {
    entries(leaf.origin);
    entries(leaf.axes);
    visit(leaf.length);
    visit(leaf.width);
    visit(leaf.thickness);
    if (leaf.curve) visit(*leaf.curve);
    if (leaf.fold) {
      visit(leaf.fold->place);
      visit(leaf.fold->angle);
      visit(leaf.fold->radius);
    }
    for (auto& factor : leaf.width_profile) visit(factor);
    for (auto& factor : leaf.thickness_profile) visit(factor);
    each_material_number(leaf.material, named);
    if (leaf.point) {
      visit(leaf.point->along);
      visit(leaf.point->across);
    }
  }
  for (auto& body : mechanism.elastic_bodies) {
    entries(body.place);
    entries(body.axes);
    for (auto& node : body.nodes) entries(node);
    for (auto& interface : body.interfaces) {
      entries(interface.origin);
      entries(interface.face);
    }
    each_material_number(body.material, named);
  }
  for (auto& joint : mechanism.joints) {
    entries(joint.place);
    entries(joint.axis);
  }
  for (auto& spring : mechanism.springs) {
    entries(spring.place);
    if (spring.matrix) {
      entries(*spring.matrix);
    } else {
      entries(spring.other_place);
      visit(spring.stiffness);
      visit(spring.free_length);
      for (auto& [length, force] : spring.line) {
        visit(length);
        visit(force);
      }
    }
  }
  for (auto& drive : mechanism.drives) {
    entries(drive.axes);
    each_actuator_number(drive, visit);
  }
}

/// What no parameter moves: name, strengths, expansion.
template <class To, class From>
void copy_constants(const MaterialT<From>& from, MaterialT<To>& to) {
  to.name = from.name;
  to.allowable_stress = from.allowable_stress;
  to.yield_strength = from.yield_strength;
  to.ultimate_strength = from.ultimate_strength;
  to.endurance_limit = from.endurance_limit;
  to.s_n_curve = from.s_n_curve;
  to.thermal_expansion = from.thermal_expansion;
}

/// A copy of the material with f(x) in place of every number x.
template <class To, class From, class F>
MaterialT<To> with_numbers(const MaterialT<From>& from, const F& f) {
  MaterialT<To> to;
  copy_constants(from, to);
  std::vector<To> numbers;
  each_material_number(from, [&](std::string_view, const From& x) { numbers.push_back(f(x)); });
  std::size_t i = 0;
  each_material_number(to, [&](std::string_view, To& x) { x = numbers[i++]; });
  return to;
}

/// The mechanism with f(x) in the place of every number x. Names, indices and kinds stay.
template <class To, class From, class F>
MechanismT<To> with_numbers(const MechanismT<From>& from, const F& f) {
  MechanismT<To> to;
  to.end_effector = from.end_effector;
  for (const RigidBodyT<From>& b : from.bodies) {
    RigidBodyT<To>& body = to.bodies.emplace_back();
    body.name = b.name;
    body.role = b.role;
    body.held = b.held;
    if (b.box) body.box.emplace();
  }
  for (const LeafSpringT<From>& l : from.leaves) {
    LeafSpringT<To>& leaf = to.leaves.emplace_back();
    leaf.name = l.name;
    leaf.base = l.base;
    leaf.tip = l.tip;
    leaf.section = l.section;
    leaf.may_cross = l.may_cross;
    leaf.width_profile.resize(l.width_profile.size());
    leaf.thickness_profile.resize(l.thickness_profile.size());
    if (l.curve) leaf.curve.emplace();
    if (l.fold) leaf.fold.emplace();
    copy_constants(l.material, leaf.material);
    leaf.growth = l.growth;
    leaf.clamp_growth = l.clamp_growth;
    if (l.point) {
      leaf.point.emplace();
      leaf.point->body = l.point->body;
      leaf.point->spread_over_tip = l.point->spread_over_tip;
    }
  }
  for (const ElasticBodyT<From>& b : from.elastic_bodies) {
    ElasticBodyT<To>& body = to.elastic_bodies.emplace_back();
    body.name = b.name;
    body.cells = b.cells;
    body.nodes.resize(b.nodes.size());
    copy_constants(b.material, body.material);
    for (const ElasticInterfaceT<From>& i : b.interfaces)
      body.interfaces.push_back({i.name, i.body, {}, i.patch, i.clamp_growth});
    body.degree = b.degree;
    body.imported = b.imported;
    body.nominal = b.nominal;
    body.coarse = b.coarse;
    body.growth = b.growth;
  }
  for (const JointT<From>& j : from.joints) {
    JointT<To>& joint = to.joints.emplace_back();
    joint.name = j.name;
    joint.type = j.type;
    joint.body = j.body;
    joint.other = j.other;
  }
  for (const SpringT<From>& s : from.springs) {
    SpringT<To>& spring = to.springs.emplace_back();
    spring.name = s.name;
    spring.body = s.body;
    spring.other = s.other;
    if (s.matrix) spring.matrix.emplace();
    spring.line.resize(s.line.size());
  }
  for (const DriveT<From>& d : from.drives) {
    DriveT<To>& drive = to.drives.emplace_back();
    drive.name = d.name;
    drive.body = d.body;
    drive.other = d.other;
    drive.direction = d.direction;
    drive.axes_change = d.axes_change;
    if (d.voice_coil) drive.voice_coil.emplace();
    if (d.piezo) drive.piezo.emplace();
  }
  std::vector<To*> places;
  each_number(to, [&](To& x) { places.push_back(&x); });
  std::size_t i = 0;
  each_number(from, [&](const From& x) { *places[i++] = f(x); });
  assert(i == places.size());
  return to;
}

/// A mechanism whose numbers are all zero: the derivative of no change.
inline Mechanism zero_rate(const Mechanism& mechanism) {
  return with_numbers<double>(mechanism, [](double) { return 0.0; });
}

}  // namespace flexopt
