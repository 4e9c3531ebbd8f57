#pragma once
// Several designs side by side: their results in one, the best first.
#include <string>
#include <vector>

#include "optim/job/job.hpp"
#include "results/files/json_text.hpp"

namespace flexopt {

/// The result of a job that lists designs, from those of each in the order of the job (null: not
/// begun). It is the best design's own (of an evaluation the first one's), with the job, status and
/// message of the whole, and beside it:
///     optimise   "ranking": feasible designs by their objective, then the others by their
///                violation, then those that could not be evaluated
///     evaluate   "designs", in the order of the job
/// each with name, folder, status, message, and its whole "result".
OrderedJson make_listed_result(const Job& job, const std::vector<OrderedJson>& results);

/// One row for each design, in the order of the ranking.
std::string ranking_csv(const OrderedJson& result);

/// Summary for stdout, one line for each design.
std::string listed_summary(const OrderedJson& result);

}  // namespace flexopt
