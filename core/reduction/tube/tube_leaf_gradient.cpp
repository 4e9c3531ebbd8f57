#include "core/reduction/tube/tube_leaf_gradient.hpp"

#include <cassert>

namespace flexopt {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

// Where the variables of the potential, (θ1y, θ2y, φx, N, M1, M2), and the deformations that the
// forces do work on stand in (e, f).
constexpr std::array<int, 6> of_potential{theta1y, theta2y, twist, 6, 7, 8};
constexpr std::array<int, 3> stretched{elongation, theta1z, theta2z};

// Derivative of tube_force_scale() by w/L, of a leaf of uniform width.
Vector3d force_scale_rate(const PlateShape& shape) { return {1, 2 * shape.width, 2 * shape.width}; }

// Derivatives in (e, f) of W* + f · c (u, θ1z, θ2z).
Vector9d force_of(const PotentialValue& W, const Vector3d& scale, const Vector6d& e,
                  const Vector3d& f) {
  Vector9d g = Vector9d::Zero();
  g(of_potential) = W.gradient;
  for (int i = 0; i < 3; ++i) {
    g[stretched[i]] = scale[i] * f[i];
    g[6 + i] += scale[i] * e[stretched[i]];
  }
  return g;
}

Matrix9d tangent_of(const PotentialValue& W, const Vector3d& scale) {
  Matrix9d H = Matrix9d::Zero();
  H(of_potential, of_potential) = W.hessian;
  for (int i = 0; i < 3; ++i) H(stretched[i], 6 + i) = H(6 + i, stretched[i]) = scale[i];
  return H;
}

}  // namespace

MatrixXd TubeLeafLinear::static_shapes(const std::vector<int>& columns) const {
  const MixedState& m = leaf_->mixed();
  const Rows3x12 shapes = -m.F_inverse * m.h * leaf_->response().frame.B;
  return shapes(Eigen::all, columns);
}

// has_linearised_interior() says that there are none.
MatrixXd TubeLeafLinear::mass_times(const MatrixXd& V) const {
  assert(false);
  return MatrixXd::Zero(V.rows(), V.cols());
}
MatrixXd TubeLeafLinear::station_motion(const MatrixXd& V) const {
  assert(false);
  return MatrixXd(0, V.cols());
}
std::unique_ptr<LeafFields> TubeLeafGradient::fields(
    const MatrixXd&, const std::vector<LeafVariation<double>>&) const {
  assert(false);
  return nullptr;
}

Answer<LeafGradient<double>> TubeLeafLinear::gradient(LeafRates& rates,
                                                      const LeafRows& rows) const {
  const std::shared_ptr<TubeModel>& model = leaf_->model();
  if (!model->differentiable()) return {nullptr, "its tube was built, not looked up"};
  const auto of_model =
      rates.of<TubeRates>(model, [&] { return TubeRates(model->potential(), model->rates()); });
  return {std::make_unique<TubeLeafGradient>(*leaf_, *of_model, rows)};
}

Answer<LeafLinear> TubeLeaf::linearise() {
  if (!model_->differentiable()) return {nullptr, "its tube was built, not looked up"};
  return {std::make_unique<TubeLeafLinear>(*this)};
}

TubeLeafGradient::TubeLeafGradient(const TubeLeaf& leaf, const TubeRates& rates,
                                   const LeafRows& rows)
    : LeafGradient<double>(rows, leaf.model()->shape().width) {
  assert(rows.unknowns == 3 && rows.point == 0);
  const ChordFrame& frame = leaf.response().frame;
  const Vector6d& e = frame.e;
  const Vector3d &f = leaf.mixed().f, &scale = leaf.model()->potential().force_scale();
  const TubeRates::Answer W = rates.evaluate({e[theta1y], e[theta2y], e[twist]}, f);
  tangent_ = tangent_of(W.potential, scale);
  third_ = W.third;
  MatrixXd shape_force(9, 3);
  for (int p = 0; p < 3; ++p) {
    const PotentialValue& by = W.by_shape[static_cast<std::size_t>(p)];
    const Vector3d scale_rate =
        p == ShapeParameter::width ? force_scale_rate(leaf.model()->shape()) : Vector3d::Zero();
    shape_force.col(p) = force_of(by, scale_rate, e, f);
    shape_tangent_[static_cast<std::size_t>(p)] = tangent_of(by, scale_rate);
  }
  chord_ = ChordGradient(frame, leaf.edges(), rows,
                         {force_of(W.potential, scale, e, f), tangent_, std::move(shape_force)});
  force_ = chord_.force();
}

LeafQuadratic<double> TubeLeafGradient::quadratic(const MatrixXd& Y,
                                                  [[maybe_unused]] const VectorXd& mu) const {
  const int columns = static_cast<int>(Y.cols());
  assert(mu.isZero(0));
  const MatrixXd T = rows_.edge_rows(Y);
  const ChordGradient::Energy& energy = chord_.energy();
  const Vector6d g = energy.force.head<6>();
  LeafQuadratic<double> q(size(), columns);
  for (int k = 0; k < columns; ++k) {
    const ChordGradient::Column column = chord_.column(T.col(k).tail<12>());
    Vector9d z, third = Vector9d::Zero();
    z << column.e1, T.col(k).head<3>();
    const Vector9d Hz = tangent_ * z;
    q.stiffness[k] = z.dot(Hz) + g.dot(column.e2);
    const Vector6d x = z(of_potential);
    for (int i = 0; i < 6; ++i) third[of_potential[i]] = x.dot(third_[i] * x);
    third += tangent_.leftCols<6>() * column.e2;
    for (int p = 0; p < 3; ++p)
      q.shape(p, k) = z.dot(shape_tangent_[static_cast<std::size_t>(p)] * z) +
                      energy.shape_force.col(p).head<6>().dot(column.e2);
    q.state.col(k).head<3>() = third.tail<3>();
    const ChordGradient::Seen seen =
        chord_.seen(column, {third.head<6>(), 2 * Hz.head<6>(), g}, Vector3d::Zero());
    chord_.add(Y, k, column, seen, Vector3d::Zero(), q);
  }
  return q;
}

}  // namespace flexopt
