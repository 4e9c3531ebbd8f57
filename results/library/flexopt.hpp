#pragma once
/// @file
/// flexopt for C++ programs: designs and jobs, evaluation over the stroke with exact gradients,
/// optimisation, and the goals of a job as functions for other optimisers.
///
///     find_package(flexopt REQUIRED COMPONENTS library)
///     target_link_libraries(program PRIVATE flexopt::flexopt)
///
/// Numbers are in SI units, angles in radians. Only the standard library is included, and only its
/// types cross the border: a program may be compiled for any processor and with any other library.
/// Nothing here holds global state; different threads may work with different objects, and read
/// the same ones.
#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

/// @name Version of this header
/// While the first number is 0 the second one counts changes that break programs; docs/versions.md
/// says what it promises.
/// @{
#define FLEXOPT_VERSION_MAJOR 0  ///< changes that break programs
#define FLEXOPT_VERSION_MINOR 1  ///< additions
#define FLEXOPT_VERSION_PATCH 0  ///< repairs
/// @}

/// What the library shows to programs.
#define FLEXOPT_EXPORTED [[gnu::visibility("default")]]

namespace flexopt {
#ifndef FLEXOPT_MAKES_LIBRARY
inline
#endif
    /// What this header promises; the name is part of every symbol, so that a program and a library
    /// that do not fit are an error of the linker.
    namespace v0 {

/// Version of the library that is linked, "0.1.0".
FLEXOPT_EXPORTED std::string version();
/// Version-control identifier of the library's sources, or "unknown".
FLEXOPT_EXPORTED std::string commit();
/// The `"flexopt"` of the jobs that the library reads.
FLEXOPT_EXPORTED int job_format();
/// The `"format"` of the results that the library writes.
FLEXOPT_EXPORTED int result_format();

// --------------------------------------------------------------------------------------- Errors

/// One thing that is wrong with a design or a job.
struct Fault {
  std::string pointer;  ///< JSON pointer of the culprit
  std::string value;    ///< what stands there
  std::string rule;     ///< what would be right
  std::string source;   ///< file that it stands in; empty: unknown
  int line = 0;         ///< in that file, from 1; 0: unknown
  int column = 0;       ///< in letters, from 1; 0: unknown
};

/// Wrong input. Thrown by all that reads a design or a job, and by a run that finds its geometry
/// impossible.
class FLEXOPT_EXPORTED JobError : public std::invalid_argument {
 public:
  /// `faults`: at least one.
  JobError(const std::string& message, std::vector<Fault> faults);
  ~JobError() override;
  /// All that is wrong, in the order of the file.
  const std::vector<Fault>& faults() const { return faults_; }

 private:
  std::vector<Fault> faults_;
};

/// Exact derivatives were asked for, and the model or the quantity has none.
class FLEXOPT_EXPORTED NoGradient : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  ~NoGradient() override;
};

/// The progress function of a run returned false.
class FLEXOPT_EXPORTED Stopped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  ~Stopped() override;
};

// ------------------------------------------------------------------------------ Designs and jobs

/// A number in SI units, or a text: a number with a unit ("0.5 mm"), a formula of other parameters
/// ("(100 mm - inner_width)/2"), a name.
using Value = std::variant<double, std::string>;
/// Values by name.
using Values = std::map<std::string, Value>;

/// A mechanism with its dimensions. Its numbers are checked when it becomes a job.
class FLEXOPT_EXPORTED Design {
 public:
  /// A design of a family (`flexopt designs`). `values`: parameters, options of the family, and
  /// "material", the name of one. Throws JobError where there is no such family.
  static Design of_family(const std::string& name, const Values& values = {});
  /// A design from a design file; `values` as in of_family(). Throws JobError where it cannot be
  /// read.
  static Design of_file(const std::filesystem::path& file, const Values& values = {});
  /// The part "design" of a job as JSON, or the content of a design file. Throws JobError for what
  /// is no JSON object.
  static Design of_json(std::string_view text);

  /// A copy of the design in which these values replace its own.
  Design with(const Values& values) const;
  /// The part "design" of a job.
  const std::string& json() const { return json_; }

 private:
  explicit Design(std::string json) : json_(std::move(json)) {}
  std::string json_;
};

/// A job: read, checked, defaults filled in. Cheap to copy.
class FLEXOPT_EXPORTED Job {
 public:
  /// A job file. `overrides`: "/pointer=value" as of `flexopt run --set`. Throws JobError with all
  /// that is wrong.
  static Job of_file(const std::filesystem::path& file,
                     const std::vector<std::string>& overrides = {});
  /// A job from its JSON text. Throws JobError with all that is wrong.
  static Job of_json(std::string_view text);
  /// An evaluation of a design, unless `keys` say another "job": the other parts of it as a JSON
  /// object, at least "stroke". Throws JobError.
  static Job of_design(const Design& design, std::string_view keys);

