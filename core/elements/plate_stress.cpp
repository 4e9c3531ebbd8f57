#include "core/elements/plate_stress.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/elements/full_leaf.hpp"

namespace flexopt {
namespace {

using Row16 = Eigen::Matrix<double, 16, 1>;
using Gradient = Eigen::Matrix<double, 16, 3>;

Row16 products(const std::array<double, 4>& X, const std::array<double, 4>& Y) {
  Row16 row;
  for (int p = 0; p < 2; ++p)
    for (int q = 0; q < 2; ++q)
      for (int k = 0; k < 4; ++k) row[8 * p + 4 * q + k] = X[2 * p + k % 2] * Y[2 * q + k / 2];
  return row;
}

Vector3d membrane_strain(const Gradient& U, const HermiteValues& X, const HermiteValues& Y) {
  const Vector3d a1 = U.transpose() * products(X.slope, Y.value);
  const Vector3d a2 = U.transpose() * products(X.value, Y.slope);
  return {0.5 * (a1.squaredNorm() - 1), 0.5 * (a2.squaredNorm() - 1), a1.dot(a2)};
}

double von_mises(const Vector3d& strain, double nu, double modulus) {
  const double k = modulus / (1 - nu * nu);
  const double s11 = k * (strain[0] + nu * strain[1]), s22 = k * (strain[1] + nu * strain[0]),
               s12 = k * 0.5 * (1 - nu) * strain[2];
  return std::sqrt(s11 * s11 - s11 * s22 + s22 * s22 + 3 * s12 * s12);
}

}  // namespace

SurfaceStress plate_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal, int i, int j,
                           double xi, double eta, double youngs_modulus) {
  const double hx = mesh.x()[i + 1] - mesh.x()[i], hy = mesh.y()[j + 1] - mesh.y()[j];
  const double nu = mesh.shape().poissons_ratio, t = mesh.shape().thickness;
  Gradient U;
  U << nodal[i].middleRows<8>(4 * j), nodal[i + 1].middleRows<8>(4 * j);
  const HermiteValues X = hermite(xi, hx), Y = hermite(eta, hy);

  const double s0 = 0.5 - 0.5 / std::sqrt(3.0), s1 = 1 - s0, r = (xi - s0) / (s1 - s0);
  const Vector3d e =
      (1 - r) * membrane_strain(U, hermite(s0, hx), Y) + r * membrane_strain(U, hermite(s1, hx), Y);

  const Vector3d a1 = U.transpose() * products(X.slope, Y.value);
  const Vector3d a2 = U.transpose() * products(X.value, Y.slope);
  const Vector3d normal = a1.cross(a2).normalized();
  const Vector3d r11 = U.transpose() * products(X.curvature, Y.value);
  const Vector3d r22 = U.transpose() * products(X.value, Y.curvature);
  const Vector3d r12 = U.transpose() * products(X.slope, Y.slope);
  // a fibre on the side of the normal is stretched by −r,ab · n
  const Vector3d kappa(-r11.dot(normal), -r22.dot(normal), -2 * r12.dot(normal));
  return {von_mises(e + 0.5 * t * kappa, nu, youngs_modulus),
          von_mises(e - 0.5 * t * kappa, nu, youngs_modulus)};
}

StressPeak plate_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const LeafSpring& leaf, const LeafScale& scale, int index) {
  StressPeak peak;
  peak.leaf = index;
  int pi = 0, pj = 0;
  double px = 0, py = 0;
  for (int i = 0; i < mesh.elements_along(); ++i)
    for (int j = 0; j < mesh.elements_across(); ++j)
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
          const SurfaceStress s =
              plate_stress(mesh, nodal, i, j, 0.5 * a, 0.5 * b, leaf.material.youngs_modulus);
          // both surfaces of a symmetric state are equal but for rounding: prefer the positive one
          const bool positive = s.positive >= s.negative * (1 - 1e-9);
          const double value = positive ? s.positive : s.negative;
          if (value <= peak.value * (1 + 1e-9)) continue;
          peak.value = value;
          peak.on_positive_normal = positive;
          pi = i, pj = j, px = 0.5 * a, py = 0.5 * b;
        }
  const auto &x = mesh.x(), &y = mesh.y();
  const double hx = x[pi + 1] - x[pi], hy = y[pj + 1] - y[pj];
  peak.along = x[pi] + px * hx;
  peak.across = (y[pj] + py * hy - y.front()) / (y.back() - y.front());
  Gradient U;
  U << nodal[pi].middleRows<8>(4 * pj), nodal[pi + 1].middleRows<8>(4 * pj);
  const Vector3d r = U.transpose() * products(hermite(px, hx).value, hermite(py, hy).value);
  peak.position = scale.origin + scale.axes * r * scale.length;
  return peak;
}

LeafShape plate_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const LeafSpring& leaf, const LeafScale& scale) {
  LeafShape shape;
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  shape.points_along = nx + 1;
  shape.points_across = ny + 1;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const Vector3d r = nodal[i].row(4 * j).transpose();
      shape.undeflected.push_back(
          scale.origin + scale.axes * Vector3d(mesh.x()[i], mesh.y()[j], 0) * scale.length);
      shape.deflected.push_back(scale.origin + scale.axes * r * scale.length);
      double stress = 0;
      for (int p = std::max(i - 1, 0); p <= std::min(i, nx - 1); ++p)
        for (int q = std::max(j - 1, 0); q <= std::min(j, ny - 1); ++q) {
          const SurfaceStress s =
              plate_stress(mesh, nodal, p, q, i - p, j - q, leaf.material.youngs_modulus);
          stress = std::max({stress, s.positive, s.negative});
        }
      shape.von_mises.push_back(stress);
    }
  return shape;
}

}  // namespace flexopt
