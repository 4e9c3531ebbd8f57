#include "core/reduction/superelement/superelement.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/math/nearest_rotation.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

constexpr double frame_tolerance = 1e-14;  // lengths / size of the body, radians
constexpr double rounding_floor = 1e-9;    // a step below it that no longer shrinks is rounding
constexpr int max_frame_steps = 30;        // 2 to 5 happen

}  // namespace

double SuperelementModel::size() const {
  double largest = 0;
  for (const Vector3d& a : nodes)
    for (const Vector3d& b : nodes) largest = std::max(largest, (a - b).norm());
  return largest;
}

Superelement::Superelement(const SuperelementModel& model) : model_(&model), size_(model.size()) {
  const int m = static_cast<int>(model.nodes.size()), n = 6 * m;
  place_.resize(m);
  to_rate_.resize(m);
  PhiD_.resize(6, n);
  Z_.resize(6, n);
  Phi_rig_.resize(n, 6);
  for (VectorXd* v : {&q_, &s_, &r_, &f_, &force_}) v->resize(n);
  for (MatrixXd* A : {&DT_, &B_, &tangent_, &work_}) A->resize(n, n);
}

// q, D and Φ_rig in the present frame.
void Superelement::place(std::span<const NodePose> nodes) {
  const Matrix3d Ft = frame_.axes.transpose();
  for (int a = 0; a < static_cast<int>(nodes.size()); ++a) {
    const int i = 6 * a;
    place_[a] = Ft * (nodes[a].position - frame_.position);
    q_.segment<3>(i) = place_[a] - model_->nodes[a];
    const Vector3d theta = rotation_log(Ft * nodes[a].axes);
    q_.segment<3>(i + 3) = theta;
    const Matrix3d K = hat(theta);
    to_rate_[a] =
        Matrix3d::Identity() - 0.5 * K + hat_square_factor(theta.squaredNorm()).value * K * K;
    Phi_rig_.block<6, 6>(i, 0).setIdentity();
    Phi_rig_.block<3, 3>(i, 3) = -hat(place_[a]);
    PhiD_.middleCols<3>(i) = model_->frame_modes.middleCols<3>(i);
    PhiD_.middleCols<3>(i + 3).noalias() =
        model_->frame_modes.middleCols<3>(i + 3).lazyProduct(to_rate_[a]);
  }
  A_.noalias() = PhiD_ * Phi_rig_;
}

bool Superelement::find_frame(std::span<const NodePose> nodes) {
  const int m = static_cast<int>(nodes.size());
  assert(m == static_cast<int>(model_->nodes.size()));
  // From the nearest rotation to the nodes' mean and their mean place. (The last frame of a path is
  // no safe start: far from the nodes Φ_CB q = 0 has other solutions, turned by half a turn.)
  Matrix3d mean = Matrix3d::Zero();
  Vector3d p = Vector3d::Zero(), X = Vector3d::Zero();
  for (int a = 0; a < m; ++a) {
    mean += nodes[a].axes;
    p += nodes[a].position / m;
    X += model_->nodes[a] / m;
  }
  frame_.axes = nearest_rotation(mean);
  frame_.position = p - frame_.axes * X;
  double previous = 1e300;  // size of the last step, lengths over that of the body
  for (int step = 0;; ++step) {
    place(nodes);
    const Vector6d c = model_->frame_modes * q_;
    const Eigen::PartialPivLU<Matrix6d> lu(A_);
    const Vector6d d = lu.solve(c);
    const double residual =
        std::max(d.head<3>().cwiseAbs().maxCoeff() / size_, d.tail<3>().cwiseAbs().maxCoeff());
    const bool rounding = residual < rounding_floor && residual >= 0.3 * previous;
    if (residual < frame_tolerance || rounding) {
      Z_ = lu.solve(PhiD_);
      return true;
    }
    // also when not a number
    if (!(residual < 1e3) || step == max_frame_steps) return false;
    previous = residual;
    frame_.position += frame_.axes * d.head<3>();
    frame_.axes = orthonormalised(frame_.axes * rotation_exp(d.tail<3>()));
  }
}

// A ← R̂ A with R̂ = diag(F, F, …).
void Superelement::rotate_rows(MatrixXd& A) const {
  for (int i = 0; i < A.rows(); i += 3)
    for (int j = 0; j < A.cols(); ++j)
      A.block<3, 1>(i, j) = (frame_.axes * A.block<3, 1>(i, j)).eval();
}

