#include <algorithm>
#include <array>
#include <bitset>
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
  DriveState drive = DriveState::locked;
  std::optional<double> stress, stiffness_share, largest_force, largest_moment;
};

constexpr const char* share_is_missing =
    "it is said of which stiffness a share counts: give stiffness_share, too";

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
          .optional_choice<DriveState>(
              "drive", {{"locked", DriveState::locked}, {"free", DriveState::free}},
              &CapacitySpec::drive,
              "while the load grows: held at its stroke, or free under the load that it has; "
              "default: locked, along a load_path free")
          .optional("stress", quantity("Pa", 0, largest_number, true), &CapacitySpec::stress,
                    "limit of the stress of all leaves and elastic bodies; default: the "
                    "yield_strength of each, where "
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

/// How far a drive goes.
struct StrokeCapacitySpec {
  std::vector<std::string> ways, supports;
  std::optional<double> up_to, stress, stiffness_share, clearance, drive_load;
};
constexpr std::array ways_of_drive{"forward", "backward"};

RecordTable<StrokeCapacitySpec> stroke_capacity_table(std::optional<Direction> drive) {
  using namespace shape;
  using Spec = StrokeCapacitySpec;
  const Shape place = drive ? stroke_place(*drive) : quantity("");
  return RecordTable<Spec>()
      .optional("up_to", drive ? quantity(place.unit, 0, place.max, true, place.open_max) : place,
                &Spec::up_to,
                "where the search ends, either way; default: the length of the longest leaf, or "
                "1 rad")
      .optional("ways", list(choice({ways_of_drive.begin(), ways_of_drive.end()}), 1, 2),
                &Spec::ways, "which are looked at; default: both")
      .optional("stress", quantity("Pa", 0, largest_number, true), &Spec::stress,
                "limit of the stress of all leaves and elastic bodies, with the fillet if the job "
                "has one; default: "
                "safeties of 1 against yield and fatigue, where all materials have what they need")
      .optional("stiffness_share", quantity("1", 0, 1, true, true), &Spec::stiffness_share,
                "of a support stiffness at rest, to which it may fall; default: it is not looked "
                "at")
      .optional("supports", list(choice({direction_names.begin(), direction_names.end()}), 1, 6),
                &Spec::supports, "whose stiffness counts; default: all")
      .optional("clearance", quantity("m", 0, 100, true), &Spec::clearance,
                "smallest distance between parts that must remain; default: it is not looked at")
      .optional(
          "drive_load", drive ? quantity(load_unit(*drive), 0, largest_number, true) : quantity(""),
          &Spec::drive_load, "largest load of the drive, in size; default: it is not looked at");
}

/// Why no load along it does anything, or nothing. `held`: drives that are not let go of either.
const char* without_effect(std::size_t direction, const Mechanism& mechanism, DriveState drive,
                           const std::bitset<6>& held = {}) {
  const std::size_t d = direction % 6;
  if (prescribed_directions(mechanism, held)[d])
    return "a drive of \"held\" holds the end-effector in this direction";
  if (drive == DriveState::locked && prescribed_directions(mechanism)[d])
    return "a drive holds the end-effector in this direction; \"drive\": \"free\" lets go of it";
  if (mechanism.bodies[static_cast<std::size_t>(mechanism.end_effector)].held[d])
    return "the end-effector cannot move in this direction";
  return nullptr;
}

}  // namespace

Field load_capacity_field() {
  return shape::optional("load_capacity", capacity_table().shape(),
                         "at every point the largest load at O beside those that act");
}

Field stroke_capacity_field(const DriveList* drives) {
  Shape shape =
      stroke_capacity_table(drives ? std::optional(drives->first()) : std::nullopt).shape();
  if (drives && drives->named()) {
    std::vector<Field> each;
    for (const DriveList::Item& drive : drives->items)
      each.push_back(shape::optional(drive.name, stroke_capacity_table(drive.direction).shape(),
                                     "of " + drive.name + ", the other drives at rest"));
    shape = shape::record(std::move(each));
  }
  return shape::optional("stroke_capacity", std::move(shape),
                         "the largest stroke from rest; of drives with names under these");
}

