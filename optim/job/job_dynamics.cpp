#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "core/mechanism/drive.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/record_table.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

constexpr double highest_frequency = 1e9;  // [Hz]: larger ones are slips of the pen
constexpr int most_modes = 60;

Shape ratio(bool undamped_too) { return shape::quantity("1", 0, 1, !undamped_too, true); }

const RecordTable<TransmissibilityRule>& transmissibility_table() {
  const Shape frequency = shape::quantity("Hz", 0, highest_frequency, true);
  const auto read_direction = [](const json& read, TransmissibilityRule& rule) {
    for (int d = 0; d < 3; ++d)
      if (read == direction_names[static_cast<std::size_t>(d)])
        rule.direction = static_cast<Direction>(d);
  };
  static const auto table =
      RecordTable<TransmissibilityRule>()
          .row(shape::required("direction", shape::choice({"ux", "uy", "uz"}),
                               "translation of the ground, and of O"),
               read_direction)
          .required("from", frequency, &TransmissibilityRule::from, "lower end of the band")
          .required("to", frequency, &TransmissibilityRule::to, "upper end of the band")
          .choice<DriveState>("drive", {{"free", DriveState::free}, {"locked", DriveState::locked}},
                              &TransmissibilityRule::drive,
                              "whether the drives' loads are constant or their strokes")
          .other(shape::optional("point", shape::text(100),
                                 "name of a point with a translation whose motion counts in "
                                 "place of O's"));
  return table;
}

const RecordTable<TransferRule>& transfer_table() {
  static const auto table =
      RecordTable<TransferRule>()
          .other(shape::required("from", shape::text(100),
                                 "point at which the load acts, or which is moved; or \"ground\", "
                                 "which moves along the direction of the other point"))
          .other(shape::required("to", shape::text(100), "point whose motion is wanted"))
          .choice<DriveState>("drive", {{"free", DriveState::free}, {"locked", DriveState::locked}},
                              &TransferRule::drive,
                              "whether the drives' loads are constant or their strokes")
          .choice<bool>("excitation", {{"load", false}, {"motion", true}}, &TransferRule::of_motion,
                        "what is given at the first point; of the ground a motion")
          .optional("name", shape::text(100), &TransferRule::name,
                    "of its quantities; default: FROM.TO, with .motion and .locked where these "
                    "are asked for");
  return table;
}

const RecordTable<DynamicsRule>& dynamics_table() {
  static const auto table =
      RecordTable<DynamicsRule>()
          .with_default("damping", ratio(false), &DynamicsRule::damping,
                        "damping ratio of every mode")
          .other(shape::optional("transmissibility", transmissibility_table().shape(),
                                 "the largest gain from the ground to O over a band"))
          .other(shape::optional(
              "transfers", shape::list(transfer_table().shape(), 1, 100),
              "compliance, or ratio of motions, and bandwidth from point to point"));
  return table;
}

const RecordTable<StateSpaceRequest>& state_space_table() {
  const auto read_damping = [](const json& read, StateSpaceRequest& request) {
    if (read.is_array())
      request.damping = read.get<std::vector<double>>();
    else
      request.damping = {read.get<double>()};
  };
  static const auto table =
      RecordTable<StateSpaceRequest>()
          .with_default("modes", shape::integer(1, most_modes), &StateSpaceRequest::modes,
                        "that are kept, drive free; the others count by their static answers")
          .row(shape::optional(
                   "damping", shape::one_of({ratio(true), shape::list(ratio(true), 1, most_modes)}),
                   "damping ratio of all modes, or of one after the other; default "
                   "that of dynamics, or 0.01"),
               read_damping)
          .with_default("sensors", shape::boolean(), &StateSpaceRequest::sensors,
                        "whether the job's points are inputs and outputs")
          .optional("points", shape::list(shape::integer(0, 10000), 1, 10001),
                    &StateSpaceRequest::points,
                    "which points of the path, the first is 0; default all");
  return table;
}

// Checks that the leaves' models have masses. Both sections need the mass of leaves that move by
// themselves, in their deflected state.
void check_mass(const ModelOptions& model, const json& read, const char* section,
                FaultList& faults) {
  if (model.leaf_modes == 0)
    faults.add(
        "/model/leaf_modes", read["model"]["leaf_modes"].dump(),
        fmt::format("\"{}\" is that of leaves with motions of their own: expected at least 1",
                    section));
  if (model.mass == LeafMass::constant)
    faults.add(
        "/model/mass", read["model"]["mass"].dump(),
        fmt::format("\"{}\" is that of the deflected leaves: expected \"consistent\"", section));
}

void check_transmissibility(const json& read, const TransmissibilityRule& rule,
                            const Mechanism& mechanism, const LoadCase& loads, FaultList& faults) {
  const Pointer at("/dynamics/transmissibility");
  if (!(rule.from < rule.to))
    faults.add(at / "to", fmt::format("{:g} Hz", rule.to),
               fmt::format("the band begins at {:g} Hz: expected more", rule.from));
  const auto d = static_cast<std::size_t>(index(rule.direction));
  const char* held = "";
  if (rule.point) return;
  if (mechanism.bodies[static_cast<std::size_t>(mechanism.end_effector)].held[d])
    held = "O cannot move there: the ground takes it along";
  else if (prescribed_directions(mechanism, loads.held)[d])
    held = "a drive of \"held\" holds O there";
  else if (rule.drive == DriveState::locked && prescribed_directions(mechanism)[d])
    held = "the locked drive holds O there: expected \"drive\": \"free\"";
  if (*held) faults.add(at / "direction", shown(read["direction"]), held);
}

