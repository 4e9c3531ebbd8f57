// Frames, bodies, leaves, joints, springs, drives of a design file with their names, and its parts:
// other files.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/spec/names.hpp"
#include "designs/family.hpp"
#include "designs/plan_reader.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

Direction direction_of(const json& name) {
  const auto at = std::ranges::find(direction_names, name.get_ref<const std::string&>());
  return static_cast<Direction>(at - direction_names.begin());
}

}  // namespace

std::string PlanReader::name(const std::string& text, const Pointer& at, DesignItem& item) {
  for (std::size_t open = 0, close = 0; (open = text.find('{', close)) != std::string::npos &&
                                        (close = text.find('}', open)) != std::string::npos;) {
    const std::string inside = text.substr(open + 1, close - open - 1);
    faults_.attempt([&] {
      Formula whole = formula(inside, names_, at);
      whole.check_unit("1");
      item.braces[inside] = {0, used(std::move(whole))};
    });
  }
  return text;
}

void PlanReader::read_frames() {
  each("frames", [&](const json& from, const Pointer& at) {
    FrameItem frame;
    read_item(from, at, "frame", frame);
    if (from.contains("in")) frame.frame = name(from["in"], at / "in", frame);
    frame.at = vector(from["at"], "m", at / "at");
    for (std::size_t i = 0; i < from["turn"].size(); ++i) {
      const json& turn = from["turn"][i];
      const Pointer here = at / "turn" / i;
      const std::string axis = turn[0].is_string() ? turn[0].get<std::string>() : "";
      if (axis != "x" && axis != "y" && axis != "z")
        throw SpecError(here / 0, shown(turn[0]), "expected \"x\", \"y\" or \"z\"");
      frame.turns.push_back({axis[0] - 'x', number(turn[1], "rad", here / 1)});
    }
    plan_.frames.push_back(std::move(frame));
  });
}

void PlanReader::read_bodies() {
  each("bodies", [&](const json& from, const Pointer& at) {
    BodyItem body;
    read_item(from, at, "body", body);
    if (body.name == "ground")
      throw SpecError(at / "name", "\"ground\"", "the ground is there already");
    if (from.contains("at") == from.contains("on"))
      throw SpecError(at / "at", from.contains("at") ? shown(from["at"]) : "nothing",
                      "give a place, or \"on\" for a point of a leaf, one of the two");
    if (from.contains("on")) {
      body.leaf = name(from["on"]["leaf"], at / "on" / "leaf", body);
      body.at = vector(from["on"]["at"], "m", at / "on" / "at");
      for (const char* key :
           {"mass", "density", "inertia", "box", "center_of_mass", "held", "elastic"})
        if (from.contains(key))
          throw SpecError(at / key, shown(from[key]),
                          "a point of a leaf is no rigid body: it has none of this");
    } else {
      body.at = vector(from["at"], "m", at / "at");
    }
    if (from.contains("density") && (from.contains("mass") || from.contains("inertia")))
      throw SpecError(at / "density", shown(from["density"]),
                      "give the density of a box, or mass and inertia");
    if (from.contains("density") && !from.contains("box"))
      throw SpecError(at / "box", "nothing", "a density is that of a box");
    if (from.contains("mass")) body.mass = number(from["mass"], "kg", at / "mass");
    if (from.contains("density")) body.density = number(from["density"], "kg/m^3", at / "density");
    if (from.contains("center_of_mass"))
      body.center_of_mass = vector(from["center_of_mass"], "m", at / "center_of_mass");
    if (from.contains("inertia")) body.inertia = matrix(from["inertia"], "kg m^2", at / "inertia");
    if (from.contains("box")) body.box = matrix(from["box"], "m", at / "box");
    if (body.density && body.box.size() != 3)
      throw SpecError(at / "density", shown(from["density"]),
                      "a box given by its edges has mass and inertia instead");
    if (from.contains("held"))
      for (std::size_t i = 0; i < from["held"].size(); ++i)
        body.held.push_back(held(from["held"][i], at / "held" / i, "/held/" + std::to_string(i)));
    if (from.contains("elastic")) read_elastic(from["elastic"], at / "elastic", from, body);
    plan_.bodies.push_back(std::move(body));
  });
}

