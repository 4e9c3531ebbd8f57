#include "optim/problem/crew_evaluation.hpp"
#include "optim/search/stages.hpp"

namespace flexopt {

void help_optimise(const Job& job, const OptimiseOptions& options) {
  if (job.optimise->search == SearchKind::global) {
    ScreeningOptions how;
    how.threads = options.threads;
    how.sharing = options.sharing;
    screen(job, options.evaluators, how);
  }
  answer_evaluations(*options.sharing->crew(), DesignProblem(job, options.evaluators));
}

}  // namespace flexopt
