#include "core/elements/plate_stress.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/elements/full_leaf.hpp"

namespace flexopt {
namespace {

using Gradient = Eigen::Matrix<double, 16, 3>;
using Strains = Eigen::Matrix<double, 6, 1>;  // e11, e22, 2 e12, κ11, κ22, 2 κ12

Gradient dofs(const std::vector<MatrixXd>& nodal, int i, int j) {
  Gradient U;
  U << nodal[i].middleRows<8>(4 * j), nodal[i + 1].middleRows<8>(4 * j);
  return U;
}

Strains strains(const Gradient& U, const HermiteValues& X, const HermiteValues& Y) {
  const Vector3d a1 = U.transpose() * hermite_products(X.slope, Y.value);
  const Vector3d a2 = U.transpose() * hermite_products(X.value, Y.slope);
  const Vector3d n = a1.cross(a2).normalized();
  const Vector3d r11 = U.transpose() * hermite_products(X.curvature, Y.value);
  const Vector3d r22 = U.transpose() * hermite_products(X.value, Y.curvature);
  const Vector3d r12 = U.transpose() * hermite_products(X.slope, Y.slope);
  Strains e;
  // a fibre on the side of the normal is stretched by −r,ab · n
  e << 0.5 * (a1.squaredNorm() - 1), 0.5 * (a2.squaredNorm() - 1), a1.dot(a2), -r11.dot(n),
      -r22.dot(n), -2 * r12.dot(n);
  return e;
}

double von_mises(const Vector3d& strain, double nu, double modulus) {
  const double k = modulus / (1 - nu * nu);
  const double s11 = k * (strain[0] + nu * strain[1]), s22 = k * (strain[1] + nu * strain[0]),
               s12 = k * 0.5 * (1 - nu) * strain[2];
  return std::sqrt(s11 * s11 - s11 * s22 + s22 * s22 + 3 * s12 * s12);
}

// Strains at the 2 × 2 Gauss stations of every element, where those of a cubic are superconvergent,
// and between them by bilinear interpolation over the whole leaf. (Second derivatives jump from
// element to element; read anywhere else they are a saw-tooth.)
class RecoveredStrains {
 public:
  RecoveredStrains(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal)
      : x_(gauss_stations(mesh.x())), y_(gauss_stations(mesh.y())) {
    for (int i = 0; i < mesh.elements_along(); ++i)
      for (int a = 0; a < 2; ++a) {
        const HermiteValues X = hermite(station[a], mesh.x()[i + 1] - mesh.x()[i]);
        for (int j = 0; j < mesh.elements_across(); ++j) {
          const Gradient U = dofs(nodal, i, j);
          for (int b = 0; b < 2; ++b)
            values_.push_back(strains(U, X, hermite(station[b], mesh.y()[j + 1] - mesh.y()[j])));
        }
      }
  }

  Strains at(double x, double y) const {
    const auto [i, s] = bracket(x_, x);
    const auto [j, t] = bracket(y_, y);
    return (1 - s) * ((1 - t) * value(i, j) + t * value(i, j + 1)) +
           s * ((1 - t) * value(i + 1, j) + t * value(i + 1, j + 1));
  }

 private:
  static constexpr double station[2] = {0.21132486540518713, 0.7886751345948129};

  static std::vector<double> gauss_stations(const std::vector<double>& points) {
    std::vector<double> s;
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      for (const double a : station) s.push_back(points[i] + a * (points[i + 1] - points[i]));
    return s;
  }
  // Interval of the stations (the first or last one beyond them) and the place in it.
  static std::pair<int, double> bracket(const std::vector<double>& points, double s) {
    const int last = static_cast<int>(points.size()) - 2;
    int i = 0;
    while (i < last && s > points[i + 1]) ++i;
    return {i, (s - points[i]) / (points[i + 1] - points[i])};
  }
  const Strains& value(int i, int j) const { return values_[i * y_.size() + j]; }

  std::vector<double> x_, y_;
  std::vector<Strains> values_;  // stations along, stations across
};

struct SurfaceStress {
  double positive = 0, negative = 0;  // on the side of the normal, and opposite
};
SurfaceStress surface_stress(const PlateMesh& mesh, const Strains& e, double youngs_modulus) {
  const double nu = mesh.shape().poissons_ratio, half = 0.5 * mesh.shape().thickness;
  return {von_mises(e.head<3>() + half * e.tail<3>(), nu, youngs_modulus),
          von_mises(e.head<3>() - half * e.tail<3>(), nu, youngs_modulus)};
}

// Stations from a to b with the ends, and those at the border of the corner zones.
std::vector<double> stations(double a, double b, int intervals, double zone) {
  std::vector<double> s = graded_points(a, b, intervals, 0.5);
  s.push_back(a + zone);
  s.push_back(b - zone);
  std::sort(s.begin(), s.end());
  return s;
}

}  // namespace

StressPeak plate_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const LeafSpring& leaf, const LeafScale& scale, int index) {
  const auto &x = mesh.x(), &y = mesh.y();
  const double zone = 0.1 * std::min(1.0, mesh.shape().width);
  const double margin = zone * (1 - 1e-9);
  const RecoveredStrains field(mesh, nodal);
  StressPeak peak;
  peak.leaf = index;
  for (const double sx : stations(x.front(), x.back(), 16, zone))
    for (const double sy : stations(y.front(), y.back(), 8, zone)) {
      const bool at_clamp = std::min(sx - x.front(), x.back() - sx) < margin;
      const bool at_free_edge = std::min(sy - y.front(), y.back() - sy) < margin;
      if (at_clamp && at_free_edge) continue;
      const SurfaceStress s = surface_stress(mesh, field.at(sx, sy), leaf.material.youngs_modulus);
      // both surfaces of a symmetric state are equal but for rounding: prefer the positive one
      const bool positive = s.positive >= s.negative * (1 - 1e-9);
      const double value = positive ? s.positive : s.negative;
      if (value <= peak.value * (1 + 1e-9)) continue;
      peak.value = value;
      peak.on_positive_normal = positive;
      peak.along = sx;
      peak.across = (sy - y.front()) / (y.back() - y.front());
    }
  peak.position = plate_material_point(mesh, nodal, scale, peak.along, peak.across);
  return peak;
}

LeafShape plate_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const LeafSpring& leaf, const LeafScale& scale) {
  LeafShape shape;
  const RecoveredStrains field(mesh, nodal);
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  shape.points_along = nx + 1;
  shape.points_across = ny + 1;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const Vector3d r = nodal[i].row(4 * j).transpose();
      shape.undeflected.push_back(
          scale.origin + scale.axes * Vector3d(mesh.x()[i], mesh.y()[j], 0) * scale.length);
      shape.deflected.push_back(scale.origin + scale.axes * r * scale.length);
      const SurfaceStress s =
          surface_stress(mesh, field.at(mesh.x()[i], mesh.y()[j]), leaf.material.youngs_modulus);
      shape.von_mises.push_back(std::max(s.positive, s.negative));
    }
  return shape;
}

Vector3d plate_material_point(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                              const LeafScale& scale, double along, double across) {
  Vector3d r = Vector3d::Zero();
  for (const NodalWeight& w : point_weights(mesh, along, across))
    r += w.weight * nodal[w.line].row(w.function).transpose();
  return scale.origin + scale.axes * r * scale.length;
}

}  // namespace flexopt
