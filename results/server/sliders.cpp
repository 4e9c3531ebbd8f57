#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "results/server/explorer.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

/// The nearest value inside the parameter's range; ends that are excluded by a thousandth of the
/// slider.
void clip(const Parameter& p, Slider& slider) {
  const double margin = 1e-3 * (slider.max - slider.min);
  slider.min = std::max(slider.min, p.open_min ? p.min + margin : p.min);
  slider.max = std::min(slider.max, p.open_max ? p.max - margin : p.max);
}

/// How far a parameter that is zero goes to both sides.
double reach(const Parameter& p, const std::vector<Parameter>& all, const ParameterValues& values) {
  double largest = 0;
  for (const Parameter& other : all)
    if (other.unit == p.unit) largest = std::max(largest, std::abs(values.at(other.name)));
  if (largest > 0) return largest / 2;
  return std::isfinite(p.min) && std::isfinite(p.max) ? std::max(-p.min, p.max) : 0;
}

std::vector<Slider> of_design(const Job& job) {
  const Family& family = resolve(job.design)->family();
  std::vector<Slider> sliders;
  for (const Parameter& p : family.parameters) {
    if (job.design.expressions.contains(p.name)) continue;
    const double value = job.design.parameters.at(p.name);
    Slider slider{p.name, p.unit, p.meaning, value};
    slider.whole = std::ranges::find(family.counts, p.name) != family.counts.end();
    std::tie(slider.min, slider.max) = std::minmax(value / 2, 2 * value);
    if (value == 0) {
      const double far = reach(p, family.parameters, job.design.parameters);
      slider.min = -far;
      slider.max = far;
    }
    clip(p, slider);
    if (slider.whole) {
      slider.min = std::ceil(slider.min);
      slider.max = std::floor(slider.max);
    }
    if (slider.min < slider.max) sliders.push_back(std::move(slider));
  }
  return sliders;
}

std::vector<Slider> of_variables(const Job& job) {
  const Family& family = resolve(job.design)->family();
  const ParameterValues numbers = numbers_of(job.design.material, job.end_effector);
  std::vector<Slider> sliders;
  for (const Variable& v : job.optimise->variables) {
    const Parameter& p = *find_parameter(family, v.parameter);
    const auto& values = job.design.parameters.contains(p.name) ? job.design.parameters : numbers;
    const double value = v.start.value_or(values.at(p.name));
    sliders.push_back({p.name, p.unit, p.meaning, std::clamp(value, v.min, v.max), v.min, v.max});
  }
  return sliders;
}

/// Pointer to a number in the document of a job.
Pointer place_of(const std::string& name) {
  if (!find_job_number(name)) return Pointer("/design/parameters") / name;
  const std::size_t dot = name.find('.');
  const std::string section = name.substr(0, dot), rest = name.substr(dot + 1);
  if (section == "material") return Pointer("/design/material") / rest;
  const std::size_t second = rest.find('.');
  return Pointer("/" + section) / rest.substr(0, second);
}

/// A component of the centre of mass, or of the inertia, which is written out.
void set_component(const std::string& name, double value, json& place) {
  const auto axis = [&](std::size_t from_end) {
    return static_cast<std::size_t>(name[name.size() - from_end] - 'x');
  };
  if (name.find("center_of_mass") != std::string::npos) {
    place.at(axis(1)) = value;
    return;
  }
  if (place.at(0).is_number()) {  // principal moments
    json whole = json::array();
    for (std::size_t i = 0; i < 3; ++i) {
      whole.push_back({0.0, 0.0, 0.0});
      whole[i][i] = place.at(i);
    }
    place = std::move(whole);
  }
  place.at(axis(2)).at(axis(1)) = value;
  place.at(axis(1)).at(axis(2)) = value;
}

}  // namespace

std::vector<Slider> sliders_of(const Job& job) {
  if (!job.designs.empty())
    throw SpecError("/designs", fmt::format("{} designs", job.designs.size()),
                    "a job of one design can be explored");
  if (job.kind == JobKind::compare)
    throw SpecError("/job", "compare", "expected \"evaluate\" or \"optimise\" to explore a design");
  std::vector<Slider> sliders = job.kind == JobKind::optimise ? of_variables(job) : of_design(job);
  if (sliders.empty())
    throw SpecError("/design/parameters", "no number that can be moved",
                    "expected a design with parameters that are numbers");
  return sliders;
}

ParameterValues read_move(const std::string& body, const std::vector<Slider>& sliders) {
  const json document = parse_json(body, "the request");
  if (!document.is_object() || document.size() != 1 || !document.contains("parameters") ||
      !document["parameters"].is_object())
    throw SpecError("", shown(document), "expected {\"parameters\": {name: number}}");
  std::vector<std::string> known;
  for (const Slider& slider : sliders) known.push_back(slider.name);
  ParameterValues values;
  for (const auto& [name, value] : document["parameters"].items()) {
    const std::string at = (Pointer("/parameters") / name).to_string();
    const auto slider = std::ranges::find(sliders, name, &Slider::name);
    if (slider == sliders.end())
      throw SpecError(at, shown(value), "it cannot be moved; " + known_names(name, known));
    const std::string unit = slider->unit == "1" ? "" : " " + slider->unit;
    const auto wrong = [&, &value = value] {
      return SpecError(at, shown(value),
                       fmt::format("expected a {}number from {:g} to {:g}{}",
                                   slider->whole ? "whole " : "", slider->min, slider->max, unit));
    };
    if (!value.is_number()) throw wrong();
    const double number = value;
    if (!(slider->min <= number && number <= slider->max)) throw wrong();
    if (slider->whole && number != std::round(number)) throw wrong();
    values[name] = number;
  }
  return values;
}

json moved_job(const Job& job, const ParameterValues& values) {
  json document = document_of(job);
  document.erase("expect");
  for (const auto& [name, value] : values) {
    json& place = document.at(place_of(name));
    if (place.is_array())
      set_component(name, value, place);
    else
      place = value;
  }
  // the width of a wire follows from its thickness, although the job has no formula for it
  for (const auto& [name, formula] : job.design.expressions)
    if (document.at(place_of(name)).is_number()) document["design"]["parameters"].erase(name);
  if (job.kind == JobKind::optimise)
    for (json& variable : document["optimise"]["variables"])
      if (const auto moved = values.find(variable["parameter"]); moved != values.end())
        variable["start"] = moved->second;
  return document;
}

}  // namespace flexopt
