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

/// Parameters, objective, constraints and status of the answer. `converged`: of the search that
/// ended there.
void judge(const DesignProblem& problem, const Scales& scales, const Chosen& answer, bool converged,
           Optimum& optimum);

/// The constraint that is violated most, in words with its figures.
std::string what_stops(const std::vector<ConstraintState>& constraints, const Scales& scales);

/// Sensitivities of the objective and the active constraints, and multipliers of the constraints,
/// at the answer: from the derivatives of all goals there.
void add_derivatives(const DesignProblem& problem, EvaluationBook& book, const Chosen& answer,
                     Optimum& optimum);

/// The same path with shapes, for drawing.
StrokeRequest drawn(StrokeRequest request);

/// The optimum's path by the job's model, drawn, and the verification; `own`: its values there.
void add_paths(const DesignProblem& problem, const Variables& variables, const DesignValues& own,
               int threads, Optimum& optimum);

}  // namespace flexopt
