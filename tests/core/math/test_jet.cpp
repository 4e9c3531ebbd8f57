// Truncated series as scalars: against the functions that they are the series of.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/jet.hpp"
#include "support/slopes.hpp"

using namespace flexopt;

namespace {

Vector3<Jet> path() { return {Jet(0.4, -0.3, 0.7), Jet(-0.9, 0.5, 0.1), Jet(0.2, 1.1, -0.6)}; }
Vector3d at(double s) {
  Vector3d v;
  for (int c = 0; c < 3; ++c) {
    const Jet x = path()[c];
    v[c] = x.c[0] + s * (x.c[1] + s * x.c[2]);
  }
  return v;
}

// Coefficients by differences of fourth order.
template <class F>
void check(const Matrix3<Jet>& series, const F& f) {
  const double h = 2e-3;
  const Matrix3d first = test::slope_at_zero([&](double s) { return f(at(s)); }, h),
                 second = (16 * (f(at(h)) + f(at(-h))) - (f(at(2 * h)) + f(at(-2 * h))) -
                           30 * f(at(0))) /
                          (24 * h * h);
  CHECK((coefficients(series, 0) - f(at(0))).norm() < 1e-14);
  CHECK((coefficients(series, 1) - first).norm() < 1e-9);
  CHECK((coefficients(series, 2) - second).norm() < 1e-8);
}

}  // namespace

TEST_CASE("jets multiply and divide as the series they are") {
  // 1/(1 − s) = 1 + s + s² and (1 + s)² (1 − s) = 1 + s − s²
  CHECK((Jet(1) / Jet(1, -1, 0) == Jet(1, 1, 1)));
  CHECK((Jet(1, 1, 0) * Jet(1, 1, 0) * Jet(1, -1, 0) == Jet(1, 1, -1)));
  CHECK((2.0 * Jet(1, 2, 3) - Jet(1, 1, 1) * 0.5 == Jet(1.5, 3.5, 5.5)));
}

TEST_CASE("rotations of jets are those of the path") {
  check(jet_rotation_exp(path()), [](const Vector3d& v) { return rotation_exp(v); });
}

TEST_CASE("products by the orders are products of jets") {
  Eigen::Matrix<Jet, 3, Eigen::Dynamic> B(3, 2), C;
  B << path(), 2.0 * path();
  const Matrix3d A = hat(Vector3d(1, 2, 3)) + Matrix3d::Identity();
  assign_product(C, A, B);
  const Vector3<Jet> one = A * path();
  for (int c = 0; c < 3; ++c) {
    CHECK((C(c, 0) == one[c]));
    CHECK((C(c, 1) == one[c] * 2.0));
  }
  const Eigen::MatrixX<Jet> same = jets(series(Eigen::MatrixX<Jet>(B)));
  CHECK((same == B));
}
