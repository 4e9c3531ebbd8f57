// Energy, force and tangent of a plate leaf, (E1) to (E4), before its interior is eliminated.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/elements/plate/plate_curvature.hpp"
#include "core/elements/plate/plate_fold.hpp"
#include "core/elements/plate/plate_leaf.hpp"
#include "core/elements/plate/plate_products.hpp"
#include "core/math/small_product.hpp"

namespace flexopt {

using namespace plate;

namespace {

// Second derivatives of the cubic part of the energy, between the components c and d of the nodal
// values.
PlateMesh::Matrix16 curvature_tangent(const PlateMesh::Element& element, const MatrixXd& field,
                                      int c, int d) {
  const int e = 3 - c - d;  // the third component
  const double sign = (c + 1) % 3 == d ? 1 : -1;
  const Eigen::Index n = element.curvature_weight.size();
  const auto row = [&](Eigen::Index k) { return element.curvature.middleRows(k * n, n); };
  const auto factor = [&](Eigen::Index k) {
    return (sign * element.curvature_weight * field.col(e).segment(k * n, n).array()).matrix();
  };
  const VectorXd f[3] = {factor(0), factor(1), factor(2)};
  MatrixXd CG(3 * n, 16);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Index l = (k + 1) % 3, m = (k + 2) % 3;
    CG.middleRows(k * n, n).noalias() = f[m].asDiagonal() * row(l);
    CG.middleRows(k * n, n).noalias() -= f[l].asDiagonal() * row(m);
  }
  PlateMesh::Matrix16 K;
  K.noalias() = element.curvature.transpose() * CG;
  return K;
}

}  // namespace

template <int Side>
void PlateLeaf::linearised_stress(const VectorXd& dx, const Vector12d& dq) {
  const int n = mesh_->functions_per_line(), nx = mesh_->elements_along(),
            ny = mesh_->elements_across();
  VectorXd T(unknowns() + 12);
  T << dx, dq;
  std::vector<MatrixXd>& rates = nodal_change_;
  for (int i = 0; i <= nx; ++i) rates[i] = nodal_rates(i, T).reshaped(n, 3);
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      if (i == mesh_->fold_line()) continue;
      const PlateMesh::Element& element = mesh_->element(i, j);
      PointState& point = points_[i * ny + j];
      Eigen::Matrix<double, 2 * Side, 3> dU;
      dU << rates[i].middleRows<Side>(4 * j), rates[i + 1].middleRows<Side>(4 * j);
      Gradient<double> da;
      assign_small_product(da, element.gradient.leftCols<2 * Side>(), dU);
      const auto& a = point.gradient;
      const auto a1 = a.topRows<points>(), a2 = a.bottomRows<points>();
      const auto d1 = da.topRows<points>(), d2 = da.bottomRows<points>();
      Stress<double> e;
      e.col(0) = 0.5 * (a1.rowwise().squaredNorm().array() - element.metric) +
                 a1.cwiseProduct(d1).rowwise().sum().array();
      e.col(1) = 0.5 * (a2.rowwise().squaredNorm().array() - 1) +
                 a2.cwiseProduct(d2).rowwise().sum().array();
      e.col(2) =
          (a1.cwiseProduct(a2) + a1.cwiseProduct(d2) + a2.cwiseProduct(d1)).rowwise().sum().array();
      point.stress = weighted(stress_of(mesh_->membrane(), e), element.weight);
    }
  stress_is_linearised_ = true;
}

MatrixXd& PlateLeaf::line_diagonal(int i) {
  const int fold = mesh_->fold_line();
  if (fold >= 0 && (i == fold || i == fold + 1)) return fold_diagonal_[i - fold];
  return is_rigid_edge(i) ? edge_diagonal_[edge_of(i)] : K_.diagonal[block(i)];
}

MatrixXd& PlateLeaf::line_below(int i) {
  const int fold = mesh_->fold_line();
  if (fold >= 0 && i >= fold - 1 && i <= fold + 1)
    return i == fold ? fold_gap_ : fold_below_[i < fold ? 0 : 1];
  return is_rigid_edge(i)       ? edge_below_[0]
         : is_rigid_edge(i + 1) ? edge_below_[1]
                                : K_.below[block(i)];
}

