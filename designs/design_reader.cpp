#include "designs/design_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "core/spec/names.hpp"
#include "core/spec/quantity.hpp"
#include "designs/design_shape.hpp"
#include "designs/library.hpp"
#include "designs/materials.hpp"

namespace flexopt {
namespace {

using nlohmann::json;
using Pointer = json::json_pointer;

bool is_identifier(const std::string& name) {
  const auto letter = [](char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
  };
  return !name.empty() && letter(name[0]) && std::ranges::all_of(name, [&](char c) {
    return letter(c) || std::isdigit(static_cast<unsigned char>(c)) != 0;
  });
}

/// The words of a formula: names, functions and units alike.
std::set<std::string> words_of(const std::string& text) {
  std::set<std::string> words;
  std::string word;
  for (const char c : text + " ") {
    const bool part = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    if (part) {
      word += c;
    } else {
      if (is_identifier(word)) words.insert(word);
      word.clear();
    }
  }
  return words;
}

/// Whether the text is a number with or without a unit, and no formula.
bool is_quantity(const std::string& text) {
  std::size_t begin = text.find_first_not_of(" \t+");
  if (begin == std::string::npos) return false;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data() + begin, text.data() + text.size(), number);
  if (error != std::errc()) return false;
  std::string unit(end, text.data() + text.size());
  unit.erase(0, std::min(unit.find_first_not_of(" \t"), unit.size()));
  return unit.find_first_not_of(" \t") == std::string::npos || measured(1, unit).has_value();
}

/// The keys of a section in the order in which they are written; none where there is no text.
std::vector<std::string> keys_in_text(const std::string& text, const char* section) {
  std::vector<std::string> keys;
  if (text.empty()) return keys;
  const auto document = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!document.is_object() || !document.contains(section)) return keys;
  for (const auto& [key, value] : document[section].items())
    if (std::ranges::find(keys, key) == keys.end()) keys.push_back(key);
  return keys;
}

Direction direction_of(const json& name) {
  const auto at = std::ranges::find(direction_names, name.get_ref<const std::string&>());
  return static_cast<Direction>(at - direction_names.begin());
}

class PlanReader {
 public:
  PlanReader(const json& document, DesignSource source, FaultList& faults,
             std::vector<std::string> within)
      : faults_(faults), within_(std::move(within)) {
    plan_.source = std::move(source);
    read_ = read_value(design_file_shape(), document, Pointer(), faults_);
  }

  std::shared_ptr<const DesignPlan> read(DesignHead& head);

 private:
  void read_head(DesignHead& head) const;
  void read_parameters();
  void read_parameter(const std::string& name, const json& from, const Pointer& at);
  void read_options();
  void read_lets();
  void read_rules();
  void read_frames();
  void read_bodies();
  void read_leaves();
  void read_joints();
  void read_springs();
  void read_parts();
  void read_drives();
  PartItem part(const json& from, const Pointer& at);
  std::shared_ptr<const DesignPlan> plan_of_part(const std::string& design, const Pointer& at);

  /// Every sound record of a list.
  template <class Read>
  void each(const char* list, Read read);
  void read_item(const json& from, const Pointer& at, const char* kind, DesignItem& item);
  void read_repeat(const json& from, const Pointer& at, DesignItem& item);
  ChoiceCondition condition(const std::string& text, const Pointer& at);

  /// Numbers in the names of the item at hand.
  DesignNumber number(const json& from, const std::string& unit, const Pointer& at);
  DesignVector vector(const json& from, const std::string& unit, const Pointer& at);
  DesignMatrix matrix(const json& from, const std::string& unit, const Pointer& at);
  DesignSize size(const json& from, const Pointer& at);
  void check_name(const std::string& name, const Pointer& at);

  FaultList& faults_;
  std::vector<std::string> within_;
  json read_;
  DesignPlan plan_;
  std::vector<FormulaName> names_;  ///< of parameters and lets; then of the item's indices
};

std::shared_ptr<const DesignPlan> PlanReader::read(DesignHead& head) {
  if (!read_.is_object()) return nullptr;
  read_head(head);
  read_options();
  read_parameters();
  read_lets();
  read_rules();
  read_frames();
  read_bodies();
  read_leaves();
  read_joints();
  read_springs();
  read_parts();
  read_drives();
  return std::make_shared<const DesignPlan>(std::move(plan_));
}

