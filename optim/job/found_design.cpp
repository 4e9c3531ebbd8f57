// A job at another design: at given numbers, or at what a finished run found.
#include "optim/job/found_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/design_plan.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;
namespace fs = std::filesystem;

namespace {

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

/// The result.json of a finished run, or of its best design. Throws SpecError at `pointer`.
json finished_result(const fs::path& folder, const std::string& pointer) {
  const auto refuse = [&](const std::string& rule) {
    return SpecError(pointer, folder.string(),
                     "expected the output folder of a finished run" + rule);
  };
  if (!fs::is_directory(folder)) throw refuse(": there is no such folder");
  if (!fs::exists(folder / "result.json")) throw refuse(": it has no result.json");
  const auto read = [&](const char* name) {  // results may be larger than files of users
    std::ifstream file(folder / name);
    return json::parse(file, nullptr, false);
  };
  json result = read("result.json");
  if (!result.is_object() || !result.contains("job"))
    throw refuse(": its result.json is of no run");
  if (fs::exists(folder / "job.json") && read("job.json") != result["job"])
    throw refuse(": its result.json is of an earlier run than its job.json");
  if (result.contains("ranking")) {
    json best = result["ranking"].empty() ? json() : result["ranking"][0].value("result", json());
    if (!best.is_object()) throw refuse(" of which a design was ranked");
    result = std::move(best);
  }
  if (!result["job"].contains("design")) throw refuse(" of one design, or of ranked ones");
  return result;
}

/// Whether --set gives the number at a place: by its own pointer, or, unless `alone`, by that of
/// what holds it or of a part.
bool is_set(const Pointer& place, const std::vector<std::string>& overrides, bool alone = false) {
  const std::string own = place.to_string();
  return std::ranges::any_of(overrides, [&](const std::string& assignment) {
    const std::string set = assignment.substr(0, assignment.find('='));
    return set == own || (!alone && (own.starts_with(set + "/") || set.starts_with(own + "/")));
  });
}

/// Whether a parameter of the job is a formula that the job gives: a wire's width is none.
bool has_formula(const Job& job, const std::string& name) {
  return document_of(job).at(place_of(name)).is_object() &&
         !(name == "width" && may_be_wire(job.design.resolved->family()) &&
           job.design.choices.at("section") == "circular");
}

/// The overrides, and, where options differ or the run has formulas for numbers of the job, the
/// design of the run: defaults of the model and a wire's width follow as the job is read again.
std::vector<std::string> with_design_of(const FoundDesign& found, const Job& job,
                                        const std::vector<std::string>& overrides) {
  std::vector<std::string> all = overrides;
  for (const auto& [name, choice] : found.choices)
    if (job.design.choices.at(name) != choice)
      all.push_back(fmt::format("/design/{}={}", name, json(choice).dump()));
  const auto take = [&](const std::string& name, const json& value) {
    if (job.design.parameters.contains(name) && !has_formula(job, name) &&
        !is_set(place_of(name), overrides))
      all.push_back(fmt::format("{}={}", place_of(name).to_string(), value.dump()));
  };
  const json& own = found.job["design"]["parameters"];
  for (const auto& [name, value] : own.items())
    if (value.is_object()) take(name, value);
  if (all.size() > overrides.size())
    for (const auto& [name, value] : found.parameters)
      if (!own.contains(name) || !own[name].is_object()) take(name, value);
  return all;
}

}  // namespace

FoundDesign found_design(const std::string& folder, const std::string& pointer) {
  const json result = finished_result(folder, pointer);
  FoundDesign found{result["job"], {}, {}};
  const json optimum = result.value("optimum", json());
  const bool optimised = optimum.is_object() && optimum.value("parameters", json()).is_object();
  if (found.job.value("job", "") == "optimise" && !optimised)
    throw SpecError(pointer, folder, "expected a run that found a design");
  for (const auto& [name, value] :
       (optimised ? optimum["parameters"] : found.job["design"]["parameters"]).items())
    if (value.is_number()) found.parameters[name] = value;
  for (const auto& [name, value] : found.job["design"]["parameters"].items())
    if (value.is_string()) found.choices[name] = value;
  return found;
}

