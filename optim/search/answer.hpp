#pragma once
// What an optimum says of its design: whether it is one, its constraints, sensitivities, and paths.
#include <string>
#include <vector>

#include "optim/problem/evaluation_book.hpp"
#include "optim/problem/posing.hpp"
#include "optim/search/optimum.hpp"

namespace flexopt {

/// What the stages hand on: the design that is the answer, and how it was posed.
struct Chosen {
  Pose pose;
  Candidate best;
  std::vector<double> multipliers;  ///< of the goals 1, 2, …; empty where unknown
};

/// Parameters, objective, constraints and status of the answer, where it is feasible
/// `if_feasible`.
void judge(const DesignProblem& problem, const Scales& scales, const Chosen& answer,
           OptimumStatus if_feasible, Optimum& optimum);

/// The violated constraints, the worst first, in words with their figures.
std::string violated_words(const std::vector<ConstraintState>& constraints, const Scales& scales);

/// What stands against a feasible design at the least violated one, in words with the figures: the
/// constraints (and bounds of variables) with a multiplier in its first-order conditions, which
/// cannot be met together near it, where these are known; else those that are violated.
std::string what_stops(const DesignProblem& problem, EvaluationBook& book, const Scales& scales,
                       const Chosen& answer, const std::vector<ConstraintState>& constraints);

/// Sensitivities of the objective and the active constraints, and multipliers of the constraints,
/// at the answer: from the derivatives of all goals there.
void add_derivatives(const DesignProblem& problem, EvaluationBook& book, const Chosen& answer,
                     Optimum& optimum);

/// Request for the same path with shapes, for drawing.
StrokeRequest drawn(StrokeRequest request);

/// The optimum's path by the job's model, drawn, and the verification; `own`: its values there.
void add_paths(const DesignProblem& problem, const Variables& variables, const DesignValues& own,
               int threads, Optimum& optimum);

}  // namespace flexopt
