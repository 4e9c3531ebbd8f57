#include "core/equilibrium/dead_loads.hpp"

namespace flexopt {

std::vector<BodyLoad> acting_loads(const LoadCase& loads, LoadFactors factors,
                                   const Mechanism& mechanism) {
  std::vector<BodyLoad> acting;
  const auto add = [&](const std::vector<DeadLoad>& list, const auto& factor_of) {
    for (const DeadLoad& load : list) {
      const double factor = factor_of(load);
      if (factor == 0) continue;
      const int body = load.body.value_or(mechanism.end_effector);
      const Vector3d arm =
          load.place ? Vector3d(*load.place - mechanism.bodies[body].reference) : load.arm;
      acting.push_back({body, factor * load.force, factor * load.moment, arm,
                        load.place.has_value(), std::nullopt, load.follows});
    }
  };
  add(loads.constant, [&](const DeadLoad& load) { return factors.of_step(load.step); });
  add(loads.growing, [&](const DeadLoad&) { return factors.growing; });
  const Vector3d gravity = factors.of_step(loads.gravity_step) * loads.gravity;
  if (gravity.isZero(0)) return acting;
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const RigidBody& body = mechanism.bodies[b];
    acting.push_back({.body = static_cast<int>(b),
                      .force = body.mass * gravity,
                      .moment = Vector3d::Zero(),
                      .arm = body.center_of_mass - body.reference,
                      .acceleration = gravity});
  }
  return acting;
}

VectorXd forces_of(const std::vector<BodyLoad>& loads, const std::vector<JointBody>& poses) {
  VectorXd forces = VectorXd::Zero(6 * static_cast<Eigen::Index>(poses.size()));
  for (const BodyLoad& load : loads) {
    const Matrix3d& R = poses[load.body].rotation;
    const Matrix3d turn = load.follows ? R : Matrix3d::Identity();
    const Vector3d force = turn * load.force;
    forces.segment<3>(6 * load.body) += force;
    forces.segment<3>(6 * load.body + 3) += turn * load.moment + (R * load.arm).cross(force);
  }
  return forces;
}

VectorXd forces_at_rest(const LoadCase& loads, LoadFactors factors, const Mechanism& mechanism) {
  return forces_of(acting_loads(loads, factors, mechanism), undeflected_bodies(mechanism));
}

}  // namespace flexopt
