#pragma once
// One evaluated design of an optimisation. Plain data.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "designs/family.hpp"

namespace flexopt {

/// What an evaluation was for: the starts, then what follows them.
enum class Stage { search, stock, pareto, verification };

/// The constraint that misses its bounds by most, or is nearest to them.
struct WorstConstraint {
  std::size_t place = 0;  ///< in the order of the job
  double excess = 0;      ///< relative, negative inside the bounds
};

/// One evaluated design; a line of evaluations.jsonl.
struct EvaluationRecord {
  Stage stage = Stage::search;
  int start = 0;      ///< which start (stock design, point of the front) asked for it
  int number = 0;     ///< counts up within the start
  bool full = false;  ///< at full accuracy, for the verification
  ParameterValues variables;
  bool ok = false;
  std::string message;  ///< why not, with the figures
  double objective = 0;
  std::vector<double> constraints;       ///< values, in the order of the job
  double violation = 0;                  ///< largest relative violation, 0 when feasible
  bool difference = false;               ///< a neighbour evaluated for central differences only
  std::optional<WorstConstraint> worst;  ///< nothing without bounds; not in the log
};

}  // namespace flexopt
