#include "core/elements/leaf/chord_frame.hpp"

#include <catch2/catch.hpp>

#include "support/moved.hpp"
#include "support/real_rotations.hpp"
#include "support/synthetic_leaf.hpp"

using namespace flexopt;
using flexopt::synthetic::Random;

namespace {

// The definition (F1), (F2) of the deformations once more in extended precision, without any
// derivative: differences of it are good to twelve digits.
using R12 = Eigen::Matrix<Real, 12, 1>;

struct RealEdges {
  R3 p[2];
  R33 R[2];
};

R6 deformations_real(const RealEdges& x, Real length) {
  const R3 d = x.p[1] - x.p[0];
  const R3 E1 = d / d.norm();
  R3 E2 = x.R[0].col(1) + x.R[1].col(1);
  E2 = (E2 - E1 * E1.dot(E2)).normalized();
  const auto roll_sum = [&](const R3& axis, R3& t1, R3& t2) {
    R33 E;
    E << E1, axis, E1.cross(axis);
    t1 = log_real(E.transpose() * x.R[0]);
    t2 = log_real(E.transpose() * x.R[1]);
    return t1[0] + t2[0];
  };
  R3 t1, t2, other1, other2;
  for (int k = 0; k < 60; ++k) {  // secant steps with a slope from a small roll
    const Real sum = roll_sum(E2, t1, t2);
    if (std::abs(sum) < 1e-19L) break;
    const Real step = 1e-6L;
    const R3 rolled = std::cos(step) * E2 + std::sin(step) * E1.cross(E2);
    const Real slope = (roll_sum(rolled, other1, other2) - sum) / step;
    const Real r = -sum / slope;
    E2 = (std::cos(r) * E2 + std::sin(r) * E1.cross(E2)).normalized();
  }
  roll_sum(E2, t1, t2);
  R6 e;
  e << d.norm() - length, t1[1], t1[2], t2[1], t2[2], t2[0] - t1[0];
  return e;
}

RealEdges moved(const EdgePoses& x, const R12& q) {
  RealEdges y;
  for (int a = 0; a < 2; ++a) {
    y.p[a] = x[a].position.cast<Real>() + q.segment<3>(6 * a);
    // the matrices of the double precision pose are rotations to 1e-16 only; both sides see them so
    y.R[a] = exp_real(q.segment<3>(6 * a + 3)) * x[a].axes.cast<Real>();
  }
  return y;
}

constexpr double length = 0.8;

/// Two edges anywhere in space, bent from their chord by up to `angle` about every axis.
EdgePoses random_edges(Random& random, double angle) {
  const Matrix3d frame = rotation_exp(random.vector<3>(2));
  const Vector3d origin = random.vector<3>(1);
  EdgePoses x;
  x[0].position = origin;
  x[1].position = origin + frame * Vector3d(length + random(0.1), 0, 0);
  for (auto& edge : x) edge.axes = orthonormalised(frame * rotation_exp(random.vector<3>(angle)));
  return x;
}

}  // namespace

TEST_CASE("the undeflected leaf has no deformation") {
  EdgePoses x{
      {{Vector3d::Zero(), Matrix3d::Identity()}, {Vector3d(length, 0, 0), Matrix3d::Identity()}}};
  const ChordFrame c = chord_frame(x, length);
  REQUIRE(c.converged);
  CHECK(c.e.norm() == 0);
  CHECK((c.axes - Matrix3d::Identity()).norm() == 0);
  // u = ux2 − ux1; θ1y = ω1y + (uz2 − uz1)/l; θ1z = ω1z − (uy2 − uy1)/l; φ = ω2x − ω1x
  Rows6x12 B = Rows6x12::Zero();
  B(elongation, 6) = 1;
  for (int a : {theta1y, theta2y}) B(a, 8) = 1 / length;
  for (int a : {theta1z, theta2z}) B(a, 7) = -1 / length;
  B.leftCols<3>() = -B.middleCols<3>(6);
  B(theta1y, 4) = B(theta1z, 5) = B(theta2y, 10) = B(theta2z, 11) = B(twist, 9) = 1;
  B(twist, 3) = -1;
  CHECK((c.B - B).norm() < 1e-15);
}

TEST_CASE("rigid motion leaves the deformations alone") {
  Random random(11);
  double worst = 0, worst_frame = 0;
  for (int n = 0; n < 1000; ++n) {
    const EdgePoses x = random_edges(random, 0.7);
    const ChordFrame c = chord_frame(x, length);
    REQUIRE(c.converged);
    const Matrix3d Q = rotation_exp(random.vector<3>(1.8));
    const Vector3d shift = random.vector<3>(1);
    EdgePoses y = x;
    for (auto& edge : y) {
      edge.position = Q * edge.position + shift;
      edge.axes = Q * edge.axes;
    }
    const ChordFrame m = chord_frame(y, length);
    REQUIRE(m.converged);
    worst = std::max(worst, (m.e - c.e).cwiseAbs().maxCoeff());
    worst_frame = std::max(worst_frame, (m.axes - Q * c.axes).cwiseAbs().maxCoeff());
  }
  CHECK(worst < 1e-13);
  CHECK(worst_frame < 1e-13);
}

