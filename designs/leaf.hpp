#pragma once
// The building blocks of every family: a leaf between two frames, and the rigid end-effector.
#include <Eigen/Dense>
#include <string>
#include <utility>

#include "core/mechanism/mechanism.hpp"
#include "designs/family.hpp"

namespace flexopt {

/// An edge frame: where the middle of a leaf's short edge sits, and which body holds it.
template <class S>
struct EdgeFrame {
  int body = ground;
  Vector3<S> middle;  ///< [m]
};

template <class S>
struct LeafSection {
  S width, thickness;  ///< [m]
  MaterialT<S> material;
};

/// The leaf from one edge frame to another, its width along `across` (a unit vector normal to the
/// line between them). Axes: along the leaf, along its width, along × across.
template <class S>
LeafSpringT<S> make_leaf(std::string name, const EdgeFrame<S>& base, const EdgeFrame<S>& tip,
                         const Vector3<S>& across, const LeafSection<S>& section) {
  LeafSpringT<S> leaf;
  leaf.name = std::move(name);
  leaf.base = base.body;
  leaf.tip = tip.body;
  leaf.origin = base.middle;
  const Vector3<S> line = tip.middle - base.middle;
  leaf.length = line.norm();
  leaf.axes.col(0) = line / leaf.length;
  leaf.axes.col(1) = across;
  leaf.axes.col(2) = Vector3<S>(leaf.axes.col(0)).cross(across);
  leaf.width = section.width;
  leaf.thickness = section.thickness;
  leaf.material = section.material;
  return leaf;
}

/// The end-effector with its reference point O at `reference`.
template <class S>
RigidBodyT<S> make_end_effector(const Vector3<S>& reference, const EndEffector& payload) {
  RigidBodyT<S> body;
  body.name = "end_effector";
  body.role = BodyRole::end_effector;
  body.reference = reference;
  body.mass = S(payload.mass);
  body.center_of_mass = reference + payload.center_of_mass.cast<S>();
  body.inertia = payload.inertia.cast<S>();
  return body;
}

/// O as a material point of a leaf: no mass, no rotations.
template <class S>
RigidBodyT<S> make_point_body(const Vector3<S>& reference) {
  RigidBodyT<S> body = make_end_effector<S>(reference, EndEffector{});
  body.name = "O";
  body.held = {false, false, false, true, true, true};
  return body;
}

/// z, the direction of the leaves' width in the planar families.
template <class S>
Vector3<S> z_axis() {
  return Vector3<S>(S(0), S(0), S(1));
}

}  // namespace flexopt
