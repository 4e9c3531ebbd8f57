#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/record_table.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

// Whether a body is a material point of a leaf, to which nothing can be fixed.
bool is_material_point(const Mechanism& mechanism, int body) {
  return std::ranges::any_of(mechanism.leaves, [&](const LeafSpring& leaf) {
    return leaf.point && leaf.point->body == body;
  });
}

NamedPoint point_on_body(const NamedPointSpec& wanted, int b, const Mechanism& mechanism,
                         const json& read, const Pointer& at) {
  const RigidBody& body = mechanism.bodies[static_cast<std::size_t>(b)];
  NamedPoint point{.name = wanted.name, .body = b, .at = wanted.at, .direction = wanted.direction};
  if (!is_material_point(mechanism, b)) return point;
  if (wanted.at && (*wanted.at - body.reference).norm() > 1e-9)
    throw SpecError(at / "at", shown(read["at"]) + " m",
                    "this body is a material point of a leaf: nothing beside it is fixed to it");
  if (point.turns())
    throw SpecError(at / "direction", shown(read["direction"]),
                    "this body is a material point of a leaf: it has no rotation");
  point.at.reset();
  return point;
}

// The point as the mechanism has it. Throws SpecError.
NamedPoint resolved(const NamedPointSpec& wanted, const Mechanism& mechanism, const json& read,
                    const Pointer& at, std::vector<std::string>& notes) {
  if (wanted.direction && wanted.direction->isZero(0))
    throw SpecError(at / "direction", shown(read["direction"]), "expected a vector with a length");
  if (!wanted.body.empty())
    return point_on_body(wanted, find_body(mechanism, wanted.body, at / "body"), mechanism, read,
                         at);
  if (!wanted.at) throw SpecError(at / "at", "nothing", "it is required where no body is named");
  if (std::optional<NamedPoint> found = point_on_leaf(mechanism, wanted.name, *wanted.at)) {
    found->direction = wanted.direction;
    if (found->turns())
      throw SpecError(at / "direction", shown(read["direction"]),
                      "a point of a leaf has no rotation; expected a translation, or a body");
    return *std::move(found);
  }
  if (is_material_point(mechanism, mechanism.end_effector))
    throw SpecError(at / "at", shown(read["at"]) + " m", "no leaf is there when undeflected");
  notes.push_back(fmt::format("{} lies on no leaf: fixed to the end-effector.", wanted.name));
  return point_on_body(wanted, mechanism.end_effector, mechanism, read, at);
}

const RecordTable<StrainGauge>& gauge_table() {
  static const auto table =
      RecordTable<StrainGauge>()
          .required("name", shape::text(100), &StrainGauge::name, "in the results")
          .other(shape::required("leaf", shape::text(100), "on which it is"))
          .required("along", shape::quantity("1", 0, 1), &StrainGauge::along,
                    "its place, as a part of the leaf's length from its base")
          .with_default("across", shape::quantity("1", 0, 1), &StrainGauge::across,
                        "its place, as a part of the leaf's width; 0.5 is the middle")
          .choice<bool>("surface", {{"positive_normal", true}, {"negative_normal", false}},
                        &StrainGauge::on_positive_normal, "on which side of the leaf")
          .with_default("angle", shape::quantity("rad", -10, 10), &StrainGauge::angle,
                        "of the strain that it measures, from along the leaf to across it");
  return table;
}

const RecordTable<StrainBridge>& bridge_table() {
  static const auto table =
      RecordTable<StrainBridge>()
          .required("name", shape::text(100), &StrainBridge::name, "in the results")
          .other(shape::required("signs", shape::map(shape::integer(-1, 1)),
                                 "1 or -1 of the gauges in its four arms"))
          .with_default("gauge_factor", shape::quantity("1", 0, 1e4, true),
                        &StrainBridge::gauge_factor,
                        "relative change of resistance over strain; with 1 the output is the mean "
                        "of the four signed strains");
  return table;
}

