#pragma once
// Search from the optimum with continuous sizes to the best design with available sizes.
#include "optim/search/optimum.hpp"
#include "optim/search/search.hpp"

namespace flexopt {

/// A stage's outcome: what is reported, and the design to go on with.
struct StockOutcome {
  StockSearch report;
  Pose pose;            ///< of the chosen design: the stock variables held
  SearchResult chosen;  ///< nothing in `best` where none is feasible
  std::vector<LoggedEvaluation> evaluations;
};

/// True if a variable carries sizes.
bool has_stock(const OptimiseSpec& spec);

/// Every combination of the next smaller and the next larger size round the optimum (the nearest
/// 64 of them) is evaluated with the other variables as they are; in the order feasible first, then
/// by objective or violation, the first 8 have their other variables optimised again. The same is
/// done with the combinations that are at most one step in each size from the best feasible one,
/// until none is better. Then each size is held further and further away with the other sizes of
/// any value, as long as that is better than the best combination, and the combinations round it
/// are tried: where goals are convex none is left that is better. It ends as well where more
/// designs were evaluated than the job allows a search.
StockOutcome search_stock(const Campaign& campaign, const EvaluationBook& known, const Pose& pose,
                          const Candidate& optimum);

}  // namespace flexopt
