#pragma once
// Turns the mixed potential W*(s, f) into energy, force and tangent in the deformations e, and at
// the edges of the leaf.
//
// s = (θ1y, θ2y, φx) soft deformations, ub = (u, θ1z, θ2z) stiff ones, f their conjugate forces
// over the scale c (diagonal):
//
//     W(e) = stat_f W*(s, f) + f · c ub,     R = ∂W*/∂f + c ub = 0                           (C1)
//     W_s = ∂W*/∂s,  W_ub = c f,  W_ee = [W*_ss 0; 0 0] − hᵀ F⁻¹ h,  h = dR/de,  F = W*_ff   (C2)
//
// Off stationarity (R ≠ 0): W −= ½ Rᵀ F⁻¹ R and W_e −= hᵀ F⁻¹ R, correct to first order in R.
#include "core/elements/leaf/chord_frame.hpp"
#include "core/reduction/tube/tube_potential.hpp"

namespace flexopt {

/// The internal forces of a leaf and the linear model of R about them. A plain value: copy it to
/// save, assign it to restore.
struct MixedState {
  Vector3d f = Vector3d::Zero();  ///< (N, M1, M2) over their scale
  Vector3d R = Vector3d::Zero();  ///< residual at the last evaluation, less what follow() removed
  Eigen::Matrix<double, 3, 6> h = Eigen::Matrix<double, 3, 6>::Zero();
  Matrix3d F_inverse = Matrix3d::Zero();
};

/// Energy and its derivatives in e = (u, θ1y, θ1z, θ2y, θ2z, φx).
struct MixedEnergy {
  double energy = 0;
  Vector6d gradient;
  Matrix6d hessian;
  Vector3d gap;  ///< R over the force scale: how far (u, θ1z, θ2z) and f still disagree [m, rad]
};

/// Evaluates (C1), (C2) at the forces that the state holds and stores R, h, F there.
MixedEnergy condense(const TubePotential& potential, const Vector6d& e, MixedState& state);

/// Moves the forces with the linearised deformation: f ← f − F⁻¹ (R + h de), where de = B dq with
/// the B of the *old* place. (The exact increment e_new − e_old costs two to four times the
/// iterations.) Does nothing before the first condense().
void follow(MixedState& state, const Vector6d& de);

/// What a reduced leaf remembers between two evaluations.
struct ReducedState {
  MixedState mixed;
  Rows6x12 B = Rows6x12::Zero();  ///< de/dq of the last evaluation
};

/// The reduced leaf seen from its edges; 12-vectors as in chord_frame.hpp.
struct ReducedResponse {
  ChordFrame frame;
  MixedEnergy mixed;
  TubeLocation location;
  Vector12d force;    ///< Bᵀ W_e
  Matrix12d tangent;  ///< Bᵀ W_ee B + Σ_k (W_e)_k ∂²e_k/∂q²
};

/// Moves the internal forces along an increment dq of the edges, taken through the lever arms of
/// the place where the leaf was last evaluated, in the axes of those poses.
void follow(ReducedState& state, const Vector12d& dq);

/// Energy, force and tangent of the leaf between `edges`; false if the frame does not exist there
/// (then the response holds the frame only).
bool evaluate_reduced_leaf(const TubePotential& potential, double length, const EdgePoses& edges,
                           ReducedState& state, ReducedResponse& response);

}  // namespace flexopt
