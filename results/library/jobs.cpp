#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "designs/family.hpp"
#include "optim/problem/stroke_sensitivity.hpp"
#include "results/files/json_text.hpp"
#include "results/files/result_json.hpp"
#include "results/files/version.hpp"
#include "results/library/translated.hpp"

static_assert(FLEXOPT_VERSION_MAJOR == FLEXOPT_MAJOR && FLEXOPT_VERSION_MINOR == FLEXOPT_MINOR &&
                  FLEXOPT_VERSION_PATCH == FLEXOPT_PATCH,
              "the version of flexopt.hpp is that of the project in CMakeLists.txt");

namespace flexopt::v0 {
namespace {

using Document = nlohmann::json;

/// Whether JSON can hold it: UTF-8.
bool is_text(const std::string& text) try {
  return !Document(text).dump().empty();
} catch (const Document::type_error&) {
  return false;
}

Document json_of(const std::string& name, const Value& value) {
  const auto* number = std::get_if<double>(&value);
  if (number && !std::isfinite(*number))
    throw SpecError("/design/parameters/" + name, fmt::format("{}", *number),
                    "expected a finite number");
  const auto* text = std::get_if<std::string>(&value);
  if (!is_text(name) || (text && !is_text(*text)))
    throw SpecError("/design/parameters", "a text", "expected texts in UTF-8");
  return number ? Document(*number) : Document(*text);
}

Document object_of(std::string_view text, const std::string& origin) {
  Document parsed = parse_json(std::string(text), origin);
  if (!parsed.is_object()) throw SpecError("", shown(parsed), "expected a JSON object");
  return parsed;
}

/// Whether the design of a family takes the value beside its parameters.
bool stands_beside(const Document& design, const std::string& name) {
  if (name == "material") return true;
  if (!design.contains("family") || !design["family"].is_string()) return false;
  const Family& family = find_family(design["family"].get<std::string>(), "/design/family");
  return std::ranges::find(family.options, name, &FamilyOption::name) != family.options.end();
}

std::string text_with(Document design, const Values& values) {
  if (!design.contains("parameters")) design["parameters"] = Document::object();
  if (!design["parameters"].is_object())
    throw SpecError("/design/parameters", shown(design["parameters"]), "expected a JSON object");
  for (const auto& [name, value] : values)
    (stands_beside(design, name) ? design : design["parameters"])[name] = json_of(name, value);
  return design.dump();
}

}  // namespace

std::string version() { return flexopt::version(); }
std::string commit() { return flexopt::commit(); }
int job_format() { return flexopt::job_format; }
int result_format() { return flexopt::result_format; }

JobError::JobError(const std::string& message, std::vector<Fault> faults)
    : std::invalid_argument(message), faults_(std::move(faults)) {}
JobError::~JobError() = default;
NoGradient::~NoGradient() = default;
Stopped::~Stopped() = default;

void raise(const SpecError& error) {
  std::vector<Fault> faults;
  for (const flexopt::Fault& f : error.faults())
    faults.push_back({f.pointer, f.value, f.rule, f.source, f.line, f.column});
  throw JobError(error.what(), std::move(faults));
}

Design Design::of_family(const std::string& name, const Values& values) {
  return translated([&] {
    find_family(name, "/design/family");
    return Design(text_with({{"family", name}}, values));
  });
}

Design Design::of_file(const std::filesystem::path& file, const Values& values) {
  return translated([&] {
    const std::string path = std::filesystem::absolute(file).string();
    read_text(path);  // whether it can be
    return Design(text_with({{"file", path}}, values));
  });
}

Design Design::of_json(std::string_view text) {
  return translated([&] {
    Document design = object_of(text, "design");
    if (design.contains("flexopt_design")) design = {{"mechanism", std::move(design)}};
    return Design(text_with(std::move(design), {}));
  });
}

Design Design::with(const Values& values) const {
  return translated([&] { return Design(text_with(Document::parse(json_), values)); });
}

Job Job::of_file(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return translated(
      [&] { return Job(std::make_shared<const Impl>(Impl{read_job(file.string(), overrides)})); });
}

Job Job::of_json(std::string_view text) {
  return translated([&] {
    const JsonText source{std::string(text), "job"};
    std::vector<flexopt::Fault> faults;
    const Document document = parse_json(source, faults);
    try {
      if (!faults.empty()) throw SpecError(faults);
      return Job(std::make_shared<const Impl>(
          Impl{parse_job(document, keys_in_text(source.text, "cases"))}));
    } catch (const SpecError& error) {
      faults = error.faults();
      locate(faults, source, {});
      throw SpecError(faults);
    }
  });
}

Job Job::of_design(const Design& design, std::string_view keys) {
  return translated([&] {
    Document job = {{"flexopt", flexopt::job_format},
                    {"name", "design"},
                    {"job", "evaluate"},
                    {"design", Document::parse(design.json())}};
    job.update(object_of(keys, "keys"));
    return Job(std::make_shared<const Impl>(Impl{parse_job(job)}));
  });
}

std::string Job::name() const { return impl_->job.name; }
std::string Job::kind() const { return name_of(impl_->job.kind); }
std::map<std::string, double> Job::parameters() const {
  const ParameterValues& values = impl_->job.design.parameters;
  return {values.begin(), values.end()};
}
std::vector<std::string> Job::differentiable() const {
  return translated([&] { return differentiable_parameters(impl_->job); });
}
std::vector<std::string> Job::notes() const { return impl_->job.notes; }
std::string Job::json() const { return json_text(OrderedJson(document_of(impl_->job))); }

}  // namespace flexopt::v0
