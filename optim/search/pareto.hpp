#pragma once
// The front of two objectives, by bounding the second one.
#include "optim/search/optimum.hpp"
#include "optim/search/search.hpp"

namespace flexopt {

struct ParetoOutcome {
  ParetoFront report;
  std::vector<LoggedEvaluation> evaluations;
};

/// ε-constraint: from the first objective's optimum (`optimum`) to the second one's, `points`
/// designs, each the best first objective with the second one bounded by ε; the bounds evenly
/// spaced between the second objective's values at both ends, each search begun at its neighbour's
/// end. Where a later, harder bound gave the better first objective, the earlier search is run
/// again from there.                              [Haimes, Lasdon, Wismer, IEEE Trans. SMC 1971]
ParetoOutcome search_front(const Campaign& campaign, const EvaluationBook& known,
                           const SearchResult& optimum);

}  // namespace flexopt