HeldDirection PlanReader::held(const json& from, const Pointer& at, std::string key) {
  HeldDirection held;
  held.key = std::move(key);
  if (from.is_string()) {
    held.direction = direction_of(from);
    return held;
  }
  held.rotation = from.contains("rotation");
  if (held.rotation == from.contains("displacement"))
    throw SpecError(at, shown(from),
                    "give the vector of a displacement or of a rotation, one of the two");
  const char* kind = held.rotation ? "rotation" : "displacement";
  held.along = vector(from[kind], "1", at / kind);
  return held;
}

HeldPlace PlanReader::edge(const json& from, const Pointer& at, LeafItem& leaf) {
  HeldPlace place{name(from.value("body", ""), at / "body", leaf),
                  vector(from["at"], "m", at / "at")};
  if (from.contains("clamp")) {
    const json& clamp = from["clamp"];
    place.clamp = {number(clamp["length"], "m", at / "clamp" / "length"),
                   normal_of(clamp, at / "clamp", "side")};
  }
  return place;
}

void PlanReader::read_leaves() {
  each("leaves", [&](const json& from, const Pointer& at) {
    LeafItem leaf;
    read_item(from, at, "leaf", leaf);
    leaf.base = edge(from["base"], at / "base", leaf);
    leaf.tip = edge(from["tip"], at / "tip", leaf);
    leaf.may_cross = from["may_cross"];
    leaf.wire = from.contains("diameter");
    for (const char* key : {"across", "width", "thickness"}) {
      if (leaf.wire && from.contains(key) && std::string(key) != "across")
        throw SpecError(at / key, shown(from[key]), "a wire has its diameter alone");
      if (!leaf.wire && !from.contains(key))
        throw SpecError(at / key, "nothing",
                        "a leaf has across, width and thickness; a wire has a diameter");
    }
    if (leaf.wire) {
      leaf.thickness = size(from["diameter"], at / "diameter");
    } else {
      leaf.width = size(from["width"], at / "width");
      leaf.thickness = size(from["thickness"], at / "thickness");
    }
    if (from.contains("across")) {
      leaf.across = vector(from["across"], "1", at / "across");
    } else {
      leaf.across = DesignVector{};
    }
    if (from.contains("material"))
      leaf.material = material_of(from["material"], at / "material", false);
    if (from.contains("curve")) {
      leaf.curve = number(from["curve"]["angle"], "rad", at / "curve" / "angle");
      if (!from.contains("across"))
        throw SpecError(at / "across", "nothing",
                        "a curved wire is bent about a direction: it needs across");
    }
    if (from.contains("fold")) {
      leaf.fold = vector(from["fold"]["at"], "m", at / "fold" / "at");
      if (from["fold"].contains("radius"))
        leaf.fold_radius = number(from["fold"]["radius"], "m", at / "fold" / "radius");
      for (const char* key : {"curve", "reinforcement", "diameter"})
        if (from.contains(key))
          throw SpecError(at / key, shown(from[key]),
                          "a folded leaf is flat on both sides of its fold, of one width and "
                          "thickness");
      for (const char* key : {"width", "thickness"})
        if (!from[key].is_number() && !from[key].is_string())
          throw SpecError(at / key, shown(from[key]),
                          "a folded leaf has one width and one thickness");
      if (!from["tip"].contains("body"))
        throw SpecError(at / "tip", shown(from["tip"]),
                        "both edges of a folded leaf are held: it needs a body");
    }
    if (from.contains("reinforcement")) {
      const json& thick = from["reinforcement"];
      const Pointer here = at / "reinforcement";
      if (leaf.wire || leaf.curve)
        throw SpecError(here, shown(thick), "of a flat leaf of given width only");
      leaf.reinforcement = {number(thick["fraction"], "1", here / "fraction"),
                            number(thick["thickness"], "m", here / "thickness"), thick["rigid"]};
    }
    plan_.leaves.push_back(std::move(leaf));
  });
}

