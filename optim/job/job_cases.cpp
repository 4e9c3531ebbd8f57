#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

/// Keys of a job that a case may have instead: what acts on the mechanism, and where it goes.
const std::vector<std::string>& case_keys() {
  static const std::vector<std::string> keys{"loads",    "gravity", "temperature", "assembly",
                                             "buckling", "stroke",  "load_path"};
  return keys;
}

constexpr std::size_t most_cases = 50;
constexpr std::size_t longest_name = 50;

Pointer at_case(const std::string& name) { return Pointer("/cases") / name; }

bool is_plain(const std::string& name) {
  return !name.empty() && name.size() <= longest_name && std::ranges::all_of(name, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  });
}

/// What stands around the cases is wrong in itself.
void check_cases(const json& cases, FaultList& faults) {
  if (!cases.is_object() || cases.empty() || cases.size() > most_cases) {
    faults.add("/cases", shown(cases),
               fmt::format("expected an object of 1 to {} load cases by their names", most_cases));
    return;
  }
  for (const auto& [name, own] : cases.items()) {
    if (!is_plain(name))
      faults.add({.pointer = at_case(name).to_string(),
                  .value = shown(name),
                  .rule = fmt::format("a load case has a name of 1 to {} letters, digits, _ and -",
                                      longest_name),
                  .of_key = true});
    if (!own.is_object())
      faults.add(
          at_case(name).to_string(), shown(own),
          fmt::format("expected an object with some of the keys {}", fmt::join(case_keys(), ", ")));
  }
}

/// Keys that a case cannot have instead of the job.
void check_keys(const json& cases, FaultList& faults) {
  for (const auto& [name, own] : cases.items())
    for (const auto& [key, value] : own.items())
      if (std::ranges::find(case_keys(), key) == case_keys().end())
        faults.add({.pointer = (at_case(name) / key).to_string(),
                    .value = shown(value),
                    .rule = "unknown key of a load case; " + known_names(key, case_keys()),
                    .of_key = true});
}

/// The document with one case alone.
json document_of_case(const json& document, const json& own) {
  json one = document;
  one.erase("cases");
  if (own.contains("stroke")) one.erase("load_path");
  if (own.contains("load_path")) one.erase("stroke");
  for (const std::string& key : case_keys())
    if (own.contains(key)) one[key] = own[key];
  return one;
}

/// The key of a job that a place lies in.
std::string key_of(const std::string& pointer) {
  return pointer.empty() ? "" : pointer.substr(1, pointer.find('/', 1) - 1);
}

/// Pointer in the document of the job for a pointer in the document of one load case.
std::string place_in_cases(const std::string& pointer, const std::string& name, const json& own) {
  return own.contains(key_of(pointer)) ? at_case(name).to_string() + pointer : pointer;
}

/// What only some cases find wrong in what they share says which they are.
void add_faults(const json& cases, std::map<std::string, std::vector<Fault>>&& found,
                FaultList& faults) {
  std::map<std::pair<std::string, std::string>, std::size_t> times;
  for (const auto& [name, list] : found)
    for (const Fault& fault : list) ++times[{fault.pointer, fault.rule}];
  for (auto& [name, list] : found)
    for (Fault& fault : list) {
      const bool own = cases[name].contains(key_of(fault.pointer));
      if (fault.source.empty() && own) {
        fault.pointer = place_in_cases(fault.pointer, name, cases[name]);
      } else if (times[{fault.pointer, fault.rule}] < cases.size()) {
        fault.rule += fmt::format(" (in the load case \"{}\")", name);
      }
      faults.add(std::move(fault));
    }
}

/// Whether some case leaves the key to the job.
bool is_inherited(const json& cases, const std::string& key) {
  return std::ranges::any_of(cases, [&](const json& own) {
    const bool other_motion = (key == "stroke" && own.contains("load_path")) ||
                              (key == "load_path" && own.contains("stroke"));
    return !own.contains(key) && !other_motion;
  });
}

/// The whole job as read: what the cases share, and what each has of its own.
json document_as_read(const json& cases, const std::map<std::string, Job>& jobs) {
  json all = document_of(jobs.begin()->second);
  for (const std::string& key : case_keys()) all.erase(key);
  all["cases"] = json::object();
  for (const auto& [name, job] : jobs) {
    json& entry = all["cases"][name] = json::object();
    for (const std::string& key : case_keys()) {
      if (!document_of(job).contains(key)) continue;
      (cases[name].contains(key) ? entry : all)[key] = document_of(job)[key];
    }
  }
  return all;
}

}  // namespace

Field cases_field(const std::vector<Field>& of_job) {
  std::vector<Field> fields;
  for (Field field : of_job) {
    if (std::ranges::find(case_keys(), field.name) == case_keys().end()) continue;
    field.default_value = nullptr;  // the job's own is the default
    fields.push_back(std::move(field));
  }
  return shape::optional("cases", shape::map(shape::record(std::move(fields))),
                         "load cases by their names, each with what it has instead of the job's "
                         "own; goals are over all of them");
}

Job read_cases(const json& document, FaultList& faults,
               const std::function<Job(const json& document, const CaseNames& cases,
                                       FaultList& faults)>& read_one) {
  const json& cases = document["cases"];
  check_cases(cases, faults);
  if (!faults.faults().empty()) return {};
  check_keys(cases, faults);
  CaseNames names;
  for (const auto& [name, own] : cases.items()) names.all.push_back(name);
  std::map<std::string, Job> jobs;
  std::map<std::string, std::vector<Fault>> found;
  for (const auto& [name, own] : cases.items()) {
    FaultList of_case;
    names.own = name;
    jobs.emplace(name, read_one(document_of_case(document, own), names, of_case));
    found[name] = of_case.faults();
  }
  add_faults(cases, std::move(found), faults);
  // Items that no case uses are checked, too.
  std::vector<std::string> unused;
  for (const std::string& key : case_keys())
    if (document.contains(key) && !is_inherited(cases, key)) unused.push_back(key);
  if (!unused.empty()) {
    FaultList plain;
    names.own.clear();
    (void)read_one(document_of_case(document, json::object()), names, plain);
    for (const Fault& fault : plain.faults())
      if (std::ranges::find(unused, key_of(fault.pointer)) != unused.end()) faults.add(fault);
  }
  if (!faults.faults().empty()) return {};

  Job job = jobs.begin()->second;
  for (const auto& [name, one] : jobs) {
    job.cases.push_back({name, one.request});
    for (const std::string& note : one.notes)
      if (std::ranges::find(job.notes, note) == job.notes.end()) job.notes.push_back(note);
  }
  const auto driven = [](const JobCase& one) { return one.request.loads.driven(); };
  if (const auto& box = job.assembly_tolerances;
      box && box->drive_load_change && std::ranges::none_of(job.cases, driven))
    faults.add("/assembly_tolerances/drive_load_change",
               shown(document["assembly_tolerances"]["drive_load_change"]),
               "nothing is driven in any load case");
  for (const std::string& key : unused)
    job.notes.push_back(fmt::format("No load case uses the job's own {}: each has another.", key));
  job.as_read = std::make_shared<const json>(document_as_read(cases, jobs));
  return job;
}

}  // namespace flexopt
