#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/reduction/superelement/superelement_rule.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/found_design.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"
#include "optim/job/job_warnings.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

std::vector<Expectation> read_expectations(const json& read, FaultList& faults) {
  std::vector<Expectation> result;
  faults.each(read, Pointer("/expect"), [&](const json& item, const Pointer& at) {
    Expectation e = expectation_table().read(item);
    try {
      static_cast<void>(Pointer(e.pointer));
    } catch (const json::exception&) {
      faults.add(at / "pointer", shown(e.pointer),
                 "expected a JSON pointer such as \"/path/10/drive_load\"");
    }
    result.push_back(std::move(e));
  });
  return result;
}

/// Every leaf must be one that the method reduces: a material point a node of its superelements.
void check_superelements(const Mechanism& mechanism, const ModelOptions& model, const json& read) {
  if (model.method == Reduction::mixed_potential || model.accuracy == Accuracy::full) return;
  for (const LeafSpring& leaf : mechanism.leaves)
    if (const Check kept = check_rules(leaf, model); !kept) {
      if (leaf.has_profile() || leaf.curve || leaf.fold)
        throw SpecError("/model/method", read["method"].dump(), leaf.name + ": " + kept.error());
      throw SpecError("/model/superelements",
                      read.contains("superelements") ? read["superelements"].dump() : "1",
                      kept.error());
    }
}

/// Reads a job from its document. Each part is read as far as what it depends on is sound.
class JobReader {
 public:
  /// Files that the job names are relative to `folder`. `cases`: which load cases there are, for
  /// goals to name.
  JobReader(const json& document, const std::string& folder, const CaseNames& cases,
            FaultList& faults)
      : document_(document),
        cases_(cases),
        faults_(faults),
        folder_(folder),
        source_(design_source(document, folder, faults)),
        family_(source_.get()) {}

  Job read();

 private:
  void read_mechanism();
  void read_assembly();
  void check_sections();
  void read_sections();
  bool sound(const char* pointer) const { return faults_.sound(pointer); }

  const json& document_;
  const CaseNames& cases_;
  FaultList& faults_;
  const std::string& folder_;
  std::shared_ptr<const Family> source_;
  const Family* family_;                ///< the family of source_
  std::optional<Mechanism> mechanism_;  ///< at the job's own parameters, where these make one
  json read_;
  Job job_;
};

Job JobReader::read() {
  const Shape shape = job_shape(family_);
  read_ = read_value(chooses_accuracy(document_) ? with_error_tolerance(shape) : shape,
                     family_ && may_be_wire(*family_) ? with_width_of_wire(document_) : document_,
                     Pointer(), faults_);
  if (!read_.is_object()) return {};
  if (family_ && !document_.contains(Pointer("/model/mesh")))
    read_["model"]["mesh"] = family_->mesh;
  head_table().read(read_, job_);
  if (read_.contains("design"))
    job_.design = read_design(read_["design"], document_["design"], source_, faults_);
  job_.end_effector = read_end_effector(read_["end_effector"], faults_);
  const ModelChoice choice = read_model(read_["model"], Pointer("/model"), faults_);
  job_.model = choice.model;
  job_.accuracy = choice.accuracy;
  job_.request.newton = choice.newton;
  if (read_.contains("limits")) limits_table().read(read_["limits"], job_.request.limits);
  if (const std::string note = note_on_atlas(choice.model); !note.empty())
    job_.notes.push_back(note);
  read_request(read_, document_, family_, faults_, job_.request);
  job_.expect = read_expectations(read_["expect"], faults_);
  read_mechanism();
  check_sections();
  if (family_) read_sections();
  if (mechanism_ && faults_.faults().empty()) {
    std::ranges::move(warnings_of(job_, *mechanism_, document_), std::back_inserter(job_.notes));
    write_whole_design(read_["design"], folder_);
  }
  job_.as_read = std::make_shared<const json>(std::move(read_));
  return std::move(job_);
}

