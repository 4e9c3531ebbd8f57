#pragma once
// The residual and the potential of a plate leaf as polynomials in x = (σ, τ, φ, N, M1, M2), from
// its fields as such: what its expansion is made of. core/reduction/README.md (R2)–(R4).
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/math/dual.hpp"
#include "core/math/polynomial.hpp"
#include "core/reduction/expansion/tube_expansion.hpp"

namespace flexopt {

/// A number at the eight membrane points of an element.
using Lanes8 = double __attribute__((vector_size(64)));

/// And one with derivatives.
template <int n>
struct DualLanes8 {
  Lanes8 value;
  std::array<Lanes8, n> derivatives;

  DualLanes8& operator+=(const DualLanes8& b) {
    value += b.value;
    for (int k = 0; k < n; ++k) derivatives[k] += b.derivatives[k];
    return *this;
  }
  DualLanes8& operator-=(double b) {
    value -= b;
    return *this;
  }
  DualLanes8& operator-=(const DualLanes8& b) {
    value -= b.value;
    for (int k = 0; k < n; ++k) derivatives[k] -= b.derivatives[k];
    return *this;
  }
  DualLanes8& operator*=(double b) {
    value *= b;
    for (int k = 0; k < n; ++k) derivatives[k] *= b;
    return *this;
  }
  friend DualLanes8 operator+(DualLanes8 a, const DualLanes8& b) { return a += b; }
  friend DualLanes8 operator*(const DualLanes8& a, const DualLanes8& b) {
    DualLanes8 c;
    c.value = a.value * b.value;
    for (int k = 0; k < n; ++k)
      c.derivatives[k] = a.value * b.derivatives[k] + a.derivatives[k] * b.value;
    return c;
  }
  friend DualLanes8 operator*(const Dual<n>& a, const DualLanes8& b) {
    DualLanes8 c;
    c.value = a.value * b.value;
    for (int k = 0; k < n; ++k)
      c.derivatives[k] = a.value * b.derivatives[k] + a.derivatives[k] * b.value;
    return c;
  }
};

template <class S>
struct PointLanes;
template <>
struct PointLanes<double> {
  using type = Lanes8;
  static type constant(double value) { return Lanes8{} + value; }
  static void set(type& lanes, int g, double value) { lanes[g] = value; }
  static double get(const type& lanes, int g) { return lanes[g]; }
};
template <int n>
struct PointLanes<Dual<n>> {
  using type = DualLanes8<n>;
  static type constant(double value) {
    type lanes{};
    lanes.value += value;
    return lanes;
  }
  static void set(type& lanes, int g, const Dual<n>& value) {
    lanes.value[g] = value.value;
    for (int k = 0; k < n; ++k) lanes.derivatives[k][g] = value.derivatives[k];
  }
  static Dual<n> get(const type& lanes, int g) {
    Dual<n> value(lanes.value[g]);
    for (int k = 0; k < n; ++k) value.derivatives[k] = lanes.derivatives[k][g];
    return value;
  }
};

/// The product of an element's operator, or of its transpose, of which the leading block counts,
/// with a matrix.
inline MatrixXd times(const PlateMesh::Matrix16& A, Eigen::Index rows, const MatrixXd& B) {
  return A.topLeftCorner(rows, B.rows()) * B;
}
inline MatrixXd transposed_times(const PlateMesh::Matrix16& A, Eigen::Index rows,
                                 const MatrixXd& B) {
  return A.topLeftCorner(B.rows(), rows).transpose() * B;
}

/// Everything about one leaf as polynomials in x, truncated at ORDER. Nodal dofs of a line:
/// functions_per_line × (3 · m), column c · m + k for component c, monomial k; m = size at the
/// edges, the monomials of the fields inside.
///
/// Operators: where the numbers of the mesh come from, the PlateMesh itself or one whose numbers
/// are of another type S; so are then the fields and the residual.
template <int ORDER, class Operators = PlateMesh>
class TubeSeries {
 public:
  using S = std::decay_t<decltype(std::declval<const Operators&>().membrane().A11)>;
  using P = Polynomial<6, ORDER, S>;
  using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
  static constexpr int size = P::size;

