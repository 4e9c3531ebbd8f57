#pragma once
// A leaf between two bodies as a design with numbers, and the exact derivatives of its force on the
// bodies and of the forms yᵀ(K − λM)y against differences of leaves that are made anew.
#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/math/ridders.hpp"
#include "core/math/rotation.hpp"
#include "support/models.hpp"
#include "support/moved.hpp"
#include "support/synthetic_leaf.hpp"

namespace flexopt::held {

/// A leaf between two bodies: the numbers of a design, and where the bodies are.
struct Design {
  LeafSpring leaf;
  std::array<Vector3d, 2> reference, displacement;
  std::array<Matrix3d, 2> rotation;
};

struct DesignRate {
  LeafSpring rate;
  std::array<Vector3d, 2> reference{Vector3d::Zero(), Vector3d::Zero()};
  Vector3d turn = Vector3d::Zero();  ///< of the axes
};

inline DesignRate still() {
  DesignRate d;
  d.rate.origin.setZero();
  d.rate.length = d.rate.width = d.rate.thickness = 0;
  d.rate.material.youngs_modulus = d.rate.material.poissons_ratio = d.rate.material.density = 0;
  return d;
}

inline Design moved(const Design& design, const DesignRate& d, double t) {
  Design m = design;
  m.leaf = moved(m.leaf, d.rate, d.turn, t);
  for (int e = 0; e < 2; ++e) m.reference[e] += t * d.reference[e];
  return m;
}

inline EdgePoses edges(const Design& d, double share) {
  EdgePoses poses;
  for (int e = 0; e < 2; ++e) {
    const Vector3d middle = e == 0 ? d.leaf.origin : d.leaf.tip_middle();
    const Matrix3d R = rotation_exp(share * rotation_log(d.rotation[e]));
    poses[e] = {d.reference[e] + share * d.displacement[e] + R * (middle - d.reference[e]),
                R * d.leaf.axes};
  }
  return poses;
}

/// Of increments of the bodies: edges by (displacement, spin) of both bodies.
inline Matrix12d edge_map(const Design& d, const EdgePoses& now) {
  Matrix12d map = Matrix12d::Identity();
  for (int e = 0; e < 2; ++e)
    map.block<3, 3>(6 * e, 6 * e + 3) =
        -hat(Vector3d(now[e].position - d.reference[e] - d.displacement[e]));
  return map;
}

inline LeafVariation<double> variation(const Design& design, Flexure flexure, const DesignRate& d) {
  const LeafSpring& leaf = design.leaf;
  const double L = leaf.length, nu = leaf.material.poissons_ratio;
  const Matrix3d axes = hat(d.turn) * leaf.axes;
  LeafVariation<double> v;
  v.length = d.rate.length / L;
  const double t = d.rate.thickness / leaf.thickness;
  v.energy = d.rate.material.youngs_modulus / leaf.material.youngs_modulus + 3 * t;
  if (flexure == Flexure::plate)
    v.energy += 2 * nu * d.rate.material.poissons_ratio / (1 - nu * nu);
  v.mass = d.rate.material.density / leaf.material.density + t + 4 * v.length;
  v.shape =
      Vector3d((d.rate.width - leaf.width * v.length) / L,
               (d.rate.thickness - leaf.thickness * v.length) / L, d.rate.material.poissons_ratio);
  v.turn = axes.transpose() * leaf.axes;
  for (int e = 0; e < 2; ++e) {
    const auto scaled = [&](const Vector3d& from, const Vector3d& rate) {
      return Vector3d((axes.transpose() * from + leaf.axes.transpose() * (rate - v.length * from)) /
                      L);
    };
    const Vector3d moves = d.reference[e] - d.rate.origin;
    v.edge[e].position = scaled(design.reference[e] + design.displacement[e] - leaf.origin, moves);
    v.edge[e].arm = -scaled(design.reference[e] - leaf.origin, moves);
    v.edge[e].rotation = axes.transpose() * design.rotation[e] * leaf.axes +
                         leaf.axes.transpose() * design.rotation[e] * axes;
  }
  return v;
}

/// Bodies at random places about the leaf, moved and turned a little.
inline Design random_design(const LeafSpring& leaf, synthetic::Random& random) {
  Design design{leaf, {}, {}, {}};
  const double L = leaf.length;
  for (int e = 0; e < 2; ++e) {
    const Vector3d middle = e == 0 ? leaf.origin : leaf.tip_middle();
    design.reference[e] = middle + random.vector<3>(0.3 * L);
    design.displacement[e] =
        random.vector<3>(0.0003 * L) + leaf.axes * Vector3d(-0.0005 * e, 0, 0.015 * e) * L;
    design.rotation[e] =
        rotation_exp(random.vector<3>(0.01) + leaf.axes * Vector3d(0.02, -0.05, 0.0));
  }
  return design;
}

/// Along every number of the design.
inline std::vector<std::pair<std::string, DesignRate>> all_directions(const LeafSpring& leaf,
                                                                      synthetic::Random& random) {
  std::vector<std::pair<std::string, DesignRate>> all;
  const auto add = [&](const char* name) -> DesignRate& {
    return all.emplace_back(name, still()).second;
  };
  const double L = leaf.length;
  add("length").rate.length = L;
  add("width").rate.width = leaf.width;
  add("thickness").rate.thickness = leaf.thickness;
  add("E").rate.material.youngs_modulus = leaf.material.youngs_modulus;
  add("nu").rate.material.poissons_ratio = leaf.material.poissons_ratio;
  add("rho").rate.material.density = leaf.material.density;
  add("origin").rate.origin = random.vector<3>(L);
  add("axes").turn = random.vector<3>(1.0);
  for (Vector3d& r : add("references").reference) r = random.vector<3>(0.1 * L);
  return all;
}

/// A leaf of a design and what is asked of it.
struct Subject {
  const Design& design;
  Flexure flexure;
  const LeafLinear& linear;
  const LeafGradient<double>& gradient;
  LeafRows rows;
  MatrixXd y;       ///< columns, scaled, the unknowns where the forms are stationary
  VectorXd lambda;  ///< of them
  /// Force on the bodies (12), then the forms, of any design.
  std::function<std::vector<double>(const Design&)> answer;
};

inline void check_derivatives(const Subject& of, synthetic::Random& random) {
  const LeafSpring& leaf = of.design.leaf;
  const LeafScale& scale = of.linear.scale();
  const LeafRows& rows = of.rows;
  const double L = leaf.length;
  const int m = rows.unknowns;
  const VectorXd mu = of.lambda * scale.mass / scale.energy;
  const LeafQuadratic<double> q = of.gradient.quadratic(of.y, mu);
  const std::vector<double> values = of.answer(of.design);
  for (int k = 0; k < mu.size(); ++k)
    CHECK(scale.energy * (q.stiffness[k] - mu[k] * q.mass[k]) ==
          Approx(values[12 + static_cast<std::size_t>(k)]).epsilon(1e-9));
  const MatrixXd shapes =
      m > 0 ? of.linear.static_shapes({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}) : MatrixXd(0, 12);
  for (const auto& [name, direction] : all_directions(leaf, random)) {
    const LeafVariation<double> v = variation(of.design, of.flexure, direction);
    const MatrixXd force_rate = of.gradient.force_rates({v});
    VectorXd state_rate = VectorXd::Zero(rows.size());
    MatrixXd change = force_rate.topRows(m);
    // the bodies' force once the unknowns follow
    VectorXd follow = VectorXd::Zero(m + 12);
    if (m > 0) {
      follow.tail(12) = shapes.transpose() * change;
      of.linear.solve(change);
      state_rate.head(m) = -change;
    }
    const VectorXd f = of.gradient.force(), df = force_rate + v.energy * f + rows.body_rows(follow);
    const Matrix3d &A = leaf.axes, dA = hat(direction.turn) * A;
    std::vector<double> exact;
    for (int i = 0; i < 12; i += 3) {
      const Vector3d fi = f.segment<3>(rows.internal() + i),
                     dfi = df.segment<3>(rows.internal() + i);
      const double unit = i % 6 == 0 ? scale.energy / L : scale.energy;
      const Vector3d g = unit * (A * dfi + dA * fi - (i % 6 == 0 ? v.length : 0.0) * (A * fi));
      exact.insert(exact.end(), g.begin(), g.end());
    }
    const MatrixXd q_rates = of.gradient.rates(q, of.y, {v});
    for (int k = 0; k < mu.size(); ++k)
      exact.push_back(scale.energy * (v.energy * q.stiffness[k] + q_rates(k, 0) +
                                      q.state.col(k).dot(state_rate)) -
                      scale.mass * v.mass * of.lambda[k] * q.mass[k]);
    const DesignRate& along = direction;
    const Derivatives r =
        ridders([&](double t) { return of.answer(moved(of.design, along, t)); }, 0, 0.01, 5);
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const double size = i < 12 ? VectorXd::Map(exact.data(), 12).cwiseAbs().maxCoeff() +
                                       VectorXd::Map(values.data(), 12).cwiseAbs().maxCoeff()
                                 : std::abs(values[i]) + std::abs(exact[i]);
      INFO(name << " " << i << ": " << exact[i] << " against " << r.value[i] << " ± " << r.error[i]
                << ", size " << size);
      CHECK(std::abs(exact[i] - r.value[i]) <= 1e-8 * size + 10 * r.error[i]);
      CHECK(r.error[i] < 1e-6 * size);
    }
  }
}

}  // namespace flexopt::held
