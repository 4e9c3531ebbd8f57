#pragma once
// Forces and energy of one element of a plate leaf whose fields are polynomials in
// x = (σ, τ, φ, N, M1, M2), or in the first of these: core/reduction/README.md (R2).
#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/elements/plate/plate_mesh.hpp"
#include "core/math/polynomial.hpp"
#include "core/reduction/expansion/point_lanes.hpp"

namespace flexopt {

/// The product of an element's operator, or of its transpose, of which the leading block counts,
/// with a matrix.
inline MatrixXd times(const PlateMesh::Matrix16& A, Eigen::Index rows, const MatrixXd& B) {
  return A.topLeftCorner(rows, B.rows()) * B;
}
inline MatrixXd transposed_times(const PlateMesh::Matrix16& A, Eigen::Index rows,
                                 const MatrixXd& B) {
  return A.topLeftCorner(B.rows(), rows).transpose() * B;
}

/// Elements of a mesh, one after the other, truncated at ORDER. Nodal dofs of a line:
/// functions_per_line × (3 · m), column c · m + k for component c, monomial k, as many monomials as
/// the line has. Operators: as TubeSeries.
template <int ORDER, class Operators, int NV>
class ElementSeries {
 public:
  using S = std::decay_t<decltype(std::declval<const Operators&>().membrane().A11)>;
  using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
  using Lanes = typename PointLanes<S>::type;
  static constexpr int points = PlateMesh::points;
  static constexpr int size = Polynomial<NV, ORDER, S>::size;
  static Lanes lanes(double value) { return PointLanes<S>::constant(value); }

  /// `field_order`: degree of the fields between the edges.
  ElementSeries(const PlateMesh& mesh, const Operators& operators, int field_order)
      : mesh_(mesh),
        operators_(operators),
        table_(monomials<NV, ORDER>()),
        field_order_(field_order) {}

  /// Nodal forces of degrees d0 to d; the lines of `force` have all monomials.
  void add_force(const std::vector<Matrix>& nodal, int i, int j, int d0, int d,
                 std::vector<Matrix>& force) {
    const int m = table_.count(d);
    gather(nodal, i, j, m);
    point_series(i, j, m, d, d);
    const Matrix& U = U_;
    const Points& p = points_;
    const std::array<Lanes, 3> w = weights(i, j);
    const auto [A11, A12, A33] = operators_.membrane();
    std::array<std::vector<Lanes>, 3> stress;
    for (auto& s : stress) s.resize(m);
    for (int k = 0; k < m; ++k) {
      stress[0][k] = w[0] * (A11 * p.strain[0][k] + A12 * p.strain[1][k]);
      stress[1][k] = w[1] * (A12 * p.strain[0][k] + A11 * p.strain[1][k]);
      stress[2][k] = w[2] * (A33 * p.strain[2][k]);
    }
    const int k0 = table_.count(d0 - 1), nd = m - k0;
    Matrix stresses(16, 3 * nd);
    for (int c = 0; c < 3; ++c) {
      std::vector<Lanes> f1(m, lanes(0)), f2(m, lanes(0));
      for (int t = d0; t <= d; ++t) {
        add_product_of_degree(table_, f1.data(), stress[0].data(), p.a1[c].data(), t, d, d);
        add_product_of_degree(table_, f1.data(), stress[2].data(), p.a2[c].data(), t, d, d);
        add_product_of_degree(table_, f2.data(), stress[2].data(), p.a1[c].data(), t, d, d);
        add_product_of_degree(table_, f2.data(), stress[1].data(), p.a2[c].data(), t, d, d);
      }
      for (int k = 0; k < nd; ++k)
        for (int g = 0; g < points; ++g) {
          stresses(g, c * nd + k) = LanesOf::get(f1[k0 + k], g);
          stresses(points + g, c * nd + k) = LanesOf::get(f2[k0 + k], g);
        }
    }
    const auto& element = operators_.element(i, j);
    const int side = mesh_.functions_per_side(), n = 2 * side;
    Matrix F = transposed_times(element.gradient, n, stresses);
    if constexpr (std::is_same_v<Operators, PlateMesh>)
      if (element.curvature_weight.size() > 0) add_natural_force(element, d0, d, F);
    for (int c = 0; c < 3; ++c) {
      F.middleCols(c * nd, nd) += times(element.bending, n, U.middleCols(c * m + k0, nd));
      force[i].block(4 * j, c * size + k0, side, nd) += F.block(0, c * nd, side, nd);
      force[i + 1].block(4 * j, c * size + k0, side, nd) += F.block(side, c * nd, side, nd);
    }
  }