  TubeSeries(const ChordLeaf& leaf, const Operators& operators, const Eigen::Matrix2d& ray,
             int field_order)
      : leaf_(leaf),
        mesh_(leaf.plate().mesh()),
        operators_(operators),
        table_(monomials<6, ORDER>()),
        field_order_(field_order) {
    const Vector3d& s = leaf.soft();
    const Vector3d scale = tube_force_scale(mesh_.shape());
    for (int k = 0; k < 2; ++k) {
      soft_[k] = P::constant(s[k]);
      soft_[k][1] = ray(k, 0);
      soft_[k][2] = ray(k, 1);
    }
    soft_[2] = P::variable(2, s[2], 1);
    for (int k = 0; k < 3; ++k) force_[k] = P::variable(3 + k, leaf.forces()[k], scale[k]);
    nodal_.assign(mesh_.lines(), Matrix());
    nodal_.front() = nodal_.back() = Matrix::Zero(mesh_.functions_per_line(), 3 * size);
  }

  /// Dead forces on the nodal dofs, functions_per_line × 3 for each line, in the chord frame.
  /// `parity`: of every derivative of the fields beside their values, in the mirror across the
  /// width: +1 or −1; none where all are even.
  void set_nodal_load(std::vector<Matrix> load, std::vector<int> parity) {
    load_ = std::move(load);
    parity_ = std::move(parity);
  }

  /// Nodal dofs of the unknowns Y (rows as ChordLeaf::unknowns, columns monomials ≤ field order).
  void set_fields(const Matrix& Y) {
    const int n = mesh_.functions_per_line(), last = mesh_.lines() - 1;
    const int m = static_cast<int>(Y.cols());
    for (int i = 1; i < last; ++i) {
      nodal_[i].resize(n, 3 * m);
      for (int c = 0; c < 3; ++c)
        nodal_[i].middleCols(c * m, m) = Y.middleRows(leaf_.plate().block_offset(i) + c * n, n);
    }
    const int u = leaf_.plate().unknowns();
    for (int k = 0; k < 3; ++k) stiff_[k] = row(Y, u + k);
    for (int e = 0; e < 2; ++e) {
      set_axes(e);
      const int line = e == 0 ? 0 : last;
      if (mesh_.shape().curve) turn_axes(e, mesh_.line_pose(line).axes);
      nodal_[line].setZero();
      for (int j = 0; j < mesh_.nodes_per_line(); ++j) {
        const auto& slopes = mesh_.edge_slopes();
        const int o = leaf_.plate().block_offset(line) + static_cast<int>(slopes.size()) * j;
        for (int c = 0; c < 3; ++c) {
          const P &e1 = axis_[e][0][c], &e2 = axis_[e][1][c];
          const auto w = operators_.line_width(line);
          const S y = operators_.y()[j];
          std::array<P, 4> v{e2 * S(y * w.factor), e1, e2 * S(w.factor), P::constant(0)};
          if (w.slope != 0.0) {
            v[1] += e2 * S(y * w.slope);
            v[3] += e2 * S(w.slope);
          }
          if (e == 1 && c == 0) {
            v[0] += stiff_[0];
            v[0][0] += chord();
          }
          for (std::size_t d = 0; d < slopes.size(); ++d)
            v[slopes[d].function] +=
                times_low(axis_[e][slopes[d].axis][c], row(Y, o + static_cast<int>(d)));
          for (int k = 0; k < 4; ++k) put(line, 4 * j + k, c, v[k]);
        }
      }
    }
  }

  /// Nodal values of the edges' lines, a column a monomial: FieldExpansion::edge_nodal.
  Matrix edge_nodal() const {
    const int n = mesh_.functions_per_line();
    Matrix values(6 * n, size);
    for (int e = 0; e < 2; ++e)
      for (int c = 0; c < 3; ++c)
        values.middleRows((3 * e + c) * n, n) =
            (e == 0 ? nodal_.front() : nodal_.back()).middleCols(c * size, size);
    return values;
  }

