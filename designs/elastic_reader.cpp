// "elastic" of the bodies of a design file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "core/spec/names.hpp"
#include "designs/elastic_item.hpp"
#include "designs/plan_reader.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

/// The one of the keys that the record has. Throws SpecError where it has none or several.
std::string one_key(const json& from, const Pointer& at, const std::vector<std::string>& keys) {
  std::string found;
  for (const std::string& key : keys) {
    if (!from.contains(key)) continue;
    if (!found.empty())
      throw SpecError(at / key, shown(from[key]),
                      fmt::format("give one of the keys {}", fmt::join(keys, ", ")));
    found = key;
  }
  if (found.empty())
    throw SpecError(at / keys.front(), "nothing",
                    fmt::format("give one of the keys {}", fmt::join(keys, ", ")));
  return found;
}

void expect_none(const json& from, const Pointer& at, const std::vector<const char*>& keys,
                 const char* rule) {
  for (const char* key : keys)
    if (from.contains(key)) throw SpecError(at / key, shown(from[key]), rule);
}

}  // namespace

DesignVector PlanReader::normal_of(const json& from, const Pointer& at, const char* face) {
  if (one_key(from, at, {face, "normal"}) == "normal")
    return vector(from["normal"], "1", at / "normal");
  const std::string name = from[face];  // "x+"
  DesignVector normal;
  normal[static_cast<std::size_t>(name[0] - 'x')].constant = name[1] == '+' ? 1 : -1;
  return normal;
}

DesignPoint PlanReader::point(const json& from, const std::string& unit, const Pointer& at) {
  return {number(from[0], unit, at / 0), number(from[1], unit, at / 1)};
}

ElasticItem::Contour PlanReader::contour(const json& from, const Pointer& at) {
  ElasticItem::Contour contour;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Pointer here = at / i;
    ElasticItem::Corner& corner = contour.emplace_back();
    if (from[i].is_array()) {
      corner.at = point(from[i], "m", here);
      continue;
    }
    corner.at = point(from[i]["at"], "m", here / "at");
    if (from[i].contains("fillet")) corner.fillet = number(from[i]["fillet"], "m", here / "fillet");
    if (from[i].contains("through"))
      corner.through = point(from[i]["through"], "m", here / "through");
    if (from.size() == 2 && corner.through)
      throw SpecError(here / "through", shown(from[i]["through"]),
                      "two corners are those of a rectangle, which has no arcs");
  }
  return contour;
}

ElasticItem::Plate PlanReader::plate(const json& from, const Pointer& at) {
  ElasticItem::Plate plate;
  plate.outline = contour(from["outline"], at / "outline");
  for (std::size_t i = 0; i < from["windows"].size(); ++i)
    plate.windows.push_back(contour(from["windows"][i], at / "windows" / i));
  for (std::size_t i = 0; i < from["holes"].size(); ++i) {
    const Pointer here = at / "holes" / i;
    plate.holes.push_back({point(from["holes"][i]["at"], "m", here / "at"),
                           number(from["holes"][i]["radius"], "m", here / "radius")});
  }
  plate.thickness = number(from["thickness"], "m", at / "thickness");
  plate.normal = vector(from["normal"], "1", at / "normal");
  plate.at = vector(from["at"], "m", at / "at");
  if (from.contains("along")) plate.along = vector(from["along"], "1", at / "along");
  return plate;
}

ElasticItem::Notch PlanReader::notch(const json& from, const Pointer& at) {
  ElasticItem::Notch notch;
  const auto own = [&](const char* key) { return number(from[key], "m", at / key); };
  const std::string contour = from.value("contour", "circular");
  constexpr std::array contours{"circular", "elliptic", "corner_filleted", "v", "power"};
  notch.contour = static_cast<NotchContour>(std::ranges::find(contours, contour) -
                                            contours.begin());  // in the order of the enum
  const bool circular = notch.contour == NotchContour::circular,
             power = notch.contour == NotchContour::power,
             filleted = notch.contour == NotchContour::corner_filleted ||
                        notch.contour == NotchContour::v_shaped;
  const std::pair<const char*, bool> needed[] = {{"radius", circular},
                                                 {"half_length", !circular},
                                                 {"depth", !circular},
                                                 {"fillet", filleted},
                                                 {"exponent", power}};
  for (const auto& [key, wanted] : needed)
    if (from.contains(key) != wanted)
      throw SpecError(at / key, wanted ? "nothing" : shown(from[key]),
                      fmt::format("a {} notch has {}", contour,
                                  circular   ? "a radius alone"
                                  : filleted ? "half_length, depth and fillet"
                                  : power    ? "half_length, depth and exponent"
                                             : "half_length and depth"));
  notch.half_length = own(circular ? "radius" : "half_length");
  notch.depth = own(circular ? "radius" : "depth");
  if (filleted) notch.fillet = own("fillet");
  if (power) notch.exponent = number(from["exponent"], "1", at / "exponent");
  if (power && notch.exponent.formula)
    throw SpecError(at / "exponent", shown(from["exponent"]),
                    "the exponent of a contour is a number: nothing varies it");
  notch.thickness = own("thickness");
  notch.width = own("width");
  notch.ends = own("ends");
  notch.axis = vector(from["axis"], "1", at / "axis");
  notch.across = vector(from["across"], "1", at / "across");
  notch.two_axes = from["two_axes"];
  return notch;
}

