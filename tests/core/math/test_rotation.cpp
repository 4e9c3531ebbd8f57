#include <catch2/catch.hpp>
#include <random>

#include "core/math/nearest_rotation.hpp"
#include "core/math/rate.hpp"
#include "core/math/rotation.hpp"

using namespace flexopt;

namespace {

Vector3d random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> u(-1, 1);
  return size * Vector3d(u(random), u(random), u(random)).normalized();
}

}  // namespace

TEST_CASE("logarithm and exponential of a rotation undo each other from 0 to nearly π") {
  std::mt19937 random(1);
  for (const double angle : {0.0, 1e-12, 1e-7, 1e-4, 1.1e-4, 0.01, 0.5, 1.5, 2.9, 3.1, 3.14}) {
    const Vector3d v = random_vector(random, angle);
    const Matrix3d R = rotation_exp(v);
    CHECK((R.transpose() * R - Matrix3d::Identity()).norm() < 1e-14);
    CHECK((rotation_log(R) - v).norm() < 1e-13 + 1e-11 * (angle > 3));
  }
}

TEST_CASE("the left tangent is the derivative of the exponential, and its inverse is one") {
  std::mt19937 random(2);
  for (const double angle : {1e-6, 9e-3, 1.1e-2, 0.7, 2.0, 3.0}) {
    const Vector3d v = random_vector(random, angle), d = random_vector(random, 1);
    double rest[2];
    for (int k = 0; k < 2; ++k) {
      const double h = 1e-3 / (1 << k);
      const Vector3d spin = rotation_log(rotation_exp(v + h * d) * rotation_exp(v).transpose());
      rest[k] = (spin - h * rotation_left_tangent(v) * d).norm();
    }
    if (angle > 0.1) CHECK(std::log2(rest[0] / rest[1]) == Approx(2).margin(0.1));
    CHECK((rotation_left_tangent(v) * rotation_left_tangent_inverse(v) - Matrix3d::Identity())
              .norm() < 1e-12);
  }
}

TEST_CASE("the nearest rotation undoes a stretch, and is a rotation of a reflection too") {
  std::mt19937 random(11);
  for (const double angle : {0.0, 1e-3, 1.0, 2.5, 3.14}) {
    const Matrix3d R = rotation_exp(random_vector(random, angle));
    const Matrix3d Q = rotation_exp(random_vector(random, 1.0));
    const Matrix3d stretch = Q * Vector3d(1.3, 0.7, 0.4).asDiagonal() * Q.transpose();
    CHECK((nearest_rotation(R * stretch) - R).norm() < 1e-13);
    const Matrix3d reflected = Q * Vector3d(1.3, 0.7, -0.4).asDiagonal() * Q.transpose();
    CHECK((nearest_rotation(R * reflected) - R).norm() < 1e-13);
  }
  const Vector3d v(0.3, -0.2, 0.5);
  const Matrix3d mean = rotation_exp(v) + rotation_exp(-v);
  CHECK((nearest_rotation(mean) - Matrix3d::Identity()).norm() < 1e-14);
}

TEST_CASE("the inverse tangent of a rotation has its closed form, in numbers with rates too") {
  for (const double a : {0.3, 1.0, 2.0, 3.0, 3.14}) {
    const HatSquareFactor g = hat_square_factor(a * a);
    const double x = 0.5 * a, cot = 1 / std::tan(x);
    CHECK(g.value == Approx((1 - x * cot) / (a * a)).epsilon(1e-13));
    CHECK(g.slope == Approx((-0.5 * (cot - x * (1 + cot * cot)) / a - 2 * g.value) / (2 * a * a))
                         .epsilon(1e-10));
  }
  // 0: no branch, and the Bernoulli numbers
  CHECK(hat_square_factor(0.0).value == Approx(1.0 / 12).epsilon(1e-15));
  CHECK(hat_square_factor(0.0).slope == Approx(1.0 / 720).epsilon(1e-15));
  // the logarithm's rate along a spin is J⁻¹ times it
  std::mt19937 random(5);
  for (const double angle : {0.0, 1e-6, 0.4, 1.5, 2.9}) {
    const Vector3d v = random_vector(random, angle), spin = random_vector(random, 1);
    const Matrix3d R = rotation_exp(v), dR = hat(spin) * R;
    const Matrix3<Rate<double>> moving =
        R.binaryExpr(dR, [](double x, double dx) { return Rate<double>(x, dx); });
    const Vector3<Rate<double>> log = rotation_log(moving);
    const Vector3d exact = rotation_left_tangent_inverse(v) * spin;
    for (int i = 0; i < 3; ++i) {
      CHECK(std::abs(log[i].value - v[i]) < 1e-13);
      CHECK(std::abs(log[i].rate - exact[i]) < 1e-12);
    }
  }
}