TEST_CASE("swapping the edges mirrors the deformations") {
  // Seen from the other end (half a turn about the normal) the base is the tip.
  Random random(12);
  const Matrix3d half = Vector3d(-1, -1, 1).asDiagonal();
  for (int n = 0; n < 50; ++n) {
    const EdgePoses x = random_edges(random, 0.6);
    EdgePoses y{{{x[1].position, x[1].axes * half}, {x[0].position, x[0].axes * half}}};
    const Vector6d a = chord_frame(x, length).e, b = chord_frame(y, length).e;
    Vector6d expected;
    expected << a[0], -a[theta2y], a[theta2z], -a[theta1y], a[theta1z], a[twist];
    CHECK((b - expected).norm() < 1e-13);
  }
}

TEST_CASE("the roll condition holds to the last digits, beyond a right angle too") {
  Random random(13);
  for (double angle : {1e-9, 1e-3, 0.3, 1.0, 1.2})
    for (int n = 0; n < 200; ++n) {
      const ChordFrame c = chord_frame(random_edges(random, angle), length);
      REQUIRE(c.converged);
      CHECK(c.roll_residual <= 1e-14);
      CHECK((c.axes.transpose() * c.axes - Matrix3d::Identity()).norm() < 1e-14);
      CHECK((c.theta[0][0] + c.theta[1][0]) == Approx(0).margin(1e-14));
    }
  // 110 degrees of pure bending at each end
  const double big = 110 * M_PI / 180;
  EdgePoses x{{{Vector3d::Zero(), rotation_exp(Vector3d(0, -big, 0))},
               {Vector3d(length, 0, 0), rotation_exp(Vector3d(0, big, 0))}}};
  const ChordFrame c = chord_frame(x, length);
  REQUIRE(c.converged);
  CHECK(c.e[theta1y] == Approx(-big).epsilon(1e-14));
  CHECK(c.e[theta2y] == Approx(big).epsilon(1e-14));
}

TEST_CASE("a frame that does not exist says so") {
  EdgePoses x{{{Vector3d::Zero(), Matrix3d::Identity()}, {Vector3d::Zero(), Matrix3d::Identity()}}};
  CHECK_FALSE(chord_frame(x, length).converged);  // no chord
  x[1].position[0] = length;
  x[1].axes = Vector3d(1, -1, -1).asDiagonal();
  CHECK_FALSE(chord_frame(x, length).converged);  // twisted by half a turn
}

TEST_CASE("B is the derivative of the deformations") {
  Random random(14);
  for (double angle : {0.0, 1e-6, 0.05, 0.5, 1.0}) {
    const EdgePoses x = random_edges(random, angle);
    const ChordFrame c = chord_frame(x, length);
    REQUIRE(c.converged);
    const Real h = 1e-4L;  // fourth order: h⁴ = 1e-16
    Rows6x12 B;
    for (int i = 0; i < 12; ++i) {
      const auto e = [&](int k) {
        return deformations_real(moved(x, R12(k * h * R12::Unit(i))), length);
      };
      B.col(i) = ((8 * (e(1) - e(-1)) - (e(2) - e(-2))) / (12 * h)).cast<double>();
    }
    CHECK((deformations_real(moved(x, R12(R12::Zero())), length).cast<double>() - c.e).norm() <
          1e-14);
    REQUIRE(B.norm() > 1);
    CHECK((B - c.B).cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("the geometric stiffness is the second derivative along the exponential map") {
  Random random(15);
  for (double angle : {0.0, 1e-6, 0.05, 0.5, 1.0}) {
    const EdgePoses x = random_edges(random, angle);
    const Vector6d g = random.vector<6>();
    const Matrix12d K = geometric_stiffness(chord_frame(x, length), g);
    CHECK((K - K.transpose()).norm() == 0);

    const auto energy = [&](const R12& q) {
      return g.cast<Real>().dot(deformations_real(moved(x, q), length));
    };
    const Real h = 2e-3L;
    const auto second = [&](const R12& v) {  // sixth order: h⁶ = 6e-17
      const Real e0 = energy(R12::Zero());
      const auto pair = [&](int k) { return energy(k * h * v) + energy(-k * h * v) - 2 * e0; };
      return (270 * pair(1) - 27 * pair(2) + 2 * pair(3)) / (180 * h * h);
    };
    Matrix12d D;
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j <= i; ++j)
        D(i, j) = D(j, i) = static_cast<double>(
            i == j
                ? second(R12::Unit(i))
                : (second(R12::Unit(i) + R12::Unit(j)) - second(R12::Unit(i) - R12::Unit(j))) / 4);
    REQUIRE(D.norm() > 0.1);
    CHECK((D - K).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("the spin of the frame is the turning of its axes") {
  Random random(17);
  for (double angle : {0.05, 0.9}) {
    const EdgePoses x = random_edges(random, angle);
    const ChordFrame c = chord_frame(x, length);
    const Vector12d dq = random.vector<12>();
    const auto error = [&](double h) {
      const Matrix3d E = chord_frame(moved(x, Vector12d(h * dq)), length).axes;
      return (rotation_log(E * c.axes.transpose()) - h * c.spin * dq).norm();
    };
    CHECK(synthetic::rate(error(1e-2), error(1e-3)) == Approx(2).margin(0.1));
    CHECK(synthetic::rate(error(1e-3), error(1e-4)) == Approx(2).margin(0.1));
  }
  // rigid spin and translation
  const EdgePoses x = random_edges(random, 0.7);
  const ChordFrame c = chord_frame(x, length);
  const Vector3d w = random.vector<3>(), v = random.vector<3>();
  Vector12d dq;
  dq << v + w.cross(x[0].position), w, v + w.cross(x[1].position), w;
  CHECK((c.spin * dq - w).norm() < 1e-13);
  CHECK((c.B * dq).norm() < 1e-13);
}