// Adds energy and force of an element and returns the field of its curvature, if it is curved.
// Both are expanded about the undeflected leaf, where they vanish: of places, second derivatives in
// a small element are differences of large numbers, and their rounding outweighs a small stroke.
template <int Side>
MatrixXd PlateLeaf::add_element_force(int i, int j) {
  constexpr int functions = 2 * Side;
  const int n = mesh_->functions_per_line();
  const PlateMesh::Element& element = mesh_->element(i, j);
  PointState& point = points_[i * mesh_->elements_across() + j];
  const auto G = element.gradient.leftCols<functions>();
  Eigen::Matrix<double, functions, 3> U, moved, bending, force;
  U << nodal_[i].middleRows<Side>(4 * j), nodal_[i + 1].middleRows<Side>(4 * j);
  moved << nodal_change_[i].middleRows<Side>(4 * j), nodal_change_[i + 1].middleRows<Side>(4 * j);
  Gradient<double> change;
  assign_small_product(point.gradient, G, U);
  assign_small_product(change, G, moved);
  assign_small_product(bending, element.bending.topLeftCorner<functions, functions>(), moved);
  // Green–Lagrange: e11, e22 and 2 e12, none of it in the undeflected leaf
  const Stress<double> e = strain_product(Gradient<double>(point.gradient - 0.5 * change), change);
  strain_ = std::max(strain_, e.leftCols<2>().abs().maxCoeff());
  const Stress<double> s = weighted(stress_of(mesh_->membrane(), e), element.weight);
  energy_ += 0.5 * ((s * e).sum() + moved.cwiseProduct(bending).sum());
  const double terms =
      element.bending.diagonal().head<functions>().dot(moved.rowwise().squaredNorm());
  rounding_ += std::pow(std::numeric_limits<double>::epsilon() * terms, 2);
  assign_small_product(force, G.transpose(), stress_times(s, point.gradient));
  force += bending;
  MatrixXd field;
  if (element.curvature_weight.size() > 0) {
    field = curvature_field(element.curvature, U);
    const MatrixXd own = curvature_field(element.curvature, moved);
    const MatrixXd product =
        curvature_product(element.curvature_weight, MatrixXd(field - 0.5 * own), own);
    energy_ +=
        own.cwiseProduct(0.5 * product - curvature_product(element.curvature_weight, own, own) / 12)
            .sum();
    force += curvature_force(element.curvature, functions, product);
  }
  for (int c = 0; c < 3; ++c) {
    nodal_force_[i].segment<Side>(c * n + 4 * j) += force.col(c).template head<Side>();
    nodal_force_[i + 1].segment<Side>(c * n + 4 * j) += force.col(c).template tail<Side>();
  }
  // Mixed Newton: the geometric stiffness takes the stresses of the linearised last step, without
  // the squares of its rotations. Identical at equilibrium, far larger steps.
  if (!stress_is_linearised_) point.stress = s;
  return field;
}

template <int Side>
void PlateLeaf::add_element_tangent(int i, int j, const MatrixXd& field) {
  constexpr int functions = 2 * Side;
  const int n = mesh_->functions_per_line();
  const auto [A11, A12, A33] = mesh_->membrane();
  const PlateMesh::Element& element = mesh_->element(i, j);
  const PointState& point = points_[i * mesh_->elements_across() + j];
  const auto w1 = element.weight.col(0), w2 = element.weight.col(1), w12 = element.weight.col(2);
  const auto Gx = element.gradient.topLeftCorner<points, functions>();
  const auto Gy = element.gradient.bottomLeftCorner<points, functions>();
  const Eigen::Matrix<double, functions, 16> Gt =
      element.gradient.leftCols<functions>().transpose();
  MatrixXd &D0 = line_diagonal(i), &D1 = line_diagonal(i + 1), &O = line_below(i);
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d <= c; ++d) {
      const PointArray c1 = point.gradient.col(c).head<points>(),
                       c2 = point.gradient.col(c).tail<points>(),
                       d1 = point.gradient.col(d).head<points>(),
                       d2 = point.gradient.col(d).tail<points>();
      PointArray xx = w1 * (A11 * c1 * d1) + w12 * (A33 * c2 * d2),
                 xy = w1 * (A12 * c1 * d2) + w12 * (A33 * c2 * d1),
                 yx = w1 * (A12 * c2 * d1) + w12 * (A33 * c1 * d2),
                 yy = w2 * (A11 * c2 * d2) + w12 * (A33 * c1 * d1);
      if (c == d) {
        xx += point.stress.col(0);
        xy += point.stress.col(2);
        yx += point.stress.col(2);
        yy += point.stress.col(1);
      }
      Eigen::Matrix<double, 16, functions> CG;
      CG.template topRows<points>().noalias() = xx.matrix().asDiagonal() * Gx;
      CG.template topRows<points>().noalias() += xy.matrix().asDiagonal() * Gy;
      CG.template bottomRows<points>().noalias() = yx.matrix().asDiagonal() * Gx;
      CG.template bottomRows<points>().noalias() += yy.matrix().asDiagonal() * Gy;
      Eigen::Matrix<double, functions, functions> K;
      assign_small_product(K, Gt, CG);
      if (c == d)
        K += element.bending.topLeftCorner<functions, functions>();
      else if (field.size() > 0)
        K += curvature_tangent(element, field, c, d).topLeftCorner<functions, functions>();
      const int r = c * n + 4 * j, s = d * n + 4 * j;
      D0.block<Side, Side>(r, s) += K.template topLeftCorner<Side, Side>();
      D1.block<Side, Side>(r, s) += K.template bottomRightCorner<Side, Side>();
      O.block<Side, Side>(r, s) += K.template bottomLeftCorner<Side, Side>();
      if (c != d) O.block<Side, Side>(s, r) += K.template topRightCorner<Side, Side>().transpose();
    }
}

