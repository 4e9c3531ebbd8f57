// The elements of a beam leaf: beams.md (1).
#include <cassert>
#include <cmath>

#include "core/elements/beam_section.hpp"
#include "core/elements/plate_mesh.hpp"

namespace flexopt {
namespace {

using Row16 = Eigen::Matrix<double, 16, 1>;

// Functions 4p + k of (r0, r0,x, d, d,x): X[2p + k % 2] times `middle` (k < 2) or `across`.
Row16 beam_functions(const std::array<double, 4>& X, double middle, double across) {
  Row16 row = Row16::Zero();
  for (int p = 0; p < 2; ++p)
    for (int k = 0; k < 4; ++k) row[4 * p + k] = X[2 * p + k % 2] * (k < 2 ? middle : across);
  return row;
}

}  // namespace

void PlateMesh::make_beam_elements() {
  const double w = shape_.width, t = shape_.thickness, nu = shape_.poissons_ratio;
  const bool circular = shape_.section == Section::circular;
  assert(!circular || std::abs(w - t) < 1e-12 * t);
  assert(nu > -1);
  const BeamSection s = beam_section(shape_.section, w, t, nu);
  const double A11 = 12 / (t * t);                       // E t over D/L²
  const double per_D = 12 / (t * t * t);                 // E over D/L³
  const double C_bend = per_D * s.I_weak;                // of |r0,xx|²
  const double C_twist = per_D * shear_ratio(nu) * s.J;  // of |d,x|²
  const double C_warp = per_D * s.C_w;                   // of |d,xx|²
  membrane_ = {A11, 0, s.shear * shear_ratio(nu) * A11};
  bending_stiffness_ = C_bend;
  y_ = {0};

  // A wire is free of shear in both planes and of restrained warping at its ends.
  if (circular)
    edge_slopes_ = {{1, 0}, {3, 0}, {3, 2}};
  else if (shape_.warping == Warping::free)
    edge_slopes_ = {{1, 0}, {1, 1}, {3, 0}, {3, 1}, {3, 2}};
  else
    edge_slopes_ = {{1, 0}, {1, 1}, {3, 0}, {3, 1}};

  // Weights across: the area exactly, and of the strong bending stiffness what |r0,xx|² and
  // |d,x|² do not give already.
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  const double zeroth = s.area / t, second = (per_D * s.I_strong - C_bend - C_twist) / A11;
  const double y_out = w * (full.point[3] - 0.5), y_in = w * (full.point[2] - 0.5);
  const double outer = 0.5 * (second - zeroth * y_in * y_in) / (y_out * y_out - y_in * y_in);
  const double inner = 0.5 * zeroth - outer;
  const std::array<double, 4> across{outer, inner, inner, outer};
  const double rotary = (s.I_weak + s.I_strong) / t;  // the spin about x exactly

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
          weight * (C_bend * r0_xx * r0_xx.transpose() + C_twist * d_x * d_x.transpose() +
                    C_warp * d_xx * d_xx.transpose());
      element.mass += weight * (zeroth * r0 * r0.transpose() + rotary * d * d.transpose());
    }
    for (int a = 0; a < 2; ++a) {
      const HermiteValues X = hermite(membrane_x.point[a], h);
      for (int b = 0; b < 4; ++b) {
        const double y = w * (full.point[b] - 0.5);
        const int g = 4 * a + b;
        element.gradient.row(g) = beam_functions(X.slope, 1, y).transpose();
        element.gradient.row(points + g) = beam_functions(X.value, 0, 1).transpose();
        element.weight[g] = membrane_x.weight[a] * across[b] * h;
      }
    }
  }
}

}  // namespace flexopt
