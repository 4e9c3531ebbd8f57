#include "support/bearable_loads.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/equilibrium/end_effector_compliance.hpp"
#include "core/equilibrium/free_motions.hpp"
#include "core/equilibrium/stroke_path.hpp"
#include "core/math/decompositions.hpp"
#include "core/response/models/leaf_models.hpp"

namespace flexopt::laws {

AtRest at_rest(const Mechanism& mechanism, const ModelOptions& model) {
  System system(mechanism, make_full_leaves(mechanism, model));
  system.assemble();
  const double stiffness = std::abs(end_effector_compliance(system).drive_stiffness[0]);
  const MatrixXd K = system.tangent().dense();
  const FreeMotions motions(system, false);
  const MatrixXd free = motions.basis().transpose() * K * motions.basis();
  const VectorXd unit = free.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
  const VectorXd values = symmetric_eigenvalues(unit.asDiagonal() * free * unit.asDiagonal());
  const double condition = values.cwiseAbs().maxCoeff() / values.cwiseAbs().minCoeff();
  // places are rounded to their distance from the origin; a leaf is that much stiffer along than
  // across
  double slender = 0;
  for (const LeafSpring& leaf : mechanism.leaves)
    slender = std::max(slender, 12 * leaf.length * (leaf.origin.norm() + leaf.length) /
                                    (leaf.thickness * leaf.thickness));
  return {is_rotation(mechanism.drives[0].direction) ? std::min(0.02, 0.02 / stiffness)
                                                     : std::min(1e-3, 1 / stiffness),
          std::numeric_limits<double>::epsilon() * (condition + slender)};
}

namespace {

// A small dead load on every body.
LoadCase loads_of(const Mechanism& mechanism) {
  LoadCase loads;
  for (int b = 0; b < static_cast<int>(mechanism.bodies.size()); ++b) {
    const double k = static_cast<double>(mechanism.bodies[static_cast<std::size_t>(b)].name.size());
    DeadLoad load{.force = 0.05 * Vector3d(std::sin(k), std::cos(2 * k), std::sin(3 * k)),
                  .moment = 5e-4 * Vector3d(std::cos(k), std::sin(2 * k), std::cos(3 * k)),
                  .body = b,
                  .arm = 0.01 * Vector3d(std::sin(5 * k), std::cos(7 * k), std::sin(2 * k))};
    const auto& held = mechanism.bodies[static_cast<std::size_t>(b)].held;
    if (held[3] && held[4] && held[5]) {  // a material point: forces act at its place
      load.moment.setZero();
      load.arm.setZero();
    }
    loads.constant.push_back(load);
  }
  return loads;
}

}  // namespace

LoadCase bearable_loads(const Mechanism& mechanism, const ModelOptions& model) {
  LoadCase loads = loads_of(mechanism);
  System system(mechanism, make_full_leaves(mechanism, model), loads);
  const auto softest = [&] {  // lengths over the longest leaf
    system.assemble();
    const MatrixXd basis = FreeMotions(system, true).basis();
    return symmetric_eigenvalues(basis.transpose() * system.tangent().dense() * basis).minCoeff();
  };
  const double at_rest = softest();
  double reached = 0, failed = 1;
  System::Snapshot state = system.save();
  if (step_load(system, {.constant = 1}, {}).converged) return loads;
  for (int k = 0; k < 10; ++k) {
    const double middle = 0.5 * (reached + failed);
    system.restore(state);
    if (step_load(system, {.constant = middle}, {}).converged) {
      state = system.save();
      reached = middle;
    } else {
      failed = middle;
    }
  }
  system.restore(state);
  if (!(softest() < 0.1 * at_rest)) throw std::runtime_error("no equilibrium under small loads");
  for (DeadLoad& load : loads.constant) {
    load.force *= 0.5 * reached;
    load.moment *= 0.5 * reached;
  }
  return loads;
}

}  // namespace flexopt::laws
