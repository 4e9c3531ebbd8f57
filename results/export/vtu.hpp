#pragma once
#include <string>

#include "core/response/response.hpp"

namespace flexopt {

/// A point of a path for ParaView: displacement, stress, and every mode that it has as a vector
/// field "mode 1, drive locked, 56.3 Hz", the largest of which is one.
std::string point_vtu(const Mechanism& mechanism, const PathPoint& point);

}  // namespace flexopt
