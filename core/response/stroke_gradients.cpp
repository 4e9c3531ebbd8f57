#include "core/response/stroke_gradients.hpp"

#include <algorithm>
#include <cassert>
#include <charconv>

namespace flexopt {
namespace {

std::optional<VectorXd> row(const MatrixXd& rows, Eigen::Index k) {
  if (k < 0 || k >= rows.rows()) return std::nullopt;
  return VectorXd(rows.row(k));
}

std::optional<VectorXd> filled(const VectorXd& gradient) {
  if (gradient.size() == 0) return std::nullopt;
  return gradient;
}

/// What follows the prefix in the name; nothing where the name does not begin with it.
std::optional<std::string_view> after(std::string_view name, std::string_view prefix) {
  if (!name.starts_with(prefix)) return std::nullopt;
  return name.substr(prefix.size());
}

Eigen::Index number(std::string_view text) {
  Eigen::Index k = -1;
  std::from_chars(text.data(), text.data() + text.size(), k);
  return k;
}

}  // namespace

std::optional<VectorXd> gradient_of(const PointGradients& point, std::string_view name) {
  if (name == "drive_load") return filled(point.drive_load);
  if (name == "drive_stiffness") return filled(point.drive_stiffness);
  if (name == "parasitic_frequency") return point.parasitic_frequency;
  if (name == "parasitic_frequency_screening") return point.parasitic_frequency_screening;
  if (name == "max_stress") return point.max_stress;
  if (const auto axis = after(name, "displacement."))
    return row(point.displacement, axis->front() - 'x');
  if (const auto axis = after(name, "rotation.")) return row(point.rotation, axis->front() - 'x');
  if (const auto rank = after(name, "frequencies.drive_free."))
    return row(point.frequencies_free, number(*rank));
  if (const auto rank = after(name, "frequencies.drive_locked."))
    return row(point.frequencies_locked, number(*rank));
  const auto direction = after(name, "support_stiffness.");
  assert(direction);
  const auto found = std::find(direction_names.begin(), direction_names.end(), *direction);
  assert(found != direction_names.end());
  return point.support_stiffness[static_cast<std::size_t>(found - direction_names.begin())];
}

}  // namespace flexopt
