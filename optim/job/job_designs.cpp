#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/spec/json_file.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

constexpr std::size_t most_listed = 100;
/// Keys of an entry that are not the design's own.
constexpr const char* own_keys[] = {"name", "variables"};

std::string at_design(std::size_t k) { return fmt::format("/designs/{}", k); }

/// Label of an entry: its name, else the origin of its design.
std::string label_of(const json& entry) {
  const auto text = [](const json& record, const char* key) {
    return record.is_object() && record.contains(key) && record[key].is_string()
               ? record[key].get<std::string>()
               : std::string();
  };
  for (const char* key : {"name", "family"})
    if (const std::string name = text(entry, key); !name.empty()) return name;
  if (const std::string file = text(entry, "file"); !file.empty())
    return std::filesystem::path(file).stem().string();
  const std::string name = entry.contains("mechanism") ? text(entry["mechanism"], "name") : "";
  return name.empty() ? "design" : name;
}

/// A name that a folder can have everywhere.
std::string folder_of(const std::string& label) {
  std::string folder;
  for (const char c : label) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    folder += plain ? c : '_';
  }
  return folder.empty() ? "design" : folder;
}

std::string unused(const std::string& name, const std::set<std::string>& taken) {
  std::string other = name;
  for (int n = 2; taken.contains(other); ++n) other = fmt::format("{}_{}", name, n);
  return other;
}

/// The document with one design alone.
json document_of_design(const json& document, std::size_t k, const std::string& label) {
  const json& entry = document["designs"][k];
  json one = document;
  one.erase("designs");
  one.erase("material");
  if (k > 0) one.erase("expect");
  one["name"] = label;
  json design = entry;
  for (const char* key : own_keys) design.erase(key);
  if (!design.contains("material") && document.contains("material"))
    design["material"] = document["material"];
  one["design"] = std::move(design);
  if (entry.contains("variables") && one.contains("optimise") && one["optimise"].is_object())
    one["optimise"]["variables"] = entry["variables"];
  return one;
}

bool shares_material(const json& document, std::size_t k) {
  return !document["designs"][k].contains("material") && document.contains("material");
}

/// Pointer in the document of the job for a pointer in the document of one design.
std::string place_in_list(const std::string& pointer, std::size_t k, bool shared_material) {
  const auto moved = [&](const std::string& from, const std::string& to) -> std::string {
    if (pointer != from && !pointer.starts_with(from + "/")) return "";
    return to + pointer.substr(from.size());
  };
  if (shared_material)
    if (std::string place = moved("/design/material", "/material"); !place.empty()) return place;
  if (std::string place = moved("/design", at_design(k)); !place.empty()) return place;
  if (std::string place = moved("/optimise/variables", at_design(k) + "/variables"); !place.empty())
    return place;
  return pointer;
}

struct PlacedFault {
  Fault fault;
  std::size_t design;
};

/// What only some designs find wrong in what they share says which they are.
void add_faults(std::vector<PlacedFault> found, const std::vector<std::string>& labels,
                FaultList& faults) {
  std::map<std::pair<std::string, std::string>, std::size_t> times;
  for (const PlacedFault& f : found) ++times[{f.fault.pointer, f.fault.rule}];
  for (PlacedFault& f : found) {
    const bool shared = f.fault.source.empty() && !f.fault.pointer.starts_with("/designs/");
    if (shared && times[{f.fault.pointer, f.fault.rule}] < labels.size())
      f.fault.rule += fmt::format(" (so says the design \"{}\")", labels[f.design]);
    faults.add(std::move(f.fault));
  }
}

/// Checks the items around the list of designs.
void check_list(const json& document, FaultList& faults) {
  const json& list = document["designs"];
  if (!list.is_array() || list.empty() || list.size() > most_listed)
    faults.add("/designs", shown(list),
               fmt::format("expected a list of 1 to {} designs", most_listed));
  else
    for (std::size_t k = 0; k < list.size(); ++k)
      if (!list[k].is_object())
        faults.add(at_design(k), shown(list[k]),
                   "expected an object: a design as under \"design\", and its variables");
  if (document.contains("name") && !document["name"].is_string())
    faults.add("/name", shown(document["name"]), "expected a text");
  if (document.contains("design"))
    faults.add("/design", "an object", "give a design or a list of designs, one of the two");
  if (document.value("job", json()) == "compare")
    faults.add("/designs", "a list", "a job \"compare\" takes one design");
  if (document.contains("optimise") && document["optimise"].is_object() &&
      document["optimise"].contains("variables"))
    faults.add("/optimise/variables", shown(document["optimise"]["variables"]),
               "of several designs each has its own: /designs/0/variables and so on");
}