void PlanReader::read_joints() {
  each("joints", [&](const json& from, const Pointer& at) {
    JointItem joint;
    read_item(from, at, "joint", joint);
    const std::string type = from["type"];
    joint.type = type == "rigid"       ? JointType::rigid
                 : type == "revolute"  ? JointType::revolute
                 : type == "spherical" ? JointType::spherical
                                       : JointType::prismatic;
    joint.body = name(from["body"], at / "body", joint);
    joint.other = name(from["other"], at / "other", joint);
    joint.at = vector(from["at"], "m", at / "at");
    joint.axis[2].constant = 1;
    const bool has_axis = joint.type == JointType::revolute || joint.type == JointType::prismatic;
    if (has_axis != from.contains("axis"))
      throw SpecError(at / "axis", has_axis ? "nothing" : shown(from["axis"]),
                      has_axis ? "it is required: the axis of the joint"
                               : fmt::format("a {} joint has no axis", type));
    if (has_axis) joint.axis = vector(from["axis"], "1", at / "axis");
    plan_.joints.push_back(std::move(joint));
  });
}

void PlanReader::read_springs() {
  each("springs", [&](const json& from, const Pointer& at) {
    SpringItem spring;
    read_item(from, at, "spring", spring);
    spring.body = name(from["body"], at / "body", spring);
    spring.other = name(from["other"], at / "other", spring);
    spring.at = vector(from["at"], "m", at / "at");
    const bool bushing = from.contains("matrix"), line = from.contains("line");
    if (bushing + line + from.contains("stiffness") != 1)
      throw SpecError(at / "stiffness",
                      from.contains("stiffness") ? shown(from["stiffness"]) : "nothing",
                      "give a stiffness, a line, or the matrix of a bushing, one of them");
    if (line && from.contains("free_length"))
      throw SpecError(at / "free_length", shown(from["free_length"]),
                      "the line of a spring says at which length it has no force");
    for (const char* key : {"other_at", "free_length"})
      if (bushing && from.contains(key))
        throw SpecError(at / key, shown(from[key]), "a bushing has one place");
    if (bushing) {
      spring.matrix = matrix(from["matrix"], "", at / "matrix");
    } else {
      if (!from.contains("other_at"))
        throw SpecError(at / "other_at", "nothing",
                        "it is required: the spring's end on the other body");
      spring.other_at = vector(from["other_at"], "m", at / "other_at");
      for (std::size_t i = 0; line && i < from["line"].size(); ++i)
        spring.line.push_back({number(from["line"][i][0], "m", at / "line" / i / 0),
                               number(from["line"][i][1], "N", at / "line" / i / 1)});
      if (!line) spring.stiffness = number(from["stiffness"], "N/m", at / "stiffness");
      if (from.contains("free_length"))
        spring.free_length = number(from["free_length"], "m", at / "free_length");
    }
    plan_.springs.push_back(std::move(spring));
  });
}

void PlanReader::read_actuator(const json& from, const Pointer& at, DriveItem& drive) {
  const bool turns = is_rotation(drive.direction);
  if (from.contains("voice_coil")) {
    const json& coil = from["voice_coil"];
    const Pointer here = at / "voice_coil";
    drive.voice_coil = {
        number(coil["motor_constant"], turns ? "N m/A" : "N/A", here / "motor_constant"),
        number(coil["resistance"], "ohm", here / "resistance")};
  }
  if (!from.contains("piezo")) return;
  const json& stack = from["piezo"];
  const Pointer here = at / "piezo";
  if (turns || drive.voice_coil)
    throw SpecError(here, shown(stack),
                    turns ? "a piezo stack pushes along ux, uy or uz of its frame"
                          : "a drive has one actuator");
  DriveItem::Piezo& piezo = drive.piezo.emplace();
  if (stack.contains("at")) piezo.at = vector(stack["at"], "m", here / "at");
  piezo.free_stroke = number(stack["free_stroke"], "m", here / "free_stroke");
  piezo.blocking_force = number(stack["blocking_force"], "N", here / "blocking_force");
}

void PlanReader::read_drives() {
  const auto read = [&](const json& from, const Pointer& at) {
    if (!from.is_object() || !faults_.sound(at)) return;
    faults_.attempt([&] {
      DriveItem drive;
      read_item(from, at, nullptr, drive);
      drive.body = name(from["body"], at / "body", drive);
      drive.other = name(from["other"], at / "other", drive);
      drive.direction = direction_of(from["direction"]);
      read_actuator(from, at, drive);
      plan_.drives.push_back(std::move(drive));
    });
  };
  plan_.named_drives = read_.contains("drives");
  if (plan_.named_drives && read_.contains("drive"))
    faults_.add("/drive", shown(read_["drive"]), "give a drive or drives, one of the two");
  if (read_.contains("drive")) read(read_["drive"], Pointer("/drive"));
  if (plan_.named_drives)
    for (std::size_t i = 0; i < read_["drives"].size(); ++i)
      read(read_["drives"][i], Pointer("/drives") / i);
}

