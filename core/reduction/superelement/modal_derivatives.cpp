#include "core/reduction/superelement/modal_derivatives.hpp"

#include <cassert>
#include <numeric>

#include "core/elements/plate/plate_series.hpp"
#include "core/math/polynomial.hpp"
#include "core/math/rotation.hpp"
#include "core/reduction/expansion/tube_expansion.hpp"

namespace flexopt {
namespace {

// The coefficient of s² of the residual along x0 + s φ, rotations of the edges exp(s hat ω) R0.
VectorXd second_order_residual(const PlateLeaf& leaf, PlateSeries& series, const VectorXd& shape) {
  const PlateLeaf::State& state = leaf.state();
  const int n = leaf.unknowns();
  std::array<EdgeBodySeries, 2> edges;
  for (int e = 0; e < 2; ++e) {
    const Vector3d turn = shape.segment<3>(n + 6 * e + 3);
    const Matrix3d W = hat(turn), &R = state.edges[e].axes;
    edges[e] = {{state.edges[e].position, shape.segment<3>(n + 6 * e), Vector3d::Zero()},
                {R, W * R, 0.5 * W * W * R},
                Vector3d::Zero()};
  }
  const Vector3d zero = Vector3d::Zero();
  series.expand(edges, {state.x, shape.head(n), VectorXd::Zero(n)},
                {{state.point, zero, zero}, {state.point_force, zero, zero}});
  const int bodies = series.rows().internal();
  const Series<VectorXd> force = series.force();
  VectorXd r(n + 12);
  r << force[2].head(n), force[2].segment<12>(bodies);
  // from the moments m(s) on the spins to those on the rotation vector, J(s ω)ᵀ m
  for (int e = 0; e < 2; ++e) {
    const Vector3d turn = shape.segment<3>(n + 6 * e + 3);
    const auto moment = [&](int order) -> Vector3d {
      return force[order].segment<3>(bodies + 6 * e + 3);
    };
    r.segment<3>(n + 6 * e + 3) +=
        -0.5 * turn.cross(moment(1)) + turn.cross(turn.cross(moment(0))) / 6;
  }
  return r;
}

}  // namespace

MatrixXd second_order_forces(const PlateLeaf& leaf, const MatrixXd& shapes) {
  const int m = static_cast<int>(shapes.cols());
  PlateSeries series(leaf);
  // shapes to the order of one, else the quadratic part drowns in rounding
  VectorXd size = shapes.colwise().norm();
  for (double& s : size) s = s > 0 ? s : 1;
  MatrixXd own(shapes.rows(), m), result(shapes.rows(), m * (m + 1) / 2);
  for (int i = 0; i < m; ++i)
    own.col(i) = second_order_residual(leaf, series, shapes.col(i) / size[i]);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i <= j; ++i) {
      auto column = result.col(pair_index(i, j));
      if (i == j) {
        column = 2 * own.col(i);
      } else {
        column =
            second_order_residual(leaf, series, shapes.col(i) / size[i] + shapes.col(j) / size[j]) -
            own.col(i) - own.col(j);
      }
      column *= size[i] * size[j];
    }
  return result;
}

MatrixXd boundary_modes(const PlateLeaf& leaf) {
  std::vector<int> columns(12);
  std::iota(columns.begin(), columns.end(), 0);
  MatrixXd Phi(leaf.unknowns() + 12, 12);
  Phi << leaf.static_shapes(columns), MatrixXd::Identity(12, 12);
  return Phi;
}

MatrixXd derivatives_edges_held(const PlateLeaf& leaf, const MatrixXd& forces) {
  MatrixXd theta = -forces.topRows(leaf.unknowns());
  leaf.solve(theta);
  return theta;
}

namespace {

constexpr double negligible = 1e-6;  // of a field, once what the others have of it is taken away

// Orthonormal columns Q that span the columns C that were added, one after the other.
struct Basis {
  MatrixXd Q;

