#include "core/math/decompositions.hpp"

#include <Eigen/Dense>
#include <limits>

#include "core/elements/leaf/chord_frame.hpp"
#include "superelement_bodies.hpp"
#include "superelement_law.hpp"
#include "support/real_rotations.hpp"

using namespace flexopt;
using namespace flexopt::bodies;
using flexopt::synthetic::Random;

namespace {

// The energy once more in extended precision, from the definition Φ_CB q = 0 alone, without any
// derivative: the frame by a secant-like iteration with the matrix of the undeformed body.
using RX = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using RXX = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

struct RealBody {
  RXX K, Phi;
  std::vector<R3> X;
  explicit RealBody(const SuperelementModel& m)
      : K(m.stiffness.topLeftCorner(m.coordinates(), m.coordinates()).cast<Real>()),
        Phi(m.frame_modes.cast<Real>()) {
    for (const Vector3d& x : m.nodes) X.push_back(x.cast<Real>());
  }

  // Nodes at exp(t v) of the given ones.
  Real energy(const std::vector<NodePose>& nodes, const NodePose& near, const VectorXd& v,
              Real t) const {
    const int m = static_cast<int>(nodes.size());
    std::vector<R3> p(m);
    std::vector<R33> R(m);
    for (int a = 0; a < m; ++a) {
      p[a] = nodes[a].position.cast<Real>() + t * v.segment<3>(6 * a).cast<Real>();
      R[a] = exp_real(t * v.segment<3>(6 * a + 3).cast<Real>()) * nodes[a].axes.cast<Real>();
    }
    R3 x = near.position.cast<Real>();
    R33 F = near.axes.cast<Real>();
    RX q(6 * m);
    for (int k = 0; k < 400; ++k) {
      for (int a = 0; a < m; ++a) {
        q.segment<3>(6 * a) = F.transpose() * (p[a] - x) - X[a];
        q.segment<3>(6 * a + 3) = log_real(F.transpose() * R[a]);
      }
      const R6 c = Phi * q;
      if (c.norm() < 1e-20L) break;
      x += F * c.head<3>();
      F = F * exp_real(c.tail<3>());
    }
    return 0.5L * q.dot(K * q);
  }
};

// Rotations of rounded matrices are made exact, so that the differences see none of it.
std::vector<NodePose> exact(std::vector<NodePose> nodes) {
  for (NodePose& n : nodes) n.axes = orthonormalised(n.axes);
  return nodes;
}

VectorXd local_coordinates(const SuperelementModel& model, const std::vector<NodePose>& nodes,
                           const NodePose& frame) {
  VectorXd q(model.coordinates());
  for (std::size_t a = 0; a < nodes.size(); ++a)
    q.segment<6>(6 * static_cast<Eigen::Index>(a))
        << frame.axes.transpose() * (nodes[a].position - frame.position) - model.nodes[a],
        rotation_log(frame.axes.transpose() * nodes[a].axes);
  return q;
}

struct Derivatives {
  Real first, second;
};
Derivatives along(const RealBody& body, const std::vector<NodePose>& nodes, const NodePose& frame,
                  const VectorXd& v) {
  const Real h = 2e-3L;  // truncation h⁶, rounding 1e-19 / h²
  Real E[7];
  for (int k = -3; k <= 3; ++k) E[k + 3] = body.energy(nodes, frame, v, k * h);
  return {
      ((E[6] - E[0]) - 9 * (E[5] - E[1]) + 45 * (E[4] - E[2])) / (60 * h),
      (2 * (E[6] + E[0]) - 27 * (E[5] + E[1]) + 270 * (E[4] + E[2]) - 490 * E[3]) / (180 * h * h)};
}

}  // namespace

