#include "core/equilibrium/springs.hpp"

#include <algorithm>

#include "core/equilibrium/constraints.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

Springs::Springs(const Mechanism& mechanism)
    : mechanism_(&mechanism),
      acting_(mechanism.springs),
      preloaded_(std::ranges::any_of(mechanism.springs, is_preloaded)) {
  for (std::size_t k = 0; k < acting_.size(); ++k) apply(k, 0);
}

void Springs::apply(std::size_t k, double share) {
  if (acting_[k].matrix) return;
  const Spring& whole = mechanism_->springs[k];
  const double built = built_length(whole), free = whole.free_length;
  const double slack = whole.line.empty() || share == 1 ? 0 : (1 - share) * pull_at(whole, built);
  for (std::size_t i = 0; i < whole.line.size(); ++i)
    acting_[k].line[i][1] = whole.line[i][1] - slack;
  acting_[k].free_length = share == 1 ? free : built + share * (free - built);
}

bool Springs::add(const std::vector<JointBody>& poses, double& energy, VectorXd& force,
                  BlockMatrix& tangent) const {
  bool known = true;
  for (const Spring& spring : acting_) {
    const JointBody body = body_or_ground(poses, spring.body),
                    other = body_or_ground(poses, spring.other);
    if (spring.matrix)
      known =
          known &&
          rotation_log(body.rotation * other.rotation.transpose(), body.turn - other.turn).norm() <
              std::numbers::pi;
    const SpringForces f = spring_forces(spring, body, other);
    energy += f.energy;
    for (int a = 0; a < 2; ++a)
      if (const int b = a == 0 ? spring.body : spring.other; b >= 0)
        force.segment<6>(6 * b) += f.force.segment<6>(6 * a);
    add_between(f.tangent, spring.body, spring.other, tangent);
  }
  return known;
}

VectorXd preload_forces(const Mechanism& mechanism) {
  const auto n = 6 * static_cast<Eigen::Index>(mechanism.bodies.size());
  Springs springs(mechanism);
  for (std::size_t k = 0; k < mechanism.springs.size(); ++k) springs.apply(k, 1);
  double energy = 0;
  VectorXd force = VectorXd::Zero(n);
  BlockMatrix tangent(static_cast<int>(mechanism.bodies.size()));
  springs.add(undeflected_bodies(mechanism), energy, force, tangent);
  return force;
}

}  // namespace flexopt