  void add(const MatrixXd& C) {
    Q.conservativeResize(C.rows(), Eigen::NoChange);
    const VectorXd size = C.colwise().norm();
    const double largest = size.maxCoeff();
    for (Eigen::Index k = 0; k < C.cols(); ++k) {
      if (size[k] <= 1e-10 * largest) continue;
      VectorXd q = C.col(k) / size[k];
      for (int twice = 0; twice < 2; ++twice) q -= Q * (Q.transpose() * q);
      const double rest = q.norm();
      if (rest <= negligible) continue;
      Q.conservativeResize(Eigen::NoChange, Q.cols() + 1);
      Q.rightCols<1>() = q / rest;
    }
  }
};

// ∂²/∂ei∂ej of the nodal values of an edge whose rotation vector is e ↦ T e and whose slopes are
// e ↦ S e, at e = 0: r = p + exp(hat T e)(w0 + w1 S e).
VectorXd edge_second_derivative(const PlateMesh& mesh, const Eigen::Matrix<double, 3, 6>& T,
                                const MatrixXd& S, int i, int j) {
  const int n = mesh.functions_per_line();
  const Matrix3d Wi = hat(T.col(i)), Wj = hat(T.col(j));
  VectorXd b(3 * n);
  for (int s = 0; s < n; ++s) {
    Vector3d w0 = Vector3d::Zero(), wi = Vector3d::Zero(), wj = Vector3d::Zero();
    if (s % 4 == 0) w0 = mesh.y()[s / 4] * Vector3d::UnitY();
    if (s % 4 == 1) w0 = Vector3d::UnitX();
    if (s % 4 == 2) w0 = Vector3d::UnitY();
    mesh.each_slope(s, [&](int axis, int unknown) {
      wi[axis] += S(unknown, i);
      wj[axis] += S(unknown, j);
    });
    const Vector3d v = 0.5 * (Wi * Wj + Wj * Wi) * w0 + Wi * wj + Wj * wi;
    for (int c = 0; c < 3; ++c) b[c * n + s] = v[c];
  }
  return b;
}

// The terms of degree 3.
FieldExpansion third_order(const FieldExpansion& expansion) {
  constexpr int terms = monomial_count(6, 3) - monomial_count(6, 2);
  return {expansion.fields.rightCols(terms), expansion.nodal.rightCols(terms)};
}

// What interface deformations and the lines that follow the edges have of them: X c + X_b b.
MatrixXd edge_share(const FieldExpansion& third, const MatrixXd& X, const MatrixXd& follow) {
  constexpr std::array<int, 3> stiff{elongation, theta1z, theta2z};
  MatrixXd share = X(Eigen::all, stiff) * third.fields.bottomRows(3);
  const Eigen::Index inner = follow.rows(), n3 = follow.cols() / 2;
  share.middleRows((X.rows() - inner) / 2, inner) +=
      follow.leftCols(n3) * third.nodal.topRows(n3) +
      follow.rightCols(n3) * third.nodal.bottomRows(n3);
  return share;
}

// Fields that are orthonormal in energy and span those given, batch by batch, without what their
// interior follows of the edges. L⁻¹ K ψ of K = L Lᵀ, ψ the whole field: scalar products are
// energies.
template <class Followed>
MatrixXd orthonormal_fields(const PlateLeaf& plate, std::vector<MatrixXd> batches, int slopes,
                            const Followed& followed) {
  const int inner = plate.unknowns() - 2 * slopes;
  PlateLeaf linear(plate.shared_mesh());
  linear.linearise();
  Basis basis;
  for (MatrixXd& field : batches) {
    field.middleRows(slopes, inner) += followed(field);
    MatrixXd coordinates = linear.tangent_times(field);
    plate.solve_lower(coordinates);
    basis.add(coordinates);
  }
  plate.solve_upper(basis.Q);
  basis.Q.middleRows(slopes, inner) -= followed(basis.Q);
  return basis.Q;
}

}  // namespace

