#include "core/elements/plate/plate_mesh_rate.hpp"

#include "core/elements/leaf/leaf_rates.hpp"
#include "core/elements/plate/beam_section.hpp"
#include "core/math/dual.hpp"

namespace flexopt {
namespace {

using Matrix16 = PlateMesh::Matrix16;
using Row16 = Eigen::Matrix<double, 16, 1>;

}  // namespace

PlateMeshRate::PlateMeshRate(const PlateMesh& mesh) {
  if (mesh.shape().is_beam())
    beam(mesh);
  else
    plate(mesh);
}

std::shared_ptr<const PlateMeshRate> shared_mesh_rate(
    LeafRates& rates, const std::shared_ptr<const PlateMesh>& mesh) {
  return rates.of<PlateMeshRate>(mesh, [&] { return PlateMeshRate(*mesh); });
}

// A function of order k across (value 0, slope 1) scales as w^k, a derivative ∂y as w⁻¹, dy as w.
void PlateMeshRate::plate(const PlateMesh& mesh) {
  const PlateShape& s = mesh.shape();
  const double w = s.width, t = s.thickness, nu = s.poissons_ratio;
  const double c_edge = s.free_edge_torsion ? 0.105 * 6 : 0.0;
  const auto order = [](int f) { return f % 4 / 2; };
  const GaussRule full = gauss_rule(4);
  const int nx = mesh.elements_along(), ny = mesh.elements_across();
  Shape &by_w = shape[width], &by_t = shape[thickness], &by_nu = shape[poissons_ratio];

  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const PlateMesh::Element& element = mesh.element(i, j);
      const double hx = mesh.x()[i + 1] - mesh.x()[i], hy = mesh.y()[j + 1] - mesh.y()[j];
      // energies ½ Uᵀ(…)U of r,xx², r,yy², 2 r,xy², 2 r,xx r,yy and of r,xy² along the free edges
      Matrix16 xx = Matrix16::Zero(), yy = xx, xy = xx, cross = xx, edge = xx;
      for (int a = 0; a < 4; ++a) {
        const HermiteValues X = hermite(full.point[a], hx);
        for (int b = 0; b < 4; ++b) {
          const HermiteValues Y = hermite(full.point[b], hy);
          const double weight = full.weight[a] * full.weight[b] * hx * hy;
          const Row16 Nxx = hermite_products(X.curvature, Y.value),
                      Nyy = hermite_products(X.value, Y.curvature),
                      Nxy = hermite_products(X.slope, Y.slope);
          xx += weight * Nxx * Nxx.transpose();
          yy += weight * Nyy * Nyy.transpose();
          xy += 2 * weight * Nxy * Nxy.transpose();
          cross += weight * (Nxx * Nyy.transpose() + Nyy * Nxx.transpose());
        }
        for (int side = 0; side < 2; ++side) {
          if (side == 0 ? j != 0 : j != ny - 1) continue;
          const Row16 Nxy = hermite_products(X.slope, hermite(side, hy).slope);
          edge += c_edge * full.weight[a] * hx * Nxy * Nxy.transpose();
        }
      }
      Matrix16 gradient, bending, mass;
      for (int f = 0; f < 16; ++f)
        for (int g = 0; g < 16; ++g) {
          const int k = order(f) + order(g);
          bending(f, g) = ((k + 1) * xx(f, g) + (k - 3) * yy(f, g) + (k - 1) * (1 - nu) * xy(f, g) +
                           (k - 1) * nu * cross(f, g) - (k - 2) * (1 - nu) * t * edge(f, g)) /
                          w;
          mass(f, g) = (k + 1) * element.mass(f, g) / w;
          const bool across = f >= PlateMesh::points;  // row f of the gradient is ∂y
          gradient(f, g) = (order(g) - (across ? 1 : 0)) * element.gradient(f, g) / w;
        }
      by_w.gradient.push_back(gradient);
      by_w.bending.push_back(bending);
      by_w.mass.push_back(mass);
      by_w.weight.push_back(element.weight / w);
      by_t.bending.push_back(-(1 - nu) * edge);
      by_nu.bending.push_back(cross - xy + t * edge);
    }
  const double A11 = mesh.membrane().A11;
  const PlateMesh::Membrane& A = mesh.membrane();
  by_t.membrane = {-2 / t * A.A11, -2 / t * A.A12, -2 / t * A.A33};
  by_nu.membrane = {0, A11, -0.5 * A11};
}

void PlateMeshRate::beam(const PlateMesh& mesh) {
  const PlateShape& s = mesh.shape();
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  std::array<double, 4> place;
  for (int b = 0; b < 4; ++b) place[b] = full.point[b] - 0.5;
  const auto e = beam_energy<Dual3>(s.section, Dual3::variable(s.width, width),
                                    Dual3::variable(s.thickness, thickness),
                                    Dual3::variable(s.poissons_ratio, poissons_ratio), place);
  for (int p = 0; p < 3; ++p) {
    const auto rate = [p](const Dual3& x) { return x.derivatives[p]; };
    Shape& by = shape[p];
    by.membrane = {rate(e.stretch), 0, rate(e.shear)};
    for (int i = 0; i < mesh.elements_along(); ++i) {
      const double h = mesh.x()[i + 1] - mesh.x()[i];
      Matrix16 gradient = Matrix16::Zero(), bending = gradient, mass = gradient;
      Eigen::Array<double, PlateMesh::points, 1> weight;
      for (int a = 0; a < 4; ++a) {
        const HermiteValues X = hermite(full.point[a], h);
        const Row16 r0 = beam_functions(X.value, 1, 0), d = beam_functions(X.value, 0, 1),
                    r0_xx = beam_functions(X.curvature, 1, 0), d_x = beam_functions(X.slope, 0, 1),
                    d_xx = beam_functions(X.curvature, 0, 1);
        const double w = full.weight[a] * h;
        bending +=
            w * (rate(e.bend) * r0_xx * r0_xx.transpose() + rate(e.twist) * d_x * d_x.transpose() +
                 rate(e.warp) * d_xx * d_xx.transpose());
        mass += w * (rate(e.area) * r0 * r0.transpose() + rate(e.rotary) * d * d.transpose());
      }
      for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 4; ++b) {
          const int g = 4 * a + b;
          if (p == width)
            gradient.row(g) =
                beam_functions(hermite(membrane_x.point[a], h).slope, 0, place[b]).transpose();
          weight[g] = membrane_x.weight[a] * rate(e.across[b]) * h;
        }
      if (p == width) by.gradient.push_back(gradient);
      by.bending.push_back(bending);
      by.mass.push_back(mass);
      by.weight.push_back(weight);
    }
  }
}

}  // namespace flexopt