// Place of a point with a direction among those that were read. Throws SpecError.
std::size_t find_point(const std::vector<NamedPoint>& points, const std::string& name,
                       const Pointer& at) {
  const auto found = std::ranges::find(points, name, &NamedPoint::name);
  if (found == points.end())
    throw SpecError(at, shown(name),
                    "no point has this name; " + known_names(name, names_in(points)));
  if (!found->direction) throw SpecError(at, shown(name), "this point has no \"direction\"");
  return static_cast<std::size_t>(found - points.begin());
}

// The names of points, once these are known.
void read_points_of_rules(const json& read, const std::vector<NamedPoint>& points,
                          FaultList& faults, DynamicsRule& rule) {
  if (rule.transmissibility && read["transmissibility"].contains("point"))
    faults.attempt([&] {
      const Pointer at("/dynamics/transmissibility/point");
      const std::string name = read["transmissibility"]["point"];
      const NamedPoint& point =
          points[*(rule.transmissibility->point = find_point(points, name, at))];
      if (point.turns())
        throw SpecError(at, shown(name), "expected a point with a translation as direction");
    });
  std::set<std::string> names;
  if (read.contains("transfers"))
    faults.each(read["transfers"], Pointer("/dynamics/transfers"),
                [&](const json& item, const Pointer& at) {
                  TransferRule transfer = transfer_table().read(item);
                  transfer.to = find_point(points, item["to"], at / "to");
                  const bool grounded = item["from"] == "ground";
                  if (grounded && points[transfer.to].turns())
                    throw SpecError(at / "to", shown(item["to"]),
                                    "the ground moves along it: expected a translation");
                  if (!grounded) transfer.from = find_point(points, item["from"], at / "from");
                  if (transfer.name.empty())
                    transfer.name =
                        fmt::format("{}.{}{}{}", item["from"].get_ref<const std::string&>(),
                                    item["to"].get_ref<const std::string&>(),
                                    transfer.of_motion && !grounded ? ".motion" : "",
                                    transfer.drive == DriveState::locked ? ".locked" : "");
                  transfer.of_motion = transfer.of_motion || grounded;
                  if (!names.insert(transfer.name).second)
                    throw SpecError(at, transfer.name,
                                    "another transfer has this name: give it another \"name\"");
                  rule.transfers.push_back(std::move(transfer));
                });
}

void read_measures(const json& read, const Mechanism& mechanism, FaultList& faults,
                   StrokeRequest& request) {
  DynamicsRule rule = dynamics_table().read(read["dynamics"]);
  if (read["dynamics"].contains("transmissibility")) {
    rule.transmissibility = transmissibility_table().read(read["dynamics"]["transmissibility"]);
  }
  if (faults.sound("/points") && faults.sound("/probes"))
    read_points_of_rules(read["dynamics"], request.named_points, faults, rule);
  if (rule.transmissibility) {
    const json& section = read["dynamics"]["transmissibility"];
    check_transmissibility(section, *rule.transmissibility, mechanism, request.loads, faults);
  }
  request.dynamics = rule;
}

void read_state_space(const json& read, FaultList& faults, StrokeRequest& request) {
  const Pointer at("/export/state_space");
  const json& section = read["export"]["state_space"];
  StateSpaceRequest wanted = state_space_table().read(section);
  if (!section.contains("damping") && request.dynamics)
    wanted.damping = {request.dynamics->damping};
  if (wanted.damping.size() != 1 && static_cast<int>(wanted.damping.size()) != wanted.modes)
    faults.add(at / "damping", fmt::format("{} ratios", wanted.damping.size()),
               fmt::format("expected one, or {} as there are modes", wanted.modes));
  for (std::size_t k = 0; k < wanted.points.size(); ++k)
    if (wanted.points[k] >= static_cast<int>(request.points.size()))
      faults.add(at / "points" / k, fmt::format("{}", wanted.points[k]),
                 fmt::format("the path has {} points: expected 0 to {}", request.points.size(),
                             request.points.size() - 1));
  request.state_space = std::move(wanted);
}

}  // namespace

std::vector<Field> dynamics_fields() {
  return {shape::optional("dynamics", dynamics_table().shape(),
                          "harmonic motion about every point: bandwidth of the drives, and "
                          "transmissibility"),
          shape::optional("export",
                          shape::record({shape::required(
                              "state_space", state_space_table().shape(),
                              "linear models about points of the path, for control engineering")}),
                          "what is written beside the results")};
}

void read_dynamics(const json& read, const Mechanism& mechanism, const ModelOptions& model,
                   FaultList& faults, StrokeRequest& request) {
  if (read.contains("dynamics") && faults.sound("/dynamics")) {
    check_mass(model, read, "dynamics", faults);
    read_measures(read, mechanism, faults, request);
  }
  if (read.contains("export") && faults.sound("/export") && faults.sound("/stroke")) {
    check_mass(model, read, "export", faults);
    read_state_space(read, faults, request);
  }
}

Check check_dynamics(const std::string& quantity, const StrokeRequest& request) {
  const bool bandwidth = quantity == "bandwidth" || quantity.starts_with("bandwidth.");
  if (bandwidth && !request.dynamics)
    return Because("it needs \"dynamics\": {}, which says how it is damped");
  if (bandwidth && !request.loads.driven())
    return Because("nothing is driven along a load_path: expected a stroke");
  if (quantity == "transmissibility" && !(request.dynamics && request.dynamics->transmissibility))
    return Because(
        "it needs \"dynamics\": {\"transmissibility\": {…}}, which says along what and at which "
        "frequencies");
  return {};
}

}  // namespace flexopt