void PlanReader::read_head(DesignHead& head) const {
  head.name = read_.value("name", "");
  head.summary = read_.value("summary", "");
  if (read_.contains("drawing")) {
    head.drawing = "\n";
    for (const json& line : read_["drawing"]) head.drawing += line.get<std::string>() + "\n";
  }
  if (read_.contains("mesh")) head.mesh = read_["mesh"].get<std::vector<int>>();
}

void PlanReader::check_name(const std::string& name, const Pointer& at) {
  const auto refuse = [&](const std::string& rule) {
    Fault fault;
    fault.pointer = at.to_string();
    fault.value = shown(name);
    fault.rule = rule;
    fault.of_key = true;
    throw SpecError({fault});
  };
  if (!is_identifier(name)) refuse("a name has letters, digits and _, and no digit first");
  if (is_formula_word(name)) refuse("it has a meaning of its own in formulas: another name");
  if (std::ranges::find(names_, name, &FormulaName::name) != names_.end())
    refuse("another parameter, \"let\" or index has this name");
}

void PlanReader::read_parameter(const std::string& name, const json& from, const Pointer& at) {
  check_name(name, at);
  Parameter p;
  p.name = name;
  p.unit = from["unit"];
  const std::optional<Measure> unit = measured(1, p.unit);
  if (p.unit != "1" && (!unit || unit->value != 1))
    throw SpecError((at / "unit").to_string(), shown(from["unit"]),
                    "expected an SI unit such as \"m\", \"rad\", \"kg\", or \"1\"");
  p.meaning = from.value("meaning", "");
  const auto bound = [&](const char* key) -> std::optional<double> {
    if (!from.contains(key)) return std::nullopt;
    return read_quantity(shape::quantity(p.unit), from[key], at / key);
  };
  for (const auto& [closed, open] : {std::pair{"min", "above"}, {"max", "below"}})
    if (from.contains(closed) && from.contains(open))
      throw SpecError((at / open).to_string(), shown(from[open]),
                      fmt::format("give {} or {}, one of the two", closed, open));
  p.open_min = from.contains("above");
  p.open_max = from.contains("below");
  p.min = bound(p.open_min ? "above" : "min").value_or(p.min);
  p.max = bound(p.open_max ? "below" : "max").value_or(p.max);
  if (from.contains("default"))
    p.standard = read_quantity(shape::quantity(p.unit, p.min, p.max, p.open_min, p.open_max),
                               from["default"], at / "default");
  names_.push_back({p.name, p.unit});
  plan_.parameters.push_back(std::move(p));
}

void PlanReader::read_parameters() {
  const auto take = [&](const std::string& name) {
    const Pointer at = Pointer("/parameters") / name;
    if (faults_.sound(at.to_string()))
      faults_.attempt([&] { read_parameter(name, read_["parameters"][name], at); });
  };
  const std::vector<std::string> order = keys_in_text(plan_.source.text.text, "parameters");
  for (const std::string& name : order)
    if (read_["parameters"].contains(name)) take(name);
  for (const auto& [name, from] : read_["parameters"].items())
    if (std::ranges::find(order, name) == order.end()) take(name);
}

void PlanReader::read_options() {
  for (const auto& [name, from] : read_["options"].items()) {
    if (!faults_.sound((Pointer("/options") / name).to_string())) continue;
    plan_.options.push_back(
        {name, from["choices"].get<std::vector<std::string>>(), from.value("meaning", "")});
  }
}

void PlanReader::read_lets() {
  std::map<std::string, json> open;
  for (const auto& [name, from] : read_["let"].items()) {
    const Pointer at = Pointer("/let") / name;
    if (faults_.sound(at.to_string()) && faults_.attempt([&] { check_name(name, at); }))
      open[name] = from;
  }
  while (!open.empty()) {
    const auto ready = std::ranges::find_if(open, [&](const auto& entry) {
      if (!entry.second.is_string()) return true;
      const auto words = words_of(entry.second.template get<std::string>());
      return std::ranges::none_of(open,
                                  [&](const auto& other) { return words.contains(other.first); });
    });
    if (ready == open.end()) {
      std::vector<std::string> circle;
      for (const auto& [name, from] : open) circle.push_back(name);
      faults_.add((Pointer("/let") / circle.front()).to_string(), shown(open.begin()->second),
                  fmt::format("these need each other in a circle: {}", fmt::join(circle, ", ")));
      return;
    }
    const auto& [name, from] = *ready;
    const Pointer at = Pointer("/let") / name;
    DesignNumber value;
    std::string unit;  // of a bare number: none
    faults_.attempt([&] {
      if (from.is_number()) {
        value.constant = from;
        return;
      }
      Formula formula(from.get<std::string>(), names_, at.to_string());
      if (formula.dimension()) unit = unit_of(*formula.dimension());
      value.formula = std::make_shared<const Formula>(std::move(formula));
    });
    plan_.lets.push_back({name, unit});
    plan_.let_numbers.push_back(std::move(value));
    names_.push_back({name, unit});
    open.erase(ready);
  }
}

