#pragma once
#include <string>

#include "results/export/exported.hpp"
#include "results/export/triangles.hpp"

namespace flexopt {

/// ASCII STL in millimetres, one closed solid a part, under its name.
std::string stl_text(const std::vector<TriangleMesh>& parts);

}  // namespace flexopt
