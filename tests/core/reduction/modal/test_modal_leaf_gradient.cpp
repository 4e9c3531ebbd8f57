#include "core/reduction/modal/modal_leaf_gradient.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/ridders.hpp"
#include "core/math/rotation.hpp"
#include "core/reduction/modal/modal_leaf_linear.hpp"
#include "support/models.hpp"
#include "support/synthetic_leaf.hpp"

using namespace flexopt;
using flexopt::synthetic::Random;

namespace {

// A leaf between two bodies: the numbers of a design, and where the bodies are.
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

DesignRate still() {
  DesignRate d;
  d.rate.origin.setZero();
  d.rate.length = d.rate.width = d.rate.thickness = 0;
  d.rate.material.youngs_modulus = d.rate.material.poissons_ratio = d.rate.material.density = 0;
  return d;
}

Design moved(const Design& design, const DesignRate& d, double t) {
  Design m = design;
  LeafSpring& l = m.leaf;
  l.origin += t * d.rate.origin;
  l.axes = rotation_exp(t * d.turn) * l.axes;
  l.length += t * d.rate.length;
  l.width += t * d.rate.width;
  l.thickness += t * d.rate.thickness;
  l.material.youngs_modulus += t * d.rate.material.youngs_modulus;
  l.material.poissons_ratio += t * d.rate.material.poissons_ratio;
  l.material.density += t * d.rate.material.density;
  for (int e = 0; e < 2; ++e) m.reference[e] += t * d.reference[e];
  return m;
}

EdgePoses edges(const Design& d, double share) {
  EdgePoses poses;
  for (int e = 0; e < 2; ++e) {
    const Vector3d middle = e == 0 ? d.leaf.origin : d.leaf.tip_middle();
    const Matrix3d R = rotation_exp(share * rotation_log(d.rotation[e]));
    poses[e] = {d.reference[e] + share * d.displacement[e] + R * (middle - d.reference[e]),
                R * d.leaf.axes};
  }
  return poses;
}

// From rest in steps, balanced.
std::unique_ptr<ModalLeaf> bent(const Design& d, const ModelOptions& model) {
  const auto mesh = std::make_shared<const PlateMesh>(leaf_shape(d.leaf, model));
  auto leaf = std::make_unique<ModalLeaf>(
      d.leaf, std::make_shared<const ModalModel>(mesh, model.method, model.modal_derivatives), 0);
  leaf->evaluate();
  EdgePoses now = edges(d, 0);
  const auto step = [&](double share) {
    const EdgePoses next = edges(d, share);
    Vector12d dq;
    for (int e = 0; e < 2; ++e)
      dq.segment<6>(6 * e) << next[e].position - now[e].position,
          rotation_log(next[e].axes * now[e].axes.transpose());
    leaf->move(next, dq);
    leaf->evaluate();
    now = next;
  };
  for (int s = 1; s <= 8; ++s)
    for (int i = 0; i < 12; ++i) step(s / 8.0);
  return leaf;
}

// Of increments of the bodies: edges by (displacement, spin) of both bodies.
Matrix12d edge_map(const Design& d, const EdgePoses& now) {
  Matrix12d map = Matrix12d::Identity();
  for (int e = 0; e < 2; ++e)
    map.block<3, 3>(6 * e, 6 * e + 3) =
        -hat(Vector3d(now[e].position - d.reference[e] - d.displacement[e]));
  return map;
}

// Force on the bodies, and yᵀ(K − λM)y with the amplitudes where they are stationary.
std::vector<double> answer(const Design& d, const ModelOptions& model, const MatrixXd& Y,
                           const VectorXd& lambda) {
  const auto leaf = bent(d, model);
  const Matrix12d map = edge_map(d, edges(d, 1));
  const VectorXd force = map.transpose() * leaf->evaluation().force;
  std::vector<double> all(force.begin(), force.end());
  const int m = leaf->model().amplitudes();
  const LeafDynamics dynamics = leaf->dynamics(m);
  for (int k = 0; k < lambda.size(); ++k) {
    const MatrixXd D = dynamics.stiffness - lambda[k] * dynamics.mass;
    const Vector12d y = map * Y.col(k);
    double q = y.dot(D.topLeftCorner<12, 12>() * y);
    const VectorXd b = D.bottomLeftCorner(m, 12) * y;
    if (m > 0) q -= b.dot(MatrixXd(D.bottomRightCorner(m, m)).partialPivLu().solve(b));
    for (int e = 0; e < 2; ++e) {  // the lever arms turn
      const Vector3d w = Y.block<3, 1>(6 * e + 3, k),
                     arm = edges(d, 1)[e].position - d.reference[e] - d.displacement[e];
      q += leaf->evaluation().force.segment<3>(6 * e).dot(w.cross(w.cross(arm)));
    }
    all.push_back(q);
  }
  return all;
}

LeafVariation<double> variation(const Design& design, const ModelOptions& model,
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

void check(Flexure flexure, Reduction method, ModalDerivativeSet set, double thickness = 2e-3) {
  Random random(7);
  ModelOptions model;
  model.flexure = flexure;
  model.method = method;
  model.modal_derivatives = set;
  model.mesh = flexure == Flexure::plate ? std::array{5, 2} : std::array{6, 1};
  Design design{models::leaf({0.3, -0.2, 0.1}, {2, 1, 0}, 0.1, 0.05, thickness), {}, {}, {}};
  const LeafSpring& leaf = design.leaf;
  const double L = leaf.length;
  for (int e = 0; e < 2; ++e) {
    const Vector3d middle = e == 0 ? leaf.origin : leaf.tip_middle();
    design.reference[e] = middle + random.vector<3>(0.3 * L);
    design.displacement[e] =
        random.vector<3>(0.0003 * L) + leaf.axes * Vector3d(-0.0005 * e, 0, 0.015 * e) * L;
    design.rotation[e] =
        rotation_exp(random.vector<3>(0.01) + leaf.axes * Vector3d(0.02, -0.05, 0.0));
  }
  const LeafScale scale(leaf, flexure);
  MatrixXd Y(12, 3);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 12; i += 3) Y.block<3, 1>(i, k) = random.vector<3>(i % 6 == 0 ? L : 1.0);
  const VectorXd lambda = Eigen::Vector3d(0, 40, 500) * scale.energy / scale.mass,
                 mu = lambda * scale.mass / scale.energy;

  const auto at = bent(design, model);
  const ModalLeafLinear linear(*at);
  const int m = linear.unknowns();
  LeafRows rows;
  rows.unknowns = m;
  const EdgePoses now = edges(design, 1);
  for (int e = 0; e < 2; ++e)
    rows.lever[e] = leaf.axes.transpose() *
                    (now[e].position - design.reference[e] - design.displacement[e]) / L;
  const auto rate = std::make_shared<const ModalModelRate>(
      at->model(), std::make_shared<const PlateMeshRate>(*at->model().mesh()));
  const ModalLeafGradient gradient(*at, rate, rows);

  // scaled increments, the amplitudes where the forms are stationary
  MatrixXd y = MatrixXd::Zero(rows.size(), 3);
  for (int k = 0; k < 3; ++k) {
    for (int e = 0; e < 2; ++e) {
      y.block<3, 1>(rows.body(e), k) = leaf.axes.transpose() * Y.block<3, 1>(6 * e, k) / L;
      y.block<3, 1>(rows.body(e) + 3, k) = leaf.axes.transpose() * Y.block<3, 1>(6 * e + 3, k);
    }
    if (m == 0) continue;
    MatrixXd V = MatrixXd::Zero(m + 12, m + 1);
    V.topLeftCorner(m, m).setIdentity();
    V.bottomRightCorner(12, 1) = rows.edge_rows(y.col(k)).bottomRows(12);
    const MatrixXd M = linear.mass_times(V).topRows(m), &H = at->generalised_tangent();
    const VectorXd b =
        H.bottomLeftCorner(m, 6) * (at->frame().B * V.bottomRightCorner(12, 1)) - mu[k] * M.col(m);
    y.col(k).head(m) = -(H.bottomRightCorner(m, m) - mu[k] * M.leftCols(m)).partialPivLu().solve(b);
  }
  const LeafQuadratic<double> q = gradient.quadratic(y, mu);
  const std::vector<double> values = answer(design, model, Y, lambda);
  for (int k = 0; k < 3; ++k)
    CHECK(scale.energy * (q.stiffness[k] - mu[k] * q.mass[k]) ==
          Approx(values[12 + k]).epsilon(1e-9));

  std::vector<std::pair<std::string, DesignRate>> directions;
  const auto add = [&](const char* name, const DesignRate& d) { directions.emplace_back(name, d); };
  DesignRate d = still();
  d.rate.length = leaf.length;
  add("length", d);
  d = still();
  d.rate.width = leaf.width;
  add("width", d);
  d = still();
  d.rate.thickness = leaf.thickness;
  add("thickness", d);
  d = still();
  d.rate.material.youngs_modulus = leaf.material.youngs_modulus;
  add("E", d);
  d = still();
  d.rate.material.poissons_ratio = leaf.material.poissons_ratio;
  add("nu", d);
  d = still();
  d.rate.material.density = leaf.material.density;
  add("rho", d);
  d = still();
  d.rate.origin = random.vector<3>(L);
  add("origin", d);
  d = still();
  d.turn = random.vector<3>(1.0);
  add("axes", d);
  d = still();
  for (Vector3d& r : d.reference) r = random.vector<3>(0.1 * L);
  add("references", d);
  for (const auto& [name, direction] : directions) {
    const LeafVariation<double> v = variation(design, model, direction);
    const MatrixXd force_rate = gradient.force_rates({v});
    VectorXd state_rate = VectorXd::Zero(rows.size());
    VectorXd change = force_rate.topRows(m);
    if (m > 0) {
      linear.solve(change);
      state_rate.head(m) = -change;
    }
    // the bodies' force once the amplitudes follow
    VectorXd follow = VectorXd::Zero(m + 12);
    if (m > 0)
      follow.tail(12) = at->frame().B.transpose() *
                        (at->generalised_tangent().topRightCorner(6, m) * state_rate.head(m));
    const VectorXd f = gradient.force(), df = force_rate + v.energy * f + rows.body_rows(follow);
    const Matrix3d &A = leaf.axes, dA = hat(direction.turn) * A;
    std::vector<double> exact;
    for (int i = 0; i < 12; i += 3) {
      const Vector3d fi = f.segment<3>(rows.internal() + i),
                     dfi = df.segment<3>(rows.internal() + i);
      const double unit = i % 6 == 0 ? scale.energy / L : scale.energy;
      const Vector3d g = unit * (A * dfi + dA * fi - (i % 6 == 0 ? v.length : 0.0) * (A * fi));
      exact.insert(exact.end(), g.begin(), g.end());
    }
    for (int k = 0; k < 3; ++k)
      exact.push_back(scale.energy * (v.energy * q.stiffness[k] + gradient.rate(q, y, k, v) +
                                      q.state.col(k).dot(state_rate)) -
                      scale.mass * v.mass * lambda[k] * q.mass[k]);
    const Derivatives r =
        ridders([&](double t) { return answer(moved(design, direction, t), model, Y, lambda); }, 0,
                0.01, 5);
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

}  // namespace

TEST_CASE("derivatives of a leaf on the quadratic manifold agree with differences of rebuilt ones",
          "[reduction][slow]") {
  check(Flexure::plate, Reduction::quadratic_manifold, ModalDerivativeSet::all);
  check(Flexure::beam, Reduction::quadratic_manifold, ModalDerivativeSet::all);
}

TEST_CASE("derivatives of a leaf of modal derivatives agree with differences of rebuilt ones",
          "[reduction][slow]") {
  check(Flexure::plate, Reduction::modal_derivatives, ModalDerivativeSet::all);
  check(Flexure::plate, Reduction::modal_derivatives, ModalDerivativeSet::bending);
  check(Flexure::beam, Reduction::modal_derivatives, ModalDerivativeSet::all);
}

TEST_CASE("derivatives of a plate with third-order fields agree with differences of rebuilt ones",
          "[reduction][slow]") {
  check(Flexure::plate, Reduction::modal_derivatives, ModalDerivativeSet::third_order);
}

TEST_CASE("derivatives of a beam with third-order fields agree with differences of rebuilt ones",
          "[reduction][slow]") {
  // at 2 mm a field stands at the threshold of being kept
  check(Flexure::beam, Reduction::modal_derivatives, ModalDerivativeSet::third_order, 2.3e-3);
}
