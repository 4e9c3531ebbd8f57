#pragma once
// SI units of what results hold; they depend on the drive (metre or radian).
#include <string>

#include "core/response/quantities.hpp"
#include "designs/family.hpp"

namespace flexopt {

/// m | rad of the first drive, or 1 for a load path
std::string stroke_unit(const DriveList& drives, const StrokeRequest& request);
std::string quantity_unit(const std::string& quantity, const DriveList& drives);  ///< "" if unknown
/// Unit of a goal's quantity; "SI" for a formula, which has no quantity.
std::string goal_unit(const std::string& quantity, const DriveList& drives);
std::string parameter_unit(const Family& family, const std::string& parameter);

}  // namespace flexopt
