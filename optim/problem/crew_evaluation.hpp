#pragma once
// Evaluations of a problem by a crew.
#include "optim/numerics/sharing.hpp"
#include "optim/problem/design_problem.hpp"

namespace flexopt {

/// DesignProblem::evaluate by whoever of the crew is free. The others have the same job and answer
/// by `answer_evaluations`. Throws as Crew::ask.
DesignValues ask_evaluation(Crew& crew, const DesignProblem& problem, const Variables& variables,
                            bool gradient, std::optional<Accuracy> accuracy);

/// Answers until the leader ends the stage.
void answer_evaluations(Crew& crew, const DesignProblem& problem);

}  // namespace flexopt
