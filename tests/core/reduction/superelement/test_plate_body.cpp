#include "core/math/decompositions.hpp"

#include <Eigen/Dense>

#include "core/elements/plate/plate_leaf.hpp"
#include "superelement_bodies.hpp"
#include "superelement_law.hpp"

using namespace flexopt;
using namespace flexopt::bodies;

namespace {

VectorXd scaled_eigenvalues(const SuperelementModel& model) {
  const VectorXd unit = units(model);
  const int n = model.coordinates();
  return symmetric_eigenvalues(unit.asDiagonal() * model.stiffness.topLeftCorner(n, n) *
                               unit.asDiagonal());
}

PlateBody seed_patch() {
  PlateBody body;
  body.plate =
      models::leaf({0, 0, 0}, {1, 0, 0}, 0.04, 0.05, 1.98e-3, {"seed", 21.5e9, 0.3, 1000, {}});
  return body;
}

}  // namespace

TEST_CASE("condensed bodies have six motions without energy and no more") {
  const VectorXd eigen = scaled_eigenvalues(condense(seed_patch()).superelement);
  CHECK(eigen.head<6>().cwiseAbs().maxCoeff() < 1e-12 * eigen.maxCoeff());
  CHECK(eigen[6] > 1e-8 * eigen.maxCoeff());  // bending against membrane: (t/L)² / 12
}

TEST_CASE("a segment between rigid edges is the undeflected plate leaf") {
  const LeafSpring leaf = models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4);
  const CondensedPlate condensed = condense({.plate = leaf,
                                             .mesh = {10, 4},
                                             .interface = Interface::rigid_edges,
                                             .free_edges = {true, true},
                                             .vibration_modes = 2});
  check_superelement(condensed.superelement);
  LeafSpring flat = leaf;
  flat.axes.setIdentity();
  flat.base = 1;  // both edges move
  FullLeaf full(flat, std::make_shared<PlateMesh>(plate_shape(leaf, {10, 4}, true)), 0);
  full.evaluate();
  const LeafDynamics dynamics = full.dynamics(2);
  const VectorXd unit = units(condensed.superelement);
  const auto scaled = [&](const MatrixXd& A) {
    return MatrixXd(unit.asDiagonal() * A.topLeftCorner(12, 12) * unit.asDiagonal());
  };
  const auto same = [&](const MatrixXd& A, const MatrixXd& B) {
    return (scaled(A) - scaled(B)).norm() / scaled(B).norm();
  };
  CHECK(same(condensed.superelement.stiffness, full.evaluation().tangent) < 1e-9);
  CHECK(same(condensed.superelement.mass, dynamics.mass) < 1e-9);
  for (int k = 0; k < 2; ++k)
    CHECK(condensed.superelement.stiffness(12 + k, 12 + k) ==
          Approx(dynamics.internal_stiffness(k, k)).epsilon(1e-6));
  // soft directions do not drown in the norm
  const MatrixXd A = Lu(scaled(condensed.superelement.stiffness).bottomRightCorner(6, 6)).inverse(),
                 B = Lu(scaled(full.evaluation().tangent).bottomRightCorner(6, 6)).inverse();
  for (int i = 0; i < 6; ++i) CHECK(A(i, i) == Approx(B(i, i)).epsilon(1e-8));
}

TEST_CASE("a four-node patch passes constant strains, curvatures and twist exactly") {
  const PlateBody body = seed_patch();
  const SuperelementModel model = condense(body).superelement;
  check_superelement(model);
  const double a = 0.04, b = 0.05, t = body.plate.thickness, E = 21.5e9, nu = 0.3;
  const double A = E * t / (1 - nu * nu), D = A * t * t / 12, G = E / 2 / (1 + nu), area = a * b;
  struct State {
    const char* name;
    Vector6d (*at)(double x, double y);
    double energy;
  };
  const State states[] = {
      {"ε11", [](double x, double) { return Vector6d{x, 0, 0, 0, 0, 0}; }, 0.5 * A * area},
      {"ε22", [](double, double y) { return Vector6d{0, y, 0, 0, 0, 0}; }, 0.5 * A * area},
      {"γ12", [](double, double y) { return Vector6d{y, 0, 0, 0, 0, -0.5}; }, 0.5 * G * t * area},
      {"κ11", [](double x, double) { return Vector6d{0, 0, x * x / 2, 0, -x, 0}; }, 0.5 * D * area},
      {"κ22", [](double, double y) { return Vector6d{0, 0, y * y / 2, y, 0, 0}; }, 0.5 * D * area},
      {"κ12", [](double x, double y) { return Vector6d{0, 0, x * y, x, -y, 0}; },
       D * (1 - nu) * area}};
  VectorXd q(24), p(24);
  for (const State& s : states) {
    for (int k = 0; k < 4; ++k) q.segment<6>(6 * k) = s.at(model.nodes[k][0], model.nodes[k][1]);
    INFO(s.name);
    CHECK(0.5 * q.dot(model.stiffness * q) == Approx(s.energy).epsilon(1e-11));
  }
  // and energies do not mix, but for Poisson's ratio
  for (int k = 0; k < 4; ++k) {
    q.segment<6>(6 * k) = states[0].at(model.nodes[k][0], model.nodes[k][1]);
    p.segment<6>(6 * k) = states[1].at(model.nodes[k][0], model.nodes[k][1]);
  }
  CHECK(p.dot(model.stiffness * q) == Approx(nu * A * area).epsilon(1e-11));
}

TEST_CASE("the forces of a constantly strained patch are its edge stresses") {
  // consistent nodal forces of a constant ε11: half of A ε b at each corner, no drilling moments
  const PlateBody body = seed_patch();
  const SuperelementModel model = condense(body).superelement;
  const double t = body.plate.thickness, A = 21.5e9 * t / (1 - 0.09);
  VectorXd q = VectorXd::Zero(24);
  for (int k = 0; k < 4; ++k) q[6 * k] = model.nodes[k][0];
  const VectorXd f = model.stiffness * q;
  for (int k = 0; k < 4; ++k) {
    CHECK(f[6 * k] == Approx((k >= 2 ? 1 : -1) * A * 0.05 / 2).epsilon(1e-10));
    CHECK(f[6 * k + 1] == Approx((k % 2 == 1 ? 1 : -1) * 0.3 * A * 0.04 / 2).epsilon(1e-10));
    // Allman's parabola takes the work of the constant stress on the ends' rotations: a side's
    // share is ± N a²/12, the same from both elements of a side and opposite
    const double mx = A * 0.05 * 0.05 / 12, my = 0.3 * A * 0.04 * 0.04 / 12;
    const double expected = (k == 0 || k == 3 ? 1 : -1) * (mx - my);
    CHECK(std::abs(f[6 * k + 5]) == Approx(std::abs(expected)).epsilon(1e-9));
  }
}
