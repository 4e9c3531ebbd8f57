#pragma once
// The floating frame of a leaf between two edges and the six deformations seen from it.
//
//     E1 along the chord p2 − p1,  E2 towards the mean width axis,  rolled about E1 until
//     θ1x + θ2x = 0,  θa = log(Eᵀ Ra)                                                       (F1)
//     e = (u = l − L, θ1y, θ1z, θ2y, θ2z, φx = θ2x − θ1x)                                   (F2)
//
// q = (dp1, dω1, dp2, dω2): displacements and spins in the axes of the given poses, varied as
// p ← p + dp, R ← exp(hat dω) R.
#include <array>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/math/types.hpp"

namespace flexopt {

using Rows3x12 = Eigen::Matrix<double, 3, 12, Eigen::RowMajor>;
using Rows6x12 = Eigen::Matrix<double, 6, 12, Eigen::RowMajor>;

/// Order of the deformations e.
enum Deformation { elongation, theta1y, theta1z, theta2y, theta2z, twist };

struct ChordFrame {
  bool converged = false;    ///< else: edges coincide, or width axes oppose each other or the chord
  double roll_residual = 0;  ///< |θ1x + θ2x| reached [rad]
  double chord = 0;          ///< l [m]
  Vector6d e;                ///< deformations (F2)
  Matrix3d axes;             ///< columns E1, E2, E3
  Rows6x12 B;                ///< de = B dq
  Rows3x12 spin;             ///< spin of the frame ψ = spin · dq

  // What the second derivatives need besides, in frame components.
  std::array<Vector3d, 2> theta;        ///< edge rotations from the frame
  std::array<Matrix3d, 2> to_rate;      ///< dθa = to_rate · (dωa − ψ)
  std::array<double, 2> gamma, dgamma;  ///< factor of hat² in to_rate, and its d/d|θ|²
  Rows3x12 spin_local;
  std::array<Rows3x12, 2> theta_rate;  ///< dθa/dq
};

/// Frame, deformations and their first derivatives for edges that stood `length` apart.
/// The roll condition is solved by Newton to 1e-14; its derivatives are those of the solution.
ChordFrame chord_frame(const EdgePoses& edges, double length);

/// Geometric stiffness Σ_k g_k ∂²e_k/∂q²: symmetric, rotations varied about the exponential map
/// to second order.
Matrix12d geometric_stiffness(const ChordFrame& frame, const Vector6d& g);

}  // namespace flexopt
