#include "core/elements/leaf/condensed_interior.hpp"

#include <cmath>

#include "core/math/decompositions.hpp"

namespace flexopt {

void CondensedInterior::condense(const BlockTridiagonal& K, const VectorXd& residual,
                                 const MatrixXd& coupling, const Vector12d& edge_force,
                                 const Matrix12d& edge_tangent, int first_of_tip) {
  y_ = residual;
  K.solve_lower(y_);
  Y_ = coupling;
  K.solve_lower(Y_.leftCols<6>());
  K.solve_lower(Y_.rightCols<6>(), first_of_tip);
  VectorXd sy = y_;
  K.apply_signs(sy);
  correction_ = std::abs(y_.dot(sy));
  force_ = edge_force - Y_.transpose() * sy;
  negative_ = K.negative_pivots();
  if (negative_ == 0) {
    tangent_ = edge_tangent - Y_.transpose() * Y_;
  } else {
    MatrixXd sY = Y_;
    K.apply_signs(sY);
    tangent_ = edge_tangent - Y_.transpose() * sY;
  }
  point_.reset();
}

void CondensedInterior::hold(const BlockTridiagonal& K, Point point) {
  Yc_ = std::move(point.gradient);
  K.solve_lower(Yc_);
  MatrixXd sYc = Yc_;
  K.apply_signs(sYc);
  const Matrix3d S = Yc_.transpose() * sYc;
  negative_ -= static_cast<int>((symmetric_eigenvalues(S).array() < 0).count());
  S_inverse_ = S.inverse();
  G_ = sYc.transpose() * Y_ - point.edge_gradient;
  h_ = point.missing + sYc.transpose() * y_;

  const Vector3d df = S_inverse_ * h_;
  point_ = {point.force + df, S_inverse_, S_inverse_ * G_};
  force_ += G_.transpose() * df;
  tangent_ += G_.transpose() * point_->coupling;
  const VectorXd rest = y_ - Yc_ * df;
  VectorXd signed_rest = rest;
  K.apply_signs(signed_rest);
  correction_ = std::abs(rest.dot(signed_rest));
}

VectorXd CondensedInterior::step(const BlockTridiagonal& K, const Vector12d& dq, const Vector3d& du,
                                 Vector3d& df) const {
  VectorXd step = -(y_ + Y_ * dq);
  df.setZero();
  if (point_) {
    df = S_inverse_ * (h_ + G_ * dq + du);
    step += Yc_ * df;
  }
  K.apply_signs(step);
  K.solve_upper(step);
  return step;
}

void CondensedInterior::solve(const BlockTridiagonal& K, Eigen::Ref<MatrixXd> b) const {
  K.solve_lower(b);
  if (point_) {
    MatrixXd sb = b;
    K.apply_signs(sb);
    b -= Yc_ * (S_inverse_ * (Yc_.transpose() * sb));
  }
  K.apply_signs(b);
  K.solve_upper(b);
}

MatrixXd CondensedInterior::static_shapes(const BlockTridiagonal& K,
                                          const std::vector<int>& columns) const {
  MatrixXd X(y_.size(), columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const int c = columns[k];
    if (c >= 12)
      X.col(k) = Yc_ * S_inverse_.col(c - 12);
    else if (point_)
      X.col(k) = Yc_ * (S_inverse_ * G_.col(c)) - Y_.col(c);
    else
      X.col(k) = -Y_.col(c);
  }
  K.apply_signs(X);
  K.solve_upper(X);
  return X;
}

}  // namespace flexopt
