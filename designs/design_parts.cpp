// Parts of a design file: other design files.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/spec/names.hpp"
#include "designs/plan_reader.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

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
  DesignHead head;
  if (from.is_object()) {
    FaultList faults;
    DesignSource source{.kind = DesignSource::Kind::job,
                        .text = {},
                        .folder = plan_.source.folder,
                        .lead = at.to_string()};
    const auto written = read_plan(from, source, head, faults, within_);
    faults.raise();
    auto plan = std::make_shared<DesignPlan>(*written);
    plan->source.lead = plan_.source.lead + source.lead;  // for what is wrong with its geometry
    return plan;
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
    return read_design_file(file.string(), head, within);
  }
  const std::string_view text = library_text(design);
  if (text.empty())
    throw SpecError(at, shown(design),
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
  for (const auto& [inner, outer] : from["join"].items()) part.join.emplace_back(inner, outer);
  return part;
}

void PlanReader::read_parts() {
  each("parts",
       [&](const json& from, const Pointer& at) { plan_.parts.push_back(part(from, at)); });
}

}  // namespace flexopt