/// What needs the geometry.
void JobReader::read_mechanism() {
  if (family_ && is_geometry_sound(*family_, faults_)) {
    const Pointer flexure("/model/flexure");  // wires are beams by default
    if (!document_.contains(flexure) && read_.contains(flexure) &&
        family_->is_of_wires(job_.design.choices)) {
      job_.model.flexure = Flexure::beam;
      read_[flexure] = "beam";
    }
    if (sound("/design/material") && sound("/model/flexure"))
      faults_.attempt([&] { check_leaf_model(job_.design, job_.model, Pointer("/model")); });
    faults_.attempt([&] { mechanism_ = make_mechanism(job_, job_.design.parameters); });
    read_points(read_, mechanism_ ? &*mechanism_ : nullptr, faults_, job_.request, job_.notes);
    if (mechanism_) {
      find_loaded_bodies(read_["loads"], *mechanism_, faults_, job_.request.loads.constant);
      read_surroundings(read_, *mechanism_, job_.model, faults_, job_.request.loads, job_.notes);
      read_assembly();
      read_stress_rules(read_, *mechanism_, faults_, job_.request);
      read_dynamics(read_, *mechanism_, job_.model, faults_, job_.request);
      read_load_capacity(read_, *mechanism_, faults_, job_.request);
      read_stroke_capacity(read_, *mechanism_, faults_, job_.request);
    }
    if (!family_->has_end_effector(job_.design.choices)) check_material_point(job_, faults_);
  }
  if (mechanism_ && has_fold(*mechanism_) &&
      (job_.model.accuracy == Accuracy::reduced || job_.model.flexure == Flexure::beam))
    job_.notes.push_back("Leaves with an elastic fold are evaluated in full, as plates.");
  if (job_.model.flexure == Flexure::plate && job_.model.warping == Warping::free)
    job_.notes.push_back("Free warping is a matter of beams; the plate's ends are clamped.");
  if (mechanism_ && sound("/model"))
    faults_.attempt([&] { check_superelements(*mechanism_, job_.model, read_["model"]); });
}

/// Edges that sit other than designed; where formulas say how far, the design gets these.
void JobReader::read_assembly() {
  std::vector<EdgeSize> sizes =
      read_mounting(read_["assembly"], *family_, *mechanism_, faults_, job_.request.loads);
  if (sizes.empty()) return;
  job_.design.resolved =
      std::make_shared<const ParametricDesign>(job_.design.resolved->with_edges(std::move(sizes)));
  faults_.attempt([&] { mechanism_ = make_mechanism(job_, job_.design.parameters); });
}

/// What does not go with the kind of the job.
void JobReader::check_sections() {
  const std::string kind = read_["job"];
  // tolerances and maps look at the goals of a search that the job does not make
  const auto looked_at = [&](const std::string& section) {
    return section == "optimise" && job_.kind == JobKind::evaluate &&
           (read_.contains("tolerances") || read_.contains("maps"));
  };
  for (const auto& [section, owner] : {std::pair{"optimise", JobKind::optimise},
                                       {"samples", JobKind::compare},
                                       {"models", JobKind::compare}})
    if (read_.contains(section) && job_.kind != owner && !looked_at(section))
      job_.notes.push_back(
          fmt::format("The section {} is not used by \"job\": \"{}\".", section, kind));
  const bool compares = job_.kind == JobKind::compare;
  const auto is_name = [](const json& quantity) { return quantity.is_string(); };
  if (!compares && read_.contains("quantities") &&
      std::ranges::any_of(read_["quantities"], is_name))
    job_.notes.push_back(
        fmt::format("Names among the quantities are not used by \"job\": \"{}\".", kind));
  for (const auto& [section, rule] :
       {std::pair{"export", "a job \"compare\" looks at models and exports nothing"},
        {"maps", "a job \"compare\" looks at models and draws no maps"},
        {"tolerances", "a job \"compare\" looks at models, not at tolerances"},
        {"assembly_tolerances", "a job \"compare\" looks at models, not at errors of assembly"}})
    if (compares && read_.contains(section))
      faults_.add("/" + std::string(section), shown(document_[section]), rule);
  if (read_.contains("tolerances") && !compares && sound("/model") &&
      job_.model.accuracy == Accuracy::reduced && job_.model.method != Reduction::mixed_potential)
    faults_.add("/model/method", read_["model"]["method"].dump(),
                "tolerances take exact derivatives, which this method has not; expected "
                "\"mixed_potential\", or \"accuracy\": \"full\"");
  for (const auto& [key, given] :
       {std::pair{"accuracy", job_.accuracy.automatic}, {"estimate", job_.accuracy.estimate}})
    if (compares && given)
      faults_.add("/model/" + std::string(key), read_["model"][key].dump(),
                  "a job \"compare\" measures errors against full accuracy and estimates none");
  if (read_.contains("tolerance_samples") && !read_.contains("tolerances"))
    faults_.add("/tolerance_samples", shown(document_["tolerance_samples"]),
                "the job has no \"tolerances\" that they could check");
  for (const auto& [section, owner] :
       {std::pair{"optimise", JobKind::optimise}, {"samples", JobKind::compare}})
    if (job_.kind == owner && !read_.contains(section))
      faults_.add("/" + std::string(section), "nothing",
                  fmt::format("it is required for \"job\": \"{}\"", kind));
}