json whole_design(json document, const std::string& folder) {
  if (!document.is_object() || !document.contains("parts")) return document;
  for (json& part : document["parts"])
    if (part.is_object() && part.contains("design") && part["design"].is_string() &&
        part["design"].get<std::string>().ends_with(".json"))
      part["design"] = whole_design_file(
          (std::filesystem::path(folder) / part["design"].get<std::string>()).string());
  return document;
}

json whole_design_file(const std::string& file) {
  json document = parse_json(read_text(file).text, file);
  const std::filesystem::path path(file);
  if (!document.contains("name")) document["name"] = path.stem().string();
  return whole_design(std::move(document), path.parent_path().string());
}

std::shared_ptr<const DesignPlan> PlanReader::plan_of_part(const json& from, const Pointer& at) {
  if (from.is_object()) {
    FaultList faults;
    DesignSource source{.kind = DesignSource::Kind::job,
                        .text = {},
                        .folder = plan_.source.folder,
                        .lead = at.to_string()};
    const auto written = read_plan(from, source, faults, within_);
    faults.raise();
    return written;
  }
  const std::string design = from;
  const auto refuse_circle = [&](const std::string& which) {
    if (std::ranges::find(within_, which) != within_.end())
      throw SpecError(
          at, shown(design),
          fmt::format("a design is no part of itself: {} > {}", fmt::join(within_, " > "), which));
  };
  std::vector<std::string> within = within_;
  if (design.ends_with(".json")) {
    const auto file = std::filesystem::path(plan_.source.folder) / design;
    std::error_code error;
    std::string name = std::filesystem::weakly_canonical(file, error).string();
    if (error) name = file.string();
    refuse_circle(name);
    return read_design_file(file.string(), within);
  }
  const std::string_view text = library_text(design);
  if (text.empty())
    throw SpecError(at, shown(design),
                    "unknown family; " + known_names(design, library_names()) +
                        "; or a path that ends in .json");
  refuse_circle(design);
  within.push_back(design);
  FaultList faults;
  auto plan =
      read_plan(parse_json(std::string(text), design), library_source(design), faults, within);
  faults.raise();
  return plan;
}

PartItem PlanReader::part(const json& from, const Pointer& at) {
  PartItem part;
  read_item(from, at, "part", part);
  if (from.contains("mirror")) part.mirror = from["mirror"].get<std::string>()[0] - 'x';
  part.design = plan_of_part(from["design"], at / "design");
  const DesignPlan& design = *part.design;
  std::vector<std::string> known;
  for (const Parameter& p : design.parameters) known.push_back(p.name);
  for (const FamilyOption& o : design.options) known.push_back(o.name);
  const Pointer here = at / "parameters";
  for (const FamilyOption& o : design.options) part.choices[o.name] = o.choices.front();
  for (const auto& [name, value] : from["parameters"].items()) {
    if (std::ranges::find(known, name) == known.end())
      throw SpecError(here / name, shown(value),
                      "the part has no such parameter; " + known_names(name, known));
    const auto option = std::ranges::find(design.options, name, &FamilyOption::name);
    if (option == design.options.end()) continue;
    const std::string choice = value.is_string() ? value.get<std::string>() : shown(value);
    if (std::ranges::find(option->choices, choice) == option->choices.end())
      throw SpecError(here / name, shown(value), known_names(choice, option->choices));
    part.choices[name] = choice;
  }
  for (const Parameter& p : design.parameters) {
    if (from["parameters"].contains(p.name)) {
      part.parameters.push_back(number(from["parameters"][p.name], p.unit, here / p.name));
    } else if (p.default_value) {
      part.parameters.push_back({*p.default_value, nullptr});
    } else {
      throw SpecError(here / p.name, "nothing",
                      "the part needs it: " + (p.meaning.empty() ? p.name : p.meaning));
    }
  }
  for (const auto& [inner, outer] : from["join"].items())
    part.join.emplace_back(name(inner, at / "join", part), name(outer, at / "join" / inner, part));
  return part;
}

void PlanReader::read_parts() {
  each("parts",
       [&](const json& from, const Pointer& at) { plan_.parts.push_back(part(from, at)); });
}

}  // namespace flexopt