  std::string name() const;  ///< name of the job
  std::string kind() const;  ///< "evaluate", "optimise" or "compare"
  /// Parameters of the job's design by name, SI.
  std::map<std::string, double> parameters() const;
  /// What results can be differentiated by: parameters that are no formulas, "material.…",
  /// "end_effector.…".
  std::vector<std::string> differentiable() const;
  /// What is odd but allowed, a sentence each.
  std::vector<std::string> notes() const;
  /// The job with defaults filled in, SI.
  std::string json() const;

  struct Impl;                                                       ///< used by the library
  const std::shared_ptr<const Impl>& impl() const { return impl_; }  ///< used by the library

 private:
  explicit Job(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// --------------------------------------------------------------------------------------- Results

/// Rows of numbers, one after the other.
struct Table {
  std::size_t rows = 0;         ///< their number
  std::size_t columns = 0;      ///< numbers in a row
  std::vector<double> numbers;  ///< rows × columns

  /// Number in row i, column j.
  double operator()(std::size_t i, std::size_t j) const { return numbers[i * columns + j]; }
};

/// What happens with the drive while loads deflect the mechanism.
enum class Drive {
  free,  ///< its load stays
  held   ///< its stroke stays
};

/// One load case over its stroke of n points. Cheap to copy; keeps its run alive.
class FLEXOPT_EXPORTED Path {
 public:
  std::string name() const;     ///< name of the load case; empty where there is one only
  std::size_t size() const;     ///< n
  std::string status() const;   ///< "ok", "no_equilibrium", "left_branch" or "limit_reached"
  std::string message() const;  ///< one sentence with the figures
  /// Whether there is an equilibrium at a point. Where there is none its values are missing, and
  /// its displacement, rotation and compliance are 0.
  bool converged(std::size_t point) const;

  std::vector<double> stroke() const;  ///< n [m or rad], of the first drive
  Table displacement() const;          ///< n × 3, of the reference point O [m]
  Table rotation() const;              ///< n × 3, rotation vector of the end-effector [rad]
  /// 6 × 6, row by row, at O: (ux uy uz rx ry rz) [m, rad] against (Fx Fy Fz Mx My Mz) [N, N m].
  std::array<double, 36> compliance(std::size_t point, Drive drive) const;
  /// Natural frequencies, ascending [Hz]; as many as the job asks for and the point has.
  std::vector<double> frequencies(std::size_t point, Drive drive) const;

  /// Quantities with a number at some point; `flexopt quantities` says what they are.
  std::vector<std::string> names() const;
  /// SI unit of a quantity. This and the following throw std::out_of_range for a name that is no
  /// quantity.
  std::string unit(const std::string& quantity) const;
  /// n numbers, SI; nothing at a point that has no such number, everywhere if none has.
  std::vector<std::optional<double>> values(const std::string& quantity) const;
  /// Exact derivatives, n × p, by the p names of Evaluation::gradients_by, SI per SI. Formulas of
  /// the design follow. Throws NoGradient where none were asked for, and where a point has none.
  Table gradient(const std::string& quantity) const;

  struct Impl;  ///< used by the library
  /// For the library only.
  explicit Path(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

 private:
  std::shared_ptr<const Impl> impl_;
};

/// What every run returns. Cheap to copy.
class FLEXOPT_EXPORTED Result {
 public:
  std::string status() const;   ///< "ok", or why the result is not usable, in one word
  std::string message() const;  ///< one sentence with the figures
  /// Whether the status is "ok".
  bool usable() const { return status() == "ok"; }
  /// The content of result.json, but for what the job's "expect" found; docs/library.md says where
  /// to look.
  std::string json() const;
  /// The report: one page that needs nothing else.
  std::string html() const;

  struct Impl;  ///< used by the library
  /// For the library only.
  explicit Result(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  const std::shared_ptr<const Impl>& impl() const { return impl_; }  ///< used by the library

 protected:
  std::shared_ptr<const Impl> impl_;  ///< the run
};

/// A design over its stroke. Its status is "ok", "no_equilibrium", "limit_reached" (the job's
/// limits), "tolerance_not_met" (of "accuracy": "auto") or "estimate_beyond_limit" (an estimated
/// error is above the job's largest_estimate).
class FLEXOPT_EXPORTED Evaluation : public Result {
 public:
  using Result::Result;
  /// Paths of all load cases of the job; none where an optimisation found no design.
  std::vector<Path> paths() const;
  /// The path of the first load case. Throws std::out_of_range where there is none.
  Path path() const;
  /// Names of the parameters that gradients are by, one for each column of their tables.
  std::vector<std::string> gradients_by() const;
};

/// A constraint at the optimum.
struct ConstraintAtOptimum {
  std::string label;            ///< "max_stress max over stroke"
  double value = 0;             ///< SI
  std::optional<double> lower;  ///< bound, SI
  std::optional<double> upper;  ///< bound, SI
  double margin = 0;            ///< distance to the nearest bound; negative: violated
  bool active = false;          ///< at a bound
};

/// What an optimisation found; its paths are those of the optimum. Its status is "ok",
/// "not_converged", "not_verified" (no equilibrium at full accuracy), "tolerance_not_met" (of
/// "accuracy": "auto"), "estimate_beyond_limit", "infeasible" or "failed".
class FLEXOPT_EXPORTED Optimum : public Evaluation {
 public:
  using Evaluation::Evaluation;
  /// The objective, SI; nothing where no design could be evaluated.
  std::optional<double> objective() const;
  /// Every parameter of the optimum, SI; empty where no design could be evaluated.
  std::map<std::string, double> parameters() const;
  std::vector<ConstraintAtOptimum> constraints() const;  ///< in the order of the job
  int evaluations() const;                               ///< evaluated designs
};

// ------------------------------------------------------------------------------------------ Runs

/// How far a run is.
struct Progress {
  int done = 0;      ///< steps
  int total = 0;     ///< steps of the run, or more than it will take; 0: the text says what begins
  std::string text;  ///< a text of one line
};

/// How to run a job.
struct Options {
  /// Folder for the files of `flexopt run`; empty: none are written. With a folder, a run that was
  /// interrupted goes on where it stopped.
  std::filesystem::path folder;
  int threads = 0;  ///< 0: as many as the machine has; no number depends on it
  /// Told how far the run is, one call at a time, from any thread; false ends the run with Stopped.
  std::function<bool(const Progress&)> progress;
  /// Evaluations only: names of Job::differentiable with respect to which results are
  /// differentiated. All numbers then come from full leaves or from looked-up ones, and the message
  /// says so.
  std::vector<std::string> gradients;
};

/// The design of a job, whatever its kind, over its stroke. A design without equilibrium is a
/// status of the result. Throws JobError, NoGradient where derivatives cannot be had, Stopped.
FLEXOPT_EXPORTED Evaluation evaluate(const Job& job, const Options& options = {});
/// Looks for the best design of a job with a part "optimise". Throws JobError, Stopped.
FLEXOPT_EXPORTED Optimum optimise(const Job& job, const Options& options = {});
/// Models against full accuracy over the sampled designs of a job of kind "compare"; the numbers
/// are in Result::json. Throws JobError, Stopped.
FLEXOPT_EXPORTED Result compare(const Job& job, const Options& options = {});

// ---------------------------------------------------------------------- Optimisers of others

/// Goals of one design: minimise f subject to bounds on g.
struct Goals {
  /// False: no values at this design (no equilibrium, no such geometry): an optimiser does best to
  /// try one that is nearer. Then all is empty but the next two.
  bool ok = false;
  std::string message;            ///< why there are no values, with the figures
  std::optional<double> reached;  ///< how far the stroke went [m or rad]
  double f = 0;                   ///< the objective, its sign turned where the job maximises it
  std::vector<double> g;          ///< m constraints
  std::vector<double> df;         ///< n derivatives of f; empty where none were asked for
  Table dg;                       ///< m × n derivatives of g
};

/// How the goals of a job are posed.
struct Posing {
  /// x in [0, 1]; f and g over what makes them of order one. Else all is in SI units.
  bool scaled = true;
  /// A bound over the stroke is one on each of its points, and the worst value of an objective over
  /// the stroke is a further, last variable "t": more rows, all of them smooth.
  bool pointwise = false;
};

/// The goals of a job as functions of its n variables:
/// minimise f(x) subject to constraint_lower ≤ g(x) ≤ constraint_upper, lower ≤ x ≤ upper.
class FLEXOPT_EXPORTED Problem {
 public:
  /// Evaluates the start, which says what is of order one. Throws JobError for a job without goals.
  explicit Problem(const Job& job, const Posing& posing = {});

  std::vector<std::string> names() const;             ///< n, of the variables
  std::vector<double> start() const;                  ///< n, of the job's design
  std::vector<double> lower() const;                  ///< n
  std::vector<double> upper() const;                  ///< n
  std::vector<std::string> constraint_names() const;  ///< m
  std::vector<double> constraint_lower() const;       ///< m; −∞ where there is none
  std::vector<double> constraint_upper() const;       ///< m; +∞ where there is none

  /// The goals at x, n numbers. The last designs are remembered; safe to call from several threads.
  /// Numbers out of their box are taken as they are. Throws JobError for numbers that are none,
  /// NoGradient where exact derivatives cannot be had.
  Goals at(const std::vector<double>& x, bool gradient = false) const;
  /// Every parameter of the design at x, SI. Throws JobError for numbers that are none.
  std::map<std::string, double> parameters(const std::vector<double>& x) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace v0
}  // namespace flexopt