void read_load_capacity(const json& read, const Mechanism& mechanism, FaultList& faults,
                        StrokeRequest& request) {
  if (!read.contains("load_capacity") || !faults.sound("/load_capacity")) return;
  const Pointer at("/load_capacity");
  const CapacitySpec spec = capacity_table().read(read["load_capacity"]);
  CapacityRule& rule = request.capacity;
  const bool driven = request.loads.driven();
  rule.drive = spec.drive;
  if (!driven && !read["load_capacity"].contains("drive"))
    rule.drive = DriveState::free;
  else if (!driven && rule.drive == DriveState::locked)
    faults.add(at / "drive", shown(read["load_capacity"]["drive"]),
               "along a load_path the drives are free");
  for (std::size_t i = 0; i < spec.directions.size(); ++i) {
    const std::size_t direction = index_of(spec.directions[i]);
    const std::string here = (at / "directions" / i).to_string();
    if (const char* why = without_effect(direction, mechanism, rule.drive, request.loads.held))
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
    faults.add(at / "supports", shown(read["load_capacity"]["supports"]), share_is_missing);
  rule.supports = {};
  for (std::size_t i = 0; i < spec.supports.size(); ++i) {
    const std::size_t support = index_of(spec.supports[i]);
    if (const char* why = without_effect(support, mechanism, DriveState::locked))
      faults.add(at / "supports" / i, shown(spec.supports[i]), why);
    rule.supports[support] = true;
  }
}

namespace {

StrokeCapacityRule stroke_capacity_rule(const json& read, std::size_t drive,
                                        const Mechanism& mechanism, const Pointer& at,
                                        FaultList& faults) {
  const Direction direction = mechanism.drives[drive].direction;
  const StrokeCapacitySpec spec = stroke_capacity_table(direction).read(read);
  StrokeCapacityRule rule{
      .drive = static_cast<int>(drive),
      .up_to = spec.up_to.value_or(is_rotation(direction) ? 1 : longest_leaf(mechanism)),
      .stress = spec.stress,
      .stiffness_share = spec.stiffness_share.value_or(0),
      .clearance = spec.clearance,
      .drive_load = spec.drive_load};
  const auto listed = [](const auto& names, const std::string& name) {
    return names.empty() || std::ranges::find(names, name) != names.end();
  };
  for (std::size_t way = 0; way < ways_of_drive.size(); ++way)
    rule.ways[way] = listed(spec.ways, ways_of_drive[way]);
  for (std::size_t d = 0; d < rule.supports.size(); ++d)
    rule.supports[d] = listed(spec.supports, std::string(direction_names[d]));
  if (!spec.supports.empty() && !spec.stiffness_share)
    faults.add(at / "supports", shown(read["supports"]), share_is_missing);
  for (std::size_t i = 0; i < spec.supports.size(); ++i)
    if (const char* why = without_effect(index_of(spec.supports[i]), mechanism, DriveState::locked))
      faults.add(at / "supports" / i, shown(spec.supports[i]), why);
  return rule;
}

}  // namespace

void read_stroke_capacity(const json& read, const Mechanism& mechanism, FaultList& faults,
                          StrokeRequest& request) {
  if (!read.contains("stroke_capacity") || !faults.sound("/stroke_capacity")) return;
  const Pointer at("/stroke_capacity");
  const json& section = read["stroke_capacity"];
  if (mechanism.drives.empty()) {
    faults.add(at, shown(section), "a drive makes the stroke, and the mechanism has none");
    return;
  }
  const DriveList drives(mechanism);
  for (std::size_t k = 0; k < mechanism.drives.size(); ++k) {
    const std::string& name = mechanism.drives[k].name;
    if (!drives.named())
      request.stroke_capacity.push_back(stroke_capacity_rule(section, k, mechanism, at, faults));
    else if (section.contains(name))
      request.stroke_capacity.push_back(
          stroke_capacity_rule(section[name], k, mechanism, at / name, faults));
  }
}

}  // namespace flexopt
