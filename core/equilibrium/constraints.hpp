#pragma once
// The conditions Ψ(q) = 0 of all joints of a mechanism: equation (Q2) of README.md; after them the
// strokes g(q) of the drives that are no coordinates: (Q4). None for a mechanism without either.
#include <vector>

#include "core/equilibrium/body_pose.hpp"
#include "core/mechanism/drive.hpp"

namespace flexopt {

class Constraints {
 public:
  /// The mechanism must outlive it.
  explicit Constraints(const Mechanism& mechanism);

  int count() const { return static_cast<int>(units_.size()); }
  int joints() const { return joints_; }  ///< how many of them are the joints'
  /// Drives that the rows from joints() on belong to.
  const std::vector<int>& drives() const { return drives_; }
  /// What a condition is compared with: the longest leaf [m], or 1 for cosines.
  const VectorXd& units() const { return units_; }

  /// Ψ and Ψ_q at these poses, of drives the stroke and the forces of unit loads. After it the
  /// results below hold.
  void evaluate(const std::vector<BodyPose>& poses);
  const VectorXd& value() const { return value_; }
  const MatrixXd& gradient() const { return gradient_; }  ///< count × 6 bodies
  /// In the rows of drives the derivative of the stroke, which gradient() need not be: there stands
  /// what the drive load does work on.
  const MatrixXd& stroke_gradient() const { return stroke_gradient_; }
  /// K += λ·Ψ_qq at these poses, rotations varied as exp(hat δ) R.
  void add_curvature(const std::vector<BodyPose>& poses, const VectorXd& multipliers,
                     MatrixXd& K) const;
  /// The rest of the derivative of Ψ_qᵀ λ: DriveStroke::winding.
  void add_winding(const std::vector<BodyPose>& poses, const VectorXd& multipliers,
                   MatrixXd& K) const;
  /// Largest |Ψ| of the joints over its unit.
  double violation() const;

 private:
  JointBody body(const std::vector<BodyPose>& poses, int body) const;

  const Mechanism* mechanism_;
  int joints_ = 0;
  std::vector<int> drives_;
  DriveLoad loads_ = DriveLoad::about_axis;
  VectorXd units_, value_;
  MatrixXd gradient_, stroke_gradient_;
};

}  // namespace flexopt
