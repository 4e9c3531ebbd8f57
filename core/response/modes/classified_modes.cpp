#include <algorithm>

#include "core/mechanism/joint.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/modes/full_modes.hpp"

namespace flexopt {

std::vector<Mode> classified_modes(const MechanismFactor& factor, bool drive_locked,
                                   const VectorXd& lambda, const MatrixXd& phi,
                                   const MatrixXd& M_phi, ModeMotions motions) {
  const int count = static_cast<int>(lambda.size());
  const Mechanism& mechanism = factor.system().mechanism();
  MatrixXd rest = phi, M_rest = M_phi;
  VectorXd of_drive = VectorXd::Zero(count);
  if (!drive_locked) {
    MatrixXd shapes = factor.drive_answers(), M_shapes = factor.mass(shapes);
    for (Eigen::Index k = 0; k < shapes.cols(); ++k) {
      for (Eigen::Index j = 0; j < k; ++j) {  // M-orthogonal, one after the other
        const double by = M_shapes.col(j).dot(shapes.col(k)) / M_shapes.col(j).dot(shapes.col(j));
        shapes.col(k) -= by * shapes.col(j);
        M_shapes.col(k) -= by * M_shapes.col(j);
      }
      const double b = shapes.col(k).dot(M_shapes.col(k));
      const Eigen::RowVectorXd a = shapes.col(k).transpose() * M_phi;
      of_drive += (a.cwiseAbs2() / b).transpose();
      rest -= shapes.col(k) * (a / b);
      M_rest -= M_shapes.col(k) * (a / b);
    }
    of_drive = of_drive.cwiseMin(1.0);
  }
  const VectorXd all = rest.cwiseProduct(M_rest).colwise().sum();
  const MatrixXd carried = factor.condensed(M_rest);
  MatrixXd motion;
  if (motions == ModeMotions::yes) motion = factor.motion(phi);
  const std::vector<int> group = rigid_groups(mechanism);
  std::vector<Mode> modes;
  for (int k = 0; k < count; ++k) {
    double end_effector = 0, intermediate = 0, bodies = 0;
    for (int b = 0; b < factor.bodies() / 6; ++b) {
      const double e = rest.col(k).segment<6>(6 * b).dot(carried.col(k).segment<6>(6 * b));
      bodies += e;
      (group[b] == mechanism.end_effector ? end_effector : intermediate) += std::max(0.0, e);
    }
    modes.push_back(mode_of_shares(lambda[k], of_drive[k], end_effector, intermediate,
                                   std::max(0.0, all[k] - bodies)));
    if (motions == ModeMotions::yes) modes.back().motion = motion.col(k);
  }
  return modes;
}

}  // namespace flexopt