ElasticItem::Imported PlanReader::imported(const json& from, const Pointer& at, bool mesh) {
  ElasticItem::Imported imported;
  imported.file =
      (std::filesystem::path(plan_.source.folder) / from["file"].get<std::string>()).string();
  imported.axis = vector(from["axis"], "1", at / "axis");
  imported.across = vector(from["across"], "1", at / "across");
  if (mesh) {
    imported.unit = from["units"] == "m" ? 1 : from["units"] == "mm" ? 1e-3 : 1e-6;
    imported.mesh = std::make_shared<const ImportedMesh>(read_mesh(imported.file, imported.unit));
  } else {
    imported.body = std::make_shared<const ImportedBody>(read_elastic_body(imported.file));
  }
  return imported;
}

ElasticItem::Interface PlanReader::interface(const json& from, const Pointer& at, std::string key,
                                             const ElasticItem& elastic, BodyItem& body) {
  ElasticItem::Interface result;
  result.key = std::move(key);
  result.name = name(from["name"], at / "name", body);
  if (from.contains("body")) result.body = name(from["body"], at / "body", body);
  if (from.contains("at")) result.at = vector(from["at"], "m", at / "at");
  if (elastic.is_imported()) {
    expect_none(from, at, {"face", "normal", "size", "along"},
                "the file says which nodes or coordinates are those of the interface");
    return result;
  }
  result.normal = normal_of(from, at, "face");
  if (from.contains("size")) result.size = point(from["size"], "m", at / "size");
  if (from.contains("along")) {
    result.along = vector(from["along"], "1", at / "along");
    if (!result.size)
      throw SpecError(at / "along", shown(from["along"]),
                      "it is the direction of the first size: without size it is the whole face");
  }
  if (result.size && !result.at)
    throw SpecError(at / "at", "nothing", "a patch of a size has a place");
  return result;
}

/// Interfaces of the file: those that are named exist, and matrices have all of theirs.
void PlanReader::complete_interfaces(const ElasticItem::Imported& file, const Pointer& at,
                                     ElasticItem& elastic) {
  const auto named = [&](const std::string& name) {
    return std::ranges::find(elastic.interfaces, name, &ElasticItem::Interface::name) !=
           elastic.interfaces.end();
  };
  for (std::size_t i = 0; i < elastic.interfaces.size(); ++i) {
    const std::string& name = elastic.interfaces[i].name;
    if (file.mesh) (void)nodes_of_set(*file.mesh, name, at / i / "name");
    if (file.body && std::ranges::find(file.body->interfaces, name, &ImportedInterface::name) ==
                         file.body->interfaces.end())
      throw SpecError(
          at / i / "name", shown(name),
          "the file has no such interface; " + known_names(name, names_in(file.body->interfaces)));
  }
  if (!file.body) return;
  for (const ImportedInterface& interface : file.body->interfaces)
    if (!named(interface.name)) {
      elastic.interfaces.emplace_back().name = interface.name;
      elastic.interfaces.back().key = "/import";
    }
}

