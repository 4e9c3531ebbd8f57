#include "core/elements/plate/deformed_plate.hpp"

#include <algorithm>

#include "core/elements/plate/beam_stress.hpp"
#include "core/elements/plate/full_leaf.hpp"
#include "core/elements/plate/plate_stress.hpp"

namespace flexopt {

LeafShape plate_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const LeafSpring& leaf, const LeafScale& scale) {
  if (mesh.shape().is_beam()) return beam_deformed_shape(mesh, nodal, leaf, scale);
  LeafShape shape;
  const StrainField field = recovered_strains(mesh, nodal);
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  shape.points_along = nx + 1;
  shape.points_across = ny + 1;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const Vector3d r = nodal[i].row(4 * j).transpose();
      const EdgePose& line = mesh.line_pose(i);
      const Vector3d place = line.position + line.axes * mesh.reference_node(i, j)[0];
      shape.undeflected.push_back(scale.origin +
                                  scale.axes * place * (scale.length / scale.growth));
      shape.deflected.push_back(scale.origin + scale.axes * r * scale.length);
      const bool second = mesh.fold_line() >= 0 && i == mesh.fold_line() + 1;
      const double x = second ? behind_fold(mesh.x()[i]) : mesh.x()[i];
      const SurfaceStress s = surface_stress(mesh.shape(), field.at(x, mesh.y()[j]),
                                             leaf.material.youngs_modulus, mesh.x()[i]);
      shape.von_mises.push_back(std::max(s.positive, s.negative));
    }
  return shape;
}

Vector3d plate_material_point(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                              const LeafScale& scale, double along, double across) {
  Vector3d r = Vector3d::Zero();
  for (const NodalWeight& w : point_weights(mesh, along, across))
    r += w.weight * nodal[w.line].row(w.function).transpose();
  return scale.origin + scale.axes * r * scale.length;
}

std::vector<Vector3d> plate_material_points(const PlateMesh& mesh,
                                            const std::vector<MatrixXd>& nodal,
                                            const LeafScale& scale,
                                            const std::vector<std::array<double, 2>>& places) {
  std::vector<Vector3d> points;
  points.reserve(places.size());
  for (const auto& [along, across] : places)
    points.push_back(plate_material_point(mesh, nodal, scale, along, across));
  return points;
}

}  // namespace flexopt
