// The full plate leaf: laws first, then derivatives, then closed forms.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/elements/plate/plate_leaf.hpp"
#include "core/math/rotation.hpp"
#include "core/reduction/expansion/tube_expansion.hpp"
#include "support/moved.hpp"
#include "support/plate_laws.hpp"

using namespace flexopt;
using namespace flexopt::plate_laws;

namespace {

std::shared_ptr<const PlateMesh> make_mesh(double w = 0.5, double t = 0.006,
                                           std::array<int, 2> mesh = {6, 3}) {
  return std::make_shared<PlateMesh>(PlateShape{w, t, 0.3, mesh, true});
}

// Moves the edges by dq and brings the internal unknowns to rest.
void move_to_rest(PlateLeaf& leaf, const Vector12d& dq) {
  const EdgePoses edges = moved(leaf.state().edges, dq);
  leaf.assemble();
  leaf.step(edges, leaf.internal_step(dq), dq);
  for (int k = 0; k < 20; ++k) {
    leaf.assemble();
    if (leaf.correction() < 1e-11) break;
    leaf.step(edges, leaf.internal_step(Vector12d::Zero()), Vector12d::Zero());
  }
  leaf.set_state(leaf.state());  // the tangent without linearised stresses
  leaf.assemble();
  REQUIRE(leaf.correction() < 1e-8);
}

// Bent, twisted and slightly pulled, in equilibrium between its edges.
void bend(PlateLeaf& leaf, const std::shared_ptr<const PlateMesh>& mesh) {
  ChordLeaf chord(mesh);
  REQUIRE(chord.solve({0.15, -0.1, 0.01}, {3, 0.2, 0.1}).converged);
  leaf.set_state(chord.plate().state());
  leaf.assemble();
  REQUIRE(leaf.correction() < 1e-8);
}

}  // namespace