void PlanReader::read_interfaces(const json& from, const Pointer& at, const json& of_body,
                                 ElasticItem& elastic, BodyItem& body) {
  if (elastic.is_notch()) {
    expect_none(from, at, {"interfaces"},
                "those of a notch are its end faces, base and tip: \"between\" names their bodies");
    for (const std::size_t end : {0u, 1u}) {
      ElasticItem::Interface& face = elastic.interfaces.emplace_back();
      face.key = from.contains("between") ? fmt::format("/between/{}", end) : "/notch";
      face.name = end == 0 ? "base" : "tip";
      if (from.contains("between"))
        face.body = name(from["between"][end], at / "between" / end, body);
    }
  } else {
    expect_none(from, at, {"between"}, "of a notch alone; interfaces name their bodies");
    const json interfaces = from.value("interfaces", json::array());
    for (std::size_t i = 0; i < interfaces.size(); ++i)
      elastic.interfaces.push_back(interface(interfaces[i], at / "interfaces" / i,
                                             fmt::format("/interfaces/{}", i), elastic, body));
    if (const auto* file = std::get_if<ElasticItem::Imported>(&elastic.shape))
      complete_interfaces(*file, at / "interfaces", elastic);
  }
  const auto is_free = [](const ElasticItem::Interface& i) { return i.body.empty(); };
  if (!elastic.has_frame())
    expect_none(
        of_body, at.parent_pointer(), {"mass", "inertia", "density", "held"},
        "all interfaces are parts of other bodies: give it to one of those, or add an interface");
  if (!from.contains("payload")) {
    if (body.name == "end_effector" && std::ranges::count_if(elastic.interfaces, is_free) != 1)
      throw SpecError(at / "payload", "nothing",
                      "it is required: the interface that carries O, one that names no body");
    return;
  }
  elastic.payload = name(from["payload"], at / "payload", body);
  const auto chosen =
      std::ranges::find(elastic.interfaces, elastic.payload, &ElasticItem::Interface::name);
  if (chosen == elastic.interfaces.end())
    throw SpecError(at / "payload", shown(from["payload"]),
                    "there is no such interface; " +
                        known_names(elastic.payload, names_in(elastic.interfaces)));
  if (!chosen->body.empty())
    throw SpecError(at / "payload", shown(from["payload"]),
                    "this interface is a part of the body " + chosen->body + ": name that one");
}

void PlanReader::read_elastic(const json& from, const Pointer& at, const json& of_body,
                              BodyItem& body) {
  const Pointer around = at.parent_pointer();
  auto elastic = std::make_shared<ElasticItem>();
  if (from.contains("material"))
    elastic->material = material_of(from["material"], at / "material", false);
  const std::string shape = one_key(from, at, {"box", "from", "plate", "notch", "mesh", "import"});
  if (from.contains("center") && shape != "box")
    throw SpecError(at / "center", shown(from["center"]), "of a box of three lengths alone");
  if (shape == "plate") {
    elastic->shape = plate(from["plate"], at / "plate");
  } else if (shape == "notch") {
    elastic->shape = notch(from["notch"], at / "notch");
  } else if (shape == "mesh" || shape == "import") {
    elastic->shape = imported(from[shape], at / shape, shape == "mesh");
    expect_none(from, at, {"elements"}, "the mesh is that of the file");
    if (shape == "import")
      expect_none(from, at, {"material", "degree"}, "the file has the stiffness: of degree 2");
  } else if (shape == "box") {
    ElasticItem::Box box{vector(from["box"], "m", at / "box"), {}};
    if (from.contains("center")) box.center = vector(from["center"], "m", at / "center");
    elastic->shape = std::move(box);
  } else {
    if (body.box.size() != 3)
      throw SpecError(around / "box", of_body.contains("box") ? shown(of_body["box"]) : "nothing",
                      "the elastic body is the box of three lengths of this body");
    expect_none(of_body, around, {"mass", "inertia", "density"},
                "the box is elastic and weighs what its material does; what is added to it stands "
                "beside an elastic \"box\" of three lengths");
    elastic->shape = ElasticItem::Box{{body.box[0], body.box[1], body.box[2]}, body.center_of_mass};
  }
  if (from.value("degree", 2) == 3)
    throw SpecError(at / "degree", "3", "2, or 4: the third degree alone has no least energy");
  if (from.contains("degree") || shape == "import")
    elastic->degree = from.value("degree", 2) == 4 ? ElasticDegree::quartic : ElasticDegree::linear;
  elastic->rigid = from["rigid"];
  if (elastic->rigid && elastic->is_notch())
    throw SpecError(at / "rigid", "true", "a rigid notch is no hinge");
  read_interfaces(from, at, of_body, *elastic, body);
  // notches in a plate bend across its thickness as well
  elastic->density.through = !elastic->is_notch() && elastic->is_hinge() ? 4 : 0;
  if (from.contains("elements")) {
    const json& elements = from["elements"];
    const Pointer here = at / "elements";
    if (elements.contains("size")) elastic->size = number(elements["size"], "m", here / "size");
    if (elements.contains("root")) elastic->root = number(elements["root"], "m", here / "root");
    elastic->density.through = elements.value("through", elastic->density.through);
    elastic->density.growth = elements.value("growth", elastic->density.growth);
  }
  body.elastic = std::move(elastic);
}

}  // namespace flexopt
