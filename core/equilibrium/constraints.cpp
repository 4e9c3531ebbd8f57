#include "core/equilibrium/constraints.hpp"

#include <algorithm>

namespace flexopt {

Constraints::Constraints(const Mechanism& mechanism) : mechanism_(&mechanism) {
  double length = 0;
  for (const LeafSpring& l : mechanism.leaves) length = std::max(length, l.length);
  std::vector<double> units;
  for (const Joint& joint : mechanism.joints) {
    const JointSize size = size_of(joint.type);
    for (int k = 0; k < size.conditions; ++k) units.push_back(k < size.lengths ? length : 1.0);
  }
  joints_ = static_cast<int>(units.size());
  drives_ = conditional_drives(mechanism);
  for (const int k : drives_)
    units.push_back(is_rotation(mechanism.drives[static_cast<std::size_t>(k)].direction) ? 1.0
                                                                                         : length);
  units_ = Eigen::Map<const VectorXd>(units.data(), static_cast<Eigen::Index>(units.size()));
  value_ = VectorXd::Zero(count());
  loads_ = load_of_rotations(mechanism);
  gradient_ = stroke_gradient_ =
      MatrixXd::Zero(count(), 6 * static_cast<Eigen::Index>(mechanism.bodies.size()));
}

JointBody Constraints::body(const std::vector<BodyPose>& poses, int b) const {
  if (b < 0) return {};
  return {poses[b].position, poses[b].rotation, mechanism_->bodies[b].reference};
}

void Constraints::evaluate(const std::vector<BodyPose>& poses) {
  int row = 0;
  for (const Joint& joint : mechanism_->joints) {
    const JointConditions c = conditions(joint, body(poses, joint.body), body(poses, joint.other));
    const int k = static_cast<int>(c.value.size());
    value_.segment(row, k) = c.value;
    if (joint.body >= 0) gradient_.block(row, 6 * joint.body, k, 6) = c.gradient.leftCols<6>();
    if (joint.other >= 0) gradient_.block(row, 6 * joint.other, k, 6) = c.gradient.rightCols<6>();
    row += k;
  }
  for (const int k : drives_) {
    const Drive& drive = mechanism_->drives[static_cast<std::size_t>(k)];
    const DriveStroke<double> s =
        drive_stroke<double>(drive, loads_, body(poses, drive.body), body(poses, drive.other));
    value_[row] = s.value;
    const auto set = [&](MatrixXd& of, const Eigen::Matrix<double, 12, 1>& values) {
      of.block<1, 6>(row, 6 * drive.body) = values.head<6>().transpose();
      if (drive.other >= 0) of.block<1, 6>(row, 6 * drive.other) = values.tail<6>().transpose();
    };
    set(gradient_, s.load);
    set(stroke_gradient_, s.gradient);
    ++row;
  }
  for (int b = 0; b < static_cast<int>(poses.size()); ++b)
    for (int d = 0; d < 6; ++d)
      if (mechanism_->bodies[b].held[d]) {
        gradient_.col(6 * b + d).setZero();
        stroke_gradient_.col(6 * b + d).setZero();
      }
}

namespace {
void add_between(const Matrix12d& H, int body, int other, MatrixXd& K) {
  const int at[2] = {body, other};
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b)
      if (at[a] >= 0 && at[b] >= 0)
        K.block<6, 6>(6 * at[a], 6 * at[b]) += H.block<6, 6>(6 * a, 6 * b);
}
}  // namespace

void Constraints::add_curvature(const std::vector<BodyPose>& poses, const VectorXd& multipliers,
                                MatrixXd& K) const {
  int row = 0;
  for (const Joint& joint : mechanism_->joints) {
    const int k = size_of(joint.type).conditions;
    const Matrix12d H = curvature(joint, body(poses, joint.body), body(poses, joint.other),
                                  multipliers.segment(row, k));
    add_between(H, joint.body, joint.other, K);
    row += k;
  }
  for (const int k : drives_) {
    const double multiplier = multipliers[row++];
    if (multiplier == 0) continue;
    const Drive& drive = mechanism_->drives[static_cast<std::size_t>(k)];
    const DriveStroke<double> s =
        drive_stroke<double>(drive, loads_, body(poses, drive.body), body(poses, drive.other));
    add_between(multiplier * s.curvature, drive.body, drive.other, K);
  }
}

void Constraints::add_winding(const std::vector<BodyPose>& poses, const VectorXd& multipliers,
                              MatrixXd& K) const {
  int row = joints_;
  for (const int k : drives_) {
    const double multiplier = multipliers[row++];
    const Drive& drive = mechanism_->drives[static_cast<std::size_t>(k)];
    if (multiplier == 0 || !is_rotation(drive.direction)) continue;
    const DriveStroke<double> s =
        drive_stroke<double>(drive, loads_, body(poses, drive.body), body(poses, drive.other));
    add_between(multiplier * s.winding, drive.body, drive.other, K);
  }
}

double Constraints::violation() const {
  if (joints_ == 0) return 0;
  return value_.head(joints_).cwiseQuotient(units_.head(joints_)).cwiseAbs().maxCoeff();
}

}  // namespace flexopt
