// The elements of a beam leaf: beams.md (B1).
#include <cassert>
#include <cmath>

#include "core/elements/plate/beam_section.hpp"
#include "core/elements/plate/plate_mesh.hpp"

namespace flexopt {

using Row16 = Eigen::Matrix<double, 16, 1>;

void PlateMesh::make_beam_elements() {
  const double w = shape_.width, t = shape_.thickness, nu = shape_.poissons_ratio;
  const bool circular = shape_.section == Section::circular;
  assert(!circular || std::abs(w - t) < 1e-12 * t);
  assert(nu > -1);
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  std::array<double, 4> place;
  for (int b = 0; b < 4; ++b) place[b] = full.point[b] - 0.5;
  const auto e = beam_energy<double>(shape_.section, w, t, nu, place);
  membrane_ = {e.stretch, 0, e.shear};
  bending_stiffness_ = e.bend;
  y_ = {0};

  // A wire is free of shear in both planes and of restrained warping at its ends.
  if (circular)
    edge_slopes_ = {{1, 0}, {3, 0}, {3, 2}};
  else if (shape_.warping == Warping::free)
    edge_slopes_ = {{1, 0}, {1, 1}, {3, 0}, {3, 1}, {3, 2}};
  else
    edge_slopes_ = {{1, 0}, {1, 1}, {3, 0}, {3, 1}};

  for (int i = 0; i < elements_along(); ++i) {
    Element& element = elements_[i];
    const double h = x_[i + 1] - x_[i];
    element.bending.setZero();
    element.mass.setZero();
    element.gradient.setZero();
    for (int a = 0; a < 4; ++a) {
      const HermiteValues X = hermite(full.point[a], h);
      const Row16 r0 = beam_functions(X.value, 1, 0), d = beam_functions(X.value, 0, 1),
                  r0_xx = beam_functions(X.curvature, 1, 0), d_x = beam_functions(X.slope, 0, 1),
                  d_xx = beam_functions(X.curvature, 0, 1);
      const double weight = full.weight[a] * h;
      element.bending +=
          weight * (e.bend * r0_xx * r0_xx.transpose() + e.twist * d_x * d_x.transpose() +
                    e.warp * d_xx * d_xx.transpose());
      element.mass += weight * (e.area * r0 * r0.transpose() + e.rotary * d * d.transpose());
    }
    for (int a = 0; a < 2; ++a) {
      const HermiteValues X = hermite(membrane_x.point[a], h);
      for (int b = 0; b < 4; ++b) {
        const double y = w * place[b];
        const int g = 4 * a + b;
        element.gradient.row(g) = beam_functions(X.slope, 1, y).transpose();
        element.gradient.row(points + g) = beam_functions(X.value, 0, 1).transpose();
        element.weight[g] = membrane_x.weight[a] * e.across[b] * h;
      }
    }
  }
}

}  // namespace flexopt
