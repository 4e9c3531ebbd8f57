#include "core/response/actuators.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/dual.hpp"
#include "core/response/quantity_readers.hpp"

namespace flexopt {
namespace {

constexpr double rounding = 1e-9;  // of a gain, and of the part of its stroke that a piezo gives

// (S39): current and power.
template <class S>
std::array<S, 2> coil_numbers(const VoiceCoilT<S>& coil, const S& load) {
  const S current = load / coil.motor_constant;
  return {current, coil.resistance * current * current};
}

// (S40): the stroke that is left, and the share of the full voltage.
template <class S>
std::array<S, 2> stack_numbers(const PiezoStackT<S>& stack, double stroke, const S& load) {
  return {stroke - load / stack.stiffness(), stroke / stack.free_stroke};
}

// (S41), of a drive of this stiffness that moves O by `gain`.
template <class S>
S amplification(const PiezoStackT<S>& stack, const S& stiffness, const S& gain) {
  return gain / (1.0 - stiffness / stack.stiffness());
}

Dual1 with_rate(double value, double rate) { return {value, {rate}}; }

// Numbers of the actuator with their rates along one direction.
VoiceCoilT<Dual1> moving(const VoiceCoilT<double>& coil, const VoiceCoilT<double>& rate) {
  return {with_rate(coil.motor_constant, rate.motor_constant),
          with_rate(coil.resistance, rate.resistance)};
}
PiezoStackT<Dual1> moving(const PiezoStackT<double>& stack, const PiezoStackT<double>& rate) {
  return {with_rate(stack.free_stroke, rate.free_stroke),
          with_rate(stack.blocking_force, rate.blocking_force)};
}

}  // namespace

bool has_actuators(const Mechanism& mechanism) {
  return std::ranges::any_of(mechanism.drives,
                             [](const Drive& d) { return d.voice_coil || d.piezo; });
}

void set_actuators(const Mechanism& mechanism, const MatrixXd& motions, PathPoint& point) {
  const std::size_t drives = mechanism.drives.size();
  point.voice_coil.assign(2 * drives, std::nullopt);
  point.piezo.assign(3 * drives, std::nullopt);
  for (std::size_t k = 0; k < point.strokes.size(); ++k) {
    const Drive& drive = mechanism.drives[k];
    if (drive.voice_coil) {
      const auto of_coil = coil_numbers(*drive.voice_coil, point.drive_loads[k]);
      for (std::size_t i = 0; i < 2; ++i) point.voice_coil[2 * k + i] = of_coil[i];
    }
    if (!drive.piezo) continue;
    const auto of_stack = stack_numbers(*drive.piezo, point.strokes[k], point.drive_loads[k]);
    for (std::size_t i = 0; i < 2; ++i) point.piezo[3 * k + i] = of_stack[i];
    const double stiffness = point.drive_stiffnesses[k],
                 gain = motions.col(static_cast<Eigen::Index>(k)).head<3>().norm();
    if (gain > rounding && 1 - stiffness / drive.piezo->stiffness() > rounding)
      point.piezo[3 * k + 2] = amplification(*drive.piezo, stiffness, gain);
  }
}

void set_actuator_gradients(const Mechanism& mechanism, const std::vector<Mechanism>& directions,
                            const MatrixXd& motions, const PathPoint& point,
                            PointGradients& gradients) {
  const auto count = static_cast<Eigen::Index>(directions.size());
  gradients.voice_coil.assign(point.voice_coil.size(), std::nullopt);
  gradients.piezo.assign(point.piezo.size(), std::nullopt);
  const bool amplified = gradients.gain.rows() > 0 && gradients.drive_stiffnesses.rows() > 0;
  for (std::size_t k = 0; k < point.strokes.size(); ++k) {
    const Drive& drive = mechanism.drives[k];
    const auto row = static_cast<Eigen::Index>(k);
    const auto take = [&](std::optional<VectorXd>& of, Eigen::Index p, const Dual1& number) {
      if (!of) of = VectorXd::Zero(count);
      (*of)[p] = number.derivatives[0];
    };
    for (Eigen::Index p = 0; p < count; ++p) {
      const Drive& rate = directions[static_cast<std::size_t>(p)].drives[k];
      const Dual1 load = with_rate(point.drive_loads[k], gradients.drive_loads(row, p));
      if (drive.voice_coil) {
        const auto of_coil = coil_numbers(moving(*drive.voice_coil, *rate.voice_coil), load);
        for (std::size_t i = 0; i < 2; ++i) take(gradients.voice_coil[2 * k + i], p, of_coil[i]);
      }
      if (!drive.piezo) continue;
      const PiezoStackT<Dual1> stack = moving(*drive.piezo, *rate.piezo);
      const auto of_stack = stack_numbers(stack, point.strokes[k], load);
      for (std::size_t i = 0; i < 2; ++i) take(gradients.piezo[3 * k + i], p, of_stack[i]);
      if (!amplified || !point.piezo[3 * k + 2]) continue;
      const Vector3d motion = motions.col(row).head<3>();
      const double gain = motion.norm();
      take(gradients.piezo[3 * k + 2], p,
           amplification(
               stack, with_rate(point.drive_stiffnesses[k], gradients.drive_stiffnesses(row, p)),
               with_rate(gain, motion.dot(gradients.gain.col(p).segment<3>(6 * row)) / gain)));
    }
  }
}

std::vector<QuantityRow> actuator_rows() {
  return {
      {.name = "voice_coil",
       .components = {"current", "power"},
       .layout = Layout::object,
       .label = "voice coil,",
       .meaning = "current: drive load over motor constant; power: what the winding turns to heat",
       .needs = {Output::equilibrium},
       .unit = [](Direction, int k) -> std::string { return k == 0 ? "A" : "W"; },
       .value = entry<&PathPoint::voice_coil>,
       .gradient = entry<&PointGradients::voice_coil>,
       .of_drives = true,
       .of_kind = &DriveList::Item::voice_coil,
       .in_report = true},
      {.name = "piezo",
       .components = {"stroke", "voltage_share", "amplification"},
       .layout = Layout::object,
       .label = "piezo stack,",
       .meaning = "stroke: that which is left of the drive's stroke, by which the stack would grow "
                  "without load; voltage_share: stroke of the drive over the free stroke; "
                  "amplification: motion of O for a small further stroke that is left",
       .needs = {Output::equilibrium, Output::stiffness, Output::gain},
       .unit = [](Direction, int k) -> std::string { return k == 0 ? "m" : "1"; },
       .value = entry<&PathPoint::piezo>,
       .gradient = entry<&PointGradients::piezo>,
       .of_drives = true,
       .of_kind = &DriveList::Item::piezo,
       .in_report = true}};
}

}  // namespace flexopt