json design_of(const FoundDesign& found) {
  json design = found.job["design"];
  for (const auto& [name, value] : found.parameters)
    if (name.starts_with("material."))
      design["material"][name.substr(9)] = value;
    else if (!find_job_number(name) && !design["parameters"][name].is_object())
      design["parameters"][name] = value;
  return design;
}

json with_found_design(json document, const std::string& folder, FaultList& faults) {
  if (!document.is_object() || !document.contains("design")) return document;
  const json written = document["design"];
  if (!written.is_object() || !written.contains("result") || !written["result"].is_string() ||
      written.contains("family") || written.contains("file") || written.contains("mechanism"))
    return document;
  faults.attempt([&] {
    const auto at = fs::path(folder) / written["result"].get<std::string>();
    document["design"] = design_of(found_design(at.string(), "/design/result"));
    json own = written;
    own.erase("result");
    if (own.contains("material")) document["design"].erase("material");  // one or the other
    document["design"].merge_patch(own);
  });
  return document;
}

json moved_job(const Job& job, const ParameterValues& values) {
  json document = document_of(job);
  document.erase("expect");
  for (const auto& [name, value] : values) {
    json& place = document.at(place_of(name));
    if (place.is_array())
      set_component(name, value, place);
    else if (!place.is_object())  // a formula stays one
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

Job read_job_at(const std::string& file, const std::vector<std::string>& overrides,
                const std::string& result) {
  Job job = read_job(file, overrides);
  if (result.empty()) return job;
  demand_one_design(job, "a job of one design can be looked at where another run ended");
  const ParameterValues numbers = numbers_of(job.design.material, job.end_effector);
  std::vector<std::string> known;
  for (const auto& [name, value] : job.design.parameters) known.push_back(name);
  for (const auto& [name, choice] : job.design.choices) known.push_back(name);
  const auto demand_known = [&](const std::string& name, bool is_known) {
    if (!is_known)
      throw SpecError("--result", result,
                      fmt::format("the run is of another design: it has a parameter {}, the job's "
                                  "design has none; {}",
                                  name, known_names(name, known)));
  };
  FoundDesign found = found_design(result, "--result");
  for (const auto& [name, value] : found.parameters)
    demand_known(name, job.design.parameters.contains(name) || numbers.contains(name));
  for (const auto& [name, choice] : found.choices)
    demand_known(name, job.design.choices.contains(name));
  std::erase_if(found.parameters,
                [&](const auto& entry) { return is_set(place_of(entry.first), overrides); });
  std::erase_if(found.choices, [&](const auto& entry) {
    return is_set(place_of(entry.first), overrides) ||
           is_set(Pointer("/design") / entry.first, overrides);
  });
  const std::vector<std::string> all = with_design_of(found, job, overrides);
  if (all.size() > overrides.size()) job = read_job(file, all);
  json moved = moved_job(job, found.parameters);
  for (std::size_t k = 0; job.optimise && k < job.optimise->variables.size(); ++k)
    if (const Pointer start = Pointer("/optimise/variables") / k / "start";
        is_set(start, overrides, true))
      moved[start] = document_of(job).at(start);
  return parse_job(moved);
}

Job beside_rigid(const Job& job) {
  const std::string name = "--rigid";
  demand_one_design(job, "--rigid compares a design with itself");
  if (job.kind != JobKind::evaluate)
    throw SpecError(name, job.name,
                    "it is for an evaluation: flexopt new FOLDER makes one of a run");
  if (!job.design.choices.contains(elastic_bodies_option))
    throw SpecError(name, job.name, "the design has no elastic bodies but hinges");
  json document = document_of(job), design = document["design"];
  document.erase("design");
  for (const char* bodies : {"elastic", "rigid"}) {
    design["name"] = design[elastic_bodies_option] = bodies;
    document["designs"].push_back(design);
  }
  return parse_job(document);
}

}  // namespace flexopt
