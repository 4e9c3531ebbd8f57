#include <Eigen/LU>

#include "results/export/parts.hpp"
#include "support/leaf_volume.hpp"
#include "tests/results/export/gallery.hpp"

using namespace flexopt;

namespace {

// Corners of the reference brick, then its mid-sides: the order of C3D20.
constexpr double corner[20][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1},
                                  {1, -1, 1},   {1, 1, 1},   {-1, 1, 1}, {0, -1, -1}, {1, 0, -1},
                                  {0, 1, -1},   {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},   {0, 1, 1},
                                  {-1, 0, 1},   {-1, -1, 0}, {1, -1, 0}, {1, 1, 0},   {-1, 1, 0}};

double shape(int k, const Vector3d& u) {
  const double* c = corner[k];
  double product = 1, sum = -2;
  for (int d = 0; d < 3; ++d) {
    product *= c[d] == 0 ? 1 - u[d] * u[d] : 1 + c[d] * u[d];
    sum += c[d] * u[d];
  }
  return k < 8 ? product * sum / 8 : product / 4;
}

/// Σ det(∂x/∂u) over the 27 Gauss points; the least determinant.
std::pair<double, double> volume_of(const SolidMesh& mesh) {
  const double g[] = {-std::sqrt(0.6), 0, std::sqrt(0.6)}, w[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  double volume = 0, least = 1;
  for (const auto& element : mesh.elements)
    for (int i = 0; i < 27; ++i) {
      const Vector3d u(g[i % 3], g[i / 3 % 3], g[i / 9]);
      Matrix3d slope = Matrix3d::Zero();
      for (int k = 0; k < 20; ++k)
        for (int d = 0; d < 3; ++d) {
          const Vector3d step = 1e-4 * Vector3d::Unit(d);
          slope.col(d) += mesh.nodes[static_cast<std::size_t>(element[k])] *
                          ((shape(k, u + step) - shape(k, u - step)) / 2e-4);
        }
      const double det = slope.determinant();
      volume += w[i % 3] * w[i / 3 % 3] * w[i / 9] * det;
      least = std::min(least, det);
    }
  return {volume, least};
}

}  // namespace

TEST_CASE("Bricks of a leaf are not inside out and fill its volume") {
  std::vector<LeafSpring> all = test::folded_leaf().mechanism.leaves;
  REQUIRE(all.front().fold);
  for (const char* name : {"parallel_guide", "curved_leaf", "tapered_leaf", "wire_flexure",
                           "reinforced_guide", "notch_beam"})
    for (const LeafSpring& leaf : test::gallery(name).mechanism.leaves) all.push_back(leaf);
  for (const LeafSpring& leaf : all) {
    CAPTURE(leaf.name);
    const auto [volume, least] = volume_of(solid_mesh(leaf, {.along = 24}));
    CHECK(least > 0);
    CHECK(volume == Approx(test::leaf_volume(leaf)).epsilon(1e-3));
  }
}

TEST_CASE("The faces at both ends of a mesh are the leaf's edges") {
  const LeafSpring leaf = test::gallery("curved_leaf").mechanism.leaves.front();
  const SolidMesh mesh = solid_mesh(leaf, {.along = 4, .across = 3, .through = 2});
  for (int end = 0; end < 2; ++end) {
    const auto& edge = mesh.edges[static_cast<std::size_t>(end)];
    CHECK(edge.size() == (2 * 3 + 1) * (2 * 2 + 1) - 3 * 2);
    const Matrix3d axes = leaf.edge_axes(end);
    const Vector3d middle = end == 0 ? leaf.origin : leaf.tip_middle();
    for (const int node : edge) {
      const Vector3d way = axes.transpose() * (mesh.nodes[static_cast<std::size_t>(node)] - middle);
      CHECK(std::abs(way[0]) < 1e-12);
      CHECK(std::abs(way[1]) < 0.5 * leaf.width + 1e-12);
      CHECK(std::abs(way[2]) < 0.5 * leaf.thickness + 1e-12);
    }
  }
}
