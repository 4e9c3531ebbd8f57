#pragma once
// Expansion of a leaf's mixed potential W*(s, f) about a bent state by static perturbation of the
// full plate leaf: the coefficients of the tube and the fields to rebuild the leaf from.
// Scaled units of plate_mesh.hpp. Equations (R1)–(R4) of core/reduction/README.md.
#include <Eigen/LU>
#include <memory>
#include <string>
#include <vector>

#include "core/elements/plate/plate_leaf.hpp"

namespace flexopt {

/// Units of (N, M1, M2) in the potential: w/L and (w/L)², in D/L and D.
Vector3d tube_force_scale(const PlateShape& shape);

/// The plate leaf in its own chord frame: soft deformations s = (θ1y, θ2y, φx) prescribed, stiff
/// ones c = (u, θ1z, θ2z) free under the forces f = (N, M1, M2). Of a curved leaf all count from
/// the undeflected one.
class ChordLeaf {
 public:
  explicit ChordLeaf(std::shared_ptr<const PlateMesh> mesh);

  /// Moves back to the undeflected leaf.
  void reset();

  /// Moves to a known state: soft deformations, forces and unknowns() of an equilibrium.
  void stand_at(const Vector3d& s, const Vector3d& f, const VectorXd& unknowns);

  struct Solution {
    bool converged = false;
    int iterations = 0;
    double correction = 0;
  };
  /// Newton's method from the present state to (s, f).
  Solution solve(const Vector3d& s, const Vector3d& f, int max_iterations = 25);

  PlateLeaf& plate() { return plate_; }
  const PlateLeaf& plate() const { return plate_; }
  const Vector3d& soft() const { return s_; }
  const Vector3d& stiff() const { return c_; }
  const Vector3d& forces() const { return f_; }
  /// All unknowns: those of the plate, then (u, θ1z, θ2z).
  VectorXd unknowns() const;
  /// W* = U − f·c at the present state.
  double potential() const;

  /// Edge poses for s and c.
  EdgePoses edges(const Vector3d& s, const Vector3d& c) const;
  /// d(edges)/dc (12 × 3).
  Eigen::Matrix<double, 12, 3> stiff_map() const;
  /// d(edges)/ds (12 × 3).
  Eigen::Matrix<double, 12, 3> soft_map() const;
  /// Stiffness of c with the plate condensed, curvature of the exponential coordinates included.
  Matrix3d stiff_tangent() const;

 private:
  PlateLeaf plate_;
  Vector3d s_ = Vector3d::Zero(), c_ = Vector3d::Zero(), f_ = Vector3d::Zero();
};

/// How far states stand apart at least [rad], but for those of arcs near the straightened leaf:
/// rounding of the plate's forces goes into the stiffness between two over their distance, that of
/// its energy over the square.
inline constexpr double least_distance_of_states = 0.03;

/// Bends `leaf` to (θ1y, θ2y) = ray σ without twist, under its present forces, in one step or,
/// where that fails, in smaller ones. Returns the σ that was reached: `to`, or less where no stable
/// equilibrium was found beyond; the leaf then is in the last equilibrium. `from`: σ of its present
/// state.
double bend(ChordLeaf& leaf, const Eigen::Vector2d& ray, double from, double to);

/// Linear answers of a leaf in its chord frame, soft deformations held, stiff ones free: solves for
/// the unknowns of the plate and the stiff deformations c at once, on the factor of the
/// leaf, which must keep its state.
class FieldSolver {
 public:
  explicit FieldSolver(const ChordLeaf& leaf);

  /// Solution −K⁻¹ R, rows as in ChordLeaf::unknowns.
  MatrixXd operator()(const MatrixXd& R) const;

 private:
  const PlateLeaf& plate_;
  Eigen::PartialPivLU<Matrix3d> S_;
  MatrixXd X_, KcT_;
};

/// Expansion about one bent state.
struct TubeExpansion {
  double sigma = 0;
  std::vector<double> W;  ///< Taylor coefficients to degree 2 order + 1
  MatrixXd fields;        ///< unknowns + 3 rows; Taylor coefficients to degree `order`
};

/// TubeExpansion::fields alone, and the Taylor coefficients of the nodal values of all lines: rows
/// line by line, in each functions_per_line for each of three components.
struct FieldExpansion {
  MatrixXd fields, nodal;
};
FieldExpansion expand_fields(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, int order);
/// FieldExpansion::nodal of fields to order 2 or 3 that are known.
MatrixXd nodal_values(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, const MatrixXd& fields);

/// Fields in (σ, τ) alone to degree 3, columns 1; σ, τ; σ², στ, τ²; σ³, σ²τ, στ², τ³: from `fields`
/// to order 2 or more. `leaf` stands at the state.
FieldExpansion expand_bending_fields(const ChordLeaf& leaf, const Eigen::Matrix2d& ray,
                                     const MatrixXd& fields);

/// Fields to `order` (2 or 3), potential to degree 2·order + 1, about the present state of `leaf`
/// (converged), in x = (σ, τ, φ, N, M1, M2) with (θ1y, θ2y) = present + ray (σ, τ).
TubeExpansion expand(ChordLeaf& leaf, double sigma, const Eigen::Matrix2d& ray, int order);

}  // namespace flexopt