template <int Side>
void PlateLeaf::assemble_elements() {
  const int nx = mesh_->elements_along();
  for (int i = 0; i <= nx; ++i) line_diagonal(i).setZero();
  for (int i = 0; i < nx; ++i) line_below(i).setZero();
  for (VectorXd& f : nodal_force_) f.setZero();
  for (int i = 0; i <= nx; ++i) nodal_change_[i] = nodal_[i] - mesh_->undeflected(i);
  energy_ = rounding_ = strain_ = 0;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; i != mesh_->fold_line() && j < mesh_->elements_across(); ++j)
      add_element_tangent<Side>(i, j, add_element_force<Side>(i, j));
  stress_is_linearised_ = false;
}

// Adds the weight, whose potential is linear in the nodal values.
void PlateLeaf::add_weight() {
  if (weight_.isZero(0)) return;
  const int n = mesh_->functions_per_line();
  for (int i = 0; i < mesh_->lines(); ++i) {
    const VectorXd& m = mesh_->mass_moment(i);
    energy_ -= m.dot(nodal_change_[i] * weight_);
    for (int c = 0; c < 3; ++c) nodal_force_[i].segment(c * n, n) -= weight_[c] * m;
  }
}

void PlateLeaf::linearise() {
  mesh_->with_side([&]<int Side>() { assemble_elements<Side>(); });
  add_weight();
  const int n = mesh_->functions_per_line(), last = mesh_->lines() - 1;
  for (const NodalWeight& w : support_.point)
    for (int c = 0; c < 3; ++c)
      nodal_force_[w.line][c * n + w.function] -= w.weight * state_.point_force[c];
  for (int i = 1; i <= last; ++i)
    if (!is_rigid_edge(i) && !is_second_of_fold(i))
      g_.segment(block_offset(i), 3 * n) = nodal_force_[i];
  if (mesh_->fold_line() >= 0) add_fold();
  coupling_.setZero();
  edge_tangent_.setZero();
  edge_force_.setZero();

  for (const int line : {0, last})
    if (is_rigid_edge(line)) add_edge(line);
}

// The block of a rigid edge: its nodal values N depend on slopes and pose, H = Jᵀ K J + f·N,uu.
void PlateLeaf::add_edge(int line) {
  const int e = edge_of(line), inner = e == 0 ? 1 : line - 1;
  const int n = mesh_->functions_per_line(), m = mesh_->edge_unknowns();
  const EdgePose& pose = state_.edges[e];
  const VectorXd& f = nodal_force_[line];
  MatrixXd& J = edge_jacobian_[e];
  J.setZero();
  for (int s = 0; s < n; ++s) {
    Vector3d v = nodal_[line].row(s).transpose();
    if (s % 4 == 0) v -= pose.position;
    for (int c = 0; c < 3; ++c) {
      J.block<1, 3>(c * n + s, m + 3) = v.cross(Vector3d::Unit(c)).transpose();  // δr = ω × v
      if (s % 4 == 0) J(c * n + s, m + c) = 1;
      mesh_->each_slope(s,
                        [&](int axis, int unknown) { J(c * n + s, unknown) = pose.axes(c, axis); });
    }
  }
  MatrixXd H = edge_curvature(e, f);
  MatrixXd& D = edge_diagonal_[e];
  D.triangularView<Eigen::StrictlyUpper>() = D.transpose();
  H.noalias() += J.transpose() * (D * J);
  const VectorXd gJ = J.transpose() * f;
  K_.diagonal[block(line)] = H.topLeftCorner(m, m);
  g_.segment(block_offset(line), m) = gJ.head(m);
  edge_force_.segment<6>(6 * e) = gJ.tail<6>();
  edge_tangent_.block<6, 6>(6 * e, 6 * e) = H.bottomRightCorner<6, 6>();
  // mixed terms stand below the diagonal only
  coupling_.block(block_offset(line), 6 * e, m, 6) = H.bottomLeftCorner(6, m).transpose();
  const MatrixXd& O = edge_below_[e];
  auto outer = coupling_.block(block_offset(inner), 6 * e, 3 * n, 6);
  if (e == 0) {
    K_.below[0].noalias() = O * J.leftCols(m);
    outer.noalias() = O * J.rightCols<6>();
  } else {
    K_.below[block(inner)].noalias() = J.leftCols(m).transpose() * O;
    outer.noalias() = O.transpose() * J.rightCols<6>();
  }
}

