#pragma once
// The conditions Ψ(q) = 0 of all joints of a mechanism: equation (Q2) of README.md. None for a
// mechanism without joints.
#include <vector>

#include "core/equilibrium/body_pose.hpp"
#include "core/mechanism/joint.hpp"

namespace flexopt {

class Constraints {
 public:
  /// The mechanism must outlive it.
  explicit Constraints(const Mechanism& mechanism);

  int count() const { return static_cast<int>(units_.size()); }
  /// What a condition is compared with: the longest leaf [m], or 1 for cosines.
  const VectorXd& units() const { return units_; }

  /// Ψ and Ψ_q at these poses. After it the results below hold.
  void evaluate(const std::vector<BodyPose>& poses);
  const VectorXd& value() const { return value_; }
  const MatrixXd& gradient() const { return gradient_; }  ///< count × 6 bodies
  /// K += λ·Ψ_qq at these poses, rotations varied as exp(hat δ) R.
  void add_curvature(const std::vector<BodyPose>& poses, const VectorXd& multipliers,
                     MatrixXd& K) const;
  /// Largest |Ψ| over its unit.
  double violation() const;

 private:
  JointBody body(const std::vector<BodyPose>& poses, int body) const;

  const Mechanism* mechanism_;
  VectorXd units_, value_;
  MatrixXd gradient_;
};

}  // namespace flexopt