ModalModel::ModalModel(std::shared_ptr<const PlateMesh> mesh, Reduction method,
                       ModalDerivativeSet set)
    : mesh_(std::move(mesh)),
      slaved_(method == Reduction::quadratic_manifold),
      slopes_(mesh_->edge_unknowns()) {
  PlateLeaf plate(mesh_);
  const int n = plate.unknowns(), u = slopes_, inner = n - 2 * u,
            n3 = 3 * mesh_->functions_per_line();
  rest_ = plate.state().x;
  edges_at_rest_ = edge_nodal(plate.state().edges, rest_);
  plate.linearise();
  follow_ = plate.line_shapes();
  const MatrixXd J0 = plate.edge_jacobian(0), J1 = plate.edge_jacobian(1);
  plate.eliminate();
  assert(plate.negative_pivots() == 0);
  const Rows12x6 G = chord_edge_map(Vector6d::Zero());
  const MatrixXd shapes = boundary_modes(plate) * G;
  modes_ = shapes.topRows(n);
  modes_.middleRows(u, inner).setZero();

  // what the lines between follow of the edges' nodal values, taken out of a field
  const auto follow_slopes = [&](const MatrixXd& field) {
    MatrixXd b(2 * n3, field.cols());
    b << J0.leftCols(u) * field.topRows(u), J1.leftCols(u) * field.bottomRows(u);
    return b;
  };
  theta_ = derivatives_edges_held(plate, second_order_forces(plate, shapes));
  MatrixXd b2(2 * n3, 21);
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i <= j; ++i)
      b2.col(pair_index(i, j)) << edge_second_derivative(*mesh_, G.middleRows<3>(3),
                                                         modes_.topRows(u), i, j),
          edge_second_derivative(*mesh_, G.bottomRows<3>(), modes_.bottomRows(u), i, j);
  theta_.middleRows(u, inner) -= follow_ * (b2 + follow_slopes(theta_));
  if (set == ModalDerivativeSet::bending)
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i <= j; ++i)
        if ((i != theta1y && i != theta2y) || (j != theta1y && j != theta2y))
          theta_.col(pair_index(i, j)).setZero();
  fields_.resize(n, 0);
  if (slaved_) return;

  std::vector<MatrixXd> batches{theta_};
  if (mesh_->shape().is_beam()) {  // the few slopes of a beam's ends stay free
    MatrixXd& slopes = batches.emplace_back(MatrixXd::Zero(n, 2 * u));
    slopes.topLeftCorner(u, u).setIdentity();
    slopes.bottomRightCorner(u, u).setIdentity();
  }
  if (set == ModalDerivativeSet::third_order) {
    const FieldExpansion expansion =
        third_order(expand_fields(ChordLeaf(mesh_), Eigen::Matrix2d::Identity(), 3));
    batches.push_back(expansion.fields.topRows(n) - edge_share(expansion, modes_, follow_));
  }
  fields_ = orthonormal_fields(plate, std::move(batches), u, [&](const MatrixXd& field) {
    return MatrixXd(follow_ * follow_slopes(field));
  });
}

MatrixXd ModalModel::derivatives_times(const Vector6d& e) const {
  MatrixXd result = MatrixXd::Zero(theta_.rows(), 6);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      if (e[j] != 0) result.col(i) += e[j] * theta_.col(pair_index(i, j));
  return result;
}

VectorXd ModalModel::edge_nodal(const EdgePoses& edges, const VectorXd& x) const {
  VectorXd b(6 * mesh_->functions_per_line());
  b << PlateLeaf::edge_nodal(*mesh_, 0, edges[0], x.data()).reshaped(),
      PlateLeaf::edge_nodal(*mesh_, 1, edges[1], x.data() + x.size() - slopes_).reshaped();
  return b;
}

VectorXd ModalModel::unknowns(const Vector6d& e, const EdgePoses& edges,
                              const VectorXd& amplitudes) const {
  VectorXd x = rest_ + modes_ * e;
  if (slaved_)
    x += 0.5 * derivatives_times(e) * e;
  else
    x += fields_ * amplitudes;
  x.segment(slopes_, x.size() - 2 * slopes_) += follow_ * (edge_nodal(edges, x) - edges_at_rest_);
  return x;
}

MatrixXd ModalModel::chart_rates(const Vector6d& e) const {
  if (slaved_) return modes_ + derivatives_times(e);
  MatrixXd V(modes_.rows(), 6 + fields_.cols());
  V << modes_, fields_;
  return V;
}

}  // namespace flexopt
