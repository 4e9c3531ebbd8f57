#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/spec/names.hpp"
#include "core/spec/quantity.hpp"
#include "designs/plan_reader.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

/// "50 N/mm" as formulas write it, "50 [N/mm]": a number and a unit of several symbols. A unit of
/// one symbol needs no brackets.
std::optional<std::string> compound_quantity(const std::string& text) {
  const char *begin = text.data(), *behind = begin + text.size();
  double number = 0;
  const auto [end, error] = std::from_chars(begin, behind, number);  // whatever the locale
  std::string unit(end, behind);
  unit.erase(0, unit.find_first_not_of(' '));
  if (error != std::errc() || unit.empty() ||
      !std::isalpha(static_cast<unsigned char>(unit.front())) ||
      unit.find_first_of(" /*^") == std::string::npos || !is_known_unit(unit))
    return std::nullopt;
  return fmt::format("{} [{}]", std::string(begin, end), unit);
}

}  // namespace

std::shared_ptr<const DesignPlan> PlanReader::read() {
  if (!read_.is_object()) return nullptr;
  read_head();
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
  if (plan_.has_elastic_bodies())
    plan_.options.push_back({elastic_bodies_option,
                             {"elastic", "rigid"},
                             "rigid: frames, stages, levers weigh the same and do not bend"});
  for (const Parameter& p : plan_.parameters)
    if (!used_.contains(p.name)) plan_.unused.push_back("/parameters/" + p.name);
  for (const FormulaName& let : plan_.lets)
    if (!used_.contains(let.name)) plan_.unused.push_back("/let/" + let.name);
  return std::make_shared<const DesignPlan>(std::move(plan_));
}

void PlanReader::read_head() {
  plan_.name = read_.value("name", "");
  plan_.summary = read_.value("summary", "");
  if (read_.contains("drawing")) {
    plan_.drawing = "\n";
    for (const json& line : read_["drawing"]) plan_.drawing += line.get<std::string>() + "\n";
  }
  if (read_.contains("mesh")) plan_.mesh = read_["mesh"].get<std::vector<int>>();
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

Formula PlanReader::formula(std::string text, const std::vector<FormulaName>& names,
                            const Pointer& at) {
  for (const std::string& word : words_of(text))
    if (lost_.contains(word)) faults_.spoil(at);
  return Formula(std::move(text), names, at.to_string());
}

std::shared_ptr<const Formula> PlanReader::used(Formula formula) {
  used_.insert(formula.names().begin(), formula.names().end());
  return std::make_shared<const Formula>(std::move(formula));
}

void PlanReader::read_parameter(const std::string& name, const json& from, const Pointer& at) {
  check_name(name, at);
  Parameter p;
  p.name = name;
  p.unit = from["unit"];
  const std::optional<Measure> unit = measured(1, p.unit);
  if (p.unit != "1" && (!unit || unit->value != 1 || !is_known_unit(p.unit)))  // " m" is none
    throw SpecError(at / "unit", shown(from["unit"]),
                    "expected an SI unit such as \"m\", \"rad\", \"kg\", or \"1\"");
  p.meaning = from.value("meaning", "");
  const auto bound = [&](const char* key) -> std::optional<double> {
    if (!from.contains(key)) return std::nullopt;
    return read_quantity(shape::quantity(p.unit), from[key], at / key);
  };
  for (const auto& [closed, open] : {std::pair{"min", "above"}, {"max", "below"}})
    if (from.contains(closed) && from.contains(open))
      throw SpecError(at / open, shown(from[open]),
                      fmt::format("give {} or {}, one of the two", closed, open));
  p.open_min = from.contains("above");
  p.open_max = from.contains("below");
  p.min = bound(p.open_min ? "above" : "min").value_or(p.min);
  p.max = bound(p.open_max ? "below" : "max").value_or(p.max);
  const Shape in_range = shape::quantity(p.unit, p.min, p.max, p.open_min, p.open_max);
  if (from.contains("default"))
    p.default_value = read_quantity(in_range, from["default"], at / "default");
  if (from.contains("example")) {
    if (p.default_value)
      throw SpecError(at / "example", shown(from["example"]),
                      "there is a default: an example is for a parameter without one");
    plan_.examples[name] = read_quantity(in_range, from["example"], at / "example");
  }
  names_.push_back({p.name, p.unit});
  plan_.parameters.push_back(std::move(p));
}

void PlanReader::read_parameters() {
  const auto take = [&](const std::string& name) {
    const Pointer at = Pointer("/parameters") / name;
    if (!faults_.sound(at) ||
        !faults_.attempt([&] { read_parameter(name, read_["parameters"][name], at); }))
      lost_.insert(name);
  };
  const std::vector<std::string> order = keys_in_text(plan_.source.text.text, "parameters");
  for (const std::string& name : order)
    if (read_["parameters"].contains(name)) take(name);
  for (const auto& [name, from] : read_["parameters"].items())
    if (std::ranges::find(order, name) == order.end()) take(name);
}

void PlanReader::read_options() {
  // what a job says beside "parameters" in its design
  constexpr std::array taken{"family",     "file",     "mechanism",
                             "parameters", "material", elastic_bodies_option};
  for (const auto& [name, from] : read_["options"].items()) {
    const Pointer at = Pointer("/options") / name;
    if (!faults_.sound(at)) continue;
    const auto refuse = [&](const Pointer& where, const std::string& value, const char* rule) {
      faults_.add(where, shown(value), rule);
    };
    if (std::ranges::find(taken, name) != taken.end())
      refuse(at, name, "it has a meaning of its own in a job's design: another name");
    if (read_["parameters"].contains(name)) refuse(at, name, "a parameter has this name");
    FamilyOption option{name, from["choices"].get<std::vector<std::string>>(),
                        from.value("meaning", "")};
    for (std::size_t k = 1; k < option.choices.size(); ++k)
      if (std::find(option.choices.begin(), option.choices.begin() + k, option.choices[k]) !=
          option.choices.begin() + k)
        refuse(at / "choices" / k, option.choices[k], "it is listed already");
    plan_.options.push_back(std::move(option));
  }
}

void PlanReader::read_lets() {
  std::map<std::string, json> open;
  for (const auto& [name, from] : read_["let"].items()) {
    const Pointer at = Pointer("/let") / name;
    if (faults_.sound(at) && faults_.attempt([&, &name = name] { check_name(name, at); }))
      open[name] = from;
    else
      lost_.insert(name);
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
      lost_.insert(circle.begin(), circle.end());
      faults_.add(Pointer("/let") / circle.front(), shown(open.begin()->second),
                  fmt::format("these need each other in a circle: {}", fmt::join(circle, ", ")));
      return;
    }
    const auto& [name, from] = *ready;
    const Pointer at = Pointer("/let") / name;
    DesignNumber value;
    std::string unit;  // unit; a bare number has none
    faults_.attempt([&, &from = from] {
      if (from.is_number()) {
        value.constant = from;
        return;
      }
      std::string text = from;
      const auto words = words_of(text);
      const bool has_names =
          std::ranges::any_of(names_, [&](const auto& n) { return words.contains(n.name); });
      if (!has_names) text = compound_quantity(text).value_or(text);
      Formula number = formula(text, names_, at);
      if (number.dimension()) unit = unit_of(*number.dimension());
      value.formula = used(std::move(number));
    });
    plan_.lets.push_back({name, unit});
    plan_.let_numbers.push_back(std::move(value));
    names_.push_back({name, unit});
    open.erase(ready);
  }
}

