#pragma once
// SI units of what results hold; they depend on the drive (metre or radian).
#include <string>

#include "core/response/response.hpp"
#include "designs/family.hpp"

namespace flexopt {

/// m | rad, or 1 for a load path
std::string stroke_unit(Direction drive, const StrokeRequest& request);
std::string load_unit(Direction direction);                               ///< N | N m
std::string stiffness_unit(Direction direction);                          ///< N/m | N m/rad
std::string quantity_unit(const std::string& quantity, Direction drive);  ///< "" if unknown
std::string parameter_unit(const Family& family, const std::string& parameter);

}  // namespace flexopt