/// The sections that need the family, whose names and units theirs are.
void JobReader::read_sections() {
  if (mechanism_) {  // whether a drive acts elsewhere depends on the axes of its frame
    auto here = std::make_shared<Family>(*family_);
    here->drives = *mechanism_;
    source_ = std::move(here);
    family_ = source_.get();
  }
  const bool compares = job_.kind == JobKind::compare;
  if (read_.contains("quantities"))
    job_.quantities = read_defined_quantities(read_["quantities"], *family_, job_, cases_, faults_);
  if (!sound("/quantities")) return;  // which the others may name
  if (mechanism_ && read_.contains("assembly_tolerances") && sound("/assembly_tolerances"))
    job_.assembly_tolerances =
        read_assembly_tolerances(read_["assembly_tolerances"], *mechanism_,
                                 job_.kind == JobKind::optimise && names_the_box(read_),
                                 GoalContext(*family_, job_, cases_, {}, faults_));
  if (read_.contains("optimise"))
    job_.optimise = read_optimise(
        read_["optimise"], *family_, job_, cases_,
        {read_.contains("tolerances"), read_.contains("assembly_tolerances")}, faults_);
  if (job_.kind == JobKind::optimise && job_.optimise && job_.assembly_tolerances)
    look_at_goals(*job_.optimise, *job_.assembly_tolerances);
  if (read_.contains("samples")) job_.compare = read_compare(read_, *family_, job_, faults_);
  if (read_.contains("tolerances") && !compares && is_geometry_sound(*family_, faults_)) {
    job_.tolerances = read_tolerances(read_, *family_, job_, faults_);
    job_.tolerances->goals = job_.optimise;
  }
  if (read_.contains("maps") && !compares) {
    job_.maps = read_maps(read_["maps"], *family_, job_, cases_, faults_);
    job_.map_goals = job_.optimise;
  }
  if (job_.kind != JobKind::optimise) job_.optimise.reset();
  if (!compares) job_.compare.reset();
}

/// Faults of the --set texts themselves.
void add_override_faults(const SpecError& error, std::vector<Fault>& faults) {
  for (Fault fault : error.faults()) {
    fault.source = "--set";
    faults.push_back(std::move(fault));
  }
}

/// Whether a document has such a list.
bool lists(const json& document, const char* key) {
  return document.is_object() && document.contains(key);
}

/// Reads a document of one design, under one load case or several.
Job read_design_document(const json& written, const std::string& folder,
                         const std::vector<std::string>& case_order, FaultList& faults) {
  const json document = with_found_design(written, folder, faults);
  if (!lists(document, "cases")) return JobReader(document, folder, {}, faults).read();
  return read_cases(document, case_order, faults,
                    [&](const json& one, const CaseNames& cases, FaultList& own) {
                      return JobReader(one, folder, cases, own).read();
                    });
}

