#include "core/reduction/expansion/stress_expansion.hpp"

#include <cassert>
#include <cmath>
#include <span>

#include "core/elements/plate/mesh_numbers.hpp"
#include "core/elements/plate/plate_stress.hpp"
#include "core/math/polynomial.hpp"

namespace flexopt {

StressPlaces::StressPlaces(const PlateShape& shape) {
  const MeshNumbers<double> numbers(shape);
  lines = numbers.x;
  nodes = numbers.y;
  x = strain_stations(lines);
  y = strain_stations(nodes);
}

namespace {

// Nodal values of the lines of a leaf, functions × (3 components of each monomial), component by
// component.
std::vector<MatrixXd> lines_of(const ChordLeaf& leaf, const MatrixXd& fields,
                               const MatrixXd& edges) {
  const PlateMesh& mesh = leaf.plate().mesh();
  const int n = mesh.functions_per_line(), last = mesh.lines() - 1;
  const Eigen::Index m = fields.cols();
  std::vector<MatrixXd> lines;
  for (int i = 0; i <= last; ++i) {
    MatrixXd& line = lines.emplace_back(n, 3 * m);
    for (int c = 0; c < 3; ++c)
      line.middleCols(c * m, m) = i == 0 ? edges.middleRows(c * n, n)
                                  : i == last
                                      ? edges.middleRows((3 + c) * n, n)
                                      : fields.middleRows(leaf.plate().block_offset(i) + c * n, n);
  }
  return lines;
}

constexpr int strain_order = 2;
using StrainSeries = Polynomial<6, strain_order>;
using SeriesVector = std::array<StrainSeries, 3>;

StrainSeries dot(const SeriesVector& a, const SeriesVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// q^(−1/2).
StrainSeries inverse_root(const StrainSeries& q) {
  std::array<double, strain_order + 1> taylor;
  taylor[0] = 1 / std::sqrt(q[0]);
  for (int k = 0; k < strain_order; ++k) taylor[k + 1] = -taylor[k] * (k + 0.5) / ((k + 1) * q[0]);
  return compose<6, strain_order, double>(std::span<const double>(taylor), q);
}

// As strains() of plate_stress.cpp, in polynomials; a row for each component, so many rows apart.
void put_strains(const SeriesVector& a1, const SeriesVector& a2, const SeriesVector& r11,
                 const SeriesVector& r22, const SeriesVector& r12, int row, int apart,
                 MatrixXd& rows) {
  SeriesVector n;
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    n[c] = a1[a] * a2[b] - a1[b] * a2[a];
  }
  const StrainSeries per = inverse_root(dot(n, n));
  for (StrainSeries& component : n) component = component * per;
  const StrainSeries one = StrainSeries::constant(1);
  const StrainSeries strains[6] = {
      (dot(a1, a1) - one) * 0.5, (dot(a2, a2) - one) * 0.5, dot(a1, a2),
      dot(r11, n) * -1.0,        dot(r22, n) * -1.0,        dot(r12, n) * -2.0};
  for (int e = 0; e < 6; ++e)
    for (int k = 0; k < StrainSeries::size; ++k) rows(row + e * apart, k) = strains[e][k];
}

}  // namespace

MatrixXd expand_stress(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, const MatrixXd& fields) {
  constexpr int m = StrainSeries::size;
  assert(fields.cols() == m);
  const PlateMesh& mesh = leaf.plate().mesh();
  [[maybe_unused]] const PlateShape& shape = mesh.shape();
  assert(!shape.curve && !shape.has_profile() && !shape.fold && !shape.is_beam());
  const StressPlaces places(mesh.shape());
  const std::vector<MatrixXd> lines = lines_of(leaf, fields, expand_edges(leaf, ray, fields));
  MatrixXd rows(places.rows(), m);
  const int stations = places.stations_along() * places.half_across();
  Eigen::Matrix<double, 5, 16> operators;
  MatrixXd U(16, 3 * m), D(5, 3 * m);
  const auto derivative = [&D](int d) {
    SeriesVector v;
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < m; ++k) v[c][k] = D(d, c * m + k);
    return v;
  };
  for (int s = 0; s < places.stations_along(); ++s) {
    const int i = s / 2;
    const double hx = mesh.x()[i + 1] - mesh.x()[i];
    const HermiteValues X = hermite(station[s % 2], hx);
    for (int t = 0; t < places.half_across(); ++t) {
      const int j = t / 2;
      const double hy = mesh.y()[j + 1] - mesh.y()[j];
      const HermiteValues Y = hermite(station[t % 2], hy);
      operators.row(0) = hermite_products(X.slope, Y.value).transpose();
      operators.row(1) = hermite_products(X.value, Y.slope).transpose();
      operators.row(2) = hermite_products(X.curvature, Y.value).transpose();
      operators.row(3) = hermite_products(X.value, Y.curvature).transpose();
      operators.row(4) = hermite_products(X.slope, Y.slope).transpose();
      const PlateMesh::Element::Shear& shear = mesh.element(i, j).shear;  // (E11)
      operators.row(2) -= shear.per_x * (station[s % 2] - 0.5) * hx * shear.force.transpose();
      U << lines[i].middleRows<8>(4 * j), lines[i + 1].middleRows<8>(4 * j);
      D.noalias() = operators * U;
      put_strains(derivative(0), derivative(1), derivative(2), derivative(3), derivative(4),
                  s + t * places.stations_along(), stations, rows);
    }
  }
  int row = places.strain_rows();
  for (const MatrixXd& line : lines)
    for (int j = 0; j < places.half_nodes(); ++j)
      for (int c = 0; c < 3; ++c) rows.row(row++) = line.block(4 * j, c * m, 1, m);
  return rows;
}

}  // namespace flexopt
