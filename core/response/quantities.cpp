#include <algorithm>
#include <cassert>
#include <functional>

#include "core/response/response.hpp"

namespace flexopt {
namespace {

using Getter = std::function<std::optional<double>(const PathPoint&)>;
struct Entry {
  Quantity quantity;
  Getter get;
};

std::optional<double> at(const std::vector<double>& list, int k) {
  if (k >= static_cast<int>(list.size())) return std::nullopt;
  return list[k];
}

std::vector<Entry> make_entries() {
  std::vector<Entry> entries;
  auto add = [&](std::string name, std::string unit, Getter get) {
    entries.push_back({{std::move(name), std::move(unit)}, std::move(get)});
  };
  // "generalised": the unit depends on whether the direction is a rotation
  add("drive_load", "load", [](const PathPoint& p) { return p.drive_load; });
  add("drive_stiffness", "stiffness", [](const PathPoint& p) { return p.drive_stiffness; });
  for (int d = 0; d < 6; ++d)
    add("support_stiffness." + std::string(direction_names[d]), d < 3 ? "N/m" : "N m/rad",
        [d](const PathPoint& p) { return p.support_stiffness[d]; });
  const char* axes = "xyz";
  for (int k = 0; k < 3; ++k)
    add(std::string("displacement.") + axes[k], "m",
        [k](const PathPoint& p) { return p.displacement[k]; });
  for (int k = 0; k < 3; ++k)
    add(std::string("rotation.") + axes[k], "rad",
        [k](const PathPoint& p) { return p.rotation[k]; });
  add("parasitic_frequency", "Hz", [](const PathPoint& p) { return p.parasitic_frequency; });
  add("parasitic_frequency_screening", "Hz",
      [](const PathPoint& p) { return p.parasitic_frequency_screening; });
  for (int k = 0; k < 12; ++k)
    add("frequencies.drive_free." + std::to_string(k), "Hz",
        [k](const PathPoint& p) { return at(p.frequencies_free, k); });
  for (int k = 0; k < 12; ++k)
    add("frequencies.drive_locked." + std::to_string(k), "Hz",
        [k](const PathPoint& p) { return at(p.frequencies_locked, k); });
  add("max_stress", "Pa", [](const PathPoint& p) -> std::optional<double> {
    if (!p.max_stress) return std::nullopt;
    return p.max_stress->value;
  });
  return entries;
}

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list = make_entries();
  return list;
}

}  // namespace

bool is_parasitic(const Mode& mode, const StrokeRequest& request) {
  switch (mode.kind) {
    case ModeKind::drive:
      return false;
    case ModeKind::leaf:
      return !request.parasitic_skips_leaf_modes;
    case ModeKind::intermediate_body:
      return !request.parasitic_skips_intermediate_modes;
    case ModeKind::end_effector:
      break;
  }
  return true;
}

std::vector<Quantity> quantities(Direction drive) {
  std::vector<Quantity> list;
  for (const Entry& e : entries()) {
    Quantity q = e.quantity;
    if (q.name == "support_stiffness." + std::string(direction_names[index(drive)])) continue;
    if (q.unit == "load") q.unit = is_rotation(drive) ? "N m" : "N";
    if (q.unit == "stiffness") q.unit = is_rotation(drive) ? "N m/rad" : "N/m";
    list.push_back(q);
  }
  return list;
}

std::optional<double> value_of(const PathPoint& point, std::string_view name) {
  if (point.status != PointStatus::converged && name != "parasitic_frequency_screening")
    return std::nullopt;
  const auto& list = entries();
  const auto entry = std::find_if(list.begin(), list.end(),
                                  [&](const Entry& e) { return e.quantity.name == name; });
  assert(entry != list.end());
  return entry->get(point);
}

}  // namespace flexopt
