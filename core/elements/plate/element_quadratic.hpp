#pragma once
// The quadratic forms of one element of a leaf and what they change by, (S8) and (S9) of
// core/response/README.md. Included by plate_gradient_quadratic.cpp alone.
#include <vector>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/plate/plate_curvature.hpp"
#include "core/elements/plate/plate_products.hpp"

namespace flexopt::plate {

// Covectors n0 of N0 (all lines) and n1 of N1 (lines that are asked for), N2 on lines that have it;
// values and shape derivatives, of
//   q = Σ w [ e1·A e1 + A e0·q2 ] + N1ᵀB N1 + N0ᵀB N2 − μ N1ᵀM N1.
// The elements are added one after the other, along columns of nodes.
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
        along_(static_cast<std::size_t>(q.shape.rows())) {}

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
  std::vector<Along> along_;  ///< every direction of the shape that is wanted
};

// Sets, for every direction of the shape, the changes of the gradient operators and of the stresses
// at constant strains.
template <class S, int Side>
void ElementQuadratic<S, Side>::set_along(const DeflectedElement<S>& e, const ElementBlock& U0,
                                          const Block& U1, const Block* U2) {
  for (int p = 0; p < q_.shape.rows(); ++p) {
    const PlateMeshRate::Shape& by = rate_.shape[p];
    Along& a = along_[p];
    a.moves = !by.gradient.empty();
    a.weighs = changes(by.membrane) || !by.weight.empty() || !by.metric.empty();
    if (a.weighs) a.dn_0 = stress_rate(mesh_, by, e, e.strain);
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
  const PlateMesh::Weights& weight = e.operators.weight;
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
  for (int p = 0; p < q_.shape.rows(); ++p) {
    const Along& a = along_[p];
    if (a.moves) {
      q_.shape(p, k) += c0.cwiseProduct(a.da0).sum() + c1.cwiseProduct(column(a.da1, k)).sum();
      if (curved)
        q_.shape(p, k) += stress_times(e.stress, e.a0).cwiseProduct(column(a.da2, k)).sum();
    }
    if (a.weighs)
      q_.shape(p, k) += sum(stress_rate(mesh_, rate_.shape[p], e, e1), e1) + sum(a.dn_0, e2);
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
  for (int p = 0; p < q_.shape.rows(); ++p) {
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

// Adds the terms from the derivatives of the bending stiffness and the mass of an element.
template <class S, int Side>
void ElementQuadratic<S, Side>::add_operator_rates(const DeflectedElement<S>& e,
                                                   const ElementBlock& U0, const Block& U1,
                                                   const Block* U2) {
  for (int p = 0; p < q_.shape.rows(); ++p) {
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

}  // namespace flexopt::plate