  /// Adds `weight` times the energy to the lanes of its coefficients.
  void add_energy(const std::vector<Matrix>& nodal, int i, int j, double weight,
                  std::vector<Lanes>& sum) {
    const int degree = field_degree(i), m = table_.count(degree);
    const int strain_degree = std::min(ORDER, 2 * degree);
    gather(nodal, i, j, m);
    point_series(i, j, m, degree, strain_degree);
    const Matrix& U = U_;
    const Points& p = points_;
    // ½ [A11 (w1 e11² + w2 e22²) + 2 A12 w1 e11 e22 + A33 w12 (2 e12)²] as three squares; w1 = w2
    // where A12 is not zero
    const std::array<Lanes, 3> w = weights(i, j);
    const auto [A11, A12, A33] = operators_.membrane();
    const S coupling = A12 / A11;
    const int ms = table_.count(strain_degree);
    std::vector<Lanes>& along = work_[0];
    along.resize(ms);
    for (int k = 0; k < ms; ++k) along[k] = p.strain[0][k] + coupling * p.strain[1][k];
    const double half = 0.5 * weight;
    add_square(table_, sum.data(), along.data(), w[0] * (half * A11), strain_degree);
    add_square(table_, sum.data(), p.strain[1].data(), w[1] * (half * (A11 - A12 * coupling)),
               strain_degree);
    add_square(table_, sum.data(), p.strain[2].data(), w[2] * (half * A33), strain_degree);
    if constexpr (std::is_same_v<Operators, PlateMesh>)
      if (mesh_.element(i, j).curvature_weight.size() > 0)
        add_natural_energy(mesh_.element(i, j), degree, weight, sum);
    // ½ U · K_B U, eight functions at a time. Bending does not see where the element stands: places
    // from one of its nodes keep the digits that places in the leaf would lose, the square of how
    // often the leaf is as long.
    Matrix& B = A_;
    const int n = static_cast<int>(U.rows());
    for (int value = n - 4; value >= 0; value -= 4) U_.row(value) -= U_.row(0);
    B = times(operators_.element(i, j).bending, n, U);
    B *= 0.5 * weight;
    std::vector<Lanes>&a = work_[0], &b = work_[1];
    a.resize(m);
    b.resize(m);
    for (int c = 0; c < 3; ++c)
      for (int half = 0; half < n / 8; ++half) {
        for (int k = 0; k < m; ++k)
          for (int g = 0; g < 8; ++g) {
            a[k].set(g, U(8 * half + g, c * m + k));
            b[k].set(g, B(8 * half + g, c * m + k));
          }
        add_product(table_, sum.data(), a.data(), b.data(), degree, degree);
      }
  }

 private:
  using LanesOf = PointLanes<S>;

  // Degree of an element's fields: the edges turn by the exponential, the rest is of field order.
  int field_degree(int i) const {
    return i == 0 || i == mesh_.elements_along() - 1 ? ORDER : std::min(ORDER, field_order_);
  }

