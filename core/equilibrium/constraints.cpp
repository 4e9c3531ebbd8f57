#include "core/equilibrium/constraints.hpp"

#include <algorithm>

#include "core/math/rotation.hpp"

namespace flexopt {

Constraints::Constraints(const Mechanism& mechanism) : mechanism_(&mechanism) {
  const double length = longest_leaf(mechanism);
  std::vector<double> units;
  for (const Joint& joint : mechanism.joints) {
    const JointSize size = size_of(joint.type);
    for (int k = 0; k < size.conditions; ++k) units.push_back(k < size.lengths ? length : 1.0);
  }
  joints_ = static_cast<int>(units.size());
  drives_ = conditional_drives(mechanism);
  for (const int k : drives_)
    units.push_back(is_rotation(mechanism.drives[k].direction) ? 1.0 : length);
  units_ = Eigen::Map<const VectorXd>(units.data(), units.size());
  value_ = VectorXd::Zero(count());
  for (const Joint& joint : mechanism.joints)
    rows_.resize(rows_.size() + static_cast<std::size_t>(size_of(joint.type).conditions),
                 {{joint.body, joint.other}, Vector12d::Zero()});
  for (const int k : drives_) {
    const Drive& drive = mechanism.drives[k];
    rows_.push_back({{drive.body, drive.other}, Vector12d::Zero()});
  }
}

void Constraints::evaluate(const std::vector<JointBody>& poses) {
  int row = 0;
  for (const Joint& joint : mechanism_->joints) {
    const JointConditions c =
        conditions(joint, body_or_ground(poses, joint.body), body_or_ground(poses, joint.other));
    const int k = static_cast<int>(c.value.size());
    value_.segment(row, k) = c.value;
    for (int i = 0; i < k; ++i) rows_[row + i].gradient = c.gradient.row(i).transpose();
    row += k;
  }
  for (const int k : drives_) {
    const Drive& drive = mechanism_->drives[k];
    const DriveStroke<double> s = drive_stroke<double>(drive, body_or_ground(poses, drive.body),
                                                       body_or_ground(poses, drive.other));
    value_[row] = is_rotation(drive.direction) ? unwrapped(s.value, value_[row]) : s.value;
    rows_[row++].gradient = s.gradient;
  }
  for (Row& r : rows_)
    for (int e = 0; e < 2; ++e)
      for (int d = 0; d < 6; ++d)
        if (r.body[e] < 0 || mechanism_->bodies[r.body[e]].held[d]) r.gradient[6 * e + d] = 0;
}

MatrixXd Constraints::gradient() const {
  MatrixXd all = MatrixXd::Zero(count(), 6 * static_cast<Eigen::Index>(mechanism_->bodies.size()));
  for (int k = 0; k < count(); ++k) rows_[k].each([&](int c, double value) { all(k, c) += value; });
  return all;
}

VectorXd Constraints::forces(const VectorXd& multipliers) const {
  VectorXd all = VectorXd::Zero(6 * static_cast<Eigen::Index>(mechanism_->bodies.size()));
  for (int k = 0; k < count(); ++k)
    rows_[k].each([&](int c, double value) { all[c] += multipliers[k] * value; });
  return all;
}

void add_between(const Matrix12d& H, int body, int other, BlockMatrix& K) {
  const int at[2] = {body, other};
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b)
      if (at[a] >= 0 && at[b] >= 0) K.block(at[a], at[b]) += H.block<6, 6>(6 * a, 6 * b);
}

void Constraints::add_curvature(const std::vector<JointBody>& poses, const VectorXd& multipliers,
                                BlockMatrix& K) const {
  int row = 0;
  for (const Joint& joint : mechanism_->joints) {
    const int k = size_of(joint.type).conditions;
    const Matrix12d H = curvature(joint, body_or_ground(poses, joint.body),
                                  body_or_ground(poses, joint.other), multipliers.segment(row, k));
    add_between(H, joint.body, joint.other, K);
    row += k;
  }
  for (const int k : drives_) {
    const double multiplier = multipliers[row++];
    if (multiplier == 0) continue;
    const Drive& drive = mechanism_->drives[k];
    const DriveStroke<double> s = drive_stroke<double>(drive, body_or_ground(poses, drive.body),
                                                       body_or_ground(poses, drive.other));
    add_between(multiplier * s.curvature, drive.body, drive.other, K);
  }
}

}  // namespace flexopt
