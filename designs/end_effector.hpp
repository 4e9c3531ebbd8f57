#pragma once
#include "core/math/types.hpp"

namespace flexopt {

/// What a job mounts on the rigid end-effector.
template <class S>
struct EndEffectorT {
  S mass{};                                 ///< [kg]
  Matrix3<S> inertia = Matrix3<S>::Zero();  ///< about its centre of mass, global axes [kg m²]
  Vector3<S> center_of_mass = Vector3<S>::Zero();  ///< relative to O [m]
};
using EndEffector = EndEffectorT<double>;

}  // namespace flexopt
