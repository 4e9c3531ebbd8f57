#include <fmt/format.h>

#include <algorithm>

#include "results/export/writers.hpp"
#include "results/files/scene.hpp"
#include "results/files/vtk.hpp"

namespace flexopt {

namespace {

/// Motion of all points; nothing where the model of a leaf does not tell.
std::optional<VtkField> field_of(const Mechanism& mechanism, const PathPoint& point,
                                 const Mode& mode, const std::string& name) {
  VtkField field{name, {}};
  double largest = 0;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const bool told = i < mode.leaf_motion.size() && mode.leaf_motion[i].size() > 0;
    if (!told && (mechanism.leaves[i].tip == free_edge || mode.body_motion.size() == 0))
      return std::nullopt;
    const VectorXd motion =
        told ? mode.leaf_motion[i] : cubic_leaf_motion(mechanism, i, point, mode.body_motion);
    for (Eigen::Index k = 0; k + 2 < motion.size(); k += 3) {
      field.values.emplace_back(motion.segment<3>(k));
      largest = std::max(largest, field.values.back().norm());
    }
  }
  if (largest > 0)
    for (Vector3d& v : field.values) v /= largest;
  return field;
}

}  // namespace

std::string point_vtu(const Mechanism& mechanism, const PathPoint& point) {
  std::vector<VtkField> fields;
  const auto add = [&](const std::vector<Mode>& modes, const char* drive) {
    for (std::size_t k = 0; k < modes.size(); ++k)
      if (auto field = field_of(
              mechanism, point, modes[k],
              fmt::format("mode {}, drive {}, {:.6g} Hz", k + 1, drive, modes[k].frequency)))
        fields.push_back(std::move(*field));
  };
  add(point.modes_locked, "locked");
  add(point.modes_free, "free");
  return shape_vtu(point.shapes, fields);
}

}  // namespace flexopt
