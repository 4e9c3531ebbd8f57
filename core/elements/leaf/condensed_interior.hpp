#pragma once
// What lies inside a leaf, condensed onto its two edges and onto a material point: equations (E5)
// and (E6) of core/elements/README.md.
#include <optional>
#include <vector>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/math/block_tridiagonal.hpp"

namespace flexopt {

/// The unknowns x of the interior follow the edges q to first order: K x = −g − K_fb dq. A material
/// point c(x, q) = u is held by its force λ. K = L Σ Lᵀ stays with the leaf, which factorises it
/// and hands it on unchanged.
class CondensedInterior {
 public:
  /// Force and tangent at the edges. `edge_force`, `edge_tangent`: those with x held.
  /// `first_of_tip`: the first block of K whose rows of K_fb differ from zero in the columns of the
  /// tip.
  void condense(const BlockTridiagonal& K, const VectorXd& residual, const MatrixXd& coupling,
                const Vector12d& edge_force, const Matrix12d& edge_tangent, int first_of_tip);
  struct Point {
    MatrixXd gradient;                           ///< (∂c/∂x)ᵀ: unknowns × 3
    Eigen::Matrix<double, 3, 12> edge_gradient;  ///< ∂c/∂q
    Vector3d missing;                            ///< u − c
    Vector3d force;                              ///< λ so far
  };
  /// Holds a material point; call condense() first.
  void hold(const BlockTridiagonal& K, Point point);

  const Vector12d& force() const { return force_; }
  const Matrix12d& tangent() const { return tangent_; }
  /// Twice the energy that the interior still releases in the step to come.
  double correction() const { return correction_; }
  int negative_pivots() const { return negative_; }
  bool has_point() const { return point_.has_value(); }
  const std::optional<LeafEvaluation::Point>& point() const { return point_; }

  /// Step dx for an increment dq of the edges, and du of the point, whose force changes by df.
  VectorXd step(const BlockTridiagonal& K, const Vector12d& dq, const Vector3d& du,
                Vector3d& df) const;
  /// K⁻¹ b with the point held.
  void solve(const BlockTridiagonal& K, Eigen::Ref<MatrixXd> b) const;
  /// dx/d(edges, point) for some of these 12 or 15 columns.
  MatrixXd static_shapes(const BlockTridiagonal& K, const std::vector<int>& columns) const;

 private:
  VectorXd y_;                      ///< L⁻¹ residual
  MatrixXd Y_;                      ///< L⁻¹ K_fb
  MatrixXd Yc_;                     ///< L⁻¹ (∂c/∂x)ᵀ
  Eigen::Matrix<double, 3, 12> G_;  ///< ∂c/∂x K⁻¹ K_fb − ∂c/∂q
  Matrix3d S_inverse_;              ///< (∂c/∂x K⁻¹ ∂c/∂xᵀ)⁻¹
  Vector3d h_;                      ///< u − c + ∂c/∂x K⁻¹ g
  Vector12d force_;
  Matrix12d tangent_;
  double correction_ = 0;
  int negative_ = 0;
  std::optional<LeafEvaluation::Point> point_;
};

}  // namespace flexopt
