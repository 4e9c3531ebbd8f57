// Force and tangent as derivatives of the energy.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/math/ridders.hpp"
#include "core/math/rotation.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/path/error_estimate.hpp"
#include "support/bearable_loads.hpp"
#include "support/mechanism_laws.hpp"
#include "support/one_stroke.hpp"

namespace flexopt::laws {

Deviation energy(const RandomDesign& design, unsigned long long seed, const ModelOptions& model) {
  const Mechanism mechanism = design.make();
  const LoadCase loads = bearable_loads(mechanism, model);
  const double stroke = at_rest(mechanism, model).stroke;
  System system(mechanism, make_full_leaves(mechanism, model), loads);
  if (const Equilibrium e = step_load(system, {.constant = 1}, {}); !e.converged)
    throw std::runtime_error(e.message);
  if (const Equilibrium e = step_to(system, stroke, {}); !e.converged)
    throw std::runtime_error(e.message);
  const System::Snapshot state = system.save();
  const int n = system.size();
  RandomNumbers random(seed);
  const double length = longest_leaf(mechanism);
  VectorXd along(n);
  for (int k = 0; k < n; ++k)
    along[k] = system.mechanism().bodies[k / 6].held[k % 6]
                   ? 0
                   : random.between(-1, 1) * (k % 6 < 3 ? length : 1);
  // dead moments have no energy: their work along the straight line is left out on both sides; the
  // moment of the load is that of its force on its arm
  system.assemble();
  VectorXd moments = VectorXd::Zero(n);
  for (const BodyLoad& load : system.acting()) {
    moments.segment<3>(6 * load.body + 3) += load.moment;
  }
  for (const int k : system.held()) moments[k] = 0;
  const auto move_to = [&](double s) {
    system.restore(state);
    system.move(s * along);
    system.assemble();
    for (int k = 0; k < 20 && system.correction() > 1e-13; ++k) {  // the leaves' interiors follow
      system.move(VectorXd::Zero(n));
      system.assemble();
    }
    return system.correction() <= 1e-12;
  };
  const auto energy_at = [&](double s) {
    move_to(s);
    return system.energy() + system.load_energy();
  };
  const auto force_along = [&] {
    return (system.internal_force() - system.load() + moments).dot(along);
  };
  // the forces that do no work: of joints and drive conditions, the same at every s
  const VectorXd multipliers = system.multipliers();
  // leaves must not buckle on the way, nor come near it: up to twice as far they stay stable, and
  // the force grows evenly
  const auto unstable = [&] {
    int negative = 0;
    for (int i = 0; i < system.leaves(); ++i)
      negative += system.leaf(i).evaluation().negative_pivots;
    return negative;
  };
  double h = 6e-5;
  move_to(0);
  const double here = force_along();
  const int at_rest_unstable = unstable();
  const auto even = [&](double way) {
    std::array<double, 2> force{};
    for (const int side : {0, 1}) {
      if (!move_to(side == 0 ? way : -way) || unstable() != at_rest_unstable) return false;
      force[static_cast<std::size_t>(side)] = force_along();
    }
    return std::abs(force[0] + force[1] - 2 * here) <= 0.01 * std::abs(force[0] - force[1]);
  };
  while (h > 1e-6 && !even(2 * h)) h *= 0.5;
  const auto potential = [&](double s) {
    const double value = energy_at(s);
    return value + (multipliers.size() > 0 ? multipliers.dot(system.constraints().value()) : 0);
  };
  const auto first = ridders([&](double s) { return std::vector<double>{potential(s)}; }, 0, h, 4);
  system.restore(state);
  system.assemble();
  const VectorXd gradient = system.internal_force() - system.load() + moments;
  const double curvature = along.dot((system.tangent() * along).col(0));
  const double scale =
      along.cwiseAbs().dot(system.internal_force().cwiseAbs()) + 1e-4 * std::abs(curvature);
  Deviation worst;
  // bending energies are differences of large numbers: what is left of the potential without its
  // slope on a way that is much shorter
  const double slope = gradient.dot(along), middle = potential(0);
  double noise = 0;
  for (const double s : {-3e-9, -2e-9, -1e-9, 1e-9, 2e-9, 3e-9})
    noise = std::max(noise, std::abs(potential(s) - middle - s * (slope + 0.5 * s * curvature)));
  worst.rounding = 1e-2 * noise / (h * scale);
  worst.add(std::max(0.0, std::abs(slope - first.value[0]) - 10 * first.error[0]), scale,
            "gradient of the energy");
  const auto second = ridders(
      [&](double s) {
        energy_at(s);
        // along the same straight line of rotation vectors: exp(s hat δ) turns about one axis, and
        // the spin of the way is δ all along
        return std::vector<double>{force_along()};
      },
      0, h, 4);
  worst.add(std::max(0.0, std::abs(curvature - second.value[0]) - 10 * second.error[0]),
            std::abs(curvature), "Hessian of the energy");
  return worst;
}

}  // namespace flexopt::laws
