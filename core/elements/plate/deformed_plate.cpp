#include "core/elements/plate/deformed_plate.hpp"

#include "core/elements/plate/full_leaf.hpp"
#include "core/elements/plate/plate_stress.hpp"

namespace flexopt {

LeafShape plate_deformed_shape(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const LeafSpring& leaf, const LeafScale& scale) {
  const bool beam = mesh.shape().is_beam();
  LeafShape shape;
  shape.points_along = mesh.lines();
  shape.points_across = beam ? 2 : mesh.nodes_per_line();
  std::vector<StressPlace> places;
  for (int j = 0; j < shape.points_across; ++j)
    for (int i = 0; i < shape.points_along; ++i) {
      const double half = 0.5 * mesh.shape().width_at(mesh.x()[i]),
                   edge = beam ? (j == 0 ? -half : half) : 0.0;
      const int node = beam ? 0 : j;
      const Vector3d r = (nodal[i].row(4 * node) + edge * nodal[i].row(4 * node + 2)).transpose();
      const EdgePose& line = mesh.line_pose(i);
      const Vector3d place =
          line.position + line.axes * mesh.reference_node(i, node)[0] + edge * line.axes.col(1);
      shape.undeflected.push_back(scale.origin +
                                  scale.axes * place * (scale.length / scale.growth));
      shape.deflected.push_back(scale.origin + scale.axes * r * scale.length);
      const bool second = mesh.fold_line() >= 0 && i == mesh.fold_line() + 1;
      places.push_back({second ? behind_fold(mesh.x()[i]) : mesh.x()[i],
                        beam ? static_cast<double>(j) : mesh.y()[j] / mesh.shape().width + 0.5});
    }
  shape.von_mises = leaf_stress(mesh, nodal, leaf, scale, 0).on_surface(places);
  return shape;
}

std::vector<Vector3d> plate_material_points(const PlateMesh& mesh,
                                            const std::vector<MatrixXd>& nodal,
                                            const LeafScale& scale,
                                            const std::vector<std::array<double, 2>>& places) {
  std::vector<Vector3d> points;
  for (const auto& [along, across] : places) {
    Vector3d r = Vector3d::Zero();
    for (const NodalWeight& w : point_weights(mesh, along, across))
      r += w.weight * nodal[w.line].row(w.function).transpose();
    points.push_back(scale.origin + scale.axes * r * scale.length);
  }
  return points;
}

}  // namespace flexopt