bool Superelement::evaluate(std::span<const NodePose> nodes, const VectorXd* stress_coordinates) {
  if (!find_frame(nodes)) return false;
  const int m = static_cast<int>(nodes.size()), n = 6 * m;
  const auto K = model_->stiffness.topLeftCorner(n, n);

  // dq = D T b for increments b in frame axes, T = 1 − Φ_rig Z                                (R7)
  DT_.noalias() = -Phi_rig_ * Z_;
  DT_.diagonal().array() += 1;
  for (int a = 0; a < m; ++a)
    DT_.middleRows<3>(6 * a + 3) = (to_rate_[a] * DT_.middleRows<3>(6 * a + 3)).eval();

  // Forces in frame axes f = Dᵀ(K q − Φ_CBᵀ λ) with λ such that Φ_rigᵀ f = 0                   (R8)
  const Eigen::PartialPivLU<Matrix6d> lu(A_.transpose());
  const auto forces = [&](const VectorXd& q) {
    s_.noalias() = K * q;
    f_ = s_;
    for (int a = 0; a < m; ++a)
      f_.segment<3>(6 * a + 3) = to_rate_[a].transpose() * s_.segment<3>(6 * a + 3);
    const Vector6d lambda = lu.solve(Phi_rig_.transpose() * f_);
    r_ = s_;
    r_.noalias() -= model_->frame_modes.transpose() * lambda;
    f_.noalias() -= PhiD_.transpose() * lambda;
  };
  forces(q_);
  energy_ = 0.5 * q_.dot(s_);
  for (int i = 0; i < n; i += 3) force_.segment<3>(i) = frame_.axes * f_.segment<3>(i);
  if (stress_coordinates) forces(*stress_coordinates);

  // K_T = R̂ [ Tᵀ(Dᵀ K + G) D T − Zᵀ S D T − hat(f) Z_ψ ] R̂ᵀ, symmetrised                      (R9)
  work_.noalias() = K * DT_;
  tangent_.noalias() = DT_.transpose() * work_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> turning = Eigen::MatrixXd::Zero(3, n);
  work_.setZero();
  for (int a = 0; a < m; ++a) {
    const int i = 6 * a;
    const Vector3d theta = q_.segment<3>(i + 3);
    const TurnedMoment moment =
        turned_moment(theta, r_.segment<3>(i + 3), hat_square_factor(theta.squaredNorm()));
    work_.middleRows<3>(i + 3).noalias() = moment.slope * DT_.middleRows<3>(i + 3);
    const Matrix3d hat_f = hat(Vector3d(f_.segment<3>(i)));
    turning.noalias() -= hat_f * DT_.middleRows<3>(i);  // Σ du × f
    tangent_.middleRows<3>(i).noalias() -= hat_f * Z_.bottomRows<3>();
    tangent_.middleRows<3>(i + 3).noalias() -=
        hat(Vector3d(f_.segment<3>(i + 3))) * Z_.bottomRows<3>();
  }
  // Tᵀ G D T = G D T − Zᵀ Φ_rigᵀ G D T; only moments enter Φ_rigᵀ G
  for (int a = 0; a < m; ++a) turning += work_.middleRows<3>(6 * a + 3);
  tangent_ += work_;
  tangent_.noalias() -= Z_.bottomRows<3>().transpose() * turning;

  // into global axes, both sides
  rotate_rows(tangent_);
  work_ = tangent_.transpose();
  rotate_rows(work_);
  tangent_ = 0.5 * (work_ + work_.transpose());
  work_ = DT_.transpose();
  rotate_rows(work_);
  B_ = work_.transpose();
  return true;
}

double Superelement::strain() const {
  double largest = 0;
  for (std::size_t a = 0; a < place_.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const double length = (model_->nodes[a] - model_->nodes[b]).norm();
      if (length > 0)
        largest = std::max(largest, std::abs((place_[a] - place_[b]).norm() / length - 1));
    }
  return largest;
}

MatrixXd Superelement::mass() const {
  const int n = model_->coordinates(), all = static_cast<int>(model_->mass.rows());
  MatrixXd R = MatrixXd::Identity(all, all);
  for (int i = 0; i < n; i += 3) R.block<3, 3>(i, i) = frame_.axes;
  return R * model_->mass * R.transpose();
}

}  // namespace flexopt
