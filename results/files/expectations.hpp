#pragma once
// "expect" of a job: numbers that the result must show.
#include <string>
#include <vector>

#include "optim/job/job.hpp"
#include "results/files/json_text.hpp"

namespace flexopt {

/// Adds "expectations" to the result, one entry each. Where one fails, an otherwise usable result
/// gets the status "expectation_failed". Returns one sentence for each that failed.
std::vector<std::string> check_expectations(const std::vector<Expectation>& expectations,
                                            OrderedJson& result);

}  // namespace flexopt