/// Reads a document of one design or of several.
Job read_document(const json& document, const std::string& folder,
                  const std::vector<std::string>& case_order, FaultList& faults) {
  if (!lists(document, "designs"))
    return read_design_document(document, folder, case_order, faults);
  return read_listed_designs(document, faults, [&](const json& one, FaultList& own) {
    return read_design_document(one, folder, case_order, own);
  });
}

}  // namespace

Job parse_job(const json& document, const std::vector<std::string>& case_order) {
  return parse_job_in("", document, case_order);
}

Job parse_job_in(const std::string& folder, const json& document,
                 const std::vector<std::string>& case_order) {
  FaultList faults;
  Job job = read_document(document, folder, case_order, faults);
  faults.raise();
  return job;
}

void check_names(const json& design) {
  const json document{{"design", design}};
  FaultList faults, wrong;
  const std::shared_ptr<const Family> family = design_source(document, "", faults);
  faults.raise();
  (void)read_value(job_shape(family.get()), document, Pointer(), faults);
  for (const Fault& fault : faults.faults())
    if (fault.of_key || fault.pointer == "/design/family") wrong.add(fault);
  wrong.raise();
}

Job read_job(const std::string& file, const std::vector<std::string>& overrides) {
  const JsonText text = read_text(file);
  std::vector<Fault> wrong;
  json document = parse_json(text, wrong);
  if (document.is_object() && document.contains("flexopt_design"))
    throw SpecError("", file,
                    "it is a design file; a job names it: \"design\": {\"file\": \"...\", ...}");
  std::vector<std::string> overridden;
  for (const std::string& assignment : overrides) try {
      overridden.push_back(apply_override(document, assignment));
    } catch (const SpecError& error) {
      add_override_faults(error, wrong);
    }
  if (document.is_object() && !document.contains("name")) {
    const std::string stem = std::filesystem::path(file).stem().string();
    if (!stem.empty()) document["name"] = stem;
  }
  FaultList faults;
  const std::string folder = std::filesystem::path(file).parent_path().string();
  Job job = read_document(document, folder, keys_in_text(text.text, "cases"), faults);
  wrong.insert(wrong.end(), faults.faults().begin(), faults.faults().end());
  if (wrong.empty()) return job;
  locate(wrong, text, overridden);
  throw SpecError(std::move(wrong));
}

const char* bound_at(const Variable& variable, double value) {
  const double near = 1e-4 * (variable.max - variable.min);
  if (variable.max - value <= near) return "max";
  return value - variable.min <= near ? "min" : nullptr;
}

double Tolerance::standard_deviation() const {
  constexpr double limits = 3;  // limits of a normal spread, in standard deviations
  return spread == ToleranceSpread::uniform ? 1 / std::sqrt(3.0) : 1 / limits;
}

std::string ToleranceMargin::text() const {
  if (kind == Kind::none) return "";
  return kind == Kind::worst ? "worst" : fmt::format("mean + {:g} sigma", deviations);
}

std::string ToleranceMargin::suffix() const {
  if (kind == Kind::none) return "";
  return kind == Kind::worst ? ", worst within tolerances" : ", " + text();
}

std::string label_suffix(const ToleranceMargin& margin, bool worst_assembly) {
  return worst_assembly ? ", worst assembly" : margin.suffix();
}

std::vector<JobCase> cases_of(const Job& job) {
  if (!job.cases.empty()) return job.cases;
  return {{{}, job.request}};
}

void demand_one_design(const Job& job, const std::string& rule) {
  if (!job.designs.empty())
    throw SpecError("/designs", fmt::format("{} designs", job.designs.size()), rule);
}

const json& document_of(const Job& job) {
  static const json nothing;
  return job.as_read ? *job.as_read : nothing;
}

}  // namespace flexopt
