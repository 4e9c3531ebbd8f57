#pragma once
// The readers of the sections of a job, each with the tables that describe it.
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/model_options.hpp"
#include "core/response/quantities.hpp"
#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/parametric_design.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// The fault of a key of `read`, which stands at `at`.
SpecError wrong(const nlohmann::json& read, const JsonPointer& at, const char* key,
                const std::string& rule);

/// "a, b, c", or of more than three names the first two and how many others there are.
std::string few_of(const std::vector<std::string>& names);

/// A number in SI, or a quantity in one of these units. Throws SpecError.
double read_in_units(const nlohmann::json& value, const std::vector<std::string>& units,
                     const JsonPointer& at);

// A job with several load cases: as many jobs of one case each, which share all else.

/// The load cases of a job, in its order, and which of them is being read.
struct CaseNames {
  std::vector<std::string> all;  ///< empty: a job with one case, which has no name
  std::string own;
};

/// What "cases" may hold, from the fields of a whole job.
Field cases_field(const std::vector<Field>& of_job);

/// Reads every case with the rest of the document by `read_one`: a key that the case has stands in
/// the place of the job's own (a stroke in that of a load_path, too, and the other way round), all
/// others are the job's. The job that comes back is that of the first case, with all of them in
/// `Job::cases`. Faults stand where the document has what is wrong: /cases/up/loads/0/force, say.
/// `order`: names of cases as the text has them, which the keys of a document have not.
Job read_cases(const nlohmann::json& document, const std::vector<std::string>& order,
               FaultList& faults,
               const std::function<Job(const nlohmann::json& document, const CaseNames& cases,
                                       FaultList& faults)>& read_one);

// What goals and variables of a job have in common, whatever section they stand in.

/// What the job defines that its goals may take into account.
struct Borne {
  bool tolerances = false, assembly_tolerances = false;
};

/// What goals need to know of the rest of the job.
struct GoalContext {
  const Family& family;
  const DesignSpec& design;
  const StrokeRequest& request;
  DriveList drives;                          ///< without the quantities that the job defines
  std::vector<Quantity> quantities;          ///< of these
  const std::vector<NamedFormula>& defined;  ///< quantities that the job defines
  ParameterValues values;          ///< that formulas may use: parameters, material, end-effector
  std::vector<FormulaName> names;  ///< names of these, the family's first
  const CaseNames& cases;
  Borne borne;
  FaultList& faults;

  GoalContext(const Family& family, const Job& job, const CaseNames& cases, Borne borne,
              FaultList& faults);

  /// The load case that a goal names; empty where it is over all of them. Throws SpecError.
  std::string load_case(const nlohmann::json& goal, const JsonPointer& at) const;
  /// Whether what the goal asks of the job is for this load case to answer.
  bool counts(const std::string& load_case) const {
    return load_case.empty() || load_case == cases.own;
  }
  const Quantity* find_quantity(const std::string& name) const;
  bool defines(const std::string& name) const;  ///< whether the job defines a quantity so called
  /// The quantity of that name, with what it asks of the rest of the job, if it counts for this
  /// load case. Throws SpecError.
  const Quantity& quantity(const std::string& name, bool counts, const JsonPointer& at) const;
  /// A formula of the values and the quantities. Throws SpecError.
  Expression formula(const std::string& text, const JsonPointer& at) const;
  /// What is measured, from the text under `key`: a quantity, or a formula; and its load case.
  /// Throws SpecError.
  void take(const nlohmann::json& goal, const char* key, bool formula, const JsonPointer& at,
            Constraint& measure) const;
  /// From "quantity" or "expression", of which there must be one: the key.
  const char* take(const nlohmann::json& goal, const JsonPointer& at, Constraint& measure) const;
};

/// "max_stress max over stroke, case up"
std::string goal_label(const Constraint& goal);

/// The quantities that the section "quantities" defines, of a job that is read but for the sections
/// that may name them. Those that are wrong stay out.
std::vector<NamedFormula> read_defined_quantities(const nlohmann::json& read, const Family& family,
                                                  Job job, const CaseNames& cases,
                                                  FaultList& faults);

/// A quantity over the stroke, or a formula, without bounds. `usual`: which value over the stroke
/// is meant where `read` does not say; nothing: it must. Throws SpecError.
Constraint read_measure(nlohmann::json& read, const GoalContext& context, const JsonPointer& at,
                        const std::optional<OverStroke>& usual);

/// Name and bounds of a parameter that may differ; the bounds are written back in SI. Faults of the
/// bounds go to the context. Throws SpecError for what cannot differ.
Variable read_range(nlohmann::json& read, const GoalContext& context, const JsonPointer& at);

// The tables that describe a job file: keys, units, ranges, defaults, meaning.

/// The job of a family: its parameters, and the unit of its stroke. Without a family: what any job
/// may hold, for the schema and for jobs whose family is not readable.
Shape job_shape(const Family* family);
/// Schema of a job with "accuracy": "auto", whose model.tolerance bounds the estimated errors.
Shape with_error_tolerance(Shape job);
/// Whether a job's document asks for that.
bool chooses_accuracy(const nlohmann::json& document);

