#include "core/elements/plate_stress.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/elements/beam_stress.hpp"
#include "core/elements/full_leaf.hpp"

namespace flexopt {
namespace {

using Gradient = Eigen::Matrix<double, 16, 3>;

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

// Strains at the 2 × 2 Gauss stations of every element, where those of a cubic are superconvergent.
// (Second derivatives jump from element to element; read anywhere else they are a saw-tooth.)
StrainField recovered_strains(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal) {
  constexpr double station[2] = {0.21132486540518713, 0.7886751345948129};
  const auto gauss_stations = [&](const std::vector<double>& points) {
    std::vector<double> s;
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      for (const double a : station) s.push_back(points[i] + a * (points[i + 1] - points[i]));
    return s;
  };
  std::vector<Strains> values;
  for (int i = 0; i < mesh.elements_along(); ++i)
    for (const double a : station) {
      const HermiteValues X = hermite(a, mesh.x()[i + 1] - mesh.x()[i]);
      for (int j = 0; j < mesh.elements_across(); ++j) {
        const Gradient U = dofs(nodal, i, j);
        for (const double b : station)
          values.push_back(strains(U, X, hermite(b, mesh.y()[j + 1] - mesh.y()[j])));
      }
    }
  return {gauss_stations(mesh.x()), gauss_stations(mesh.y()), std::move(values)};
}

// Interval of the stations (the first or last one beyond them) and the place in it.
std::pair<int, double> bracket(const std::vector<double>& points, double s) {
  const int last = static_cast<int>(points.size()) - 2;
  int i = 0;
  while (i < last && s > points[i + 1]) ++i;
  return {i, (s - points[i]) / (points[i + 1] - points[i])};
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

StrainField::StrainField(std::vector<double> x, std::vector<double> y, std::vector<Strains> values)
    : x_(std::move(x)), y_(std::move(y)), values_(std::move(values)) {
  assert(values_.size() == x_.size() * y_.size());
}

Strains StrainField::at(double x, double y) const {
  const auto [i, s] = bracket(x_, x);
  const auto [j, t] = bracket(y_, y);
  const Strains *low = &values_[i * y_.size() + j], *high = low + y_.size();
  return (1 - s) * ((1 - t) * low[0] + t * low[1]) + s * ((1 - t) * high[0] + t * high[1]);
}

SurfaceStress surface_stress(const PlateShape& shape, const Strains& e, double youngs_modulus) {
  const double nu = shape.poissons_ratio, half = 0.5 * shape.thickness;
  return {von_mises(e.head<3>() + half * e.tail<3>(), nu, youngs_modulus),
          von_mises(e.head<3>() - half * e.tail<3>(), nu, youngs_modulus)};
}

StressPeak largest_stress(const StrainField& field, const PlateShape& shape, double youngs_modulus,
                          int index) {
  const double width = shape.width, zone = 0.1 * std::min(1.0, width);
  const double margin = zone * (1 - 1e-9);
  StressPeak peak;
  peak.leaf = index;
  for (const double sx : stations(0, 1, 16, zone))
    for (const double sy : stations(-width / 2, width / 2, 8, zone)) {
      const bool at_clamp = std::min(sx, 1 - sx) < margin;
      const bool at_free_edge = std::min(sy + width / 2, width / 2 - sy) < margin;
      if (at_clamp && at_free_edge) continue;
      const SurfaceStress s = surface_stress(shape, field.at(sx, sy), youngs_modulus);
      // both surfaces of a symmetric state are equal but for rounding: prefer the positive one
      const bool positive = s.positive >= s.negative * (1 - 1e-9);
      const double value = positive ? s.positive : s.negative;
      if (value <= peak.value * (1 + 1e-9)) continue;
      peak.value = value;
      peak.on_positive_normal = positive;
      peak.along = sx;
      peak.across = (sy + width / 2) / width;
    }
  return peak;
}

StressPeak plate_max_stress(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                            const LeafSpring& leaf, const LeafScale& scale, int index) {
  if (mesh.shape().is_beam()) return beam_max_stress(mesh, nodal, leaf, scale, index);
  StressPeak peak = largest_stress(recovered_strains(mesh, nodal), mesh.shape(),
                                   leaf.material.youngs_modulus, index);
  peak.position = plate_material_point(mesh, nodal, scale, peak.along, peak.across);
  return peak;
}

LeafShape plate_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const LeafSpring& leaf, const LeafScale& scale) {
  if (mesh.shape().is_beam()) return beam_deformed_shape(mesh, nodal, leaf, scale);
  LeafShape shape;
  const StrainField field = recovered_strains(mesh, nodal);
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  shape.points_along = nx + 1;
  shape.points_across = ny + 1;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const Vector3d r = nodal[i].row(4 * j).transpose();
      shape.undeflected.push_back(
          scale.origin + scale.axes * Vector3d(mesh.x()[i], mesh.y()[j], 0) * scale.length);
      shape.deflected.push_back(scale.origin + scale.axes * r * scale.length);
      const SurfaceStress s = surface_stress(mesh.shape(), field.at(mesh.x()[i], mesh.y()[j]),
                                             leaf.material.youngs_modulus);
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