void PlanReader::read_rules() {
  for (std::size_t i = 0; i < read_["rules"].size(); ++i) {
    const json& from = read_["rules"][i];
    const Pointer at = Pointer("/rules") / i;
    if (!faults_.sound(at.to_string()) || !from.is_object()) continue;
    faults_.attempt([&] {
      const std::string that = from["that"], where = (at / "that").to_string();
      if (that.find_first_of("<>=") == std::string::npos)
        throw SpecError(where, shown(that), "a rule compares: \"spacing > 2*thickness\"");
      plan_.rules.push_back({where, Formula(that, names_, where), from["else"]});
    });
  }
}

template <class Read>
void PlanReader::each(const char* list, Read read) {
  const std::vector<FormulaName> names = names_;
  for (std::size_t i = 0; i < read_[list].size(); ++i) {
    const Pointer at = Pointer("/" + std::string(list)) / i;
    const json& from = read_[list][i];
    if (!from.is_object() || !faults_.sound(at.to_string())) continue;
    faults_.attempt([&] { read(from, at); });
    names_ = names;
  }
}

ChoiceCondition PlanReader::condition(const std::string& text, const Pointer& at) {
  const auto split = [](const std::string& from, const std::string& by) {
    std::vector<std::string> parts;
    std::size_t begin = 0;
    for (std::size_t end; (end = from.find(by, begin)) != std::string::npos;
         begin = end + by.size())
      parts.push_back(from.substr(begin, end - begin));
    parts.push_back(from.substr(begin));
    return parts;
  };
  const auto trimmed = [](const std::string& from) {
    const std::size_t begin = from.find_first_not_of(" \t'\""),
                      end = from.find_last_not_of(" \t'\"");
    return begin == std::string::npos ? std::string() : from.substr(begin, end - begin + 1);
  };
  ChoiceCondition result;
  for (const std::string& alternative : split(text, "||")) {
    auto& terms = result.alternatives.emplace_back();
    for (const std::string& term : split(alternative, "&&")) {
      const bool equal = term.find("!=") == std::string::npos;
      const auto sides = split(term, equal ? "==" : "!=");
      if (sides.size() != 2)
        throw SpecError(at.to_string(), shown(text), "expected \"OPTION == CHOICE\" or !=");
      const std::string name = trimmed(sides[0]), choice = trimmed(sides[1]);
      const auto option = std::ranges::find(plan_.options, name, &FamilyOption::name);
      if (option == plan_.options.end()) {
        std::vector<std::string> known;
        for (const FamilyOption& o : plan_.options) known.push_back(o.name);
        throw SpecError(at.to_string(), shown(text),
                        fmt::format("there is no option '{}'; {}", name, known_names(name, known)));
      }
      if (std::ranges::find(option->choices, choice) == option->choices.end())
        throw SpecError(at.to_string(), shown(text),
                        fmt::format("'{}' is no choice of {}; {}", choice, name,
                                    known_names(choice, option->choices)));
      terms.push_back({name, choice, equal});
    }
  }
  return result;
}

void PlanReader::read_repeat(const json& from, const Pointer& at, DesignItem& item) {
  for (const auto& [name, bounds] : from.items()) {
    check_name(name, at / name);
    RepeatIndex index{.name = name, .first = {}, .last = {}};
    index.first = number(bounds[0], "1", at / name / 0);
    index.last = number(bounds[1], "1", at / name / 1);
    item.repeat.push_back(std::move(index));
  }
  for (const RepeatIndex& index : item.repeat) names_.push_back({index.name, "1"});
}

