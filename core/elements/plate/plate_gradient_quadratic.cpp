// The quadratic forms of a full leaf and what they change by: (S7)–(S9) of core/response/README.md.
#include <cassert>

#include "core/elements/plate/plate_curvature.hpp"
#include "core/elements/plate/plate_gradient.hpp"
#include "core/elements/plate/plate_products.hpp"

namespace flexopt {

using namespace plate;

namespace {

bool changes(const PlateMesh::Membrane& rate) {
  return rate.A11 != 0 || rate.A12 != 0 || rate.A33 != 0;
}

/// An undeflected element, and what it has become.
template <class S>
struct DeflectedElement {
  int index = 0;
  const PlateMesh::Element& operators;
  const Gradient<S>& a0;
  const Stress<S>&strain, &stress;   ///< stress times weight
  const Eigen::MatrixX<S>& natural;  ///< of a curved leaf
};

// Covectors n0 of N0 (all lines) and n1 of N1 (lines that are asked for), N2 on lines that have it;
// values and shape derivatives, of
//   q = Σ w [ e1·A e1 + A e0·q2 ] + N1ᵀB N1 + N0ᵀB N2 − μ N1ᵀM N1.
// Of one element after the other, along columns of nodes.
template <class S, int Side>
class ElementQuadratic {
 public:
  using Matrix = Eigen::MatrixX<S>;
  using Vector = Eigen::VectorX<S>;
  static constexpr int functions = 2 * Side;
  using Block = Eigen::Matrix<S, functions, Eigen::Dynamic>;
  using ElementBlock = Eigen::Matrix<S, functions, 3>;

  ElementQuadratic(const PlateMesh& mesh, const PlateMeshRate& rate, const Vector& mu,
                   LeafQuadratic<S>& q)
      : mesh_(mesh),
        rate_(rate),
        mu_(mu),
        q_(q),
        columns_(static_cast<int>(mu.size())),
        s0_(16, 3 * columns_),
        s1_(16, 3 * columns_),
        along_(static_cast<std::size_t>(rate.directions())) {}

  /// Nodes of the element, N2 where `curved`; covectors of N1 are wanted where `moved`.
  void add(const DeflectedElement<S>& e, const ElementBlock& U0, const Block& U1, const Block* U2,
           bool moved);
  const Block& n0() const { return F0_; }
  const Block& n1() const { return F1_; }  ///< where moved

 private:
  using PointBlock = Eigen::Matrix<S, 16, Eigen::Dynamic>;
  /// What the fields of the element change by along one direction of the shape.
  struct Along {
    bool moves = false, weighs = false, bends = false;
    Gradient<S> da0;
    PointBlock da1, da2;
    Stress<S> dn_0;
    Matrix db0, db1, db2;  // of the fields of a curved leaf
  };
  template <class M>
  static auto column(M& of, int k) {
    return of.template middleCols<3>(3 * k);
  }
  template <class Add>
  void column_dots(const Block& A, const Block& B, const Add& add) const {
    for (int k = 0; k < columns_; ++k) add(k, column(A, k).cwiseProduct(column(B, k)).sum());
  }
  Stress<S> stress_rate(const PlateMeshRate::Shape& by, const DeflectedElement<S>& e,
                        const Stress<S>& strain) const;
  void set_along(const DeflectedElement<S>& e, const ElementBlock& U0, const Block& U1,
                 const Block* U2);
  void add_membrane(const DeflectedElement<S>& e, int k, bool curved);
  void add_curvature(const DeflectedElement<S>& e, const Block& U1, const Block* U2, bool moved);
  void add_curvature_rates(const DeflectedElement<S>& e, int k, const Matrix& c0, const Matrix& c1,
                           const Matrix& c2, bool curved);
  void add_operator_rates(const DeflectedElement<S>& e, const ElementBlock& U0, const Block& U1,
                          const Block* U2);

