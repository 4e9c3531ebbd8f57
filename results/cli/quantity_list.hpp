#pragma once
// The table of quantities for the terminal.
#include <string>

#include "core/response/quantities.hpp"

namespace flexopt {

/// A line for every row of the table, with the names that goals may use, SI units, what an
/// evaluation must compute for it, and what it is.
std::string describe_quantities(const DriveList& drives);

}  // namespace flexopt
