#include "core/elements/plate/plate_mesh_rate.hpp"

#include <algorithm>
#include <cassert>

#include "core/elements/plate/element_numbers.hpp"

namespace flexopt {
namespace {

template <class Part>
void drop_zeros(std::vector<Part>& parts) {
  if (std::ranges::all_of(parts, [](const Part& p) { return (p.array() == 0).all(); }))
    parts.clear();
}

PlateMeshRate::Shape rate_along(const PlateMesh& mesh, const ShapeRate& direction) {
  const MeshNumbers<Dual1> numbers(mesh.shape(), direction);
  const ElementNumbers<Dual1> operators(numbers);
  PlateMeshRate::Shape by;
  for (int i = 0; i < mesh.elements_along(); ++i)
    for (int j = 0; j < mesh.elements_across(); ++j) {
      const PlateMesh::Element rate = operators.element(i, j);
      by.gradient.push_back(rate.gradient);
      by.bending.push_back(rate.bending);
      by.mass.push_back(rate.mass);
      by.weight.push_back(rate.weight);
      by.metric.push_back(rate.metric);
      by.curvature.push_back(rate.curvature);
      by.curvature_weight.push_back(rate.curvature_weight);
    }
  drop_zeros(by.gradient);
  drop_zeros(by.mass);
  drop_zeros(by.weight);
  drop_zeros(by.metric);
  drop_zeros(by.curvature_weight);
  drop_zeros(by.curvature);
  const auto [A11, A12, A33] = numbers.membrane();
  by.membrane = {part_of(A11), part_of(A12), part_of(A33)};
  for (int i = 0; i < mesh.lines(); ++i) {
    const MatrixXd zero = MatrixXd::Zero(mesh.functions_per_line(), 3);
    MatrixXd &own = by.reference.emplace_back(zero), &nodes = by.undeflected.emplace_back(zero);
    for (int j = 0; j < mesh.nodes_per_line(); ++j) {
      const auto in_line = numbers.reference_node(i, j), place = numbers.undeflected_node(i, j);
      for (int k = 0; k < 4; ++k)
        for (int c = 0; c < 3; ++c) {
          own(4 * j + k, c) = part_of(in_line[static_cast<std::size_t>(k)][c]);
          nodes(4 * j + k, c) = part_of(place[static_cast<std::size_t>(k)][c]);
        }
    }
  }
  drop_zeros(by.reference);
  drop_zeros(by.undeflected);
  return by;
}

}  // namespace

PlateMeshRate::PlateMeshRate(const PlateMesh& mesh, const std::vector<ProfileRate>& profiles) {
  for (int k = 0; k < ShapeParameter::sizes; ++k)
    direction.emplace_back(Vector3d(Vector3d::Unit(k)));
  for (const ProfileRate& profile : profiles) direction.emplace_back(profile);
  for (const ShapeRate& along : direction) shape.push_back(rate_along(mesh, along));
}

ShapeRate PlateMeshRate::along(const VectorXd& shape_rate) const {
  assert(shape_rate.size() == directions());
  ShapeRate sum(shape_rate.head<ShapeParameter::sizes>());
  const auto add = [](std::vector<double>& to, double factor, const std::vector<double>& from) {
    if (factor == 0 || from.empty()) return;
    to.resize(from.size());
    for (std::size_t k = 0; k < from.size(); ++k) to[k] += factor * from[k];
  };
  for (int k = ShapeParameter::sizes; k < directions(); ++k) {
    const ShapeRate& own = direction[k];
    add(sum.width_profile, shape_rate[k], own.width_profile);
    add(sum.thickness_profile, shape_rate[k], own.thickness_profile);
    sum.curve += shape_rate[k] * own.curve;
    sum.fold.place += shape_rate[k] * own.fold.place;
    sum.fold.angle += shape_rate[k] * own.fold.angle;
    sum.fold.radius += shape_rate[k] * own.fold.radius;
  }
  return sum;
}

std::shared_ptr<const PlateMeshRate> shared_mesh_rate(
    LeafRates& rates, const std::shared_ptr<const PlateMesh>& mesh) {
  return rates.of<PlateMeshRate>(mesh, [&] {
    const PlateShape& shape = mesh->shape();
    return PlateMeshRate(
        *mesh, rates.profiles().of({shape.width_profile, shape.thickness_profile,
                                    shape.curve.value_or(0), shape.fold.value_or(LeafFold{})}));
  });
}

}  // namespace flexopt
