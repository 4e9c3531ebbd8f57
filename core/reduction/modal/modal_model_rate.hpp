#pragma once
// Derivatives of a ModalModel in w/L, t/L, ν: its fields follow from the undeflected leaf by linear
// solves, whose derivatives are solves by the same factor. Equations (M10), (M11) of
// core/reduction/modal/README.md.
#include <array>
#include <memory>

#include "core/elements/plate/plate_mesh_rate.hpp"
#include "core/reduction/modal/modal_leaf.hpp"

namespace flexopt {

struct ModalModelRate {
  struct Shape {
    VectorXd rest, edges_at_rest;  ///< unknowns and nodal values of the edges, undeflected
    MatrixXd follow, boundary, theta;
    MatrixXd fields;  ///< of their span: combinations of the derivatives with constant factors
  };
  std::shared_ptr<const PlateMeshRate> mesh;
  std::array<Shape, 3> shape;

  ModalModelRate(const ModalModel& model, std::shared_ptr<const PlateMeshRate> rate);
};

/// Those of a model that leaves share, made when first asked for.
std::shared_ptr<const ModalModelRate> shared_model_rate(
    LeafRates& rates, const std::shared_ptr<const ModalModel>& model);

}  // namespace flexopt
