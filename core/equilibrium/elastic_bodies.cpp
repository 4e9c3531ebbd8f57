#include "core/equilibrium/elastic_bodies.hpp"

namespace flexopt {

ElasticBodies::ElasticBodies(const Mechanism& mechanism) : mechanism_(&mechanism) {
  for (const ElasticBody& body : mechanism.elastic_bodies)
    bodies_.push_back({condensed(body), std::vector<JointBody>(body.interfaces.size()), {}});
}

bool ElasticBodies::add(const std::vector<JointBody>& poses, double& energy, VectorXd& force,
                        BlockMatrix& tangent) {
  for (int k = 0; k < count(); ++k) {
    auto& [solid, holders, held] = bodies_[k];
    const ElasticBody& own = body(k);
    for (std::size_t a = 0; a < holders.size(); ++a)
      holders[a] = body_or_ground(poses, own.interfaces[a].body);
    evaluate_held(own, solid->model, holders, action_, held);
    if (!held.floating.framed) return false;
    // the weight has none at its undeflected place
    energy += held.floating.energy + action_.gravity.dot(solid->model.total_mass * own.place +
                                                         own.axes * solid->model.mass_moment);
    add_holder_forces(own, held.force, force);
    add_between(held.tangent, own, tangent);
  }
  return true;
}

void ElasticBodies::add_mass(BlockMatrix& mass) const {
  for (int k = 0; k < count(); ++k) add_between(held_mass(model(k), held(k)), body(k), mass);
}

ElasticAction action_of(const LoadCase& loads, LoadFactors factors) {
  return {factors.of_step(loads.gravity_step) * loads.gravity,
          factors.of_step(loads.temperature_step)};
}

VectorXd elastic_forces(const Mechanism& mechanism, const ElasticAction& action) {
  const int bodies = static_cast<int>(mechanism.bodies.size());
  ElasticBodies elastic(mechanism);
  elastic.act(action);
  double energy = 0;
  VectorXd force = VectorXd::Zero(6 * bodies);
  BlockMatrix tangent(bodies);
  elastic.add(undeflected_bodies(mechanism), energy, force, tangent);
  return force;
}

void add_between(const MatrixXd& H, const ElasticBody& body, BlockMatrix& K) {
  const int count = static_cast<int>(body.interfaces.size());
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) {
      const int a = body.interfaces[i].body, b = body.interfaces[j].body;
      if (a >= 0 && b >= 0) K.block(a, b) += H.block<6, 6>(6 * i, 6 * j);
    }
}

}  // namespace flexopt
