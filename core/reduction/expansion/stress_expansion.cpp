#include "core/reduction/expansion/stress_expansion.hpp"

#include <cassert>
#include <cmath>
#include <span>

#include "core/elements/plate/mesh_numbers.hpp"
#include "core/elements/plate/strain_field.hpp"
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

// Strains and places as polynomials in so many variables.
template <int NV, int ORDER>
class StrainExpansion {
 public:
  static constexpr int size = monomial_count(NV, ORDER);

  explicit StrainExpansion(const PlateMesh& mesh) : mesh_(mesh), places_(mesh.shape()) {}

  /// Rows as of StressPlaces, from FieldExpansion::nodal.
  MatrixXd rows(const MatrixXd& nodal) const {
    MatrixXd rows(places_.rows(), size);
    const int n = mesh_.functions_per_line();
    const int stations = places_.stations_along() * places_.half_across();
    const PlateShape& shape = mesh_.shape();
    const double line = line_share(shape.thickness, shape.width, shape.poissons_ratio);
    Eigen::Matrix<double, 5, 16> operators;
    MatrixXd U(16, 3 * size), D(5, 3 * size);
    const auto derivative = [&D](int d) {
      Vector v;
      for (int c = 0; c < 3; ++c)
        for (int k = 0; k < size; ++k) v[c][k] = D(d, c * size + k);
      return v;
    };
    for (int s = 0; s < places_.stations_along(); ++s) {
      const int i = s / 2;
      const double hx = mesh_.x()[i + 1] - mesh_.x()[i];
      const HermiteValues X = hermite(station[s % 2], hx);
      Series shear_slope = Series::constant(0);  // (E18)
      for (int t = 0; t < 2 * places_.half_across(); ++t) {
        const int j = t / 2;
        const double hy = mesh_.y()[j + 1] - mesh_.y()[j];
        const HermiteValues Y = hermite(station[t % 2], hy);
        operators.row(0) = hermite_products(X.slope, Y.value).transpose();
        operators.row(1) = hermite_products(X.value, Y.slope).transpose();
        operators.row(2) = hermite_products(X.curvature, Y.value).transpose();
        operators.row(3) = hermite_products(X.value, Y.curvature).transpose();
        operators.row(4) = hermite_products(X.slope, Y.slope).transpose();
        const PlateMesh::Element::Shear& shear = mesh_.element(i, j).shear;  // (E11)
        operators.row(2) -= shear.per_x * (station[s % 2] - 0.5) * hx * shear.force.transpose();
        for (int p = 0; p < 2; ++p)
          for (int c = 0; c < 3; ++c)
            U.block<8, size>(8 * p, c * size) = nodal.middleRows<8>((3 * (i + p) + c) * n + 4 * j);
        D.noalias() = operators * U;
        const Vector a1 = derivative(0), a2 = derivative(1), r11 = derivative(2),
                     r12 = derivative(4);
        shear_slope = shear_slope + (dot(r11, a2) + dot(a1, r12)) * (0.5 * hy / shape.width);
        if (t < places_.half_across())
          put_strains(a1, a2, r11, derivative(3), r12, s + t * places_.stations_along(), stations,
                      rows);
      }
      for (int t = 0; t < places_.half_across(); ++t)
        for (int k = 0; k < size; ++k)
          rows(s + t * places_.stations_along(), k) -=
              line * places_.y[static_cast<std::size_t>(t)] * shear_slope[k];
    }
    int row = places_.strain_rows();
    for (int i = 0; i < mesh_.lines(); ++i)
      for (int j = 0; j < places_.half_nodes(); ++j)
        for (int c = 0; c < 3; ++c) rows.row(row++) = nodal.row((3 * i + c) * n + 4 * j);
    return rows;
  }

 private:
  using Series = Polynomial<NV, ORDER>;
  using Vector = std::array<Series, 3>;

  static Series dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
  // q^(−1/2).
  static Series inverse_root(const Series& q) {
    std::array<double, ORDER + 1> taylor;
    taylor[0] = 1 / std::sqrt(q[0]);
    for (int k = 0; k < ORDER; ++k) taylor[k + 1] = -taylor[k] * (k + 0.5) / ((k + 1) * q[0]);
    return compose<NV, ORDER, double>(std::span<const double>(taylor), q);
  }
  // Strains as in strains() of strain_field.cpp, as polynomials: one row for each component,
  // `apart` rows from one to the next.
  static void put_strains(const Vector& a1, const Vector& a2, const Vector& r11, const Vector& r22,
                          const Vector& r12, int row, int apart, MatrixXd& rows) {
    Vector n;
    for (int c = 0; c < 3; ++c) {
      const int a = (c + 1) % 3, b = (c + 2) % 3;
      n[c] = a1[a] * a2[b] - a1[b] * a2[a];
    }
    const Series per = inverse_root(dot(n, n));
    for (Series& component : n) component = component * per;
    const Series one = Series::constant(1);
    const Series strains[6] = {
        (dot(a1, a1) - one) * 0.5, (dot(a2, a2) - one) * 0.5, dot(a1, a2),
        dot(r11, n) * -1.0,        dot(r22, n) * -1.0,        dot(r12, n) * -2.0};
    for (int e = 0; e < 6; ++e)
      for (int k = 0; k < size; ++k) rows(row + e * apart, k) = strains[e][k];
  }

  const PlateMesh& mesh_;
  StressPlaces places_;
};

}  // namespace

MatrixXd expand_stress(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, const MatrixXd& fields) {
  const PlateMesh& mesh = leaf.plate().mesh();
  [[maybe_unused]] const PlateShape& shape = mesh.shape();
  assert(!shape.curve && !shape.has_profile() && !shape.fold && !shape.is_beam());
  assert(fields.cols() == monomial_count(6, 2));
  const MatrixXd to_second = StrainExpansion<6, 2>(mesh).rows(nodal_values(leaf, ray, fields)),
                 of_bending = StrainExpansion<2, 3>(mesh).rows(
                     expand_bending_fields(leaf, ray, fields).nodal);
  constexpr int cubic = monomial_count(2, 3) - monomial_count(2, 2);
  MatrixXd rows(to_second.rows(), to_second.cols() + cubic);
  rows << to_second, of_bending.rightCols<cubic>();
  return rows;
}

}  // namespace flexopt
