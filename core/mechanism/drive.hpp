#pragma once
// Drives: what a stroke measures and its derivatives. Rotations are varied as exp(hat δ) R, to
// second order. Equations (Q4) and (Q5) of core/equilibrium/README.md.
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/joint.hpp"

namespace flexopt {

/// The coordinate 6 body + direction that the stroke of this drive is, up to the numbering of
/// rotations: of a drive against the ground along a global axis, and of a rotation only where it is
/// the only drive. Nothing for others: their stroke is a condition with a multiplier.
std::optional<int> coordinate_of(const Mechanism& mechanism, std::size_t drive);

/// The drives whose strokes are conditions, in order.
std::vector<int> conditional_drives(const Mechanism& mechanism);

/// The global axis along (or about) which a drive moves the end-effector against the ground, if it
/// is such a drive.
std::optional<Direction> end_effector_direction(const Mechanism& mechanism, const Drive& drive);

/// Directions of the end-effector that drives prescribe.
std::array<bool, 6> prescribed_directions(const Mechanism& mechanism);

/// Stroke of a drive over (displacement, spin) of `body` and of `other`. With p, p′ the present
/// reference points, P, P′ the undeflected ones, R, R′ the rotations, a the undeflected axis:
///   translation  s = (R′a)·(p − p′) − a·(P − P′)   [m]
///   rotation     s = a·log(R′ᵀR)                   [rad]
/// That is how the point of `other` that lay at P sees P move, and its rotation vector of `body`.
/// S: double, or Jet along a path; then rotations stay below π.
template <class S>
struct DriveStroke {
  S value{};
  Eigen::Matrix<S, 12, 1> gradient = Eigen::Matrix<S, 12, 1>::Zero();
  /// Forces of a unit drive load: the gradient, or of a moment about the axis R′a on both bodies.
  Eigen::Matrix<S, 12, 1> load = Eigen::Matrix<S, 12, 1>::Zero();
  /// Second derivative along the displacements and, of rotations, along the incremental rotation
  /// vector of `body` as `other` sees it, from the present state; symmetric.
  Eigen::Matrix<S, 12, 12> curvature = Eigen::Matrix<S, 12, 12>::Zero();
  /// What the derivative of `load` has besides.
  Eigen::Matrix<S, 12, 12> winding = Eigen::Matrix<S, 12, 12>::Zero();
};
/// The load of a rotation is that which does work on the stroke where there are several drives, and
/// the moment about the axis where it is the only one, as of a drive about a global axis.
enum class DriveLoad { conjugate, about_axis };
DriveLoad load_of_rotations(const Mechanism& mechanism);

template <class S>
DriveStroke<S> drive_stroke(const Drive& drive, DriveLoad load, const JointBodyOf<S>& body,
                            const JointBodyOf<S>& other);

/// All that the stroke depends on, or how it moves; of a drive that moves only the axes count.
template <class S>
struct StrokeState {
  Drive drive;
  JointBodyOf<S> body, other;
};
/// Derivative of all that drive_stroke() answers while the state moves at `rate`.
template <class S>
DriveStroke<S> drive_stroke_rate(const StrokeState<S>& state, DriveLoad load,
                                 const StrokeState<S>& rate);

extern template DriveStroke<double> drive_stroke(const Drive&, DriveLoad,
                                                 const JointBodyOf<double>&,
                                                 const JointBodyOf<double>&);
extern template DriveStroke<Jet> drive_stroke(const Drive&, DriveLoad, const JointBodyOf<Jet>&,
                                              const JointBodyOf<Jet>&);
extern template DriveStroke<double> drive_stroke_rate(const StrokeState<double>&, DriveLoad,
                                                      const StrokeState<double>&);
extern template DriveStroke<Jet> drive_stroke_rate(const StrokeState<Jet>&, DriveLoad,
                                                   const StrokeState<Jet>&);

/// The first broken rule of the drives by themselves: indices, names, axes, held directions.
std::optional<std::string> broken_drive_rule(const Mechanism& mechanism);

}  // namespace flexopt
