// Narrow leaves: the section's stiffness in the plane, (E9) of core/elements/README.md, and the
// mesh lines near the clamps, (E13).
#include <Eigen/Cholesky>

#include "core/elements/plate/plate_mesh.hpp"
#include "support/gradient_checks.hpp"

using namespace flexopt;

namespace {

/// Stiffness of a leaf bent uniformly in its plane over E t w³/12, its sections free to change:
/// u = −x y, v = x²/2 + V(y) with V of the least energy. From one element after the other across.
double section_in_plane(const PlateShape& shape) {
  const PlateMesh mesh(shape);
  const int i = mesh.elements_along() / 2, ny = mesh.elements_across(), unknowns = 2 * ny + 2;
  MatrixXd K = MatrixXd::Zero(unknowns + 1, unknowns + 1);  // of V, V' and of the bending
  for (int j = 0; j < ny; ++j) {
    const PlateMesh::Element& e = mesh.element(i, j);
    MatrixXd u = MatrixXd::Zero(16, unknowns + 1), v = u;
    for (int p = 0; p < 2; ++p)
      for (int q = 0; q < 2; ++q) {
        const double x = mesh.x()[i + p], y = mesh.y()[j + q];
        const int first = 8 * p + 4 * q;
        u.col(unknowns).segment<4>(first) << -x * y, -y, -x, -1;
        v.col(unknowns).segment<4>(first) << 0.5 * x * x, x, 0, 0;
        v(first, 2 * (j + q)) = v(first + 2, 2 * (j + q) + 1) = 1;
      }
    constexpr int n = PlateMesh::points;
    const MatrixXd ux = e.gradient.topRows<n>() * u, uy = e.gradient.bottomRows<n>() * u,
                   vx = e.gradient.topRows<n>() * v, vy = e.gradient.bottomRows<n>() * v,
                   shear = uy + vx;
    const VectorXd stretch = e.weight.col(0), shearing = e.weight.col(2);
    const auto w = stretch.asDiagonal();
    const PlateMesh::Membrane& A = mesh.membrane();
    K += A.A11 * (ux.transpose() * w * ux + vy.transpose() * w * vy) +
         A.A12 * (ux.transpose() * w * vy + vy.transpose() * w * ux) +
         A.A33 * (shear.transpose() * shearing.asDiagonal() * shear) +
         u.transpose() * e.bending * u + v.transpose() * e.bending * v;
  }
  const int free = unknowns - 1;  // V at one edge is a rigid motion
  const VectorXd b = K.col(unknowns).segment(1, free);
  const double h = mesh.x()[i + 1] - mesh.x()[i],
               left =
                   K(unknowns, unknowns) - b.dot(K.block(1, 1, free, free).ldlt().solve(b).eval()),
               nu = shape.poissons_ratio;
  return left / (h * (1 - nu * nu) * std::pow(shape.width, 3) / std::pow(shape.thickness, 2));
}

StrokeResponse guided(double width, std::array<int, 2> mesh) {
  return test::evaluated(models::guide(0.1, width, 1e-3),
                         {.accuracy = Accuracy::full, .mesh = mesh},
                         {.points = {1e-4, 0.01}, .outputs = test::without_stress()});
}

}  // namespace

TEST_CASE("the section of a narrow plate bends in its plane by E t w³/12 on any mesh") {
  for (const double nu : {0.0, 0.3, 0.45})
    for (const double ratio : {3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 60.0})
      for (const int across : {4, 5, 8, 14}) {
        PlateShape shape{.width = 0.05};
        shape.thickness = shape.width / ratio;
        shape.poissons_ratio = nu;
        shape.mesh = {6, across};
        CAPTURE(nu, ratio, across);
        // (E9) is a series: its next term is of the order (t/w)⁵
        CHECK(section_in_plane(shape) == Approx(1).epsilon(ratio < 4 ? 1.2e-3 : 2e-4));
      }
}

TEST_CASE("without the free edges' layer the section is right as well") {
  CHECK(section_in_plane({.width = 0.05, .thickness = 0.01, .free_edge_torsion = false}) ==
        Approx(1).epsilon(2e-4));
}

TEST_CASE("the default mesh has narrow leaves within 0.2 % of a fine one", "[slow]") {
  for (const double width : {0.004, 0.005, 0.007, 0.01, 0.014}) {
    const StrokeResponse coarse = guided(width, default_mesh), fine = guided(width, {44, 10});
    for (std::size_t k = 0; k < coarse.path.size(); ++k) {
      const PathPoint &a = coarse.path[k], &b = fine.path[k];
      CAPTURE(width, a.stroke);
      CHECK(a.drive_load == Approx(b.drive_load).epsilon(1.5e-3));
      CHECK(test::support_error(a, b) < 1.8e-3);
    }
  }
}

TEST_CASE("mesh lines near the clamps move smoothly with the width, those of wide leaves hardly") {
  const auto first = [](double width) {
    PlateShape shape{.width = width};
    return PlateMesh(shape).x()[1];
  };
  double last = first(0.01);
  for (double w = 0.012; w < 0.6; w *= 1.1) {
    CAPTURE(w);
    const double here = first(w);
    CHECK(here > last);
    CHECK(here < 1.2 * last);
    last = here;
  }
  CHECK(first(0.3) == Approx(first(3)).epsilon(1e-5));
}

TEST_CASE("a narrow plate bent in its plane is stressed by M w/2I, the clamps' layer or not") {
  // (E18); gradients of the strain along free edges leave von Mises stresses 1 to 2 % too low
  const double L = 0.05, t = 5e-4;
  for (const double ratio : {2.0, 3.0, 5.0}) {
    const double w = ratio * t;
    for (const std::array<int, 2>& mesh : {default_mesh, std::array{48, 6}}) {
      CAPTURE(ratio, mesh[0]);
      const auto point = [&](Accuracy accuracy) {
        return test::evaluated(models::single_leaf(L, w, t, Direction::ry),
                               {.accuracy = accuracy, .mesh = mesh}, {.points = {2e-3}})
            .path[0];
      };
      const PathPoint full = point(Accuracy::full);
      CHECK(full.max_stress->value ==
            Approx(std::abs(full.drive_load) * 6 / (t * w * w)).epsilon(0.02));
      if (mesh == default_mesh)
        CHECK(point(Accuracy::reduced).max_stress->value ==
              Approx(full.max_stress->value).epsilon(1e-3));
    }
  }
}

TEST_CASE("gradients of narrow leaves, whose mesh lines move, agree with differences", "[slow]") {
  const auto [ratio, flexure] =
      GENERATE(std::pair{10.0, Flexure::plate}, std::pair{3.0, Flexure::plate},
               std::pair{2.0, Flexure::beam});
  const auto make = [](const test::Values& p) {
    Mechanism m;
    m.drives = {make_drive(Direction::uy)};
    m.bodies = {models::body({p[0], 0.001, 0.002}, 0.4, 3e-4)};
    for (const double y : {0.03, -0.03})
      m.leaves.push_back(models::leaf({0, y, 0}, {1, 0.02, 0}, p[0], p[1], p[2]));
    return m;
  };
  test::check_loaded_guide(
      {make, {{"length", 0.1}, {"width", 0.6e-3 * ratio}, {"thickness", 0.6e-3}}, {0, 1, 2}, ratio},
      flexure, Accuracy::full, 0.012);
}
