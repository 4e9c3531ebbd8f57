#pragma once
// The worst errors of assembly in a box, and the size of the box at which they become critical.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "optim/job/job.hpp"
#include "optim/problem/goals.hpp"

namespace flexopt {

/// A quantity at its worst in the box.
struct WorstAssembly {
  Constraint of;                            ///< which one, and which side of it
  double nominal = 0;                       ///< with the job's own errors of assembly
  std::optional<double> corner, worst;      ///< at the corner that the gradients point to; found
  GoalPlace place;                          ///< load case and point where it is the worst
  std::vector<AssemblyError> misalignment;  ///< beside the job's own
  /// Other places of the box that are as bad but for rounding, of those that were looked at.
  std::vector<std::vector<AssemblyError>> as_bad;
  int evaluations = 0;  ///< number of paths evaluated
  std::string reason;   ///< where something in the box has no value
};

/// The largest common scale of the box that keeps clear of what is critical.
struct CriticalAssembly {
  double scale = 0;
  std::string limit;  ///< "stiffness", "drive_load", "instability", or "none" up to the largest
  std::string text;   ///< what happens there
  GoalPlace place;
  std::vector<AssemblyError> misalignment;
  int evaluations = 0;
};

struct AssemblyReport {
  std::string message;  ///< why there is nothing; empty otherwise
  std::vector<WorstAssembly> quantities;
  std::optional<CriticalAssembly> critical;
};

/// Is told the number of paths so far.
using PathsSoFar = std::function<void(int paths)>;

/// How many paths the study of a job evaluates at most, about: all of its searches to their ends.
int most_paths(const Job& job);

/// Study of the assembly errors of the job's design with these parameters, by this model, over the
/// worst of its load cases. Derivatives along the errors are central differences. Where max_paths
/// ends it, the worst that was found has the reason.
AssemblyReport study_assembly(const Job& job, const ParameterValues& parameters,
                              const ModelOptions& model, const PathsSoFar& progress = {});

}  // namespace flexopt
