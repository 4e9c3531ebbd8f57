#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/mechanism/drive.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/record_table.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

/// Loads at O that are increased, and to what.
struct CapacitySpec {
  std::vector<std::string> directions, supports;
  std::optional<double> stress, stiffness_share, largest_force, largest_moment;
};

/// Index in CapacityRule::directions of a name with or without a sign.
std::size_t index_of(const std::string& name) {
  const bool against = name.starts_with('-');
  const auto found = std::ranges::find(direction_names, std::string_view(name).substr(against));
  return static_cast<std::size_t>(found - direction_names.begin()) + (against ? 6 : 0);
}

const RecordTable<CapacitySpec>& capacity_table() {
  using namespace shape;
  const std::vector<std::string> supports(direction_names.begin(), direction_names.end());
  std::vector<std::string> both = supports;
  for (const std::string& name : supports) both.push_back("-" + name);
  static const auto table =
      RecordTable<CapacitySpec>()
          .required("directions", list(choice(both), 1, both.size()), &CapacitySpec::directions,
                    "of the load at O: a force along ux, uy, uz, a moment about rx, ry, "
                    "rz, with - the other way")
          .optional("stress", quantity("Pa", 0, largest_number, true), &CapacitySpec::stress,
                    "limit of the stress of all leaves; default: the yield_strength of each, where "
                    "its material has one")
          .optional("stiffness_share", quantity("1", 0, 1, true, true),
                    &CapacitySpec::stiffness_share,
                    "of a support stiffness without the load, to which it may fall; default: it "
                    "is not looked at")
          .optional("supports", list(choice(supports), 1, 6), &CapacitySpec::supports,
                    "whose stiffness counts; default: all")
          .optional("largest_force", quantity("N", 0, largest_number, true),
                    &CapacitySpec::largest_force,
                    "up to which it is looked; default: as far as it goes")
          .optional("largest_moment", quantity("N m", 0, largest_number, true),
                    &CapacitySpec::largest_moment, "likewise");
  return table;
}

/// Why no load along it does anything, or nothing.
const char* without_effect(std::size_t direction, const Mechanism& mechanism) {
  const std::size_t d = direction % 6;
  if (prescribed_directions(mechanism)[d])
    return "a drive holds the end-effector in this direction";
  if (mechanism.bodies[static_cast<std::size_t>(mechanism.end_effector)].held[d])
    return "the end-effector cannot move in this direction";
  return nullptr;
}

}  // namespace

Field load_capacity_field() {
  return shape::optional("load_capacity", capacity_table().shape(),
                         "at every point the largest load at O beside those that act");
}

void read_load_capacity(const json& read, const Mechanism& mechanism, FaultList& faults,
                        StrokeRequest& request) {
  if (!read.contains("load_capacity") || !faults.sound("/load_capacity")) return;
  const Pointer at("/load_capacity");
  const CapacitySpec spec = capacity_table().read(read["load_capacity"]);
  CapacityRule& rule = request.capacity;
  if (!request.loads.driven()) {
    faults.add(at, shown(read["load_capacity"]["directions"]),
               "loads are increased with the drives held: give a stroke, not a load_path");
    return;
  }
  for (std::size_t i = 0; i < spec.directions.size(); ++i) {
    const std::size_t direction = index_of(spec.directions[i]);
    const std::string here = (at / "directions" / i).to_string();
    if (const char* why = without_effect(direction, mechanism))
      faults.add(here, shown(spec.directions[i]), why);
    else if (rule.directions[direction])
      faults.add(here, shown(spec.directions[i]), "it is listed before");
    rule.directions[direction] = true;
  }
  rule.stress = spec.stress;
  rule.stiffness_share = spec.stiffness_share.value_or(0);
  rule.largest_force = spec.largest_force;
  rule.largest_moment = spec.largest_moment;
  if (spec.supports.empty()) return;
  if (!spec.stiffness_share)
    faults.add(at / "supports", shown(read["load_capacity"]["supports"]),
               "it is said of which stiffness a share counts: give stiffness_share, too");
  rule.supports = {};
  for (std::size_t i = 0; i < spec.supports.size(); ++i) {
    const std::size_t support = index_of(spec.supports[i]);
    if (const char* why = without_effect(support, mechanism))
      faults.add(at / "supports" / i, shown(spec.supports[i]), why);
    rule.supports[support] = true;
  }
}

}  // namespace flexopt
