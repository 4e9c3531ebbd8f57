#pragma once
// A deformed body seen from rigid interface frames: energy, force and exact tangent in absolute
// coordinates. The body's rigid motion is taken up by a floating frame that is found anew at every
// state. Equations (U1)–(U6) of README.md.
#include <span>

#include "core/elements/solid/elastic_model.hpp"
#include "core/math/floating_frame.hpp"

namespace flexopt {

/// Answers of a floating body. Vectors have (force, moment) or (displacement, spin) of each
/// interface, global axes; rotations are varied as exp(hat δ) R to second order.
template <class S>
struct FloatingAnswersOf {
  bool framed = false;  ///< else no frame was found, and nothing below holds
  FramePoseOf<S> frame;
  Eigen::VectorX<S> local;    ///< d
  S energy{};                 ///< [J], of gravity too, from the global origin on
  Eigen::VectorX<S> force;    ///< derivative of the energy
  Eigen::MatrixX<S> tangent;  ///< its second derivative, symmetric
};

/// What acts on a body beside its interfaces.
template <class S>
struct BodyActionOf {
  Vector3<S> gravity = Vector3<S>::Zero();  ///< [m/s²], global axes
  S growth = S(1.0);                        ///< stress-free sizes over nominal ones
};

/// Evaluates into `answers`, whose storage is used again: no allocation where its sizes fit.
template <class S>
void evaluate_floating(const ElasticModel& model, std::span<const FramePoseOf<S>> interfaces,
                       const BodyActionOf<S>& action, FloatingAnswersOf<S>& answers);

/// Derivatives of the answers while the interfaces move by `pose_rates` (rates of position and of
/// the entries of the axes) and the model changes by `model_rate`.
template <class S>
FloatingAnswersOf<S> floating_rates(const ElasticModel& model, const ElasticModel& model_rate,
                                    std::span<const FramePoseOf<S>> interfaces,
                                    std::span<const FramePoseOf<S>> pose_rates,
                                    const BodyActionOf<S>& action);

/// Mass over (displacement, spin) of the interfaces, global axes, for this frame; 6N × 6N.
template <class S>
Eigen::MatrixX<S> floating_mass(const ElasticModel& model, const Matrix3<S>& frame_axes);

}  // namespace flexopt
