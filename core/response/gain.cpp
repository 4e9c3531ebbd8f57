#include "core/response/gain.hpp"

#include "core/mechanism/drive.hpp"
#include "core/response/quantity_readers.hpp"

namespace flexopt {
namespace {

QuantityRow motion_row(std::string name, std::string label, std::string meaning) {
  return {.name = std::move(name),
          .components = {direction_names.begin(), direction_names.end()},
          .layout = Layout::object,
          .label = std::move(label),
          .meaning = std::move(meaning),
          .needs = {Output::equilibrium, Output::gain},
          .unit = [](Direction drive, int d) -> std::string {
            const bool turned = is_rotation(static_cast<Direction>(d));
            return turned == is_rotation(drive) ? "1" : turned ? "rad/m" : "m/rad";
          },
          .of_supports = true,
          .of_drives = true,
          .in_report = true};
}

}  // namespace

std::optional<int> output_of(const Drive& drive, const Vector6d& motion) {
  constexpr double rounding = 1e-9, alike = 1e-6;
  const int first = is_rotation(drive.direction) ? 3 : 0;
  const Vector3d sizes = motion.segment<3>(first).cwiseAbs();
  int largest = 0;  // the first of axes that rounding alone tells apart
  for (int k = 1; k < 3; ++k)
    if (sizes[k] > (1 + alike) * sizes[largest]) largest = k;
  if (!(sizes[largest] > rounding)) return std::nullopt;
  return first + largest;
}

void set_gain(const Mechanism& mechanism, const MatrixXd& motions, PathPoint& point) {
  const std::array<bool, 6> prescribed = prescribed_directions(mechanism);
  point.gain.assign(6 * mechanism.drives.size(), std::nullopt);
  point.cross_coupling = point.gain;
  for (std::size_t k = 0; k < mechanism.drives.size(); ++k) {
    const Vector6d motion = motions.col(static_cast<Eigen::Index>(k));
    const bool remote = !end_effector_direction(mechanism, mechanism.drives[k]);
    const std::optional<int> output = output_of(mechanism.drives[k], motion);
    for (std::size_t d = 0; d < 6; ++d) {
      if (prescribed[d]) continue;
      if (remote) point.gain[6 * k + d] = motion[d];
      if (output) point.cross_coupling[6 * k + d] = motion[d] / motion[*output];
    }
  }
}

void set_gain_gradients(const Mechanism& mechanism, const MatrixXd& motions, const MatrixXd& rates,
                        PointGradients& gradients) {
  gradients.gain = rates;
  gradients.cross_coupling = MatrixXd::Zero(rates.rows(), rates.cols());
  for (Eigen::Index k = 0; k < motions.cols(); ++k) {
    const Vector6d motion = motions.col(k);
    const auto output = output_of(mechanism.drives[static_cast<std::size_t>(k)], motion);
    if (!output) continue;
    const auto of_drive = rates.middleRows<6>(6 * k);
    gradients.cross_coupling.middleRows<6>(6 * k) =
        (of_drive - motion / motion[*output] * of_drive.row(*output)) / motion[*output];
  }
}

std::vector<QuantityRow> gain_rows() {
  QuantityRow gain = motion_row(
      "gain", "gain",
      "derivative of the end-effector's motion in a direction (displacement of O, spin, along "
      "global axes) by the stroke of a drive that acts elsewhere, other drives locked; along the "
      "output of an amplifier its amplification ratio");
  gain.value = entry<&PathPoint::gain>;
  gain.gradient = rate_row<&PointGradients::gain>;
  gain.of_kind = &DriveList::Item::remote;
  QuantityRow coupling = motion_row(
      "cross_coupling", "cross-coupling",
      "motion of the end-effector in a direction over that along the output of the drive, while "
      "this drive alone moves on; the output is the global axis along which a sliding drive moves "
      "O most, or about which a turning one turns the end-effector most");
  coupling.value = entry<&PathPoint::cross_coupling>;
  coupling.gradient = rate_row<&PointGradients::cross_coupling>;
  return {gain, coupling};
}

}  // namespace flexopt