void PlanReader::read_item(const json& from, const Pointer& at, const char* kind,
                           DesignItem& item) {
  item.pointer = at.to_string();
  item.name = from.value("name", "");
  item.frame = from.value("frame", "");
  if (kind != nullptr && item.name.empty())
    throw SpecError((at / "name").to_string(), "nothing",
                    fmt::format("it is required: what the {} is called", kind));
  if (from.contains("when")) item.when = condition(from["when"], at / "when");
  if (from.contains("repeat")) read_repeat(from["repeat"], at / "repeat", item);
}

DesignNumber PlanReader::number(const json& from, const std::string& unit, const Pointer& at) {
  DesignNumber result;
  faults_.attempt([&] {
    if (from.is_number()) {
      result.constant = from;
      return;
    }
    const std::string text = from;
    if (is_quantity(text)) {
      result.constant = parse_quantity(text, unit, at.to_string());
      return;
    }
    Formula formula(text, names_, at.to_string());
    formula.check_unit(unit);
    result.formula = std::make_shared<const Formula>(std::move(formula));
  });
  return result;
}

DesignVector PlanReader::vector(const json& from, const std::string& unit, const Pointer& at) {
  DesignVector result;
  for (std::size_t i = 0; i < 3; ++i) result[i] = number(from[i], unit, at / i);
  return result;
}

DesignMatrix PlanReader::matrix(const json& from, const std::string& unit, const Pointer& at) {
  DesignMatrix result;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!from[i].is_array()) {
      result.push_back(number(from[i], unit, at / i));
      continue;
    }
    for (std::size_t j = 0; j < from[i].size(); ++j) {
      // of a 6x6: N/m, N, N m
      const std::size_t rotations = (i >= 3 ? 1u : 0u) + (j >= 3 ? 1u : 0u);
      const char* const of_bushing[] = {"N/m", "N", "N m"};
      result.push_back(number(from[i][j], unit.empty() ? of_bushing[rotations] : unit, at / i / j));
    }
  }
  return result;
}

DesignSize PlanReader::size(const json& from, const Pointer& at) {
  DesignSize result;
  if (from.is_object()) {
    const std::string where = (at / "profile").to_string();
    if (std::ranges::find(names_, "s", &FormulaName::name) != names_.end())
      throw SpecError(where, shown(from["profile"]),
                      "s is the place along the leaf here: another name for the other s");
    std::vector<FormulaName> names = names_;
    names.push_back({"s", "1"});
    Formula formula(from["profile"].get<std::string>(), names, where);
    formula.check_unit("m");
    result.profile = std::make_shared<const Formula>(std::move(formula));
  } else if (from.is_array()) {
    result.base = number(from[0], "m", at / 0);
    result.tip = number(from[1], "m", at / 1);
  } else {
    result.base = number(from, "m", at);
  }
  return result;
}