// The block of a fold: the first leg's nodal values N are unknowns themselves, those of the second
// N2(u), so that K = K1 + Jᵀ K2 J + f2·N2,uu with J = N2,u.
void PlateLeaf::add_fold() {
  const int n = mesh_->functions_per_line(), line = mesh_->fold_line(), b = block(line),
            size = fold_unknowns();
  constexpr int unknowns = FoldNode<double>::unknowns;
  const auto map = FoldMap<double>::of(mesh_->shape().fold->angle);
  const auto x = state_.x.segment(block_offset(line), size);
  const VectorXd& f = nodal_force_[line + 1];
  MatrixXd& J = fold_jacobian_;
  MatrixXd H = MatrixXd::Zero(size, size);
  J.setZero();
  for (int j = 0; j < mesh_->nodes_per_line(); ++j) {
    const auto u = FoldNode<double>::state(x, n, j);
    for (int c = 0; c < 3; ++c)
      for (const int k : {0, 2}) J(c * n + 4 * j + k, c * n + 4 * j + k) = 1;
    const int rows[] = {4 * j + 1, 4 * j + 3};
    for (int k = 0; k < unknowns; ++k) {
      const auto y = FoldNode<double>::unit(k);
      const auto along = map.first(u, y);
      for (int p = 0; p < 2; ++p)
        for (int c = 0; c < 3; ++c)
          J(c * n + rows[p], FoldNode<double>::row(k, n, j)) = along[p][c];
      for (int l = 0; l < unknowns; ++l) {
        const auto twice = map.second(u, y, FoldNode<double>::unit(l));
        double& h = H(FoldNode<double>::row(k, n, j), FoldNode<double>::row(l, n, j));
        for (int p = 0; p < 2; ++p)
          for (int c = 0; c < 3; ++c) h += f[c * n + rows[p]] * twice[p][c];
      }
    }
  }
  MatrixXd& D = fold_diagonal_[1];
  D.triangularView<Eigen::StrictlyUpper>() = D.transpose();
  H.noalias() += J.transpose() * (D * J);
  H.topLeftCorner(3 * n, 3 * n) += fold_diagonal_[0];  // its lower triangle counts
  K_.diagonal[b] = H;
  g_.segment(block_offset(line) + 3 * n, size - 3 * n).setZero();
  g_.segment(block_offset(line), size) += J.transpose() * f;
  K_.below[b - 1].setZero(size, K_.below[b - 1].cols());
  K_.below[b - 1].topRows(3 * n) = fold_below_[0];
  K_.below[b] = fold_below_[1] * J;
}

MatrixXd PlateLeaf::edge_curvature(int e, const VectorXd& f) const {
  const int n = mesh_->functions_per_line(), m = mesh_->edge_unknowns();
  const EdgePose& pose = state_.edges[e];
  const MatrixXd& nodal = nodal_[e == 0 ? 0 : mesh_->lines() - 1];
  MatrixXd H = MatrixXd::Zero(m + 6, m + 6);
  for (int s = 0; s < n; ++s) {
    const Vector3d fs(f[s], f[n + s], f[2 * n + s]);
    Vector3d v = nodal.row(s).transpose();
    if (s % 4 == 0) v -= pose.position;
    H.bottomRightCorner<3, 3>() +=
        0.5 * (fs * v.transpose() + v * fs.transpose()) - fs.dot(v) * Matrix3d::Identity();
    mesh_->each_slope(s, [&](int axis, int unknown) {
      H.block<3, 1>(m + 3, unknown) += pose.axes.col(axis).cross(fs);
    });
  }
  return H;
}

template void PlateLeaf::linearised_stress<8>(const VectorXd&, const Vector12d&);
template void PlateLeaf::linearised_stress<4>(const VectorXd&, const Vector12d&);

}  // namespace flexopt