TEST_CASE("the undeflected leaf stores no energy and carries no force") {
  PlateLeaf leaf(make_mesh());
  leaf.assemble();
  CHECK(std::abs(leaf.energy()) < 1e-11);
  CHECK(leaf.force().cwiseAbs().maxCoeff() < 1e-9);
  CHECK(leaf.residual().cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("a rigid motion stores no energy and turns force and tangent with it") {
  const auto mesh = make_mesh();
  PlateLeaf leaf(mesh);
  bend(leaf, mesh);
  const double energy = leaf.energy();
  const Vector12d force = leaf.force();
  const Matrix12d tangent = leaf.tangent();
  REQUIRE(energy > 1e-3);

  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  const int n = mesh->functions_per_line();
  for (int trial = 0; trial < 5; ++trial) {
    const Matrix3d Q = rotation_exp(3 * Vector3d(u(random), u(random), u(random)));
    const Vector3d shift(u(random), u(random), u(random));
    PlateLeaf::State moved = leaf.state();
    for (EdgePose& e : moved.edges) e = {Q * e.position + shift, Q * e.axes};
    for (int i = 1; i + 1 < mesh->lines(); ++i) {
      Eigen::Map<MatrixXd> r(moved.x.data() + leaf.block_offset(i), n, 3);
      r = (r * Q.transpose()).eval();
      for (int j = 0; j < mesh->nodes_per_line(); ++j) r.row(4 * j) += shift.transpose();
    }
    PlateLeaf other(mesh);
    other.set_state(moved);
    other.assemble();
    Matrix12d T = Matrix12d::Zero();
    for (int k = 0; k < 4; ++k) T.block<3, 3>(3 * k, 3 * k) = Q;
    CHECK(std::abs(other.energy() / energy - 1) < 1e-9);
    CHECK((other.force() - T * force).norm() < 1e-9 * tangent.norm() * 1e-2);
    CHECK((other.tangent() - T * tangent * T.transpose()).norm() < 1e-10 * tangent.norm());
  }
}

TEST_CASE("the internal force is the gradient of the energy and the tangent its Hessian") {
  const auto mesh = make_mesh();
  PlateLeaf leaf(mesh);
  const PlateLeaf::State state = random_state(*mesh, 7);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  VectorXd dx(leaf.unknowns());
  for (double& x : dx) x = u(random);
  Vector12d dq;
  for (double& x : dq) x = u(random);

  const double e0 = energy_along(leaf, state, 0 * dx, 0 * dq);
  const double slope = leaf.residual().dot(dx) + leaf.edge_force().dot(dq);
  REQUIRE(std::abs(slope) > 0);
  double rest[2];
  for (int k = 0; k < 2; ++k) {
    const double h = 2e-4 / (1 << k);
    rest[k] = std::abs(energy_along(leaf, state, h * dx, h * dq) - e0 - h * slope);
  }
  CHECK(observed_rate(rest[0], rest[1]) == Approx(2).margin(0.1));

  // K_ff v = w is solved exactly when v = K_ff⁻¹ w: compare with differences of the residual.
  energy_along(leaf, state, 0 * dx, 0 * dq);
  VectorXd v = dx;
  leaf.solve(v);
  const VectorXd w = dx / v.norm();
  v /= v.norm();
  const Vector12d coupled = leaf.coupling().transpose() * v;
  const Matrix12d edge = leaf.edge_tangent();
  VectorXd Kv[2];
  Vector12d Kbv[2];
  for (int k = 0; k < 2; ++k) {
    const double h = 4e-3 / (1 << k);  // differences of second order, extrapolated to fourth
    energy_along(leaf, state, h * v, 0 * dq);
    Kv[k] = leaf.residual() / (2 * h);
    Kbv[k] = leaf.edge_force() / (2 * h);
    energy_along(leaf, state, -h * v, 0 * dq);
    Kv[k] -= leaf.residual() / (2 * h);
    Kbv[k] -= leaf.edge_force() / (2 * h);
  }
  // the energy is quartic: extrapolation is exact but for rounding of the membrane forces
  CHECK(((4 * Kv[1] - Kv[0]) / 3 - w).norm() < 1e-5 * w.norm());
  CHECK(((4 * Kbv[1] - Kbv[0]) / 3 - coupled).norm() < 1e-6 * coupled.norm());

  // All blocks at once: the rest beyond the quadratic term is of third order.
  energy_along(leaf, state, 0 * dx, 0 * dq);
  const double along = leaf.residual().dot(v) + leaf.edge_force().dot(dq);
  const double curvature = v.dot(w) + 2 * dq.dot(coupled) + dq.dot(edge * dq);
  for (int k = 0; k < 2; ++k) {
    const double h = 4e-3 / (1 << k);
    rest[k] = std::abs(energy_along(leaf, state, h * v, h * dq) - e0 - h * along -
                       0.5 * h * h * curvature);
  }
  CHECK(observed_rate(rest[0], rest[1]) == Approx(3).margin(0.1));

  // The edges' own block: second difference of the energy along edge motions.
  for (int trial = 0; trial < 4; ++trial) {
    for (double& x : dq) x = u(random);
    double second[2];
    for (int k = 0; k < 2; ++k) {
      const double s = 4e-3 / (1 << k);
      second[k] = (energy_along(leaf, state, 0 * dx, s * dq) - 2 * e0 +
                   energy_along(leaf, state, 0 * dx, -s * dq)) /
                  (s * s);
    }
    const double extrapolated = (4 * second[1] - second[0]) / 3;
    CHECK(extrapolated == Approx(dq.dot(edge * dq)).epsilon(1e-6));
  }
}

TEST_CASE("the condensed tangent is the derivative of the condensed force and symmetric") {
  const auto mesh = make_mesh();
  PlateLeaf leaf(mesh);
  bend(leaf, mesh);
  const PlateLeaf::State state = leaf.state();
  const Matrix12d K = leaf.tangent();
  const Vector12d f = leaf.force();
  CHECK((K - K.transpose()).norm() < 1e-12 * K.norm());
  // rigid translations meet no stiffness
  for (int c = 0; c < 3; ++c) {
    Vector12d shift = Vector12d::Zero();
    shift[c] = shift[6 + c] = 1;
    CHECK((K * shift).norm() < 1e-9 * K.norm());
  }
  std::mt19937 random(17);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 3; ++trial) {
    Vector12d dq;
    for (double& x : dq) x = u(random);
    double second[2];
    for (int k = 0; k < 2; ++k) {
      const double s = 1e-5 / (1 << k);
      double e[2];
      for (int side = 0; side < 2; ++side) {
        leaf.set_state(state);
        move_to_rest(leaf, (side == 0 ? s : -s) * dq);
        e[side] = leaf.force().dot(dq);
      }
      second[k] = (e[0] - e[1]) / (2 * s);
    }
    // force · dq along a screw motion differs from dqᵀ K dq by no first-order term
    CHECK((4 * second[1] - second[0]) / 3 == Approx(dq.dot(K * dq)).epsilon(1e-6));
  }
  CHECK(f.norm() > 0);
}

TEST_CASE("mass sums to density times volume, and to its moments of inertia") {
  const auto mesh = make_mesh(0.7, 0.01, {5, 4});
  PlateLeaf leaf(mesh);
  leaf.assemble();
  const int n = leaf.unknowns();
  // rigid motions: K⁻¹ of the constraint modes reproduces them exactly
  MatrixXd X = leaf.coupling();
  leaf.solve(X);
  MatrixXd T(n + 12, 12);
  T << -X, Matrix12d::Identity();
  const MatrixXd M = leaf.mass(T);
  auto rigid = [](const Vector3d& v, const Vector3d& w) {
    Vector12d q;
    q << v, w, v + w.cross(Vector3d::UnitX()), w;
    return q;
  };
  const double area = 0.7;
  for (int c = 0; c < 3; ++c) {
    const Vector12d q = rigid(Vector3d::Unit(c), Vector3d::Zero());
    CHECK(q.dot(M * q) == Approx(area).epsilon(1e-9));
  }
  const double along = area / 3, across = area * 0.7 * 0.7 / 12;
  const Vector12d rx = rigid(Vector3d::Zero(), Vector3d::UnitX()),
                  ry = rigid(Vector3d::Zero(), Vector3d::UnitY()),
                  rz = rigid(Vector3d::Zero(), Vector3d::UnitZ());
  CHECK(rx.dot(M * rx) == Approx(across).epsilon(1e-9));
  CHECK(ry.dot(M * ry) == Approx(along).epsilon(1e-9));
  CHECK(rz.dot(M * rz) == Approx(along + across).epsilon(1e-9));
}

TEST_CASE("fixed-interface modes are mass-orthonormal and solve their eigenproblem") {
  const auto mesh = make_mesh(0.3, 0.005, {8, 4});
  PlateLeaf leaf(mesh);
  leaf.assemble();
  const auto modes = leaf.modes(6);
  REQUIRE(modes.size() == 6);
  for (std::size_t a = 0; a < modes.size(); ++a) {
    const VectorXd Mv = leaf.mass_times(modes[a].shape);
    for (std::size_t b = 0; b < modes.size(); ++b)
      CHECK(modes[b].shape.dot(Mv) == Approx(a == b ? 1 : 0).margin(1e-8));
    VectorXd x = Mv * modes[a].omega2;
    leaf.solve(x);
    CHECK((x - modes[a].shape).norm() < 1e-7 * modes[a].shape.norm());
    if (a > 0) CHECK(modes[a].omega2 >= modes[a - 1].omega2);
  }
  // first bending mode of a clamped–clamped strip with free edges: between the beam's 22.373² E I
  // (plane stress) and the same with plane strain
  const double low = (1 - 0.09) * 22.3733 * 22.3733, high = 22.3733 * 22.3733;
  CHECK(modes[0].omega2 > low);
  CHECK(modes[0].omega2 < high);
}
