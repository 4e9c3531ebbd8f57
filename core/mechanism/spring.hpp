#pragma once
// Springs between two points and bushings: energy, forces and tangent at any displacement and
// rotation. Rotations are varied as exp(hat δ) R, to second order.
#include "core/mechanism/joint.hpp"

namespace flexopt {

/// Energy of a spring or bushing, with derivatives by (displacement, spin) of `body` and `other`.
///
/// A spring whose ends are d apart has the energy ½ k (|d| − l₀)². The force of one with a line is
/// a cubic of the length between two neighbours of the table, with the slopes that the parabola
/// through a length and its two neighbours has there; beyond the ends it goes on straight. So its
/// stiffness has no jumps, and its energy counts from the first length.
///
/// A bushing with the matrix K has ½ eᵀ K e. The six numbers e are how far its place on `body` is
/// from that on `other`, and the rotation vector of `body` relative to `other`, both in axes that
/// turn half-way between the two bodies. So the energy does not change when the whole turns, nor
/// when `body` and `other` change their names; a spring that turns with one of the two would not
/// have the second property. Relative rotations must stay below half a turn.
template <class S>
struct SpringForcesOf {
  S energy{};                        ///< [J]
  Eigen::Matrix<S, 12, 1> force;     ///< derivative of the energy
  Eigen::Matrix<S, 12, 12> tangent;  ///< its second derivative, symmetric
};
using SpringForces = SpringForcesOf<double>;

/// S: double, or Jet along a path.
template <class S>
SpringForcesOf<S> spring_forces(const Spring& spring, const JointBodyOf<S>& body,
                                const JointBodyOf<S>& other);

/// State on which the forces of a spring depend, or the derivative of that state.
template <class S>
struct SpringState {
  const Spring* spring;
  JointBodyOf<S> body, other;
};
/// Derivatives of spring_forces() while the state moves at `rate`.
template <class S>
SpringForcesOf<S> spring_rates(const SpringState<S>& state, const SpringState<S>& rate);

extern template SpringForcesOf<double> spring_forces(const Spring&, const JointBodyOf<double>&,
                                                     const JointBodyOf<double>&);
extern template SpringForcesOf<Jet> spring_forces(const Spring&, const JointBodyOf<Jet>&,
                                                  const JointBodyOf<Jet>&);
extern template SpringForcesOf<double> spring_rates(const SpringState<double>&,
                                                    const SpringState<double>&);
extern template SpringForcesOf<Jet> spring_rates(const SpringState<Jet>&, const SpringState<Jet>&);

/// Distance of the undeflected ends of a spring between two points [m].
double built_length(const Spring& spring);
/// Force of a spring between two points that pulls its ends together at a length [m] [N].
double pull_at(const Spring& spring, double length);
/// Whether it pulls or pushes in the undeflected state. Bushings do not.
bool is_preloaded(const Spring& spring);

}  // namespace flexopt
