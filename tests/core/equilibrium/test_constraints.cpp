#include "core/equilibrium/constraints.hpp"

#include <catch2/catch.hpp>

#include "core/math/ridders.hpp"
#include "core/math/rotation.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

/// Two bodies with a joint of every type: between them, and to the ground.
Mechanism jointed() {
  Mechanism m = models::guide(0.1, 0.02, 5e-4);
  m.bodies.push_back(models::body({0.05, 0.02, -0.01}, 0.1, 1e-5));
  const Vector3d place(0.07, 0.01, 0.02), axis = Vector3d(1, 2, -2) / 3;
  m.joints = {{"rigid", JointType::rigid, 0, 1, place, axis},
              {"revolute", JointType::revolute, 1, ground, place, axis},
              {"spherical", JointType::spherical, 0, ground, place, axis},
              {"prismatic", JointType::prismatic, 1, 0, place, axis}};
  return m;
}

std::vector<JointBody> poses_at_rest(const Mechanism& m) { return undeflected_bodies(m); }

/// Moved by increments (displacement, spin) of the bodies.
std::vector<JointBody> moved(std::vector<JointBody> poses, const VectorXd& q) {
  for (std::size_t b = 0; b < poses.size(); ++b) {
    poses[b].position += q.segment<3>(6 * b);
    poses[b].rotation = rotation_exp(Vector3d(q.segment<3>(6 * b + 3))) * poses[b].rotation;
  }
  return poses;
}

VectorXd somewhere(int n, double size, int seed) {
  VectorXd q(n);
  for (int i = 0; i < n; ++i) q[i] = size * std::sin(seed + 1.7 * i);
  return q;
}

}  // namespace

TEST_CASE("constraints hold at rest, each joint with the conditions of its type") {
  const Mechanism m = jointed();
  Constraints c(m);
  REQUIRE(c.count() == 6 + 5 + 3 + 5);
  c.evaluate(poses_at_rest(m));
  CHECK(c.value().cwiseQuotient(c.units()).cwiseAbs().maxCoeff() < 1e-15);
  REQUIRE(c.units().size() == c.count());
  CHECK(c.units().minCoeff() == Approx(0.1));  // the longest leaf
  CHECK(c.units().maxCoeff() == 1);            // cosines
}

TEST_CASE("the gradient of the constraints is their derivative at any pose") {
  const Mechanism m = jointed();
  Constraints c(m);
  const auto poses = moved(poses_at_rest(m), somewhere(12, 0.3, 1));
  c.evaluate(poses);
  const MatrixXd gradient = c.gradient();
  REQUIRE(gradient.rows() == c.count());
  REQUIRE(gradient.cols() == 12);
  for (int k = 0; k < 12; ++k) {
    const auto along = [&](double s) {
      c.evaluate(moved(poses, s * VectorXd::Unit(12, k)));
      return std::vector<double>(c.value().begin(), c.value().end());
    };
    const Derivatives d = ridders(along, 0, 0.05);
    for (int i = 0; i < c.count(); ++i) {
      INFO("condition " << i << " along " << k);
      CHECK(gradient(i, k) == Approx(d.value[i]).margin(1e-10));
    }
  }
}

TEST_CASE("the curvature of the constraints is their second derivative along the exponential map") {
  const Mechanism m = jointed();
  Constraints c(m);
  const auto poses = moved(poses_at_rest(m), somewhere(12, 0.3, 2));
  const VectorXd multipliers = somewhere(c.count(), 2, 3);
  BlockMatrix blocks(2);
  c.evaluate(poses);
  c.add_curvature(poses, multipliers, blocks);
  const MatrixXd K = blocks.dense();
  CHECK((K - K.transpose()).norm() < 1e-13 * K.norm());
  for (int seed = 4; seed < 8; ++seed) {
    const VectorXd q = somewhere(12, 1, seed);
    const auto potential = [&](double s) {
      c.evaluate(moved(poses, s * q));
      return multipliers.dot(c.value());
    };
    const auto slope = [&](double s) {
      return std::vector<double>{
          ridders([&](double t) { return std::vector<double>{potential(t)}; }, s, 0.05).value[0]};
    };
    CHECK(q.dot(K * q) == Approx(ridders(slope, 0, 0.05).value[0]).epsilon(1e-6));
  }
  c.add_curvature(poses, multipliers, blocks);
  CHECK((blocks.dense() - 2 * K).norm() < 1e-13 * K.norm());  // it is added
}

TEST_CASE("a mechanism without joints has no constraints") {
  const Mechanism m = models::guide(0.1, 0.02, 5e-4);
  Constraints c(m);
  c.evaluate(poses_at_rest(m));
  CHECK(c.count() == 0);
}