/// Names that users gave are different; the others are made so.
std::vector<std::string> labels_of(const json& list, FaultList& faults) {
  std::vector<std::string> labels;
  std::set<std::string> taken;
  for (const json& entry : list)
    if (entry.contains("name")) taken.insert(label_of(entry));
  std::set<std::string> given;
  for (std::size_t k = 0; k < list.size(); ++k) {
    std::string label = label_of(list[k]);
    if (list[k].contains("name")) {
      if (!list[k]["name"].is_string() || label.size() > 100 || list[k]["name"] == "")
        faults.add(at_design(k) + "/name", shown(list[k]["name"]),
                   "expected a name of 1 to 100 letters");
      else if (!given.insert(label).second)
        faults.add(at_design(k) + "/name", shown(list[k]["name"]), "names must be different");
    } else {
      label = unused(label, taken);
    }
    taken.insert(label);
    labels.push_back(std::move(label));
  }
  return labels;
}

/// The whole job as read: what the designs share, and each with all its numbers.
json document_as_read(const json& document, const std::vector<ListedDesign>& designs) {
  json all = document_of(*designs.front().job);
  const bool own_mesh = document.contains("model") && document["model"].is_object() &&
                        document["model"].contains("mesh");
  if (!own_mesh) all["model"].erase("mesh");  // each family has its own
  all.erase("design");
  if (all.contains("optimise")) all["optimise"].erase("variables");
  all["designs"] = json::array();
  for (const ListedDesign& listed : designs) {
    const json& one = document_of(*listed.job);
    json entry = one["design"];
    entry["name"] = listed.label;
    if (one.contains("optimise")) entry["variables"] = one["optimise"]["variables"];
    all["designs"].push_back(std::move(entry));
  }
  if (document.contains("name"))
    all["name"] = document["name"];
  else
    all.erase("name");
  return all;
}

}  // namespace

Job read_listed_designs(
    const json& document, FaultList& faults,
    const std::function<Job(const json& document, FaultList& faults)>& read_one) {
  check_list(document, faults);
  if (!faults.faults().empty()) return {};
  const json& list = document["designs"];
  const std::vector<std::string> labels = labels_of(list, faults);
  std::vector<PlacedFault> found;
  std::vector<Job> jobs;
  for (std::size_t k = 0; k < list.size(); ++k) {
    FaultList own;
    jobs.push_back(read_one(document_of_design(document, k, labels[k]), own));
    const bool shared_material = shares_material(document, k);
    for (Fault fault : own.faults()) {
      if (fault.source.empty()) fault.pointer = place_in_list(fault.pointer, k, shared_material);
      found.push_back({std::move(fault), k});
    }
  }
  add_faults(std::move(found), labels, faults);
  if (!faults.faults().empty()) return {};

  Job job = jobs.front();
  job.notes.clear();
  std::set<std::string> folders;
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    const bool shared_material = shares_material(document, k);
    for (const std::string& note : jobs[k].notes) {  // one of a warning begins with its pointer
      const std::string text = labels[k] + ": " + place_in_list(note, k, shared_material);
      job.notes.push_back(text);
    }
    jobs[k].expect.clear();
    const std::string folder = unused(folder_of(labels[k]), folders);
    folders.insert(folder);
    job.designs.push_back(
        {labels[k], "designs/" + folder, std::make_shared<const Job>(std::move(jobs[k]))});
  }
  job.name = document.contains("name") ? document["name"].get<std::string>() : "";
  job.as_read = std::make_shared<const json>(document_as_read(document, job.designs));
  return job;
}

void add_designs_to_schema(json& schema) {
  const auto drop = [](json& of, const char* name) {
    if (of.contains("required"))
      of["required"].erase(std::remove(of["required"].begin(), of["required"].end(), name),
                           of["required"].end());
  };
  json& properties = schema["properties"];
  json entry = properties["design"];
  entry["properties"]["name"] = {{"type", "string"},
                                 {"description", "for the results; default: the design's own"}};
  entry["properties"]["variables"] = properties["optimise"]["properties"]["variables"];
  drop(entry, "material");
  properties["designs"] = {{"type", "array"},
                           {"items", std::move(entry)},
                           {"minItems", 1},
                           {"maxItems", most_listed},
                           {"description",
                            "several designs under the same requirement, instead "
                            "of one: each evaluated, or optimised and ranked"}};
  properties["material"] = properties["design"]["properties"]["material"];
  properties["material"]["description"] = "of listed designs that have none of their own";
  drop(schema, "design");
  drop(properties["optimise"], "variables");
  schema["anyOf"] = json::array(
      {{{"required", json::array({"design"})}}, {{"required", json::array({"designs"})}}});
}

}  // namespace flexopt