StrainBridge read_bridge(const json& item, const Pointer& at,
                         const std::vector<StrainGauge>& gauges) {
  StrainBridge bridge = bridge_table().read(item);
  for (const auto& [name, sign] : item["signs"].items()) {
    const auto found = std::ranges::find(gauges, name, &StrainGauge::name);
    if (found == gauges.end())
      throw SpecError(at / "signs" / name, shown(sign),
                      "no gauge has this name; " + known_names(name, names_in(gauges)));
    if (sign == 0) throw SpecError(at / "signs" / name, "0", "expected 1 or -1");
    bridge.arms.push_back({static_cast<std::size_t>(found - gauges.begin()), sign.get<double>()});
  }
  if (bridge.arms.empty() || bridge.arms.size() > 4)
    throw SpecError(at / "signs", fmt::format("{} gauges", bridge.arms.size()),
                    "a bridge has four arms: expected 1 to 4");
  return bridge;
}

using Names = std::set<std::string>;

// Adds the name of an item of a list to those before it, which are different ones.
void add_name(const json& item, const Pointer& at, FaultList& faults, Names& names) {
  if (faults.sound(at / "name") && !names.insert(item["name"]).second)
    faults.add(at / "name", shown(item["name"]), "names must be different");
}

void read_gauges(const json& read, const Mechanism& mechanism, FaultList& faults,
                 StrokeRequest& request) {
  Names gauges, bridges;
  faults.each(read["gauges"], Pointer("/gauges"), [&](const json& item, const Pointer& at) {
    add_name(item, at, faults, gauges);
    StrainGauge gauge = gauge_table().read(item);
    gauge.leaf = find_leaf(mechanism, item["leaf"], at / "leaf");
    request.gauges.push_back(std::move(gauge));
  });
  if (!faults.sound("/gauges")) return;
  faults.each(read["bridges"], Pointer("/bridges"), [&](const json& item, const Pointer& at) {
    add_name(item, at, faults, bridges);
    request.bridges.push_back(read_bridge(item, at, request.gauges));
  });
}

}  // namespace

std::vector<Field> point_fields() {
  const Shape list = shape::list(named_point_table().shape(), 0, 100);
  return {shape::with_default("points", list, json::array(),
                              "sensors and actuators: points of bodies and leaves whose motion is "
                              "wanted, inputs and outputs of linear models"),
          shape::with_default("probes", list, json::array(),
                              "the same list under an earlier name, which its results keep"),
          shape::with_default("gauges", shape::list(gauge_table().shape(), 0, 1000), json::array(),
                              "strain gauges on the surfaces of leaves"),
          shape::with_default("bridges", shape::list(bridge_table().shape(), 0, 100), json::array(),
                              "Wheatstone bridges of gauges")};
}

void read_points(const json& read, const Mechanism* mechanism, FaultList& faults,
                 StrokeRequest& request, std::vector<std::string>& notes) {
  if (!read["points"].empty() && !read["probes"].empty())
    faults.add("/probes", fmt::format("{} points", read["probes"].size()),
               "it is an earlier name of \"points\", which the job has too: expected one of them");
  Names names;
  for (const auto& [list, kind] : {std::pair{"points", "point"}, {"probes", "probe"}})
    for (std::size_t i = 0; i < read[list].size(); ++i) {
      const json& item = read[list][i];
      const Pointer at = Pointer("/" + std::string(list)) / i;
      if (!item.is_object()) continue;
      add_name(item, at, faults, names);
      if (!mechanism || !faults.sound(at)) continue;
      faults.attempt([&] {
        const NamedPointSpec wanted = named_point_table().read(item);
        NamedPoint point = resolved(wanted, *mechanism, item, at, notes);
        point.kind = kind;
        request.named_points.push_back(std::move(point));
      });
    }
  if (mechanism) read_gauges(read, *mechanism, faults, request);
}

}  // namespace flexopt
