#pragma once
// What the ends of the starts are worth: which design is the answer, and whether it is an optimum.
#include <memory>
#include <string>
#include <vector>

#include "optim/search/search.hpp"

namespace flexopt {

/// A start of an optimisation, from its begin to its end.
struct Start {
  std::unique_ptr<EvaluationBook> book;
  VectorXd from;
  SearchResult result;
};

struct Confirmation {
  int best = -1;       ///< the start whose end is the answer; −1: no design could be evaluated
  bool holds = false;  ///< the answer keeps its bounds and meets the test of an optimum
  bool confirmed = false;  ///< ... and so does a second search that knew nothing of the first
  std::string message;     ///< which one, with the figures
};

/// The answer is the best design of all that the starts evaluated: where a search passed by it, it
/// goes on from there. Where no other start ends at the same objective, and the answer does not
/// stand out among the designs round it, a fresh search from beside the answer, scaled there, must
/// come back to it; where it finds a better design, that is the answer, and the same is asked of
/// it. Each search spends what the start's own left of the evaluations. All ends are weighed in the
/// scales of the answer, which become the campaign's.
Confirmation confirm(Campaign& campaign, std::vector<Start>& starts);

/// Whether the first-order conditions at a design are those of a strict local optimum, by what the
/// book knows: where multipliers leave directions free, designs that it evaluated span them, and
/// the Lagrangian is larger at all that are near. False where that is not known.
bool stands_out(const DesignProblem& problem, EvaluationBook& book, const Pose& pose,
                const Candidate& at);

/// A design beside one in the box, away from the bounds that it is at, to begin a fresh search
/// from.
VectorXd beside(const DesignProblem& problem, EvaluationBook& book, const Pose& pose,
                const Candidate& at);

}  // namespace flexopt
