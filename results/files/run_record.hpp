#pragma once
// Everything one run leaves behind, before it becomes files. Plain data.
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/response/path/model_choice.hpp"
#include "core/response/response.hpp"
#include "optim/job/job.hpp"
#include "optim/search/optimum.hpp"
#include "optim/studies/assembly_study.hpp"
#include "optim/studies/comparison.hpp"
#include "optim/studies/response_map.hpp"
#include "optim/studies/tolerance_study.hpp"

namespace flexopt {

/// Another design that the report draws beside that of the result.
struct DrawnDesign {
  std::string label, kind;  ///< kind: "start", or "pareto" for a point of the front
  ParameterValues parameters;
  Mechanism mechanism;
  StrokeResponse response;
};

struct RunRecord {
  Job job;
  Mechanism mechanism;                ///< the evaluated one: of the job, or of the optimum
  StrokeResponse response;            ///< job evaluate; of several load cases the first
  std::vector<StrokeResponse> cases;  ///< job evaluate: of all load cases, where there are several
  /// Gradients of every path of responses_of, where they were asked for, or the reason why there
  /// are none.
  std::vector<StrokeGradients> gradients;
  std::string no_gradients;
  /// Estimated errors of every path of responses_of, where the job asks for them.
  std::vector<StrokeErrors> errors;
  std::optional<ChosenModel> chosen;     ///< by "accuracy": "auto"; then also the model of `job`
  std::optional<Optimum> optimum;        ///< job optimise; its response stands for `response`
  std::optional<Comparison> comparison;  ///< job compare; there is no path then
  std::optional<ToleranceReport> tolerances;  ///< where the job has some, and a design to look at
  std::optional<AssemblyReport> assembly;     ///< where the job has a box of errors of assembly
  std::vector<ResponseMap> maps;          ///< the job's maps, where there is a design to look at
  std::string status = "ok";              ///< "ok", or why the result is not usable, in one word
  std::string message;                    ///< one sentence with the figures
  std::vector<DrawnDesign> others;        ///< designs of an optimisation; for the report alone
  std::map<std::string, double> timings;  ///< [s], only for timings.json
};

/// Fills in status and message from the response, the optimum or the comparison, and what the
/// estimated errors add to them.
void conclude(RunRecord& record);

/// What a run says of its design: terminal, result.json and page say the same.
struct Verdict {
  std::string tone;  ///< "good", "warn" or "bad"
  std::string
      word;  ///< "works", "unstable", "overstressed", "optimal", …, or the status of the run
  std::string text;  ///< sentences with the figures
};

/// What a status says by itself.
Verdict verdict_of(std::string status, const std::string& message);
/// The verdict of a run that is concluded: failures first, then instability, then numbers that are
/// not believed, then stress beyond what the material allows.
Verdict verdict_of(const RunRecord& record);

/// Whether what was chosen keeps the tolerance at the design that the run is about.
bool meets_tolerance(const RunRecord& record);

/// The drives of its mechanism, with the quantities that its job defines.
DriveList drives_of(const RunRecord& record);

/// The path that the run is about; of several load cases that of the first.
const StrokeResponse& response_of(const RunRecord& record);
/// The paths of all load cases, in the order of cases_of(record.job); none where the run has none.
std::vector<const StrokeResponse*> responses_of(const RunRecord& record);

/// Status and message of the path of a load case.
std::pair<std::string, std::string> conclusion_of_case(const RunRecord& record, std::size_t k);

std::string name_of(Accuracy accuracy);
std::string name_of(PointStatus status);
std::string name_of(ModeKind kind);
std::string name_of(OptimumStatus status);

}  // namespace flexopt
