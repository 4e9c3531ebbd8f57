#pragma once
// Mechanisms that many tests share, written out by hand: independent of the families.
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt {

/// A drive against the ground along a global axis.
inline Drive make_drive(Direction direction, int body = 0) {
  Drive drive;
  drive.direction = direction;
  drive.body = body;
  return drive;
}

/// Direction of the first drive; uy where there is none.
inline Direction drive_direction(const Mechanism& mechanism) {
  return mechanism.drives.empty() ? Direction::uy : mechanism.drives.front().direction;
}

}  // namespace flexopt

namespace flexopt::models {

inline Material steel() { return {"steel", 200e9, 0.3, 7800, {}}; }
inline Material without_poisson() { return {"steel", 200e9, 0, 7800, {}}; }

/// A function of the place at the stations of a profile.
template <class F>
std::vector<double> sampled(const F& f) {
  std::vector<double> p;
  for (const double s : profile_stations()) p.push_back(f(s));
  return p;
}

/// Leaf from `from` along `along`, width along z.
inline LeafSpring leaf(const Vector3d& from, const Vector3d& along, double length, double width,
                       double thickness, const Material& material = steel()) {
  LeafSpring l;
  l.origin = from;
  l.axes.col(0) = along.normalized();
  l.axes.col(1) = Vector3d::UnitZ();
  l.axes.col(2) = l.axes.col(0).cross(l.axes.col(1));
  l.length = length;
  l.width = width;
  l.thickness = thickness;
  l.material = material;
  return l;
}

inline RigidBody body(const Vector3d& at, double mass, double inertia) {
  RigidBody b;
  b.name = "end-effector";
  b.reference = b.center_of_mass = at;
  b.mass = mass;
  b.inertia = inertia * Matrix3d::Identity();
  return b;
}

/// A body on the way from the ground to the end-effector.
inline RigidBody intermediate(const Vector3d& at, double mass, double inertia,
                              std::string name = "intermediate") {
  RigidBody b = body(at, mass, inertia);
  b.name = std::move(name);
  b.role = BodyRole::intermediate;
  return b;
}

/// A point without rotations, for a place on a leaf.
inline RigidBody follower(const Vector3d& at, double mass = 0) {
  RigidBody b = body(at, mass, 0);
  b.held = {false, false, false, true, true, true};
  return b;
}

/// The leaf from one body to another.
inline LeafSpring between(int base, int tip, LeafSpring leaf) {
  leaf.base = base;
  leaf.tip = tip;
  return leaf;
}

/// One leaf along x, O at the middle of its tip.
inline Mechanism single_leaf(double length, double width, double thickness,
                             Direction drive = Direction::uy, const Material& m = steel()) {
  Mechanism mechanism;
  mechanism.drives = {make_drive(drive)};
  mechanism.bodies = {body({length, 0, 0}, 0, 0)};
  mechanism.leaves = {leaf({0, 0, 0}, {1, 0, 0}, length, width, thickness, m)};
  return mechanism;
}

/// Its tip free, O the middle of that edge.
inline Mechanism free_tip(Mechanism single, double mass = 0) {
  LeafSpring& leaf = single.leaves[0];
  leaf.tip = free_edge;
  leaf.point = LeafPoint{.body = 0, .along = 1, .across = 0.5, .spread_over_tip = true};
  single.bodies = {follower(leaf.tip_middle(), mass)};
  return single;
}

/// Clamped at both edges, O at shares of its length along x and of its width.
inline Mechanism clamped_at_both(Mechanism single, double along, double across, double mass = 0) {
  LeafSpring& leaf = single.leaves[0];
  leaf.tip = ground;
  leaf.point = LeafPoint{.body = 0, .along = along, .across = across};
  single.bodies = {follower({along * leaf.length, 0, (across - 0.5) * leaf.width}, mass)};
  return single;
}

/// A leaf between edges that stay parallel, pressed along itself (x) and sheared (y).
inline Mechanism pressed_leaf() {
  Mechanism m = models::single_leaf(0.05, 0.01, 2e-4);
  m.bodies[0].held = {false, false, true, true, true, true};
  m.drives = {make_drive(Direction::ux), make_drive(Direction::uy)};
  m.drives[0].name = "x";
  m.drives[1].name = "y";
  return m;
}

/// Two leaves along x, O on the line of their tips.
inline Mechanism guide(double length, double width, double thickness, double spacing = 0.06,
                       double mass = 0.5, double inertia = 4e-4) {
  Mechanism mechanism;
  mechanism.drives = {make_drive(Direction::uy)};
  mechanism.bodies = {body({length, 0, 0}, mass, inertia)};
  for (const double y : {0.5 * spacing, -0.5 * spacing})
    mechanism.leaves.push_back(leaf({0, y, 0}, {1, 0, 0}, length, width, thickness));
  return mechanism;
}

/// Leaves that cross at the origin under ±45°, given by (side, z, width).
struct Crossing {
  double side, z, width;
};
inline Mechanism hinge(double length, double thickness, const std::vector<Crossing>& leaves,
                       double mass = 0.3, double inertia = 3e-4) {
  Mechanism mechanism;
  mechanism.drives = {make_drive(Direction::rz)};
  mechanism.bodies = {body({0, 0, 0}, mass, inertia)};
  for (const Crossing& c : leaves) {
    const Vector3d along = Vector3d(1, c.side, 0).normalized();
    mechanism.leaves.push_back(
        leaf(Vector3d(0, 0, c.z) - 0.5 * length * along, along, length, c.width, thickness));
  }
  return mechanism;
}

/// Outer, inner, outer leaf of equal total width.
inline Mechanism three_leaf_hinge(double length, double width, double thickness) {
  return hinge(length, thickness,
               {{1, 0.8 * width, 0.5 * width}, {-1, 0, width}, {1, -0.8 * width, 0.5 * width}});
}

/// Stiffness E w t³/12 in bending [N m²].
inline double bending(const LeafSpring& leaf) {
  return leaf.material.youngs_modulus * leaf.width * std::pow(leaf.thickness, 3) / 12;
}

/// The same leaf, its other edge called the base.
inline LeafSpring turned(const LeafSpring& leaf) {
  LeafSpring t = leaf;
  std::swap(t.base, t.tip);
  t.origin = leaf.origin + leaf.length * leaf.axes.col(0);
  t.axes.col(0) = -leaf.axes.col(0);
  t.axes.col(1) = -leaf.axes.col(1);
  return t;
}

/// Strokes from zero to the end, both among them, at equal distances.
inline std::vector<double> evenly(double end, int points = 11) {
  std::vector<double> all;
  for (int k = 0; k < points; ++k) all.push_back(end * k / (points - 1));
  return all;
}

/// Full beams, as Euler and Bernoulli have them: sections warp freely.
inline ModelOptions free_beams(int elements) {
  return {.accuracy = Accuracy::full,
          .flexure = Flexure::beam,
          .warping = Warping::free,
          .mesh = {elements, 1}};
}

}  // namespace flexopt::models
