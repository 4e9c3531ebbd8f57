#pragma once
// A few lines about a run for the terminal.
#include <string>

#include "results/files/run_record.hpp"

namespace flexopt {

std::string summary_of(const RunRecord& record);

}  // namespace flexopt
