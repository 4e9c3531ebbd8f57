#pragma once
// Everything one run leaves behind, before it becomes files. Plain data.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "optim/compare/comparison.hpp"
#include "optim/job/job.hpp"
#include "optim/search/optimum.hpp"

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
  Mechanism mechanism;                    ///< the evaluated one: of the job, or of the optimum
  StrokeResponse response;                ///< job evaluate
  std::optional<Optimum> optimum;         ///< job optimise; its response stands for `response`
  std::optional<Comparison> comparison;   ///< job compare; there is no path then
  std::string status = "ok";              ///< "ok", or why the result is not usable, in one word
  std::string message;                    ///< one sentence with the figures
  std::vector<DrawnDesign> others;        ///< of an optimisation; for the report alone
  std::map<std::string, double> timings;  ///< [s], only for timings.json
};

/// Fills in status and message from the response, the optimum or the comparison.
void conclude(RunRecord& record);

/// The path that the run is about.
const StrokeResponse& response_of(const RunRecord& record);

std::string name_of(JobKind kind);
std::string name_of(Accuracy accuracy);
std::string name_of(PointStatus status);
std::string name_of(ModeKind kind);
std::string name_of(OverStroke over);
std::string name_of(OptimumStatus status);

}  // namespace flexopt