TEST_CASE("a superelement's force and tangent are the derivatives of its energy") {
  for (int m = 2; m <= 8; ++m) {
    const SuperelementModel model = irregular(10 + m, m, m % 3);
    check_superelement(model);
    Random random(m);
    const std::vector<NodePose> nodes = exact(deformed(model, random, 0.03, 0.25));
    Superelement element(model);
    REQUIRE(element.evaluate(nodes));
    const RealBody oracle(model);
    const VectorXd unit = units(model);
    const int n = model.coordinates();
    const double force_size = element.force().cwiseProduct(unit).norm(),
                 tangent_size = (unit.asDiagonal() * element.tangent() * unit.asDiagonal()).norm();
    REQUIRE(force_size > 0);
    CHECK((element.tangent() - element.tangent().transpose()).norm() <
          1e-9 * element.tangent().norm());
    CHECK(static_cast<double>(oracle.energy(nodes, element.frame(), VectorXd::Zero(n), 0)) ==
          Approx(element.energy()).epsilon(1e-12));
    for (int k = 0; k < 12; ++k) {
      VectorXd v(n);
      for (double& x : v) x = random();
      v.normalize();
      v = unit.asDiagonal() * v;  // displacements in units of the size
      const Derivatives d = along(oracle, nodes, element.frame(), v);
      INFO("m = " << m << ", direction " << k);
      CHECK(std::abs(static_cast<double>(d.first) - element.force().dot(v)) < 1e-9 * force_size);
      CHECK(std::abs(static_cast<double>(d.second) - v.dot(element.tangent() * v)) <
            1e-9 * tangent_size);
    }
  }
}

TEST_CASE("the geometric terms of a superelement's tangent are there") {
  // with the stresses of another state the tangent differs: the test above would see it missing
  const SuperelementModel model = irregular(3, 4);
  Random random(3);
  const std::vector<NodePose> nodes = deformed(model, random, 0.03, 0.25);
  Superelement element(model);
  REQUIRE(element.evaluate(nodes));
  const MatrixXd K = element.tangent();
  const VectorXd none = VectorXd::Zero(model.coordinates());
  REQUIRE(element.evaluate(nodes, &none));
  CHECK((K - element.tangent()).norm() > 1e-4 * K.norm());
  const VectorXd present = element.local();
  REQUIRE(element.evaluate(nodes, &present));
  CHECK((K - element.tangent()).norm() < 1e-13 * K.norm());
}

TEST_CASE("a superelement does not notice a thousand rigid motions") {
  const SuperelementModel model = irregular(7, 5);
  Random random(7);
  const std::vector<NodePose> nodes = deformed(model, random, 0.02, 0.2);
  Superelement element(model);
  REQUIRE(element.evaluate(nodes));
  const VectorXd unit = units(model), q = element.local(), g = element.force();
  const double energy = element.energy();
  double residual = 0, energy_error = 0, q_error = 0, force_error = 0, tangent_error = 0;
  const MatrixXd K = element.tangent();
  Matrix3d R = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero();
  for (int k = 0; k < 1000; ++k) {
    R = orthonormalised(random_rotation(random, 0.7) * R);
    p = 0.95 * p + random.vector<3>(0.1);
    REQUIRE(element.evaluate(moved(nodes, R, p)));
    const VectorXd c =
        model.frame_modes * local_coordinates(model, moved(nodes, R, p), element.frame());
    residual = std::max({residual, c.head<3>().norm() / model.size(), c.tail<3>().norm()});
    energy_error = std::max(energy_error, std::abs(element.energy() / energy - 1));
    q_error = std::max(
        q_error, (unit.cwiseInverse().asDiagonal() * (element.local() - q)).cwiseAbs().maxCoeff());
    force_error = std::max(
        force_error, (unit.asDiagonal() * (turned(R.transpose(), element.force()) - g)).norm() /
                         (unit.asDiagonal() * g).norm());
    if (k % 100 == 0) {
      MatrixXd back(K.rows(), K.cols());
      for (int j = 0; j < K.cols(); ++j)
        back.col(j) = turned(R.transpose(), element.tangent().col(j));
      MatrixXd both(K.rows(), K.cols());
      for (int i = 0; i < K.rows(); ++i)
        both.row(i) = turned(R.transpose(), back.row(i).transpose()).transpose();
      tangent_error =
          std::max(tangent_error, (unit.asDiagonal() * (both - K) * unit.asDiagonal()).norm() /
                                      (unit.asDiagonal() * K * unit.asDiagonal()).norm());
    }
  }
  CHECK(residual < 1e-12);
  CHECK(q_error < 1e-12);
  CHECK(energy_error < 1e-12);
  CHECK(force_error < 1e-12);
  CHECK(tangent_error < 1e-12);
}