  // Columns of the monomials ≤ degree, component by component.
  void gather(const std::vector<Matrix>& nodal, int i, int j, int m) {
    const int side = mesh_.functions_per_side();
    Matrix& U = U_;
    U.setZero(2 * side, 3 * m);
    for (int p = 0; p < 2; ++p) {
      const Matrix& line = nodal[i + p];
      const int stored = static_cast<int>(line.cols()) / 3, used = std::min(m, stored);
      for (int c = 0; c < 3; ++c)
        U.block(side * p, c * m, side, used) = line.block(4 * j, c * stored, side, used);
    }
  }

  struct Points {
    std::array<std::vector<Lanes>, 3> a1, a2;
    std::array<std::vector<Lanes>, 3> strain;  ///< e11, e22, 2 e12, all monomials
  };

  // Gradients and Green–Lagrange strains of the gathered element; strains to `strain_degree`.
  void point_series(int i, int j, int m, int degree, int strain_degree) {
    Matrix& A = A_;
    A = times(operators_.element(i, j).gradient, 2 * points, U_);
    Points& p = points_;
    for (int c = 0; c < 3; ++c) {
      p.a1[c].resize(m);
      p.a2[c].resize(m);
      for (int k = 0; k < m; ++k)
        for (int g = 0; g < points; ++g) {
          LanesOf::set(p.a1[c][k], g, A(g, c * m + k));
          LanesOf::set(p.a2[c][k], g, A(points + g, c * m + k));
        }
      p.strain[c].assign(table_.count(strain_degree), lanes(0));
    }
    if (strain_degree == std::min(ORDER, 2 * degree)) {  // nothing to leave out
      const Lanes one = lanes(1);
      for (int c = 0; c < 3; ++c) {
        add_square(table_, p.strain[0].data(), p.a1[c].data(), one, degree);
        add_square(table_, p.strain[1].data(), p.a2[c].data(), one, degree);
        add_product(table_, p.strain[2].data(), p.a1[c].data(), p.a2[c].data(), degree, degree);
      }
    } else {
      add_strains(p, strain_degree, degree);
    }
    subtract_metric(i, j, p.strain[0][0]);
    p.strain[1][0] -= 1.0;
    for (int q = 0; q < 2; ++q)
      for (Lanes& e : p.strain[q]) e *= 0.5;
  }
  void subtract_metric(int i, int j, Lanes& strain) const {
    if constexpr (std::is_same_v<Operators, PlateMesh>) {
      Lanes metric;
      for (int g = 0; g < points; ++g) metric.set(g, mesh_.element(i, j).metric[g]);
      strain -= metric;
    } else {
      strain -= 1.0;  // flat leaves alone
    }
  }

  // The field of plate_curvature.hpp, eight bending points at a time from the first, and its
  // factors.
  struct Bent {
    std::array<std::array<std::vector<Lanes>, 3>, 3> a;  ///< [vector][component]
    Lanes c;
  };
  Bent bent_points(const PlateMesh::Element& element, Eigen::Index first, const MatrixXd& field,
                   int m) const {
    Bent bent;
    const Eigen::Index n = element.curvature_weight.size();
    for (int g = 0; g < points; ++g)
      bent.c.set(g, first + g < n ? element.curvature_weight[first + g] : 0);
    for (int v = 0; v < 3; ++v)
      for (int c = 0; c < 3; ++c) {
        bent.a[v][c].assign(m, lanes(0));
        for (int k = 0; k < m; ++k)
          for (int g = 0; g < points && first + g < n; ++g)
            bent.a[v][c][k].set(g, field(v * n + first + g, c * m + k));
      }
    return bent;
  }

  // Adds component c of a × b, to a degree.
  void add_cross(std::vector<Lanes>& sum, const std::array<std::vector<Lanes>, 3>& a,
                 const std::array<std::vector<Lanes>, 3>& b, int c, int d0, int d1,
                 int degree) const {
    const int x = (c + 1) % 3, y = (c + 2) % 3;
    std::vector<Lanes> minus(sum.size(), lanes(0));
    for (int d = d0; d <= d1; ++d) {
      add_product_of_degree(table_, sum.data(), a[x].data(), b[y].data(), d, degree, degree);
      add_product_of_degree(table_, minus.data(), a[y].data(), b[x].data(), d, degree, degree);
    }
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] -= minus[k];
  }