/// The numbers of a family parameter: unit and range.
Shape parameter_shape(const Parameter& parameter);

/// The section "model".
Shape model_shape();

/// What the section "model" says; `at` is its place. What its keys contradict is added to `faults`.
ModelChoice read_model(const nlohmann::json& read, const JsonPointer& at, FaultList& faults);

/// Refuses a model that the design's leaves do not allow: plates of wires, or of a material with a
/// Poisson's ratio above a half. Throws SpecError.
void check_leaf_model(const DesignSpec& design, const ModelOptions& model, const JsonPointer& at);

/// Fills in the section "optimise". `read` has passed its table; bounds get their units here, and
/// `read` is completed with what was decided; `job` is read but for its sections, and takes notes.
/// What is wrong is added to `faults`; parts that depend on something wrong are not checked.
/// Goals may name one of `cases`, and count `tolerances` where the job has some.
OptimiseSpec read_optimise(nlohmann::json& read, const Family& family, Job& job,
                           const CaseNames& cases, Borne borne, FaultList& faults);

/// Fills in the sections "samples" and "models" of a job that has passed its table, and completes
/// them in `read` with what was decided. Faults as in read_optimise.
CompareSpec read_compare(nlohmann::json& read, const Family& family, const Job& job,
                         FaultList& faults);

// The design of a job: where it comes from, its numbers, its material.

/// Puts the content of a design file in the place of its name, and those of the files of its parts:
/// a job as read needs no other file.
void write_whole_design(nlohmann::json& design, const std::string& folder);

/// What the document takes its design from: a family by name, a file relative to `folder`, or a
/// mechanism that is written into it. Null where there is none that can be read.
std::shared_ptr<const Family> design_source(const nlohmann::json& document,
                                            const std::string& folder, FaultList& faults);

/// Whether the design is one leaf whose section may be a circle: its width is then its thickness.
bool may_be_wire(const Family& family);

/// A wire needs no width: it is the thickness.
nlohmann::json with_width_of_wire(nlohmann::json document);

/// Whether nothing is wrong with what makes the geometry.
bool is_geometry_sound(const Family& family, const FaultList& faults);

/// Reads the design of a job. Without a family, the material alone.
DesignSpec read_design(nlohmann::json& read, const nlohmann::json& written,
                       const std::shared_ptr<const Family>& family, FaultList& faults);

// A job that lists several designs: as many jobs of one design each, which share all else.

/// Reads every design with the rest of the document by `read_one`. The job that comes back is that
/// of the first design, with all of them in `Job::designs`. Faults stand where the document has
/// what is wrong: /designs/2/parameters/length, say.
Job read_listed_designs(
    const nlohmann::json& document, FaultList& faults,
    const std::function<Job(const nlohmann::json& document, FaultList& faults)>& read_one);

/// Completes the schema of a job of one design.
void add_designs_to_schema(nlohmann::json& schema);

/// Parses a job as parse_job does; files that the job names are relative to `folder`.
Job parse_job_in(const std::string& folder, const nlohmann::json& document,
                 const std::vector<std::string>& case_order = {});

// What acts on the mechanism of a job: the end-effector's body, the stroke, loads.

EndEffector read_end_effector(const nlohmann::json& read, FaultList& faults);

/// Adds to `request`, which holds what stands at the head of the job.
void read_request(nlohmann::json& read, const nlohmann::json& as_written, const Family* family,
                  FaultList& faults, StrokeRequest& request);

/// Checks that nothing rigid is attached to O where O is a material point of a leaf.
void check_material_point(const Job& job, FaultList& faults);

/// Place of the leaf of that name; `at` is where it stands. Throws SpecError where none has it.
/// `end`: which edge of it is meant, 0 base, 1 tip: of a leaf in parts that of its name is
/// suggested.
int find_leaf(const Mechanism& mechanism, const std::string& name, const JsonPointer& at,
              std::optional<int> end = {});

/// The same of a body; the end-effector has two names.
int find_body(const Mechanism& mechanism, const std::string& name, const JsonPointer& at);

/// The bodies that loads name, once these are known; `loads` are those of the job that were sound.
void find_loaded_bodies(const nlohmann::json& read, const Mechanism& mechanism, FaultList& faults,
                        std::vector<DeadLoad>& loads);

std::vector<Field> point_fields();
/// The points of the job. `mechanism`: null where the geometry is not known.
void read_points(const nlohmann::json& read, const Mechanism* mechanism, FaultList& faults,
                 StrokeRequest& request, std::vector<std::string>& notes);

/// Gravity and temperature, once the leaves are known. `notes`: which leaves are full models
/// because of them.
void read_surroundings(const nlohmann::json& read, const Mechanism& mechanism,
                       const ModelOptions& model, FaultList& faults, LoadCase& loads,
                       std::vector<std::string>& notes);

/// What "assembly" may hold: edges that are moved or turned at once, or the steps of the mounting.
Shape mounting_shape();

