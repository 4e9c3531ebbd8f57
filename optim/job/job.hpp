#pragma once
// The job file as read: defaults filled in, SI, checked.
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "designs/parametric_design.hpp"

namespace flexopt {

enum class JobKind { evaluate, optimise, compare };

/// How the values of a quantity over the stroke become one number.
enum class OverStroke { min, max, max_abs, first, last };

/// The names that a job gives them.
std::string name_of(JobKind kind);
std::string name_of(OverStroke over);

struct Variable {
  std::string parameter;        ///< a parameter of the family, or one of job_numbers
  double min = 0, max = 0;      ///< SI
  std::optional<double> start;  ///< first start; the job's own value otherwise
  /// Sizes that can be bought or made, ascending, within min and max; empty: any size.
  std::vector<double> stock;
};

/// "min" or "max" where a value is within 1e-4 of the range from that bound; null between them.
const char* bound_at(const Variable& variable, double value);

/// What tolerances do to a goal, to first order, and how much of it counts: the farthest within
/// all limits, or so many standard deviations, to the side that is worse.
struct ToleranceMargin {
  enum class Kind { none, worst, deviations } kind = Kind::none;
  double deviations = 0;  ///< standard deviations that count, where the kind is that

  explicit operator bool() const { return kind != Kind::none; }
  /// The statistic as a job names it: "worst", "mean + 2 sigma".
  std::string text() const;
  /// What ends the label of such a goal: ", mean + 2 sigma".
  std::string suffix() const;
};

/// What ends the label of a goal that bears something: that of its margin, or ", worst assembly".
std::string label_suffix(const ToleranceMargin& margin, bool worst_assembly);

/// A number of a design that counts, with its bounds where it is a constraint.
struct Constraint {
  std::string quantity;                      ///< a quantity of a path point, or
  std::string expression;                    ///< a formula; one of the two is empty
  OverStroke over_stroke = OverStroke::max;  ///< unused for a formula of the parameters
  std::optional<double> min, max;            ///< SI; of a constraint, at least one
  std::string label;                         ///< "max_stress max over stroke"
  std::string load_case;                     ///< the one that counts; empty: the worst of all
  ToleranceMargin margin;
  bool worst_assembly = false;     ///< its worst in the box of errors of assembly counts
  std::string unit = "SI";         ///< SI unit of the formula's value, where it is known
  std::vector<std::string> terms;  ///< quantities in the formula; none: it is of the parameters

  const std::string& name() const { return quantity.empty() ? expression : quantity; }
  /// Quantities that it is made of.
  std::vector<std::string> quantities() const {
    return quantity.empty() ? terms : std::vector{quantity};
  }
  /// Whether it is a formula of the parameters alone, which needs no mechanics.
  bool of_parameters() const { return quantities().empty(); }
  /// Whether it is one number of the design: the same at every point of a path.
  bool of_design() const;
};

struct Objective : Constraint {
  bool maximise = true;
};

struct Algorithm {
  std::string library = "nlopt";  ///< nlopt | ipopt
  std::string name = "LD_SLSQP";  ///< NLopt's name; unused for ipopt
  std::string local;              ///< what runs inside AUGLAG and MLSL; empty: their default
};

/// How the starts but the first lie in their box.
enum class Spread { sobol, latin_hypercube };

/// Where the starts of an optimisation come from.
enum class SearchKind {
  starts,  ///< the job's own design and points of the spread
  global   ///< the best of the clusters that a screening of the whole box finds
};

/// Second objective of a job, traded against the first.
struct ParetoSpec : Constraint {
  bool maximise = false;
  int points = 9;
};

/// Settings to correct the optimum to full accuracy.
struct VerifySpec {
  double tolerance = 0.002;  ///< largest difference of what steers the search, relative
  int max_full_evaluations = 6;
};

struct OptimiseSpec {
  std::vector<Variable> variables;
  Objective objective{{.over_stroke = OverStroke::min}};
  std::vector<Constraint> constraints;
  Algorithm algorithm;
  SearchKind search = SearchKind::starts;
  int screened_designs = 0;  ///< designs that a global search screens
  int starts = 1;
  Spread spread = Spread::sobol;
  unsigned seed = 1;
  std::optional<ParetoSpec> pareto;
  std::optional<VerifySpec> verify;
  int max_evaluations = 500;  ///< per start
  /// A start with gradients ends where kkt_residual is at most a tenth of it, one without where
  /// scaled variables and objective change by less, relative.
  double tolerance = 1e-5;
  double constraint_tolerance = 1e-4;  ///< relative to the bound
};

class Expression;

/// A quantity that a job defines by a formula of quantities and parameters.
struct NamedFormula {
  std::string name;
  std::shared_ptr<const Expression> formula;  ///< without names of other such formulas
};

/// Map of quantities over two parameters.
struct MapSpec {
  std::array<Variable, 2> parameters;  ///< name and range alone
  std::array<int, 2> points{21, 21};
  std::vector<Constraint> quantities;  ///< without bounds
};

enum class SampleMethod { sobol, latin_hypercube, grid, list };

/// A number that differs from design to design.
struct SampleRange {
  std::string name;
  bool symbol = false;       ///< not a parameter of the family: a name for formulas
  double min = 0, max = 0;   ///< SI
  bool logarithmic = false;  ///< even in the logarithm
  int points = 0;            ///< values in a grid
};

/// A parameter (or the stroke) that follows from sampled numbers.
struct SampleFormula {
  std::string parameter, formula;
  std::vector<FormulaName> may_use;  ///< names that are known before it
  std::string pointer;               ///< into the job
};

struct SamplesSpec {
  SampleMethod method = SampleMethod::sobol;
  int count = 64;
  unsigned seed = 1;
  std::vector<SampleRange> ranges;
  std::vector<SampleFormula> formulas;   ///< in their order
  std::vector<ParameterValues> designs;  ///< a list of designs: what differs from the job's own, SI
  SampleFormula largest_stroke;          ///< no formula: the job's stroke for every design
};

/// What the job wants to know of its errors.
struct AccuracySpec {
  bool estimate = false;     ///< estimated errors beside the numbers
  bool automatic = false;    ///< accuracy and mesh are chosen by them; `model` is where that begins
  double tolerance = 0.003;  ///< largest error that the choice accepts, relative
  double largest = 0.1;      ///< estimate of a result that is "ok"; of stresses ten times that

