#pragma once
// Derivatives of the element operators of plate_mesh.hpp with respect to the shape of the leaf:
// width w/L, thickness t/L, Poisson's ratio, and along directions of its profiles.
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_rates.hpp"
#include "core/elements/plate/plate_mesh.hpp"

namespace flexopt {

struct PlateMeshRate {
  struct Shape {
    /// Derivatives of the operators of every element. All but `bending` are left empty where a
    /// direction changes none of them.
    std::vector<PlateMesh::Matrix16> gradient, bending, mass;
    std::vector<PlateMesh::Weights> weight;
    std::vector<Eigen::Array<double, PlateMesh::points, 1>> metric;
    /// Derivatives of the operators and factors of PlateMesh::Element::curvature.
    std::vector<MatrixXd> curvature;
    std::vector<Eigen::ArrayXd> curvature_weight;
    PlateMesh::Membrane membrane;
    /// Derivatives of the undeflected nodal values, functions × 3 for every line, in the axes of
    /// the line (PlateMesh::reference_node) and in those of the chord; empty where these are
    /// constant.
    std::vector<MatrixXd> reference, undeflected;
  };
  std::vector<ShapeRate> direction;  ///< of every ShapeParameter
  std::vector<Shape> shape;          ///< along each of them

  /// `profiles`: directions in which the profiles change.
  explicit PlateMeshRate(const PlateMesh& mesh, const std::vector<ProfileRate>& profiles = {});

  int directions() const { return static_cast<int>(shape.size()); }
  /// Change of the shape along the direction with these coordinates.
  ShapeRate along(const VectorXd& shape) const;
};

/// Derivatives of a mesh that leaves share, made when first asked for.
std::shared_ptr<const PlateMeshRate> shared_mesh_rate(LeafRates& rates,
                                                      const std::shared_ptr<const PlateMesh>& mesh);

}  // namespace flexopt