void PlanReader::read_rules() {
  faults_.each(read_["rules"], Pointer("/rules"), [&](const json& from, const Pointer& at) {
    if (!from.is_object()) return;
    const std::string that = from["that"];
    const Pointer where = at / "that";
    if (that.find_first_of("<>=") == std::string::npos)
      throw SpecError(where, shown(that), "a rule compares: \"spacing > 2*thickness\"");
    plan_.rules.push_back({where.to_string(), *used(formula(that, names_, where)), from["else"]});
  });
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
        throw SpecError(at, shown(text), "expected \"OPTION == CHOICE\" or !=");
      const std::string name = trimmed(sides[0]), choice = trimmed(sides[1]);
      const auto option = std::ranges::find(plan_.options, name, &FamilyOption::name);
      if (option == plan_.options.end())
        throw SpecError(at, shown(text),
                        fmt::format("there is no option '{}'; {}", name,
                                    known_names(name, names_in(plan_.options))));
      if (std::ranges::find(option->choices, choice) == option->choices.end())
        throw SpecError(at, shown(text),
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
  if (kind != nullptr && from.value("name", "").empty())
    throw SpecError(at / "name", "nothing",
                    fmt::format("it is required: what the {} is called", kind));
  if (from.contains("when")) item.when = condition(from["when"], at / "when");
  if (from.contains("repeat")) read_repeat(from["repeat"], at / "repeat", item);
  item.name = name(from.value("name", ""), at / "name", item);
  item.frame = name(from.value("frame", ""), at / "frame", item);
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
    Formula of_names = formula(text, names_, at);
    of_names.check_unit(unit);
    result.formula = used(std::move(of_names));
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
      const std::size_t rotations = (i >= 3 ? 1u : 0u) + (j >= 3 ? 1u : 0u);
      const char* const of_bushing[] = {"N/m", "N/rad", "N m/rad"};  // or N and N m
      result.push_back(number(from[i][j], unit.empty() ? of_bushing[rotations] : unit, at / i / j));
    }
  }
  return result;
}

DesignSize PlanReader::size(const json& from, const Pointer& at) {
  DesignSize result;
  if (from.is_object()) {
    const Pointer where = at / "profile";
    if (std::ranges::find(names_, "s", &FormulaName::name) != names_.end())
      throw SpecError(where, shown(from["profile"]),
                      "s is the place along the leaf here: another name for the other s");
    std::vector<FormulaName> names = names_;
    names.push_back({"s", "1"});
    Formula profile = formula(from["profile"].get<std::string>(), names, where);
    profile.check_unit("m");
    result.profile = used(std::move(profile));
  } else if (from.is_array()) {
    result.base = number(from[0], "m", at / 0);
    result.tip = number(from[1], "m", at / 1);
  } else {
    result.base = number(from, "m", at);
  }
  return result;
}

DesignSource library_source(const std::string& name) {
  return {.kind = DesignSource::Kind::library,
          .text = {std::string(library_text(name)), name},
          .folder = {},
          .lead = {}};
}

std::shared_ptr<const DesignPlan> read_plan(const json& document, const DesignSource& source,
                                            FaultList& faults, std::vector<std::string> within) {
  FaultList own;
  auto plan = PlanReader(document, source, own, std::move(within)).read();
  if (own.faults().empty()) return plan;
  faults.add(located(source, SpecError(own.faults())));
  return nullptr;
}

std::shared_ptr<const DesignPlan> read_design_file(const std::string& file,
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
  auto plan = read_plan(document, source, faults, std::move(within));
  wrong.insert(wrong.end(), faults.faults().begin(), faults.faults().end());
  if (!wrong.empty()) throw SpecError(std::move(wrong));
  return plan;
}

}  // namespace flexopt
