#pragma once
// Drives: what a stroke measures and its derivatives. Rotations are varied as exp(hat δ) R, to
// second order. Equations (Q4) and (Q5) of core/equilibrium/README.md.
#include <bitset>
#include <optional>
#include <vector>

#include "core/mechanism/joint.hpp"

namespace flexopt {

/// The coordinate 6 body + direction that the stroke of this drive is: of a displacement against
/// the ground along a global axis that no parameter turns. Nothing for others: their stroke is a
/// condition with a multiplier.
std::optional<int> coordinate_of(const Drive& drive);

/// The drives whose strokes are conditions, in order.
std::vector<int> conditional_drives(const Mechanism& mechanism);

/// The global axis along (or about) which a drive moves the end-effector against the ground, if it
/// is such a drive.
std::optional<Direction> end_effector_direction(const Mechanism& mechanism, const Drive& drive);

/// Directions of the end-effector that these drives prescribe; by default all.
std::array<bool, 6> prescribed_directions(const Mechanism& mechanism,
                                          const std::bitset<6>& drives = ~std::bitset<6>());

/// Stroke of a drive over (displacement, spin) of `body` and of `other`. With p, p′ the present
/// reference points, P, P′ the undeflected ones, R, R′ the rotations, a the undeflected axis:
///   translation  s = (R′a)·(p − p′) − a·(P − P′)   [m]
///   rotation     the angle about a of Q = R′ᵀR     [rad], −π < s ≤ π
/// That is how the point of `other` that lay at P sees P move, and by how much it sees `body` turn
/// about the axis: Q is this turn after, or before, one about an axis at right angles to a. With
/// (q₀, q) the quaternion of Q, s = 2 atan2(a·q, q₀). Where Q turns about a alone, s is its angle
/// and has no second derivative.
/// The drive load is the force or moment conjugate to s: a unit of it acts on the bodies with
/// `gradient`, of a rotation the moments ±(b + c)/(1 + b·c), where b = R′a and c = Ra.
/// S: double, or Jet along a path.
template <class S>
struct DriveStroke {
  S value{};
  Eigen::Matrix<S, 12, 1> gradient = Eigen::Matrix<S, 12, 1>::Zero();
  Eigen::Matrix<S, 12, 12> curvature = Eigen::Matrix<S, 12, 12>::Zero();  ///< symmetric
};
template <class S>
DriveStroke<S> drive_stroke(const Drive& drive, const JointBodyOf<S>& body,
                            const JointBodyOf<S>& other);

/// State on which the stroke depends, or the derivative of that state. Of a drive that moves only
/// the axes count.
template <class S>
struct StrokeState {
  Drive drive;
  JointBodyOf<S> body, other;
};
/// Derivative of all that drive_stroke() answers while the state moves at `rate`.
template <class S>
DriveStroke<S> drive_stroke_rate(const StrokeState<S>& state, const StrokeState<S>& rate);

extern template DriveStroke<double> drive_stroke(const Drive&, const JointBody&, const JointBody&);
extern template DriveStroke<Jet> drive_stroke(const Drive&, const JointBodyOf<Jet>&,
                                              const JointBodyOf<Jet>&);
extern template DriveStroke<double> drive_stroke_rate(const StrokeState<double>&,
                                                      const StrokeState<double>&);
extern template DriveStroke<Jet> drive_stroke_rate(const StrokeState<Jet>&,
                                                   const StrokeState<Jet>&);

/// Rules of the drives by themselves: indices, names, axes, held directions.
Check check_drives(const Mechanism& mechanism);

}  // namespace flexopt