  bool wants_estimates() const { return estimate || automatic; }
};

struct ModelChoice {
  std::string name;
  ModelOptions model;
  NewtonOptions newton;
  AccuracySpec accuracy;
};

struct CompareSpec {
  SamplesSpec samples;
  ModelChoice full;                 ///< the reference: the job's model at full accuracy
  std::vector<ModelChoice> models;  ///< what is compared with it
  /// Names of the compared quantities; empty: those of compared_quantities.
  std::vector<std::string> quantities;
};

struct Expectation {
  std::string pointer;              ///< into result.json
  double value = 0, tolerance = 0;  ///< absolute tolerance
  std::string source;
};

struct DesignSpec {
  std::string family;
  ParameterValues parameters;  ///< every parameter of the family, SI
  /// Parameters that are formulas of the others, SI: {"outer_width", "(0.1 - inner_width)/2"}.
  std::map<std::string, std::string> expressions;
  FamilyChoices choices;  ///< the choice for every option of the family
  Material material;
  /// The family with its formulas, compiled; only for a design that was read.
  std::shared_ptr<const ParametricDesign> resolved;
};

/// The family found and its formulas compiled: what the reader left, or made anew for a design that
/// was written by hand. Throws SpecError.
std::shared_ptr<const ParametricDesign> resolve(const DesignSpec& design);

/// How a number lies within its tolerance: evenly between the limits, or normal with the limits at
/// three standard deviations.
enum class ToleranceSpread { uniform, normal };

struct ToleranceTerm {
  /// A parameter of the family, or one of job_numbers; or that of one leaf (name_of_one_leaf).
  std::string parameter;
  double change = 0;      ///< at the entry's upper limit: SI, or
  bool relative = false;  ///< over the size of the parameter