void PlanReader::read_frames() {
  each("frames", [&](const json& from, const Pointer& at) {
    FrameItem frame;
    read_item(from, at, "frame", frame);
    if (from.contains("in")) frame.frame = from["in"];
    frame.at = vector(from["at"], "m", at / "at");
    for (std::size_t i = 0; i < from["turn"].size(); ++i) {
      const json& turn = from["turn"][i];
      const Pointer here = at / "turn" / i;
      const std::string axis = turn[0].is_string() ? turn[0].get<std::string>() : "";
      if (axis != "x" && axis != "y" && axis != "z")
        throw SpecError((here / 0).to_string(), shown(turn[0]), "expected \"x\", \"y\" or \"z\"");
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
      throw SpecError((at / "name").to_string(), "\"ground\"", "the ground is there already");
    if (from.contains("at") == from.contains("on"))
      throw SpecError((at / "at").to_string(), from.contains("at") ? shown(from["at"]) : "nothing",
                      "give a place, or \"on\" for a point of a leaf, one of the two");
    if (from.contains("on")) {
      body.leaf = from["on"]["leaf"];
      body.at = vector(from["on"]["at"], "m", at / "on" / "at");
      for (const char* key : {"mass", "density", "inertia", "box", "center_of_mass", "held"})
        if (from.contains(key))
          throw SpecError((at / key).to_string(), shown(from[key]),
                          "a point of a leaf is no rigid body: it has none of this");
    } else {
      body.at = vector(from["at"], "m", at / "at");
    }
    if (from.contains("density") && (from.contains("mass") || from.contains("inertia")))
      throw SpecError((at / "density").to_string(), shown(from["density"]),
                      "give the density of a box, or mass and inertia");
    if (from.contains("density") && !from.contains("box"))
      throw SpecError((at / "box").to_string(), "nothing", "a density is that of a box");
    if (from.contains("mass")) body.mass = number(from["mass"], "kg", at / "mass");
    if (from.contains("density")) body.density = number(from["density"], "kg/m^3", at / "density");
    if (from.contains("center_of_mass"))
      body.center_of_mass = vector(from["center_of_mass"], "m", at / "center_of_mass");
    if (from.contains("inertia")) body.inertia = matrix(from["inertia"], "kg m^2", at / "inertia");
    if (from.contains("box")) body.box = vector(from["box"], "m", at / "box");
    if (from.contains("held"))
      for (const json& name : from["held"]) body.held.push_back(direction_of(name));
    plan_.bodies.push_back(std::move(body));
  });
}

void PlanReader::read_leaves() {
  each("leaves", [&](const json& from, const Pointer& at) {
    LeafItem leaf;
    read_item(from, at, "leaf", leaf);
    leaf.base = {from["base"]["body"], vector(from["base"]["at"], "m", at / "base" / "at")};
    leaf.tip = {from["tip"].value("body", ""), vector(from["tip"]["at"], "m", at / "tip" / "at")};
    leaf.wire = from.contains("diameter");
    for (const char* key : {"across", "width", "thickness"}) {
      if (leaf.wire && from.contains(key) && std::string(key) != "across")
        throw SpecError((at / key).to_string(), shown(from[key]), "a wire has its diameter alone");
      if (!leaf.wire && !from.contains(key))
        throw SpecError((at / key).to_string(), "nothing",
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
    if (from.contains("material")) leaf.material = material_of(from["material"]);
    if (from.contains("curve"))
      leaf.curve = number(from["curve"]["angle"], "rad", at / "curve" / "angle");
    if (from.contains("reinforcement")) {
      const json& thick = from["reinforcement"];
      const Pointer here = at / "reinforcement";
      if (!thick["rigid"].get<bool>())
        throw SpecError((here / "rigid").to_string(), "false",
                        "this version reinforces leaves by rigid boxes; an elastic middle is a "
                        "leaf of its own between two bodies");
      if (leaf.wire || leaf.curve)
        throw SpecError(here.to_string(), shown(thick), "of a flat leaf of given width only");
      leaf.reinforcement = {number(thick["fraction"], "1", here / "fraction"),
                            number(thick["thickness"], "m", here / "thickness")};
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
    joint.body = from["body"];
    joint.other = from["other"];
    joint.at = vector(from["at"], "m", at / "at");
    joint.axis[2].constant = 1;
    const bool has_axis = joint.type == JointType::revolute || joint.type == JointType::prismatic;
    if (has_axis != from.contains("axis"))
      throw SpecError((at / "axis").to_string(), has_axis ? "nothing" : shown(from["axis"]),
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
    spring.body = from["body"];
    spring.other = from["other"];
    spring.at = vector(from["at"], "m", at / "at");
    if (from.contains("matrix") == from.contains("stiffness"))
      throw SpecError((at / "stiffness").to_string(),
                      from.contains("stiffness") ? shown(from["stiffness"]) : "nothing",
                      "give a stiffness, or the matrix of a bushing, one of the two");
    const bool bushing = from.contains("matrix");
    for (const char* key : {"other_at", "free_length"})
      if (bushing && from.contains(key))
        throw SpecError((at / key).to_string(), shown(from[key]), "a bushing has one place");
    if (bushing) {
      spring.matrix = matrix(from["matrix"], "", at / "matrix");
    } else {
      if (!from.contains("other_at"))
        throw SpecError((at / "other_at").to_string(), "nothing",
                        "it is required: the spring's end on the other body");
      spring.other_at = vector(from["other_at"], "m", at / "other_at");
      spring.stiffness = number(from["stiffness"], "N/m", at / "stiffness");
      if (from.contains("free_length"))
        spring.free_length = number(from["free_length"], "m", at / "free_length");
    }
    plan_.springs.push_back(std::move(spring));
  });
}

std::shared_ptr<const DesignPlan> PlanReader::plan_of_part(const std::string& design,
                                                           const Pointer& at) {
  DesignHead head;
  const auto refuse_circle = [&](const std::string& which) {
    if (std::ranges::find(within_, which) != within_.end())
      throw SpecError(
          at.to_string(), shown(design),
          fmt::format("a design is no part of itself: {} > {}", fmt::join(within_, " > "), which));
  };
  std::vector<std::string> within = within_;
  if (design.ends_with(".json")) {
    const auto file = std::filesystem::path(plan_.source.folder) / design;
    std::error_code error;
    std::string name = std::filesystem::weakly_canonical(file, error).string();
    if (error) name = file.string();
    refuse_circle(name);
    return read_design_file(file.string(), head, within);
  }
  const std::string_view text = library_text(design);
  if (text.empty())
    throw SpecError(at.to_string(), shown(design),
                    "unknown family; " + known_names(design, library_names()) +
                        "; or a path that ends in .json");
  refuse_circle(design);
  within.push_back(design);
  FaultList faults;
  auto plan = read_plan(parse_json(std::string(text), design), library_source(design), head, faults,
                        within);
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
      throw SpecError((here / name).to_string(), shown(value),
                      "the part has no such parameter; " + known_names(name, known));
    const auto option = std::ranges::find(design.options, name, &FamilyOption::name);
    if (option == design.options.end()) continue;
    const std::string choice = value.is_string() ? value.get<std::string>() : shown(value);
    if (std::ranges::find(option->choices, choice) == option->choices.end())
      throw SpecError((here / name).to_string(), shown(value),
                      known_names(choice, option->choices));
    part.choices[name] = choice;
  }
  for (const Parameter& p : design.parameters) {
    if (from["parameters"].contains(p.name)) {
      part.parameters.push_back(number(from["parameters"][p.name], p.unit, here / p.name));
    } else if (p.standard) {
      part.parameters.push_back({*p.standard, nullptr});
    } else {
      throw SpecError((here / p.name).to_string(), "nothing",
                      "the part needs it: " + (p.meaning.empty() ? p.name : p.meaning));
    }
  }
  for (const auto& [inner, outer] : from["join"].items()) part.join.emplace_back(inner, outer);
  return part;
}

void PlanReader::read_parts() {
  each("parts",
       [&](const json& from, const Pointer& at) { plan_.parts.push_back(part(from, at)); });
}

void PlanReader::read_drives() {
  const auto read = [&](const json& from, const Pointer& at) {
    if (!from.is_object() || !faults_.sound(at.to_string())) return;
    faults_.attempt([&] {
      DriveItem drive;
      read_item(from, at, nullptr, drive);
      drive.body = from["body"];
      drive.other = from["other"];
      drive.direction = direction_of(from["direction"]);
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

}  // namespace

DesignSource library_source(const std::string& name) {
  return {.kind = DesignSource::Kind::library,
          .text = {std::string(library_text(name)), name},
          .folder = {},
          .lead = {}};
}

std::shared_ptr<const DesignPlan> read_plan(const json& document, DesignSource source,
                                            DesignHead& head, FaultList& faults,
                                            std::vector<std::string> within) {
  FaultList own;
  auto plan = PlanReader(document, source, own, std::move(within)).read(head);
  if (own.faults().empty()) return plan;
  faults.add(located(source, SpecError(own.faults())));
  return nullptr;
}

std::shared_ptr<const DesignPlan> read_design_file(const std::string& file, DesignHead& head,
                                                   std::vector<std::string> within) {
  DesignSource source{
      .kind = DesignSource::Kind::file, .text = read_text(file), .folder = {}, .lead = {}};
  source.folder = std::filesystem::path(file).parent_path().string();
  std::vector<Fault> wrong;
  const json document = parse_json(source.text, wrong);
  std::error_code error;
  const auto name = std::filesystem::weakly_canonical(file, error);
  within.push_back(error ? file : name.string());
  FaultList faults;
  auto plan = read_plan(document, source, head, faults, std::move(within));
  wrong.insert(wrong.end(), faults.faults().begin(), faults.faults().end());
  if (!wrong.empty()) throw SpecError(std::move(wrong));
  if (head.name.empty()) head.name = std::filesystem::path(file).stem().string();
  return plan;
}

}  // namespace flexopt