  /// Degree-d part of the residual ∂Π/∂y: rows as the unknowns, one column a monomial of degree d.
  Matrix residual(int d) {
    const int n = mesh_.functions_per_line(), last = mesh_.lines() - 1;
    const int k0 = table_.count(d - 1), k1 = table_.count(d);
    std::vector<Matrix> force(mesh_.lines(), Matrix::Zero(n, 3 * size));
    const int across = mesh_.elements_across();
    const bool halved = across % 2 == 0 && symmetric();  // the other half is the mirror image
    // the turning edges mix all degrees of the nodal forces there
    for (int i = 0; i < mesh_.elements_along(); ++i)
      for (int j = 0; j < (halved ? across / 2 : across); ++j)
        add_force(i, j, i == 0 || i == mesh_.elements_along() - 1 ? 0 : d, d, force);
    if (halved)
      for (Matrix& line : force) add_mirror_image(line, k1);
    for (std::size_t i = 0; i < load_.size(); ++i)
      for (int c = 0; c < 3; ++c) force[i].col(c * size) -= load_[i].col(c);

    Matrix R(leaf_.plate().unknowns() + 3, k1 - k0);
    for (int i = 1; i < last; ++i)
      for (int c = 0; c < 3; ++c)
        R.middleRows(leaf_.plate().block_offset(i) + c * n, n) =
            force[i].middleCols(c * size + k0, k1 - k0);
    for (int e = 0; e < 2; ++e) {
      const int line = e == 0 ? 0 : last;
      std::array<P, 3> moment{P::constant(0), P::constant(0), P::constant(0)};
      P pull = P::constant(0);
      for (int j = 0; j < mesh_.nodes_per_line(); ++j) {
        const auto& slopes = mesh_.edge_slopes();
        const int o = leaf_.plate().block_offset(line) + static_cast<int>(slopes.size()) * j;
        for (int k = 0; k < 4; ++k) {
          const int s = 4 * j + k;
          std::array<P, 3> g, r;
          for (int c = 0; c < 3; ++c) {
            g[c] = get(force[line], s, c);
            r[c] = get(nodal_[line], s, c);
          }
          // lever arms count from the middle of the edge
          if (k == 0 && e == 1) {
            r[0] -= stiff_[0];
            r[0][0] -= chord();
          }
          for (int c = 0; c < 3; ++c) {
            const int a = (c + 1) % 3, b = (c + 2) % 3;
            moment[c] += r[a] * g[b] - r[b] * g[a];
          }
          if (k == 0) pull += g[0];
          for (std::size_t d = 0; d < slopes.size(); ++d)
            if (slopes[d].function == k) {
              P sum = P::constant(0);
              for (int c = 0; c < 3; ++c) sum += axis_[e][slopes[d].axis][c] * g[c];
              copy_degree(sum, k0, k1, R, o + static_cast<int>(d));
            }
        }
      }
      const int u = leaf_.plate().unknowns();
      if (e == 1) copy_degree(pull - force_[0], k0, k1, R, u);
      P sum = P::constant(0);
      for (int c = 0; c < 3; ++c) sum += tangent_z_[e][c] * moment[c];
      copy_degree(sum - force_[1 + e], k0, k1, R, u + 1 + e);
    }
    return R;
  }

  /// Π = U − f·c. Odd powers of (φ, M1, M2) are not filled where the state is mirror symmetric.
  std::vector<double> potential() {
    std::vector<Lanes> sum(size, lanes(0));
    const int ny = mesh_.elements_across();
    for (int j = 0; j < (symmetric() ? (ny + 1) / 2 : ny); ++j) {
      const double weight = symmetric() && 2 * j + 1 != ny ? 2 : 1;  // for its mirror image
      for (int i = 0; i < mesh_.elements_along(); ++i) add_energy(i, j, weight, sum);
    }
    P total = P::constant(0);
    for (int k = 0; k < size; ++k)
      for (int g = 0; g < points; ++g) total[k] += sum[k][g];
    for (int k = 0; k < 3; ++k) total -= force_[k] * stiff_[k];
    return {total.c.begin(), total.c.end()};
  }

 private:
  using LanesOf = PointLanes<S>;
  using Lanes = typename LanesOf::type;
  static constexpr int points = PlateMesh::points;
  static Lanes lanes(double value) { return LanesOf::constant(value); }

  // In the mirror across the width.
  bool symmetric() const {
    return leaf_.soft()[2] == 0 && leaf_.forces()[1] == 0 && leaf_.forces()[2] == 0;
  }
  P row(const Matrix& Y, int r) const {
    P p = P::constant(0);
    for (int k = 0; k < Y.cols(); ++k) p[k] = Y(r, k);
    return p;
  }
  // b has no degree above the order of the fields
  P times_low(const P& a, const P& b) const {
    P r = P::constant(0);
    add_product(table_, r.c.data(), b.c.data(), a.c.data(), field_order_, ORDER);
    return r;
  }
  void put(int line, int s, int c, const P& p) {
    for (int k = 0; k < size; ++k) nodal_[line](s, c * size + k) = p[k];
  }
  P get(const Matrix& m, int s, int c) const {
    P p;
    for (int k = 0; k < size; ++k) p[k] = m(s, c * size + k);
    return p;
  }
  static void copy_degree(const P& p, int k0, int k1, Matrix& R, int r) {
    for (int k = k0; k < k1; ++k) R(r, k - k0) = p[k];
  }