  double value_in(const ParameterValues& values) const {
    return values.at(parts_of_name(parameter).parameter);
  }
  double change_of(double value) const { return relative ? change * std::abs(value) : change; }
  double change_in(const ParameterValues& values) const { return change_of(value_in(values)); }
};

/// A deviation z, −1 … 1 between its limits, of one parameter or of several together:
/// parameter + Σ change · z.
struct Tolerance {
  std::string name;
  ToleranceSpread spread = ToleranceSpread::uniform;
  std::vector<ToleranceTerm> terms;
  /// Entry of the job that it is of, which a name for one leaf begins with.
  std::string entry = name;
  /// Standard deviation of z: 1/√3 for a uniform spread, 1/3 for a normal one.
  double standard_deviation() const;
};

struct TolerancesSpec {
  std::vector<Tolerance> entries;
  int samples = 200;
  unsigned seed = 1;
  /// Objective and constraints that are looked at: those of "optimise", whatever the job.
  std::optional<OptimiseSpec> goals;
};

/// How far a clamped edge may sit other than designed, to either side [m, rad], global axes.
struct EdgeTolerance {
  int leaf = 0, end = 0;  ///< as of an AssemblyError
  Vector3d move = Vector3d::Zero(), turn = Vector3d::Zero();
};

/// A box of errors of assembly about those of the load case.
struct AssemblyTolerances {
  std::vector<EdgeTolerance> edges;
  /// Quantities whose worst value is sought: the least, the largest, or the largest absolute value
  /// over the stroke.
  std::vector<Constraint> quantities;
  /// A size of the box is critical where a support keeps such a share of its stiffness, the drive
  /// load changes by so much of its largest value, or the mechanism becomes unstable.
  std::optional<double> stiffness_share, drive_load_change;
  double largest_scale = 100;  ///< largest scale of the box
  int starts = 4;              ///< starts of each search
  unsigned seed = 1;
  std::optional<int> max_paths;  ///< after so many the study ends with what it has found

  bool wants_critical() const { return stiffness_share || drive_load_change; }
};

/// One of several load cases: what acts on the mechanism, and where it goes.
struct JobCase {
  std::string name;
  StrokeRequest request;
};

struct Job;

/// One of several designs, as a job of its own.
struct ListedDesign {
  std::string label;   ///< unique among the listed designs
  std::string folder;  ///< folder of its results within the run's folder
  std::shared_ptr<const Job> job;
};

struct Job {
  std::string name;
  JobKind kind = JobKind::evaluate;
  DesignSpec design;
  EndEffector end_effector;
  StrokeRequest request;  ///< the request, of the first of several load cases
  /// Load cases of a job that has several, in its order.
  std::vector<JobCase> cases;
  std::vector<NamedFormula> quantities;  ///< that it defines
  ModelOptions model;
  AccuracySpec accuracy;
  /// For a run that chose `model` by estimated errors: the model with looked-up leaves that an
  /// optimisation searches with. The optimum is then corrected on full leaves of `model`.
  std::optional<ModelOptions> search_model;
  std::optional<OptimiseSpec> optimise;
  std::optional<CompareSpec> compare;
  std::optional<TolerancesSpec> tolerances;
  std::optional<AssemblyTolerances> assembly_tolerances;
  std::vector<MapSpec> maps;
  /// Objective and constraints that maps are drawn with: those of "optimise", whatever the job.
  std::optional<OptimiseSpec> map_goals;
  /// Designs of a job that lists several; all other members are then those of the first design.
  std::vector<ListedDesign> designs;
  std::vector<Expectation> expect;
  std::vector<std::string> notes;  ///< what the reader found odd but allowed; for the user's eyes
  /// The job with defaults filled in, SI: what result.json shows. Empty for a job made by hand.
  std::shared_ptr<const nlohmann::json> as_read;
};

/// Reads and checks a job. `overrides` are --set /pointer=value texts. Throws SpecError with all
/// that is wrong, in the order of the file, each with its line and column.
Job read_job(const std::string& file, const std::vector<std::string>& overrides = {});
/// Reads and checks a job from a parsed document. Load cases under their names come in this order.
/// Throws SpecError with all that is wrong.
Job parse_job(const nlohmann::json& document, const std::vector<std::string>& case_order = {});
/// Checks the names alone of the part "design" of a job, whose values may be missing. Throws
/// SpecError.
void check_names(const nlohmann::json& design);

/// The load cases of a job: its own, or the one without a name.
std::vector<JobCase> cases_of(const Job& job);

/// Throws SpecError with this rule for a job that lists designs.
void demand_one_design(const Job& job, const std::string& rule);

/// What the job's reader left in `as_read`; null for a job made by hand.
const nlohmann::json& document_of(const Job& job);

/// The JSON Schema of a job, made from the same descriptions that drive reading.
nlohmann::json job_schema();

/// Parameters with every formula among them computed anew from the others; numbers of material and
/// end-effector (job_numbers) may be among them. Throws SpecError out of range.
ParameterValues complete_parameters(const DesignSpec& design, ParameterValues parameters);

/// The mechanism of a job with other parameter values (those of an optimiser, say); formulas are
/// computed anew, and numbers of material and end-effector among the values take the places of the
/// job's. Throws SpecError where these values make no sensible geometry.
Mechanism make_mechanism(const Job& job, const ParameterValues& parameters);

}  // namespace flexopt