  const PlateMesh& mesh_;
  const PlateMeshRate& rate_;
  const Vector& mu_;
  LeafQuadratic<S>& q_;
  int columns_;
  PointBlock a1_, a2_, s0_, s1_;  ///< gradients, and covectors of a0 and a1
  Matrix b1_, b2_;                ///< fields of a curved leaf
  Block BU_, F0_, F1_;
  std::vector<Along> along_;  ///< every direction of the shape
};

template <class S, int Side>
Stress<S> ElementQuadratic<S, Side>::stress_rate(const PlateMeshRate::Shape& by,
                                                 const DeflectedElement<S>& e,
                                                 const Stress<S>& strain) const {
  Stress<S> n = Stress<S>::Zero();
  if (changes(by.membrane)) n = weighted(stress_of(by.membrane, strain), e.operators.weight);
  if (!by.weight.empty()) n += weighted(stress_of(mesh_.membrane(), strain), by.weight[e.index]);
  return n;
}

// Of the gradients, and of the stresses by the shape, the strains being constant.
template <class S, int Side>
void ElementQuadratic<S, Side>::set_along(const DeflectedElement<S>& e, const ElementBlock& U0,
                                          const Block& U1, const Block* U2) {
  for (int p = 0; p < rate_.directions(); ++p) {
    const PlateMeshRate::Shape& by = rate_.shape[p];
    Along& a = along_[p];
    a.moves = !by.gradient.empty();
    a.weighs = changes(by.membrane) || !by.weight.empty() || !by.metric.empty();
    if (a.weighs) a.dn_0 = stress_rate(by, e, e.strain);
    if (!by.metric.empty())
      a.dn_0 += metric_stress<S>(mesh_, by.metric[e.index], e.operators.weight);
    a.bends = !by.curvature.empty();
    if (a.bends) {
      const MatrixXd& dH = by.curvature[e.index];
      a.db0 = curvature_field(dH, U0);
      a.db1 = curvature_field(dH, U1);
      if (U2) a.db2 = curvature_field(dH, *U2);
    }
    if (!a.moves) continue;
    const auto dG = by.gradient[e.index].template leftCols<functions>();
    assign_product(a.da0, dG, U0);
    assign_product(a.da1, dG, U1);
    if (U2) assign_product(a.da2, dG, *U2);
  }
}

template <class S, int Side>
void ElementQuadratic<S, Side>::add_membrane(const DeflectedElement<S>& e, int k, bool curved) {
  const auto a1k = column(a1_, k);
  const PointArray& weight = e.operators.weight;
  const Stress<S> e1 = strain_product(e.a0, a1k);
  Stress<S> e2 = strain_product(a1k, a1k);
  if (curved) e2 += strain_product(e.a0, column(a2_, k));
  const Stress<S> nu1 = weighted(stress_of(mesh_.membrane(), e1), weight),
                  nu2 = weighted(stress_of(mesh_.membrane(), e2), weight);
  q_.stiffness[k] += sum(nu1, e1) + sum(e.stress, e2);
  Gradient<S> c0 = 2.0 * stress_times(nu1, a1k) + stress_times(nu2, e.a0);
  if (curved) c0 += stress_times(e.stress, column(a2_, k));
  const Gradient<S> c1 = 2.0 * (stress_times(nu1, e.a0) + stress_times(e.stress, a1k));
  column(s0_, k) = c0;
  column(s1_, k) = c1;
  // shape: the operators alone
  for (int p = 0; p < rate_.directions(); ++p) {
    const Along& a = along_[p];
    if (a.moves) {
      q_.shape(p, k) += c0.cwiseProduct(a.da0).sum() + c1.cwiseProduct(column(a.da1, k)).sum();
      if (curved)
        q_.shape(p, k) += stress_times(e.stress, e.a0).cwiseProduct(column(a.da2, k)).sum();
    }
    if (a.weighs) q_.shape(p, k) += sum(stress_rate(rate_.shape[p], e, e1), e1) + sum(a.dn_0, e2);
  }
}

// The cubic energy of a curved leaf: b1·(b0, b1) + ½ b2·(b0, b0) of curvature_product.
template <class S, int Side>
void ElementQuadratic<S, Side>::add_curvature(const DeflectedElement<S>& e, const Block& U1,
                                              const Block* U2, bool moved) {
  const MatrixXd& rows = e.operators.curvature;
  const Eigen::ArrayXd& c = e.operators.curvature_weight;
  b1_ = curvature_field(rows, U1);
  if (U2) b2_ = curvature_field(rows, *U2);
  const Matrix c2 = 0.5 * curvature_product(c, e.natural, e.natural);
  for (int k = 0; k < columns_; ++k) {
    const auto b1k = column(b1_, k);
    const Matrix once = curvature_product(c, e.natural, b1k), c1 = 2.0 * once;
    Matrix c0 = curvature_product(c, b1k, b1k);
    q_.stiffness[k] += once.cwiseProduct(b1k).sum();
    if (U2) {
      const auto b2k = column(b2_, k);
      c0 += curvature_product(c, e.natural, b2k);
      q_.stiffness[k] += c2.cwiseProduct(b2k).sum();
    }
    column(F0_, k) += curvature_force(rows, functions, c0);
    if (moved) column(F1_, k) += curvature_force(rows, functions, c1);
    add_curvature_rates(e, k, c0, c1, c2, U2 != nullptr);
  }
}

template <class S, int Side>
void ElementQuadratic<S, Side>::add_curvature_rates(const DeflectedElement<S>& e, int k,
                                                    const Matrix& c0, const Matrix& c1,
                                                    const Matrix& c2, bool curved) {
  const auto b1k = column(b1_, k);
  for (int p = 0; p < rate_.directions(); ++p) {
    const Along& a = along_[p];
    if (a.bends) {
      q_.shape(p, k) += c0.cwiseProduct(a.db0).sum() + c1.cwiseProduct(column(a.db1, k)).sum();
      if (curved) q_.shape(p, k) += c2.cwiseProduct(column(a.db2, k)).sum();
    }
    if (rate_.shape[p].curvature_weight.empty()) continue;
    const Eigen::ArrayXd& dc = rate_.shape[p].curvature_weight[e.index];
    q_.shape(p, k) += curvature_product(dc, e.natural, b1k).cwiseProduct(b1k).sum();
    if (curved)
      q_.shape(p, k) +=
          0.5 * curvature_product(dc, e.natural, e.natural).cwiseProduct(column(b2_, k)).sum();
  }
}

// Of bending stiffness and mass.
template <class S, int Side>
void ElementQuadratic<S, Side>::add_operator_rates(const DeflectedElement<S>& e,
                                                   const ElementBlock& U0, const Block& U1,
                                                   const Block* U2) {
  for (int p = 0; p < rate_.directions(); ++p) {
    const PlateMeshRate::Shape& by = rate_.shape[p];
    const auto dB = by.bending[e.index].template topLeftCorner<functions, functions>();
    if (!dB.isZero(0)) {
      assign_product(BU_, dB, U1);
      column_dots(U1, BU_, [&](int k, const S& d) { q_.shape(p, k) += d; });
      if (U2) {
        ElementBlock BU0;
        assign_product(BU0, dB, U0);
        for (int k = 0; k < columns_; ++k) q_.shape(p, k) += BU0.cwiseProduct(column(*U2, k)).sum();
      }
    }
    if (by.mass.empty()) continue;
    const auto dM = by.mass[e.index].template topLeftCorner<functions, functions>();
    assign_product(BU_, dM, U1);
    column_dots(U1, BU_, [&](int k, const S& d) { q_.shape(p, k) -= mu_[k] * d; });
  }
}

template <class S, int Side>
void ElementQuadratic<S, Side>::add(const DeflectedElement<S>& e, const ElementBlock& U0,
                                    const Block& U1, const Block* U2, bool moved) {
  const auto G = e.operators.gradient.template leftCols<functions>();
  const auto B = e.operators.bending.template topLeftCorner<functions, functions>();
  const auto M = e.operators.mass.template topLeftCorner<functions, functions>();
  assign_product(a1_, G, U1);
  if (U2) assign_product(a2_, G, *U2);
  set_along(e, U0, U1, U2);
  for (int k = 0; k < columns_; ++k) add_membrane(e, k, U2 != nullptr);
  assign_product(BU_, B, U1);
  column_dots(U1, BU_, [&](int k, const S& d) { q_.stiffness[k] += d; });
  assign_product(F0_, G.transpose(), s0_);
  if (moved) {
    assign_product(F1_, G.transpose(), s1_);
    F1_ += 2.0 * BU_;
  }
  if (e.operators.curvature_weight.size() > 0) add_curvature(e, U1, U2, moved);
  if (U2) {
    assign_product(BU_, B, *U2);
    F0_ += BU_;
    for (int k = 0; k < columns_; ++k) q_.stiffness[k] += U0.cwiseProduct(column(BU_, k)).sum();
  }
  add_operator_rates(e, U0, U1, U2);
  assign_product(BU_, M, U1);
  column_dots(U1, BU_, [&](int k, const S& d) { q_.mass[k] += d; });
  if (moved)
    for (int k = 0; k < columns_; ++k) column(F1_, k) -= S(2.0 * mu_[k]) * column(BU_, k);
}

}  // namespace

template <class S>
template <int Side>
void PlateGradient<S>::quadratic_elements(const std::vector<Matrix>& N1,
                                          const std::vector<Matrix>& N2, const Vector& mu,
                                          LeafQuadratic<S>& q, std::vector<Matrix>& n0,
                                          std::vector<Matrix>& n1) const {
  const int nx = mesh_->elements_along(), ny = mesh_->elements_across();
  const Matrix zero =
      Matrix::Zero(mesh_->functions_per_line(), 3 * static_cast<Eigen::Index>(mu.size()));
  const auto or_zero = [&](const Matrix& N) -> const Matrix& { return N.size() > 0 ? N : zero; };
  ElementQuadratic<S, Side> elements(*mesh_, *rate_, mu, q);
  typename ElementQuadratic<S, Side>::Block U1, U2;
  for (int i = 0; i < nx; ++i) {
    const bool curved = N2[i].size() > 0 || N2[i + 1].size() > 0,
               moved = n1[i].size() > 0 || n1[i + 1].size() > 0;
    for (int j = 0; j < ny; ++j) {
      const int k = i * ny + j;
      U1 = gather<Side>(N1[i], N1[i + 1], j);
      if (curved) U2 = gather<Side>(or_zero(N2[i]), or_zero(N2[i + 1]), j);
      elements.add({k, mesh_->element(i, j), a0_[k], strain_[k], n0_[k], natural_[k]},
                   gather<Side>(state_.nodal[i], state_.nodal[i + 1], j), U1,
                   curved ? &U2 : nullptr, moved);
      const auto add = [&](Matrix& to, const auto& rows) {
        if (to.size() > 0) to.template middleRows<Side>(4 * j) += rows;
      };
      if (moved) {
        add(n1[i], elements.n1().template topRows<Side>());
        add(n1[i + 1], elements.n1().template bottomRows<Side>());
      }
      add(n0[i], elements.n0().template topRows<Side>());
      add(n0[i + 1], elements.n0().template bottomRows<Side>());
    }
  }
}

// N2 = ω×(ω×v) + 2 Σ ȧ ω×d with v = R w and axes d.
template <class S>
auto PlateGradient<S>::second_nodes(int e, const Matrix& Y) const -> Matrix {
  const auto& slopes = mesh_->edge_slopes();
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(Y.cols()),
            per_node = static_cast<int>(slopes.size());
  Matrix second = Matrix::Zero(n, 3 * columns);
  for (int k = 0; k < columns; ++k) {
    const Vector3<S> w = Y.template block<3, 1>(rows_.body(e) + 3, k);
    for (int s = 0; s < n; ++s) {
      Vector3<S> r = w.cross(w.cross(edges_[e].arm[s]));
      for (int d = 0; d < per_node; ++d)
        if (slopes[d].function == s % 4)
          r += S(2.0 * Y(plate_->block_offset(edges_[e].line) + per_node * (s / 4) + d, k)) *
               w.cross(edges_[e].axes.col(slopes[d].axis));
      second.template block<1, 3>(s, 3 * k) = r.transpose();
    }
  }
  return second;
}

// The edges: N0 = p + v, N1 = u̇ + ω×v + Σ ȧ d, N2 as above.
template <class S>
void PlateGradient<S>::add_edge_quadratic(int e, const Matrix& Y, const Matrix& n0,
                                          const Matrix& n1, LeafQuadratic<S>& q) const {
  const auto& slopes = mesh_->edge_slopes();
  const int n = mesh_->functions_per_line(), columns = static_cast<int>(Y.cols()),
            per_node = static_cast<int>(slopes.size()), line = edges_[e].line, body = rows_.body(e);
  const Matrix3<S>& R = edges_[e].axes;
  for (int k = 0; k < columns; ++k) {
    typename LeafQuadratic<S>::Edge& g = q.edge[k][e];
    const Vector3<S> w = Y.template block<3, 1>(body + 3, k);
    for (int s = 0; s < n; ++s) {
      const Vector3<S> f0 = n0.template block<1, 3>(s, 3 * k).transpose(),
                       f1 = n1.template block<1, 3>(s, 3 * k).transpose(),
                       f2 = nodal_force_[line].row(s).transpose();
      const Vector3<S>&v = edges_[e].arm[s], f2w = f2.cross(w);
      const Vector3<S> c = f0 + f1.cross(w) + f2w.cross(w);
      g.rotation += c * edges_[e].local[s].transpose();
      g.spin += v.cross(f1) + w.cross(v).cross(f2) + v.cross(f2w);
      q.state.template block<3, 1>(body + 3, k) += v.cross(c);
      if (s % 4 == 0) {
        g.position += f0;
        g.displacement += f1;
        g.arm += R.transpose() * c;
      }
      for (int p = 0; p < directions(); ++p)
        if (!rate_->shape[p].reference.empty())
          q.shape(p, k) += c.dot(R * rate_->shape[p].reference[line].row(s).transpose());
      for (int d = 0; d < per_node; ++d) {
        if (slopes[d].function != s % 4) continue;
        const int row = plate_->block_offset(line) + per_node * (s / 4) + d;
        const Vector3<S> axis = R.col(slopes[d].axis);
        const S rate = Y(row, k);
        const Vector3<S> cd = rate * (f1 + 2.0 * f2w);
        g.rotation.col(slopes[d].axis) += cd;
        g.spin += S(2.0 * rate) * axis.cross(f2);
        q.state.template block<3, 1>(body + 3, k) += axis.cross(cd);
        q.state(row, k) += c.dot(axis);
      }
    }
    q.state.template block<3, 1>(body, k) += g.position;
  }
}

template <class S>
auto PlateGradient<S>::quadratic(const Matrix& Y, const Vector& mu) const -> LeafQuadratic<S> {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines(),
            columns = static_cast<int>(Y.cols());
  assert(Y.rows() == size() && mu.size() == columns);
  std::vector<Matrix> N1(lines), n0(lines, Matrix::Zero(n, 3 * columns));
  for (int i = 0; i < lines; ++i) N1[i] = line_rates(i, Y);
  std::vector<Matrix> N2(lines), n1(lines);  // of the edges alone
  for (int e = 0; e < 2; ++e) {
    if (!rigid_[e]) continue;
    N2[edges_[e].line] = second_nodes(e, Y);
    n1[edges_[e].line] = Matrix::Zero(n, 3 * columns);
  }
  LeafQuadratic<S> q(size(), columns, directions());
  if (mesh_->functions_per_side() == 8)
    this->template quadratic_elements<8>(N1, N2, mu, q, n0, n1);
  else
    this->template quadratic_elements<4>(N1, N2, mu, q, n0, n1);
  add_point_quadratic(Y, N1, N2, q, n1);

  for (int i = 0; i < lines; ++i)
    if (edge_at(i) < 0) add_to_rows(i, n0[i], q.state);
  for (int e = 0; e < 2; ++e)
    if (rigid_[e]) add_edge_quadratic(e, Y, n0[edges_[e].line], n1[edges_[e].line], q);
  return q;
}

template <class S>
auto PlateGradient<S>::nodal_quadratic(const std::vector<Matrix>& N1,
                                       const std::vector<Matrix>& N2) const -> NodalQuadratic {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines(),
            columns = static_cast<int>(N1[0].cols() / 3);
  const std::vector<Matrix> none(static_cast<std::size_t>(lines), Matrix::Zero(n, 3 * columns));
  NodalQuadratic result{LeafQuadratic<S>(0, columns, directions()), none, none};
  const Vector mu = Vector::Zero(columns);
  if (mesh_->functions_per_side() == 8)
    this->template quadratic_elements<8>(N1, N2, mu, result.value, result.n0, result.n1);
  else
    this->template quadratic_elements<4>(N1, N2, mu, result.value, result.n0, result.n1);
  return result;
}

#define INSTANTIATE(S)                                                                       \
  template LeafQuadratic<S> PlateGradient<S>::quadratic(const Matrix&, const Vector&) const; \
  template PlateGradient<S>::NodalQuadratic PlateGradient<S>::nodal_quadratic(               \
      const std::vector<Matrix>&, const std::vector<Matrix>&) const;
INSTANTIATE(double)
INSTANTIATE(Jet)
#undef INSTANTIATE

}  // namespace flexopt
