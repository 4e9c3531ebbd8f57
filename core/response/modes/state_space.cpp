#include "core/response/modes/state_space.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/response/modes/mechanism_factor.hpp"
#include "core/response/modes/point_forces.hpp"

namespace flexopt {
namespace {

std::string name_of_drive(const MechanismFactor& factor, std::size_t k, const char* what) {
  const std::string& name = factor.system().mechanism().drives[k].name;
  return name.empty() ? what : fmt::format("{}.{}", what, name);
}

// The signals of points: motions, or the loads that do work on them.
void add_points(const std::vector<NamedPoint>& points, bool loads, std::vector<Signal>& signals) {
  for (const NamedPoint& point : points) {
    const std::string name = fmt::format("{}.{}", point.kind, point.name);
    const char* unit = loads ? (point.turns() ? "N m" : "N") : (point.turns() ? "rad" : "m");
    if (point.direction)
      signals.push_back({name, unit});
    else
      for (const char axis : {'x', 'y', 'z'})
        signals.push_back({fmt::format("{}.{}", name, axis), unit});
  }
}

std::vector<Signal> inputs_of(const MechanismFactor& factor,
                              const std::vector<NamedPoint>& points) {
  std::vector<Signal> inputs;
  const std::vector<Drive>& drives = factor.system().mechanism().drives;
  for (std::size_t k = 0; k < drives.size(); ++k)
    inputs.push_back(
        {name_of_drive(factor, k, "drive_load"), is_rotation(drives[k].direction) ? "N m" : "N"});
  for (int d = 0; d < 6; ++d)
    inputs.push_back({fmt::format("ground.{}", direction_names[d]), d < 3 ? "m/s^2" : "rad/s^2"});
  for (int d = 0; d < 6; ++d)
    inputs.push_back({fmt::format("load.{}", direction_names[d]), d < 3 ? "N" : "N m"});
  add_points(points, true, inputs);
  return inputs;
}

std::vector<Signal> outputs_of(const MechanismFactor& factor,
                               const std::vector<NamedPoint>& points) {
  std::vector<Signal> outputs;
  for (int d = 0; d < 6; ++d)
    outputs.push_back({fmt::format("O.{}", direction_names[d]), d < 3 ? "m" : "rad"});
  const std::vector<Drive>& drives = factor.system().mechanism().drives;
  for (std::size_t k = 0; k < drives.size(); ++k)
    outputs.push_back(
        {name_of_drive(factor, k, "stroke"), is_rotation(drives[k].direction) ? "rad" : "m"});
  add_points(points, false, outputs);
  return outputs;
}

// `at_points`: loads on points.
MatrixXd forces_of(const MechanismFactor& factor, const MatrixXd& at_points) {
  const MatrixXd drives = factor.system().drive_forces();
  const Eigen::Index of_drives = drives.cols();
  MatrixXd F = MatrixXd::Zero(factor.size(), of_drives + 12 + at_points.cols());
  F.topLeftCorner(factor.bodies(), of_drives) = drives;
  F.middleCols(of_drives, 6) = -rigid_motion(factor).inertia;
  F.block<6, 6>(6 * factor.system().mechanism().end_effector, of_drives + 6).setIdentity();
  F.rightCols(at_points.cols()) = at_points;
  factor.clear_held(F);
  return F;
}

// Values of all outputs for motions X of all unknowns.
MatrixXd outputs_for(const MechanismFactor& factor, const MatrixXd& at_points, const MatrixXd& X) {
  const MatrixXd strokes = factor.system().drive_forces().transpose();
  MatrixXd Y(6 + strokes.rows() + at_points.cols(), X.cols());
  Y << X.middleRows<6>(6 * factor.system().mechanism().end_effector),
      strokes * X.topRows(factor.bodies()), at_points.transpose() * X;
  return Y;
}

}  // namespace

Answer<StateSpace> state_space(const MechanismFactor& factor, const StateSpaceRequest& request,
                               const std::vector<NamedPoint>& all_points, const FullModes& free,
                               LeafRates& rates) {
  const std::vector<NamedPoint> points = request.sensors ? all_points : std::vector<NamedPoint>();
  const Answer<MatrixXd> at_points = point_forces(factor, points, rates);
  if (!at_points) return Because(at_points.error());
  const int modes = std::min(request.modes, free.converged);
  StateSpace model;
  model.inputs = inputs_of(factor, points);
  model.outputs = outputs_of(factor, points);
  model.omega2 = free.lambda.head(modes);
  model.damping.resize(modes);
  for (int k = 0; k < modes; ++k)
    model.damping[k] = request.damping.size() == 1 ? request.damping.front() : request.damping[k];
  const MatrixXd forces = forces_of(factor, *at_points), phi = free.phi.leftCols(modes);
  MatrixXd X(factor.size(), modes + forces.cols());
  X << phi, factor.solve(forces);
  const MatrixXd Y = outputs_for(factor, *at_points, X);
  model.forces = phi.transpose() * forces;
  model.motions = Y.leftCols(modes);
  model.residual = Y.rightCols(forces.cols()) -
                   model.motions * model.omega2.cwiseInverse().asDiagonal() * model.forces;
  return model;
}

}  // namespace flexopt