  // exp(hat v) and the third column of its left tangent.
  void set_axes(int e) {
    const std::array<P, 3> v{soft_[2] * (e == 0 ? -0.5 : 0.5), soft_[e], stiff_[1 + e]};
    const P q = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    // Taylor coefficients at q0 of Σ (−q)^k/(2k + m)!, m = 1, 2, 3
    auto function = [&](int m) {
      std::array<S, ORDER + 1> taylor{};
      const S q0 = q[0];
      for (int t = 0; t <= ORDER; ++t) {
        double binomial = 1;
        S term = 0, power = 1;
        for (int k = t; k < t + 16; ++k) {
          const double inverse_factorial = 1 / std::tgamma(2 * k + m + 1);
          term += (k % 2 == 0 ? 1 : -1) * binomial * power * inverse_factorial;
          binomial *= static_cast<double>(k + 1) / (k + 1 - t);
          power *= q0;
        }
        taylor[t] = term;
      }
      return compose<6, ORDER, S>(std::span<const S>(taylor), q);
    };
    const P a = function(1), b = function(2), c = function(3);
    std::array<std::array<P, 3>, 3> K, K2;
    for (auto& r : K) r.fill(P::constant(0));
    K[0][1] = v[2] * -1.0;
    K[0][2] = v[1];
    K[1][0] = v[2];
    K[1][2] = v[0] * -1.0;
    K[2][0] = v[1] * -1.0;
    K[2][1] = v[0];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        K2[i][j] = v[i] * v[j];
        if (i == j) K2[i][j] -= q;
      }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        axis_[e][j][i] = a * K[i][j] + b * K2[i][j];
        if (i == j) axis_[e][j][i][0] += 1;
      }
      tangent_z_[e][i] = b * K[i][2] + c * K2[i][2];
      if (i == 2) tangent_z_[e][i][0] += 1;
    }
  }

  // Of the undeflected leaf.
  double chord() const { return mesh_.line_pose(mesh_.lines() - 1).position[0]; }

  // Axes of an edge that stands turned by Q in the undeflected leaf.
  void turn_axes(int e, const Matrix3d& Q) {
    const auto turned = axis_[e];
    for (int j = 0; j < 3; ++j)
      for (int c = 0; c < 3; ++c) {
        axis_[e][j][c] = P::constant(0);
        for (int i = 0; i < 3; ++i)
          if (Q(i, j) != 0) axis_[e][j][c] += turned[i][c] * S(Q(i, j));
      }
  }

  S mirrored(const S& x, double sign) const {
    S image = x * sign;
    if constexpr (!std::is_same_v<S, double>)
      for (std::size_t k = 0; k < parity_.size(); ++k) image.derivatives[k] *= parity_[k];
    return image;
  }
  // Nodal forces of one half of the width: those of the other half too, of the first monomials.
  void add_mirror_image(Matrix& line, int monomials) const {
    const int nodes = mesh_.nodes_per_line();
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < monomials; ++k) {
        const auto e = table_.exponents(k);  // φ, M1 and M2 change their signs
        const double parity = ((e[2] + e[4] + e[5]) % 2 == 0) == (c != 1) ? 1 : -1;
        auto f = line.col(c * size + k);
        for (int j = 0; j <= nodes / 2; ++j)
          for (int s = 0; s < 4; ++s) {
            const int a = 4 * j + s, b = 4 * (nodes - 1 - j) + s;
            const double sign = s < 2 ? parity : -parity;
            if (a == b) {
              f[a] += mirrored(f[a], sign);
            } else {
              const S image = mirrored(f[b], sign);
              f[b] += mirrored(f[a], sign);
              f[a] += image;
            }
          }
      }
  }

  // Degree of an element's fields: the edges turn by the exponential, the rest is of field order.
  int field_degree(int i) const {
    return i == 0 || i == mesh_.elements_along() - 1 ? ORDER : std::min(ORDER, field_order_);
  }

  // Columns of the monomials ≤ degree, component by component.
  void gather(int i, int j, int m) {
    const int side = mesh_.functions_per_side();
    Matrix& U = U_;
    U.setZero(2 * side, 3 * m);
    for (int p = 0; p < 2; ++p) {
      const Matrix& line = nodal_[i + p];
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
      for (int g = 0; g < points; ++g) metric[g] = mesh_.element(i, j).metric[g];
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
      bent.c[g] = first + g < n ? element.curvature_weight[first + g] : 0;
    for (int v = 0; v < 3; ++v)
      for (int c = 0; c < 3; ++c) {
        bent.a[v][c].assign(m, lanes(0));
        for (int k = 0; k < m; ++k)
          for (int g = 0; g < points && first + g < n; ++g)
            bent.a[v][c][k][g] = field(v * n + first + g, c * m + k);
      }
    return bent;
  }

  // Component c of a × b, to a degree.
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

  // And the energy itself, with what makes it zero at rest.
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
    sum[0][0] += weight * element.rest_energy;
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

  Lanes weights(int i, int j) const {
    Lanes w;
    for (int g = 0; g < points; ++g) LanesOf::set(w, g, operators_.element(i, j).weight[g]);
    return w;
  }

  // Nodal forces of degrees d0 to d.
  void add_force(int i, int j, int d0, int d, std::vector<Matrix>& force) {
    const int m = table_.count(d);
    gather(i, j, m);
    point_series(i, j, m, d, d);
    const Matrix& U = U_;
    const Points& p = points_;
    const Lanes w = weights(i, j);
    const auto [A11, A12, A33] = operators_.membrane();
    std::array<std::vector<Lanes>, 3> stress;
    for (auto& s : stress) s.resize(m);
    for (int k = 0; k < m; ++k) {
      stress[0][k] = w * (A11 * p.strain[0][k] + A12 * p.strain[1][k]);
      stress[1][k] = w * (A12 * p.strain[0][k] + A11 * p.strain[1][k]);
      stress[2][k] = w * (A33 * p.strain[2][k]);
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

  void add_energy(int i, int j, double weight, std::vector<Lanes>& sum) {
    const int degree = field_degree(i), m = table_.count(degree);
    const int strain_degree = std::min(ORDER, 2 * degree);
    gather(i, j, m);
    point_series(i, j, m, degree, strain_degree);
    const Matrix& U = U_;
    const Points& p = points_;
    // ½ [A11 (e11² + e22²) + 2 A12 e11 e22 + A33 (2 e12)²] as three squares
    const Lanes w = weights(i, j) * (0.5 * weight);
    const auto [A11, A12, A33] = operators_.membrane();
    const int ms = table_.count(strain_degree);
    std::vector<Lanes>&mean = work_[0], &difference = work_[1];
    mean.resize(ms);
    difference.resize(ms);
    for (int k = 0; k < ms; ++k) {
      mean[k] = p.strain[0][k] + p.strain[1][k];
      difference[k] = p.strain[0][k] - p.strain[1][k];
    }
    add_square(table_, sum.data(), mean.data(), w * (0.5 * (A11 + A12)), strain_degree);
    add_square(table_, sum.data(), difference.data(), w * (0.5 * (A11 - A12)), strain_degree);
    add_square(table_, sum.data(), p.strain[2].data(), w * A33, strain_degree);
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
            a[k][g] = U(8 * half + g, c * m + k);
            b[k][g] = B(8 * half + g, c * m + k);
          }
        add_product(table_, sum.data(), a.data(), b.data(), degree, degree);
      }
  }

  const ChordLeaf& leaf_;
  const PlateMesh& mesh_;
  const Operators& operators_;
  const MonomialTable& table_;
  int field_order_;
  std::array<P, 3> soft_, stiff_, force_;
  std::array<std::array<std::array<P, 3>, 3>, 2> axis_;  ///< [edge][column][component]
  std::array<std::array<P, 3>, 2> tangent_z_;            ///< [edge][component] of J e_z
  std::vector<Matrix> nodal_;
  std::vector<Matrix> load_;  ///< none, or of every line
  std::vector<int> parity_;

  // of the element at hand
  Matrix U_, A_;
  Points points_;
  std::array<std::vector<Lanes>, 2> work_;
};

}  // namespace flexopt
