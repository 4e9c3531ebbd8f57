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
  units_ = Eigen::Map<const VectorXd>(units.data(), static_cast<Eigen::Index>(units.size()));
  value_ = VectorXd::Zero(count());
  gradient_ = MatrixXd::Zero(count(), 6 * static_cast<Eigen::Index>(mechanism.bodies.size()));
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
  for (int b = 0; b < static_cast<int>(poses.size()); ++b)
    for (int d = 0; d < 6; ++d)
      if (mechanism_->bodies[b].held[d]) gradient_.col(6 * b + d).setZero();
}

void Constraints::add_curvature(const std::vector<BodyPose>& poses, const VectorXd& multipliers,
                                MatrixXd& K) const {
  int row = 0;
  for (const Joint& joint : mechanism_->joints) {
    const int k = size_of(joint.type).conditions;
    const Matrix12d H = curvature(joint, body(poses, joint.body), body(poses, joint.other),
                                  multipliers.segment(row, k));
    const int at[2] = {joint.body, joint.other};
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b)
        if (at[a] >= 0 && at[b] >= 0)
          K.block<6, 6>(6 * at[a], 6 * at[b]) += H.block<6, 6>(6 * a, 6 * b);
    row += k;
  }
}

double Constraints::violation() const {
  return count() == 0 ? 0 : value_.cwiseQuotient(units_).cwiseAbs().maxCoeff();
}

}  // namespace flexopt