  // Forces of the cubic energy of a curved leaf, of degrees d0 to d, on the gathered element.
  void add_natural_force(const PlateMesh::Element& element, int d0, int d, MatrixXd& F) {
    const int m = table_.count(d), k0 = table_.count(d0 - 1), nd = m - k0;
    const Eigen::Index n = element.curvature_weight.size(), functions = U_.rows();
    const MatrixXd field = element.curvature.leftCols(functions) * U_;
    MatrixXd moments = MatrixXd::Zero(3 * n, 3 * nd);
    for (Eigen::Index first = 0; first < n; first += points) {
      const Bent bent = bent_points(element, first, field, m);
      for (int v = 0; v < 3; ++v)
        for (int c = 0; c < 3; ++c) {
          std::vector<Lanes> s(m, lanes(0));
          add_cross(s, bent.a[(v + 1) % 3], bent.a[(v + 2) % 3], c, d0, d, d);
          for (int k = 0; k < nd; ++k)
            for (int g = 0; g < points && first + g < n; ++g)
              moments(v * n + first + g, c * nd + k) = bent.c[g] * s[k0 + k][g];
        }
    }
    F += element.curvature.leftCols(functions).transpose() * moments;
  }

  // Adds the energy of the natural curvature, including what makes it zero at rest.
  void add_natural_energy(const PlateMesh::Element& element, int degree, double weight,
                          std::vector<Lanes>& sum) {
    const int m = table_.count(degree), full = std::min(ORDER, 2 * degree);
    const MatrixXd field = element.curvature.leftCols(U_.rows()) * U_;
    for (Eigen::Index first = 0; first < element.curvature_weight.size(); first += points) {
      const Bent bent = bent_points(element, first, field, m);
      const auto& [a1, a2, a3] = bent.a;
      for (int c = 0; c < 3; ++c) {
        const int x = (c + 1) % 3, y = (c + 2) % 3;
        std::vector<Lanes> normal(size, lanes(0)), minus = normal;
        add_product(table_, normal.data(), a1[x].data(), a2[y].data(), degree, degree);
        add_product(table_, minus.data(), a1[y].data(), a2[x].data(), degree, degree);
        for (int k = 0; k < size; ++k) normal[k] = (normal[k] - minus[k]) * (bent.c * weight);
        add_product(table_, sum.data(), normal.data(), a3[c].data(), full, degree);
      }
    }
    sum[0].set(0, sum[0][0] + weight * element.rest_energy);
  }

  void add_strains(Points& p, int strain_degree, int degree) const {
    for (int d = 0; d <= strain_degree; ++d)
      for (int c = 0; c < 3; ++c) {
        add_product_of_degree(table_, p.strain[0].data(), p.a1[c].data(), p.a1[c].data(), d, degree,
                              degree);
        add_product_of_degree(table_, p.strain[1].data(), p.a2[c].data(), p.a2[c].data(), d, degree,
                              degree);
        add_product_of_degree(table_, p.strain[2].data(), p.a1[c].data(), p.a2[c].data(), d, degree,
                              degree);
      }
  }

  /// Area weights of e11, e22 and 2 e12 at the membrane points of element (i, j).
  std::array<Lanes, 3> weights(int i, int j) const {
    const auto& element = operators_.element(i, j);
    std::array<Lanes, 3> w;
    for (int c = 0; c < 3; ++c)
      for (int g = 0; g < points; ++g) LanesOf::set(w[c], g, element.weight(g, c));
    return w;
  }

  const PlateMesh& mesh_;
  const Operators& operators_;
  const MonomialTable& table_;
  int field_order_;

  // of the element at hand
  Matrix U_, A_;
  Points points_;
  std::array<std::vector<Lanes>, 2> work_;
};

}  // namespace flexopt
