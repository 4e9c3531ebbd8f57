#pragma once
// Deformed mid-surfaces for ParaView: one shape_NNN.vtu a stroke point and shapes.pvd over all.
#include <filesystem>
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "core/response/response.hpp"

namespace flexopt {

/// A vector at every point of all leaves, such as the motion of a mode.
struct VtkField {
  std::string name;
  std::vector<Vector3d> values;
};

/// VTK XML unstructured grid of quadrilaterals on the undeflected leaves, with the point data
/// displacement [m] and von_mises [Pa], further ones, and the cell data leaf (index).
std::string shape_vtu(const std::vector<LeafShape>& leaves,
                      const std::vector<VtkField>& fields = {});

/// A point of a path for ParaView: displacement, stress, and every mode that it has as a vector
/// field "mode 1, drive locked, 56.3 Hz", the largest of which is one.
std::string point_vtu(const Mechanism& mechanism, const PathPoint& point);

/// Writes both, and removes shape files of a longer earlier path. Nothing if no point has shapes.
void write_shapes(const std::filesystem::path& folder, const std::vector<PathPoint>& path);

}  // namespace flexopt
