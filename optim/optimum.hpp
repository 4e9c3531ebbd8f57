#pragma once
// What an optimisation returns. Plain data, named as in result.json.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "designs/family.hpp"

namespace flexopt {

struct ConstraintState {
  std::string label;
  double value = 0;
  std::optional<double> min, max;    ///< bounds asked for
  double margin = 0;                 ///< distance to the nearest bound, negative when violated
  bool active = false;               ///< |margin| within the constraint tolerance
  std::optional<double> multiplier;  ///< dObjective/dBound, where the algorithm yields one
};

/// One evaluated design; a line of evaluations.jsonl.
struct EvaluationRecord {
  int start = 0;   ///< which start asked for it
  int number = 0;  ///< counts up within the start
  ParameterValues variables;
  bool ok = false;
  std::string message;  ///< why not, with the figures
  double objective = 0;
  std::vector<double> constraints;  ///< values, in the order of the job
  double violation = 0;             ///< largest relative violation, 0 when feasible
  bool difference = false;          ///< a neighbour evaluated for central differences only
};

struct StartSummary {
  int index = 0;
  ParameterValues from, to;
  double objective = 0, violation = 0;
  bool feasible = false;
  std::string status, stop_reason;
  int evaluations = 0, failed_evaluations = 0;
};

/// The optimum evaluated again at full accuracy. Where that found no equilibrium, `response` says
/// so and there are no values. Differences: reduced / full − 1, reduced − full where full is 0.
struct Verification {
  StrokeResponse response;
  double objective = 0;
  std::vector<double> constraints;
  double objective_difference = 0;             ///< reduced / full - 1
  std::vector<double> constraint_differences;  ///< reduced / full - 1
};

struct Sensitivity {
  std::string of, parameter;  ///< d of / d parameter
  double value = 0;           ///< SI
};

enum class OptimumStatus { optimal, feasible, infeasible, failed };

struct Optimum {
  OptimumStatus status = OptimumStatus::failed;
  std::string stop_reason;
  std::string gradients;       ///< "none", "central differences", "exact"
  ParameterValues parameters;  ///< all of the family's
  double objective = 0;
  std::vector<ConstraintState> constraints;
  int evaluations = 0, failed_evaluations = 0;
  int best_start = 0;
  std::vector<StartSummary> starts;
  StrokeResponse response;  ///< at the optimum, with the job's own model
  std::optional<Verification> verified;
  std::vector<Sensitivity> sensitivities;
  std::vector<EvaluationRecord> history;  ///< in the order start, number
};

}  // namespace flexopt
