#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>
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
  static const std::vector<std::string> keys{"loads",           "gravity",  "temperature",
                                             "assembly",        "buckling", "load_capacity",
                                             "stroke_capacity", "stroke",   "load_path"};
  return keys;
}

constexpr std::size_t most_cases = 500;
constexpr std::size_t longest_name = 80;  // a folder has it, every byte escaped at worst

/// A load case as it is written.
struct WrittenCase {
  std::string name;
  json own;    ///< what it has instead of the job's own
  Pointer at;  ///< place in the job
};

bool is_printed(const std::string& name) {
  return !name.empty() && name.size() <= longest_name && std::ranges::none_of(name, [](char c) {
    return std::iscntrl(static_cast<unsigned char>(c)) != 0;
  });
}

/// The cases in the order of the job: those of an object as `order` names them, the others behind.
/// Those that are no objects are among the faults.
std::vector<WrittenCase> written_cases(const json& cases, const std::vector<std::string>& order,
                                       FaultList& faults) {
  std::vector<WrittenCase> list;
  if (!(cases.is_object() || cases.is_array()) || cases.empty() || cases.size() > most_cases) {
    faults.add("/cases", shown(cases),
               fmt::format("expected an object of 1 to {} load cases by their names, or a list",
                           most_cases));
    return list;
  }
  const Pointer all("/cases");
  for (const auto& [key, own] : cases.items())
    list.push_back({key, own, cases.is_array() ? all / list.size() : all / key});
  std::ranges::stable_sort(list, {}, [&](const WrittenCase& one) {
    return std::ranges::find(order, one.name) - order.begin();
  });
  std::vector<std::string> known;
  for (WrittenCase& one : list) {
    if (!one.own.is_object()) {
      faults.add(
          one.at, shown(one.own),
          fmt::format("expected an object with some of the keys {}", fmt::join(case_keys(), ", ")));
      continue;
    }
    const bool named = cases.is_array() && one.own.contains("name");
    if (cases.is_array())
      one.name =
          named && one.own["name"].is_string() ? one.own["name"].get<std::string>() : std::string();
    if (named) one.own.erase("name");
    const bool twice = std::ranges::find(known, one.name) != known.end();
    if (!is_printed(one.name) || twice)
      faults.add({.pointer = (cases.is_array() ? one.at / "name" : one.at).to_string(),
                  .value = shown(one.name),
                  .rule = twice ? "another load case has this name"
                                : fmt::format("a load case has a name of 1 to {} letters, digits "
                                              "and other characters that are printed",
                                              longest_name),
                  .of_key = cases.is_object()});
    known.push_back(one.name);
  }
  return list;
}

/// Keys that a case cannot have instead of the job.
void check_keys(const std::vector<WrittenCase>& cases, FaultList& faults) {
  for (const WrittenCase& one : cases)
    for (const auto& [key, value] : one.own.items())
      if (std::ranges::find(case_keys(), key) == case_keys().end())
        faults.add({.pointer = (one.at / key).to_string(),
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

/// What only some cases find wrong in what they share says which they are. `found`: of each case.
void add_faults(const std::vector<WrittenCase>& cases, std::vector<std::vector<Fault>>&& found,
                FaultList& faults) {
  std::map<std::pair<std::string, std::string>, std::size_t> times;
  for (const std::vector<Fault>& list : found)
    for (const Fault& fault : list) ++times[{fault.pointer, fault.rule}];
  for (std::size_t k = 0; k < found.size(); ++k)
    for (Fault& fault : found[k]) {
      if (fault.source.empty() && cases[k].own.contains(key_of(fault.pointer)))
        fault.pointer = cases[k].at.to_string() + fault.pointer;
      else if (times[{fault.pointer, fault.rule}] < cases.size())
        fault.rule += fmt::format(" (in the load case \"{}\")", cases[k].name);
      faults.add(std::move(fault));
    }
}

/// Whether some case leaves the key to the job.
bool is_inherited(const std::vector<WrittenCase>& cases, const std::string& key) {
  return std::ranges::any_of(cases, [&](const WrittenCase& one) {
    const bool other_motion = (key == "stroke" && one.own.contains("load_path")) ||
                              (key == "load_path" && one.own.contains("stroke"));
    return !one.own.contains(key) && !other_motion;
  });
}

/// The whole job as read: what the cases share, and a list of what each has of its own.
json document_as_read(const std::vector<WrittenCase>& cases, const std::vector<Job>& jobs) {
  json all = document_of(jobs.front());
  for (const std::string& key : case_keys()) all.erase(key);
  all["cases"] = json::array();
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    json& entry = all["cases"].emplace_back(json{{"name", cases[k].name}});
    const json& read = document_of(jobs[k]);
    for (const std::string& key : case_keys())
      if (read.contains(key)) (cases[k].own.contains(key) ? entry : all)[key] = read[key];
  }
  return all;
}

/// Load cases are of one design, and so are the sizes of its edges that are formulas.
void share_edges(const std::vector<Job>& jobs, const std::vector<WrittenCase>& cases,
                 FaultList& faults, DesignSpec& design) {
  const auto edges = [](const DesignSpec& of) {
    std::vector<std::tuple<int, int, int, std::string>> all;
    for (const EdgeSize& size : of.resolved->edges())
      all.emplace_back(size.leaf, size.end, size.axis, size.formula.text());
    return all;
  };
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    const DesignSpec& own = jobs[k].design;
    if (own.resolved->edges().empty()) continue;
    if (design.resolved->edges().empty()) design.resolved = own.resolved;
    if (edges(own) != edges(design))
      faults.add(cases[k].at / "assembly",
                 shown(cases[k].own.value("assembly", json("that of the job"))),
                 "load cases are of one design: they share the formulas of their edges");
  }
}

}  // namespace

Field cases_field(const std::vector<Field>& of_job) {
  std::vector<Field> fields;
  for (Field field : of_job) {
    if (std::ranges::find(case_keys(), field.name) == case_keys().end()) continue;
    field.default_value = nullptr;  // the job's own is the default
    fields.push_back(std::move(field));
  }
  const Shape by_name = shape::map(shape::record(fields));
  fields.insert(fields.begin(), shape::required("name", shape::text(longest_name),
                                                "what goals and results call the load case"));
  return shape::optional(
      "cases",
      shape::one_of({by_name, shape::list(shape::record(std::move(fields)), 1, most_cases)}),
      "load cases by their names, or a list of them, each with what it has instead of the job's "
      "own; goals are over all of them");
}

Job read_cases(const json& document, const std::vector<std::string>& order, FaultList& faults,
               const std::function<Job(const json& document, const CaseNames& cases,
                                       FaultList& faults)>& read_one) {
  const std::vector<WrittenCase> cases = written_cases(document["cases"], order, faults);
  if (!faults.faults().empty()) return {};
  check_keys(cases, faults);
  CaseNames names;
  for (const WrittenCase& one : cases) names.all.push_back(one.name);
  std::vector<Job> jobs;
  std::vector<std::vector<Fault>> found;
  for (const WrittenCase& one : cases) {
    FaultList of_case;
    names.own = one.name;
    jobs.push_back(read_one(document_of_case(document, one.own), names, of_case));
    found.push_back(of_case.faults());
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

  Job job = jobs.front();
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    job.cases.push_back({cases[k].name, jobs[k].request});
    for (const std::string& note : jobs[k].notes)
      if (std::ranges::find(job.notes, note) == job.notes.end()) job.notes.push_back(note);
  }
  share_edges(jobs, cases, faults, job.design);
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
