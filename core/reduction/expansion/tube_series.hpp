#pragma once
// The residual and the potential of a plate leaf as polynomials in x = (σ, τ, φ, N, M1, M2), from
// its fields as such: what its expansion is made of. core/reduction/README.md (R2)–(R4).
#include <array>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/math/polynomial.hpp"
#include "core/reduction/expansion/edge_series.hpp"
#include "core/reduction/expansion/element_series.hpp"
#include "core/reduction/expansion/tube_expansion.hpp"

namespace flexopt {

/// Everything about one leaf as polynomials in x, truncated at ORDER. Nodal dofs of a line:
/// functions_per_line × (3 · m), column c · m + k for component c, monomial k; m = size at the
/// edges, the monomials of the fields inside.
///
/// Operators: where the numbers of the mesh come from, the PlateMesh itself or one whose numbers
/// are of another type S; so are then the fields and the residual. NV: 6, or 2 for (σ, τ) alone.
template <int ORDER, class Operators = PlateMesh, int NV = 6>
class TubeSeries {
 public:
  using S = std::decay_t<decltype(std::declval<const Operators&>().membrane().A11)>;
  using P = Polynomial<NV, ORDER, S>;
  using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
  static constexpr int size = P::size;

  TubeSeries(const ChordLeaf& leaf, const Operators& operators, const Eigen::Matrix2d& ray,
             int field_order)
      : leaf_(leaf),
        mesh_(leaf.plate().mesh()),
        operators_(operators),
        table_(monomials<NV, ORDER>()),
        field_order_(field_order),
        elements_(mesh_, operators, field_order) {
    const Vector3d& s = leaf.soft();
    const Vector3d scale = tube_force_scale(mesh_.shape());
    for (int k = 0; k < 2; ++k) {
      soft_[k] = P::constant(s[k]);
      soft_[k][1] = ray(k, 0);
      soft_[k][2] = ray(k, 1);
    }
    soft_[2] = P::constant(s[2]);
    for (int k = 0; k < 3; ++k) force_[k] = P::constant(leaf.forces()[k]);
    if constexpr (NV == 6) {
      soft_[2][3] = 1;
      for (int k = 0; k < 3; ++k) force_[k][4 + k] = scale[k];
    }
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
      edge_[e] =
          EdgeSeries<NV, ORDER, S>({soft_[2] * (e == 0 ? -0.5 : 0.5), soft_[e], stiff_[1 + e]});
      const int line = e == 0 ? 0 : last;
      if (mesh_.shape().curve) edge_[e].turn(mesh_.line_pose(line).axes);
      nodal_[line].setZero();
      for (int j = 0; j < mesh_.nodes_per_line(); ++j) {
        const auto& slopes = mesh_.edge_slopes();
        const int o = leaf_.plate().block_offset(line) + static_cast<int>(slopes.size()) * j;
        for (int c = 0; c < 3; ++c) {
          const P &e1 = edge_[e].axis[0][c], &e2 = edge_[e].axis[1][c];
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
                times_low(edge_[e].axis[slopes[d].axis][c], row(Y, o + static_cast<int>(d)));
          for (int k = 0; k < 4; ++k) put(line, 4 * j + k, c, v[k]);
        }
      }
    }
  }

  /// Nodal values of fields to ORDER: FieldExpansion::nodal.
  Matrix nodal() const {
    const int n = mesh_.functions_per_line(), lines = mesh_.lines();
    Matrix values(3 * n * lines, size);
    for (int i = 0; i < lines; ++i)
      for (int c = 0; c < 3; ++c)
        values.middleRows((3 * i + c) * n, n) = nodal_[i].middleCols(c * size, size);
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
        elements_.add_force(nodal_, i, j, i == 0 || i == mesh_.elements_along() - 1 ? 0 : d, d,
                            force);
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
      for (int s = 0; s < n; ++s) {
        std::array<P, 3> g, r;
        for (int c = 0; c < 3; ++c) {
          g[c] = get(force[line], s, c);
          r[c] = get(nodal_[line], s, c);
        }
        // lever arms count from the middle of the edge
        if (s % 4 == 0 && e == 1) {
          r[0] -= stiff_[0];
          r[0][0] -= chord();
        }
        for (int c = 0; c < 3; ++c) {
          const int a = (c + 1) % 3, b = (c + 2) % 3;
          moment[c] += r[a] * g[b] - r[b] * g[a];
        }
        if (s % 4 == 0) pull += g[0];
        mesh_.each_slope(s, [&](int axis, int unknown) {
          P sum = P::constant(0);
          for (int c = 0; c < 3; ++c) sum += edge_[e].axis[axis][c] * g[c];
          copy_degree(sum, k0, k1, R, leaf_.plate().block_offset(line) + unknown);
        });
      }
      const int u = leaf_.plate().unknowns();
      if (e == 1) copy_degree(pull - force_[0], k0, k1, R, u);
      P sum = P::constant(0);
      for (int c = 0; c < 3; ++c) sum += edge_[e].tangent_z[c] * moment[c];
      copy_degree(sum - force_[1 + e], k0, k1, R, u + 1 + e);
    }
    return R;
  }

  /// Π = U − f·c. Odd powers of (φ, M1, M2) are not filled where the state is mirror symmetric.
  std::vector<double> potential() {
    using Elements = ElementSeries<ORDER, Operators, NV>;
    std::vector<typename Elements::Lanes> sum(size, Elements::lanes(0));
    const int ny = mesh_.elements_across();
    for (int j = 0; j < (symmetric() ? (ny + 1) / 2 : ny); ++j) {
      const double weight = symmetric() && 2 * j + 1 != ny ? 2 : 1;  // for its mirror image
      for (int i = 0; i < mesh_.elements_along(); ++i)
        elements_.add_energy(nodal_, i, j, weight, sum);
    }
    P total = P::constant(0);
    for (int k = 0; k < size; ++k)
      for (int g = 0; g < Elements::points; ++g) total[k] += sum[k][g];
    for (int k = 0; k < 3; ++k) total -= force_[k] * stiff_[k];
    return {total.c.begin(), total.c.end()};
  }

 private:
  // Whether the state is symmetric in the mirror across the width.
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

  // Chord of the undeflected leaf, over its length.
  double chord() const { return mesh_.line_pose(mesh_.lines() - 1).position[0]; }

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
        const int changes = NV == 2 ? 0 : e[2] + e[4] + e[5];
        const double parity = (changes % 2 == 0) == (c != 1) ? 1 : -1;
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

  const ChordLeaf& leaf_;
  const PlateMesh& mesh_;
  const Operators& operators_;
  const MonomialTable& table_;
  int field_order_;
  ElementSeries<ORDER, Operators, NV> elements_;
  std::array<P, 3> soft_, stiff_, force_;
  std::array<EdgeSeries<NV, ORDER, S>, 2> edge_;
  std::vector<Matrix> nodal_;
  std::vector<Matrix> load_;  ///< none, or of every line
  std::vector<int> parity_;
};

}  // namespace flexopt