TEST_CASE("the chord frame of a leaf is a case of the floating frame") {
  // u1 = 0, u2y = u2z = 0, θ1x + θ2x = 0 are linear in q: Φ_CB of the chord frame
  const double L = 0.1;
  SuperelementModel model;
  model.nodes = {Vector3d::Zero(), Vector3d(L, 0, 0)};
  model.frame_modes = MatrixXd::Zero(6, 12);
  MatrixXd& Phi = model.frame_modes;
  Phi(0, 0) = Phi(1, 1) = Phi(2, 2) = 1;
  Phi(3, 3) = Phi(3, 9) = 0.5;
  Phi(4, 8) = -1 / L;  // the frame turns by −u2z/L about y
  Phi(4, 2) = 1 / L;
  Phi(5, 7) = 1 / L;
  Phi(5, 1) = -1 / L;
  Random random(4);
  Matrix6d W;
  for (double& x : W.reshaped()) x = random();
  W = (W * W.transpose()).eval();
  // e = E q of the frame's own coordinates, up to their rigid motions
  Eigen::Matrix<double, 6, 12> E = Eigen::Matrix<double, 6, 12>::Zero();
  E(elongation, 6) = 1;
  E(elongation, 0) = -1;
  E(theta1y, 4) = E(theta1z, 5) = E(theta2y, 10) = E(theta2z, 11) = 1;
  for (const int row : {theta1y, theta2y}) E.row(row) -= Phi.row(4);
  for (const int row : {theta1z, theta2z}) E.row(row) -= Phi.row(5);
  E(twist, 9) = 1;
  E(twist, 3) = -1;
  model.stiffness = E.transpose() * W * E;
  model.mass = MatrixXd::Identity(12, 12);
  check_superelement(model);

  for (int k = 0; k < 5; ++k) {
    const std::vector<NodePose> nodes = deformed(model, random, 0.1, 0.6);
    Superelement element(model);
    REQUIRE(element.evaluate(nodes));
    const ChordFrame chord = chord_frame(
        {EdgePose{nodes[0].position, nodes[0].axes}, EdgePose{nodes[1].position, nodes[1].axes}},
        L);
    REQUIRE(chord.converged);
    CHECK((chord.axes - element.frame().axes).norm() < 1e-12);
    CHECK((nodes[0].position - element.frame().position).norm() < 1e-12 * L);
    const Vector6d g = W * chord.e;
    const VectorXd force = chord.B.transpose() * g;
    CHECK((force - element.force()).norm() < 1e-11 * force.norm());
    const MatrixXd K = chord.B.transpose() * W * chord.B + geometric_stiffness(chord, g);
    CHECK((K - element.tangent()).norm() < 1e-11 * K.norm());
  }
}

TEST_CASE("a superelement's mass is that of the body, turned") {
  const PlateBody plate{.plate = models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.06, 0.004),
                        .mesh = {5, 4},
                        .vibration_modes = 3};
  const SuperelementModel model = condense(plate).superelement;
  Random random(12);
  const auto nodes = deformed(model, random, 0.0, 0.0);
  Superelement element(model);
  REQUIRE(element.evaluate(nodes));
  const MatrixXd M = element.mass();
  REQUIRE(M.rows() == model.coordinates() + 3);
  // translations carry the whole mass, in every direction
  const double mass = plate.plate.material.density * 0.1 * 0.06 * 0.004;
  for (int d = 0; d < 3; ++d) {
    VectorXd v = VectorXd::Zero(M.rows());
    for (int a = 0; a < 4; ++a) v[6 * a + d] = 1;
    CHECK(v.dot(M * v) == Approx(mass).epsilon(1e-9));
  }
}

TEST_CASE("places that are not finite have no frame") {
  const SuperelementModel model = irregular(14, 3);
  Random random(14);
  std::vector<NodePose> nodes = deformed(model, random, 0.01, 0.1);
  Superelement element(model);
  REQUIRE(element.evaluate(nodes));
  nodes[1].position[0] = std::numeric_limits<double>::infinity();
  CHECK_FALSE(element.evaluate(nodes));
}
