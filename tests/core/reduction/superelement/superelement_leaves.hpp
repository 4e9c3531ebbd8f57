#pragma once
// Leaves of superelements of every kind, bent, and how their numbers move.
#include <array>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "core/math/rotation.hpp"
#include "core/reduction/superelement/superelement_leaf_gradient.hpp"
#include "support/models.hpp"
#include "support/moved.hpp"
#include "support/synthetic_leaf.hpp"

namespace flexopt::superelement_leaves {

using flexopt::synthetic::Random;

struct Case {
  std::string name;
  LeafSpring leaf;
  ModelOptions model;
};

// A body that holds an edge: where it is, and how its reference point moves with the design.
struct Body {
  Vector3d reference, displacement, reference_rate;
  Matrix3d rotation;
};

// Numbers of a design: a leaf and the bodies' reference points, at direction · t.
struct Design {
  LeafSpring leaf;
  std::array<Body, 2> body;
};

// Along a direction the axes turn by `turn`.
struct DesignRate {
  LeafSpring rate;
  std::array<Vector3d, 2> reference{Vector3d::Zero(), Vector3d::Zero()};
  Vector3d turn = Vector3d::Zero();
};

inline Design moved(const Design& design, const DesignRate& d, double t) {
  Design m = design;
  m.leaf = moved(m.leaf, d.rate, d.turn, t);
  for (int e = 0; e < 2; ++e) m.body[e].reference += t * d.reference[e];
  return m;
}

inline bool held(const LeafSpring& leaf, int e) { return (e == 0 ? leaf.base : leaf.tip) >= 0; }

inline EdgePoses edges(const Design& design) {
  EdgePoses poses;
  for (int e = 0; e < 2; ++e) {
    const Vector3d middle = e == 0 ? design.leaf.origin : design.leaf.tip_middle();
    const Body& b = design.body[e];
    poses[e] = {middle, design.leaf.axes};
    if (held(design.leaf, e))
      poses[e] = {b.reference + b.displacement + b.rotation * (middle - b.reference),
                  b.rotation * design.leaf.axes};
  }
  return poses;
}

inline LeafVariation<double> variation(const Design& design, const ModelOptions& model,
                                       const DesignRate& d) {
  const LeafSpring& leaf = design.leaf;
  const double L = leaf.length, nu = leaf.material.poissons_ratio;
  const Matrix3d axes = hat(d.turn) * leaf.axes;
  LeafVariation<double> v;
  v.length = d.rate.length / L;
  const double t = d.rate.thickness / leaf.thickness;
  v.energy = d.rate.material.youngs_modulus / leaf.material.youngs_modulus + 3 * t;
  if (model.flexure == Flexure::plate)
    v.energy += 2 * nu * d.rate.material.poissons_ratio / (1 - nu * nu);
  v.mass = d.rate.material.density / leaf.material.density + t + 4 * v.length;
  v.shape =
      Vector3d((d.rate.width - leaf.width * v.length) / L,
               (d.rate.thickness - leaf.thickness * v.length) / L, d.rate.material.poissons_ratio);
  v.turn = axes.transpose() * leaf.axes;
  for (int e = 0; e < 2; ++e) {
    if (!held(leaf, e)) continue;
    const Body& b = design.body[e];
    const auto scaled = [&](const Vector3d& from, const Vector3d& rate) {
      return Vector3d((axes.transpose() * from + leaf.axes.transpose() * (rate - v.length * from)) /
                      L);
    };
    const Vector3d moves = d.reference[e] - d.rate.origin;
    v.edge[e].position = scaled(b.reference + b.displacement - leaf.origin, moves);
    v.edge[e].arm = -scaled(b.reference - leaf.origin, moves);
    v.edge[e].rotation =
        axes.transpose() * b.rotation * leaf.axes + leaf.axes.transpose() * b.rotation * axes;
  }
  return v;
}

inline std::vector<Case> cases() {
  ModelOptions model{.mesh = {8, 4}, .method = Reduction::linear_craig_bampton, .leaf_modes = 4};
  const LeafSpring plate = models::leaf({0.3, -0.2, 0.1}, {2, 1, 0}, 0.1, 0.05, 2e-3);
  std::vector<Case> all;
  const auto add = [&](std::string name, LeafSpring leaf, std::array<int, 2> superelements) {
    model.superelements = superelements;
    if (leaf.base == ground && leaf.tip == 0 && !leaf.point) leaf.base = 1;  // both edges move
    all.push_back({std::move(name), std::move(leaf), model});
  };
  add("segments", plate, {3, 0});
  add("one patch", plate, {1, 1});
  add("patches", plate, {2, 2});
  LeafSpring at_point = plate;
  at_point.point = LeafPoint{.body = 2, .along = 0.5, .across = 0.5};
  add("point of patches", at_point, {2, 2});
  LeafSpring tip = plate;
  tip.tip = free_edge;
  tip.base = 0;
  tip.point = LeafPoint{.body = 2, .along = 1, .across = 0.5, .spread_over_tip = true};
  add("free tip of patches", tip, {2, 2});
  add("free tip of segments", tip, {2, 0});
  model.flexure = Flexure::beam;
  add("beams", plate, {3, 0});
  LeafSpring wire = plate;
  wire.section = Section::circular;
  wire.width = wire.thickness;
  add("wires", wire, {2, 0});
  add("free tip of beams", tip, {2, 0});
  return all;
}

struct Bent {
  Design design;
  std::unique_ptr<SuperelementLeaf> leaf;
  LeafRows rows;
};

// Moved in steps; `converged`: balanced at the last one, too.
inline Bent bend(const Case& c, Random& random, bool converged) {
  Bent bent{{c.leaf, {}}, nullptr, {}};
  bent.leaf = std::make_unique<SuperelementLeaf>(
      c.leaf, std::make_shared<const SuperelementGrid>(c.leaf, c.model), 0);
  SuperelementLeaf& leaf = *bent.leaf;
  leaf.evaluate();
  const double L = c.leaf.length;
  std::array<Vector3d, 2> shift, turn;
  for (int e = 0; e < 2; ++e) {
    const Vector3d middle = e == 0 ? c.leaf.origin : c.leaf.tip_middle();
    shift[e] = random.vector<3>(0.001 * L) + c.leaf.axes * Vector3d(-0.006 * e, 0, 0.1 * e) * L;
    turn[e] = random.vector<3>(0.05) + c.leaf.axes * Vector3d(0.1, -0.2, 0);
    if (e == 1) turn[e] += random.vector<3>(0.05);
    bent.design.body[e] = {middle + random.vector<3>(0.3 * L), Vector3d::Zero(), Vector3d::Zero(),
                           Matrix3d::Identity()};
  }
  const Vector3d point = c.leaf.axes * Vector3d(-0.01, 0.003, 0.2) * L;
  Vector3d point_now = Vector3d::Zero();
  EdgePoses now = edges(bent.design);
  constexpr int steps = 8;
  const auto step = [&](double share) {
    for (int e = 0; e < 2; ++e) {
      if (!held(c.leaf, e)) continue;
      bent.design.body[e].displacement = share * shift[e];
      bent.design.body[e].rotation = rotation_exp(share * turn[e]);
    }
    const EdgePoses next = edges(bent.design);
    Vector12d dq;
    for (int e = 0; e < 2; ++e)
      dq.segment<6>(6 * e) << next[e].position - now[e].position,
          rotation_log(next[e].axes * now[e].axes.transpose());
    if (c.leaf.point) leaf.displace_point(share * point, share * point - point_now);
    leaf.move(next, dq);
    leaf.evaluate();
    now = next;
    point_now = share * point;
  };
  const auto balance = [&](double share) {
    for (int i = 0; i < 30 && (i < 2 || leaf.evaluation().correction > 1e-13); ++i) step(share);
    REQUIRE(leaf.evaluation().correction < 1e-11);
  };
  for (int s = 1; s < steps; ++s) balance(double(s) / steps);
  if (converged)
    balance(1);
  else
    step(1);
  const ScaledSuperelements scaled(leaf);
  bent.rows.unknowns = scaled.unknowns();
  bent.rows.point = c.leaf.point ? 3 : 0;
  for (int e = 0; e < 2; ++e)
    if (held(c.leaf, e)) {
      const Body& b = bent.design.body[e];
      bent.rows.lever[e] = c.leaf.axes.transpose() *
                           (now[e].position - b.reference - b.displacement) / c.leaf.length;
    }
  return bent;
}

}  // namespace flexopt::superelement_leaves
