#pragma once
// Derivatives of the element operators of plate_mesh.hpp with respect to the shape of the leaf:
// width w/L, thickness t/L, Poisson's ratio.
#include <array>
#include <memory>
#include <vector>

#include "core/elements/plate/plate_mesh.hpp"

namespace flexopt {

class LeafRates;

struct PlateMeshRate {
  /// Parts that a parameter does not enter are left empty.
  struct Shape {
    std::vector<PlateMesh::Matrix16> gradient, bending, mass;        ///< of every element
    std::vector<Eigen::Array<double, PlateMesh::points, 1>> weight;  ///< of every element
    PlateMesh::Membrane membrane;
  };
  static constexpr int width = 0, thickness = 1, poissons_ratio = 2;
  std::array<Shape, 3> shape;

  /// Plates by the powers of w and t that every entry is made of; beams through the constants of
  /// their section.
  explicit PlateMeshRate(const PlateMesh& mesh);

 private:
  void plate(const PlateMesh& mesh);
  void beam(const PlateMesh& mesh);
};

/// Those of a mesh that leaves share, made when first asked for.
std::shared_ptr<const PlateMeshRate> shared_mesh_rate(LeafRates& rates,
                                                      const std::shared_ptr<const PlateMesh>& mesh);

}  // namespace flexopt
