#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/spec/json_file.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

bool turns(const NamedPointSpec& point) {
  return point.direction && !point.direction->tail<3>().isZero(0);
}

// Whether a body is a material point of a leaf, to which nothing can be fixed.
bool is_material_point(const Mechanism& mechanism, int body) {
  return std::ranges::any_of(mechanism.leaves, [&](const LeafSpring& leaf) {
    return leaf.point && leaf.point->body == body;
  });
}

NamedPoint point_on_body(const NamedPointSpec& wanted, int b, const Mechanism& mechanism,
                         const json& read, const Pointer& at) {
  const RigidBody& body = mechanism.bodies[static_cast<std::size_t>(b)];
  NamedPoint point{.name = wanted.name, .body = b, .at = wanted.at};
  if (!is_material_point(mechanism, b)) return point;
  if (wanted.at && (*wanted.at - body.reference).norm() > 1e-9)
    throw SpecError(at / "at", shown(read["at"]) + " m",
                    "this body is a material point of a leaf: nothing beside it is fixed to it");
  if (turns(wanted))
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
    if (turns(wanted))
      throw SpecError(at / "direction", shown(read["direction"]),
                      "a point of a leaf has no rotation; expected a translation, or a body");
    return *std::move(found);
  }
  if (is_material_point(mechanism, mechanism.end_effector))
    throw SpecError(at / "at", shown(read["at"]) + " m", "no leaf is there when undeflected");
  notes.push_back(fmt::format("{} lies on no leaf: fixed to the end-effector.", wanted.name));
  return point_on_body(wanted, mechanism.end_effector, mechanism, read, at);
}

}  // namespace

std::vector<Field> point_fields() {
  const Shape list = shape::list(named_point_table().shape(), 0, 100);
  return {shape::with_default("points", list, json::array(),
                              "sensors and actuators: points of bodies and leaves whose motion is "
                              "wanted, inputs and outputs of linear models"),
          shape::with_default("probes", list, json::array(),
                              "the same list under an earlier name, which its results keep")};
}

void read_points(const json& read, const Mechanism* mechanism, FaultList& faults,
                 StrokeRequest& request, std::vector<std::string>& notes) {
  if (!read["points"].empty() && !read["probes"].empty())
    faults.add("/probes", fmt::format("{} points", read["probes"].size()),
               "it is an earlier name of \"points\", which the job has too: expected one of them");
  std::set<std::string> names;
  for (const auto& [list, kind] : {std::pair{"points", "point"}, {"probes", "probe"}})
    for (std::size_t i = 0; i < read[list].size(); ++i) {
      const json& item = read[list][i];
      const Pointer at = Pointer("/" + std::string(list)) / i;
      if (!item.is_object()) continue;
      if (faults.sound(at / "name") && !names.insert(item["name"]).second)
        faults.add(at / "name", shown(item["name"]), "names must be different");
      if (!mechanism || !faults.sound(at)) continue;
      faults.attempt([&] {
        const NamedPointSpec wanted = named_point_table().read(item);
        NamedPoint point = resolved(wanted, *mechanism, item, at, notes);
        point.direction = wanted.direction;
        point.kind = kind;
        request.named_points.push_back(std::move(point));
      });
    }
}

}  // namespace flexopt