/// Takes in moved and turned edges, and the steps in which these and the other loads, which have
/// been read, come; what no step names comes in one more behind them. Returns the sizes of edges
/// that are formulas of the family's parameters.
std::vector<EdgeSize> read_mounting(const nlohmann::json& read, const Family& family,
                                    const Mechanism& mechanism, FaultList& faults, LoadCase& loads);

// Where the drives of a design go: the stroke of one, and the strokes of drives with names.

/// What "stroke" may hold. Without drives (null) its unit is not known.
Shape stroke_shape(const DriveList* drives);

/// Sets the points of the request, and the strokes of drives with names. `read` has passed the
/// shape; it gets what was left to defaults. Throws SpecError.
void read_stroke(nlohmann::json& read, const nlohmann::json& as_written, const DriveList& drives,
                 StrokeRequest& request);

// How large loads at O may get: the key "load_capacity" of a job.

Field load_capacity_field();
/// And how far drives may go: "stroke_capacity". Without drives (null) units are not known.
Field stroke_capacity_field(const DriveList* drives);

/// Reads it against the drives, the end-effector and the materials. `request` has its loads.
void read_load_capacity(const nlohmann::json& read, const Mechanism& mechanism, FaultList& faults,
                        StrokeRequest& request);

/// Likewise; what it has by default does not depend on the points of the stroke.
void read_stroke_capacity(const nlohmann::json& read, const Mechanism& mechanism, FaultList& faults,
                          StrokeRequest& request);

// How stresses are judged: the keys "fillet" and "fatigue" of a job.

/// The keys "fillet" and "fatigue" of a job.
std::vector<Field> stress_fields();

/// Reads the two keys against the leaves and their materials into the rules of a request whose path
/// is read.
void read_stress_rules(const nlohmann::json& read, const Mechanism& mechanism, FaultList& faults,
                       StrokeRequest& request);

/// Whether the request answers a quantity made of stress.
Check check_stress(const std::string& quantity, const StrokeRequest& request);

// Harmonic motion and linear models: the keys "dynamics" and "export" of a job.

/// The keys "dynamics" and "export" of a job.
std::vector<Field> dynamics_fields();

/// Reads the two keys against the mechanism and the stroke points, which `request` has.
void read_dynamics(const nlohmann::json& read, const Mechanism& mechanism,
                   const ModelOptions& model, FaultList& faults, StrokeRequest& request);

/// Whether the request answers a quantity of the dynamics.
Check check_dynamics(const std::string& quantity, const StrokeRequest& request);

// A box of errors of assembly, of which the worst is looked for: the key "assembly_tolerances".

Field assembly_tolerances_field();

/// Whether a goal, read but for this, counts at the worst errors of assembly of the box; throws
/// SpecError where it cannot.
bool read_worst_assembly(nlohmann::json& goal, const GoalContext& context, const Constraint& read,
                         const JsonPointer& at);

/// Whether a goal of the job, read or not, names the box.
bool names_the_box(const nlohmann::json& job);

/// Reads it against the leaves and what goals may name. `in_goals`: some goals name it.
AssemblyTolerances read_assembly_tolerances(nlohmann::json& read, const Mechanism& mechanism,
                                            bool in_goals, const GoalContext& context);

/// Lets the worst values of the goals be sought as those of `quantities` are.
void look_at_goals(const OptimiseSpec& goals, AssemblyTolerances& spec);

// The sections "tolerances" and "tolerance_samples" of a job.

/// What the two sections may hold.
Field tolerances_field();
Field tolerance_samples_field();

/// The key of a goal that makes tolerances or assembly errors count in it.
Field under_field();
Field margin_field();

/// Reads from a goal how tolerances count, and completes what was read. `tolerances`: the job has
/// some. Throws SpecError.
ToleranceMargin read_margin(nlohmann::json& goal, bool tolerances, const JsonPointer& at);

/// The goals without the tolerances and errors of assembly that they bear.
OptimiseSpec without_margins(OptimiseSpec goals);

/// Reads both sections of a job that is read but for its other sections. `read` has passed its
/// shape, and is completed with what was decided. What is wrong is added to `faults`.
TolerancesSpec read_tolerances(nlohmann::json& read, const Family& family, const Job& job,
                               FaultList& faults);

// The section "maps" of a job.

/// Reads the section of a job that is read but for its other sections. `read` has passed its shape,
/// and is completed with what was decided. What is wrong is added to `faults`.
std::vector<MapSpec> read_maps(nlohmann::json& read, const Family& family, const Job& job,
                               const CaseNames& cases, FaultList& faults);

// The atlas that a job's leaves are looked up in.

/// Opens the atlas of a model that wants one, unless it has it. All is well too
/// if the model wants none or is of full accuracy.
Check find_atlas(ModelOptions& model);

/// Why the atlas that a user names is not the model's, for the user's eyes; empty where it is.
std::string note_on_atlas(ModelOptions model);

/// The model with reduced leaves, looked up where it allows that and there is a look-up table.
ModelOptions on_reduced_leaves(ModelOptions model);

}  // namespace flexopt
