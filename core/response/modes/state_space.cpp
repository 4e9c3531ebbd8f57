#include "core/response/modes/state_space.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/response/modes/mechanism_factor.hpp"

namespace flexopt {
namespace {

std::string name_of_drive(const MechanismFactor& factor, std::size_t k, const char* what) {
  const std::string& name = factor.system().mechanism().drives[k].name;
  return name.empty() ? what : fmt::format("{}.{}", what, name);
}

std::vector<Signal> inputs_of(const MechanismFactor& factor) {
  std::vector<Signal> inputs;
  const std::vector<Drive>& drives = factor.system().mechanism().drives;
  for (std::size_t k = 0; k < drives.size(); ++k)
    inputs.push_back(
        {name_of_drive(factor, k, "drive_load"), is_rotation(drives[k].direction) ? "N m" : "N"});
  for (int d = 0; d < 6; ++d)
    inputs.push_back({fmt::format("ground.{}", direction_names[d]), d < 3 ? "m/s^2" : "rad/s^2"});
  for (int d = 0; d < 6; ++d)
    inputs.push_back({fmt::format("load.{}", direction_names[d]), d < 3 ? "N" : "N m"});
  return inputs;
}

std::vector<Signal> outputs_of(const MechanismFactor& factor, const std::vector<Probe>& probes) {
  std::vector<Signal> outputs;
  for (int d = 0; d < 6; ++d)
    outputs.push_back({fmt::format("O.{}", direction_names[d]), d < 3 ? "m" : "rad"});
  const std::vector<Drive>& drives = factor.system().mechanism().drives;
  for (std::size_t k = 0; k < drives.size(); ++k)
    outputs.push_back(
        {name_of_drive(factor, k, "stroke"), is_rotation(drives[k].direction) ? "rad" : "m"});
  for (const Probe& probe : probes)
    for (const char axis : {'x', 'y', 'z'})
      outputs.push_back({fmt::format("probe.{}.{}", probe.name, axis), "m"});
  return outputs;
}

MatrixXd forces_of(const MechanismFactor& factor) {
  const MatrixXd drives = factor.system().drive_forces();
  const Eigen::Index of_drives = drives.cols();
  MatrixXd F = MatrixXd::Zero(factor.size(), of_drives + 12);
  F.topLeftCorner(factor.bodies(), of_drives) = drives;
  F.middleCols(of_drives, 6) = -rigid_motion(factor).inertia;
  F.block<6, 6>(6 * factor.system().mechanism().end_effector, of_drives + 6).setIdentity();
  factor.clear_held(F);
  return F;
}

// Displacement of a material point of a leaf for motions X of all unknowns, in global axes [m].
Answer<MatrixXd> probe_motion(const MechanismFactor& factor, const Probe& probe, const MatrixXd& X,
                              LeafRates& rates) {
  const MechanismFactor::Leaf& leaf = factor.leaves()[probe.leaf];
  const auto gradient = leaf.linear->gradient(rates, leaf.rows);
  if (!gradient) return Because(gradient.error());
  LeafVariation<double> none;  // a leaf as it is: only its state moves
  none.shape = VectorXd::Zero(ShapeParameter::sizes);
  const auto fields = (*gradient)->fields(
      factor.leaf_rows(leaf, X),
      std::vector<LeafVariation<double>>(static_cast<std::size_t>(X.cols()), none));
  const LeafScale& scale = leaf.linear->scale();
  return scale.length * scale.axes * fields->place_rates(probe.along, probe.across);
}

// Values of all outputs for motions X of all unknowns.
Answer<MatrixXd> outputs_for(const MechanismFactor& factor, const std::vector<Probe>& probes,
                             const MatrixXd& X, LeafRates& rates) {
  const MatrixXd strokes = factor.system().drive_forces().transpose();
  const auto of_probes = static_cast<Eigen::Index>(probes.size());
  MatrixXd Y(6 + strokes.rows() + 3 * of_probes, X.cols());
  Y.topRows(6) = X.middleRows<6>(6 * factor.system().mechanism().end_effector);
  Y.middleRows(6, strokes.rows()) = strokes * X.topRows(factor.bodies());
  for (Eigen::Index k = 0; k < of_probes; ++k) {
    const Probe& probe = probes[k];
    const Answer<MatrixXd> motion = probe_motion(factor, probe, X, rates);
    if (!motion) return Because(fmt::format("probe {}: {}", probe.name, motion.error()));
    Y.middleRows(6 + strokes.rows() + 3 * k, 3) = *motion;
  }
  return Y;
}

}  // namespace

Answer<StateSpace> state_space(const MechanismFactor& factor, const StateSpaceRequest& request,
                               const std::vector<Probe>& all_probes, const FullModes& free,
                               LeafRates& rates) {
  const std::vector<Probe> probes = request.probes ? all_probes : std::vector<Probe>();
  const int modes = std::min(request.modes, free.converged);
  StateSpace model;
  model.inputs = inputs_of(factor);
  model.outputs = outputs_of(factor, probes);
  model.omega2 = free.lambda.head(modes);
  model.damping.resize(modes);
  for (int k = 0; k < modes; ++k)
    model.damping[k] = request.damping.size() == 1 ? request.damping.front() : request.damping[k];
  const MatrixXd forces = forces_of(factor), phi = free.phi.leftCols(modes);
  MatrixXd X(factor.size(), modes + forces.cols());
  X << phi, factor.solve(forces);
  const Answer<MatrixXd> Y = outputs_for(factor, probes, X, rates);
  if (!Y) return Because(Y.error());
  model.forces = phi.transpose() * forces;
  model.motions = Y->leftCols(modes);
  model.residual = Y->rightCols(forces.cols()) -
                   model.motions * model.omega2.cwiseInverse().asDiagonal() * model.forces;
  return model;
}

}  // namespace flexopt
