// Elements of a beam: beams.md (B1), (B2).
#include "core/elements/plate/beam_section.hpp"
#include "core/elements/plate/element_numbers.hpp"
#include "core/elements/plate/element_rows.hpp"

namespace flexopt {
namespace {

// (B2) of beams.md: what both membrane points of an element of the length h add to the stiffness
// against a strain. `of_slope`: stiffness against its slope at the four points of the bending;
// `section`: against the strain at the two points.
template <class S>
std::array<S, 2> relief_of_slope(const S& h, const std::array<S, 4>& of_slope,
                                 const std::array<S, 2>& section) {
  const GaussRule full = gauss_rule(4);
  S whole(0), first(0), second(0);
  for (int a = 0; a < 4; ++a) {
    const S w = full.weight[a] * of_slope[a];
    const double x = full.point[a] - 0.5;
    whole += w;
    first += x * w;
    second += x * x * w;
  }
  if (value_of(second) == 0) return {S(0), S(0)};
  // the least that a slope costs, whatever its own slope; the points are h/√3 apart
  const S least = 3.0 / h * (whole - first * first / second);
  return {least * (section[0] / section[1] - 1.0), least * (section[1] / section[0] - 1.0)};
}

// `section`: at the membrane points. The last two: stiffness against a slope of e11 at the points
// of the bending, over that against the stretch.
template <class S>
void set_membrane(PlateMesh::Element& element, const MeshNumbers<S>& mesh, int i,
                  const std::array<BeamEnergyT<S>, 2>& section,
                  const std::array<S, 4>& bend_of_slope, const std::array<S, 4>& warp_of_slope) {
  const S h = mesh.x[i + 1] - mesh.x[i];
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  const auto area_relief = relief_of_slope<S>(h, bend_of_slope, {section[0].area, section[1].area}),
             second_relief =
                 relief_of_slope<S>(h, warp_of_slope, {section[0].strong, section[1].strong});
  for (int a = 0; a < 2; ++a) {
    const HermiteValuesT<S> X = hermite<S>(membrane_x.point[a], h);
    const S metric = mesh.rest(i, membrane_x.point[a]).metric;
    const ElementRow<S> r0_x = beam_functions(X.slope, 1, 0), d_x = beam_functions(X.slope, 0, 1),
                        d = beam_functions(X.value, 0, 1);
    const S width = mesh.width * mesh.width_factor(S(mesh.x[i] + membrane_x.point[a] * h)),
            inner = width * (full.point[2] - 0.5), outer = width * (full.point[3] - 0.5),
            area = membrane_x.weight[a] * h * section[a].area,
            second = membrane_x.weight[a] * h * section[a].second;
    const auto across = weights_across<S>(area, second, inner, outer),
               along = weights_across<S>(area + area_relief[a], second + second_relief[a], inner,
                                         outer);
    for (int b = 0; b < 4; ++b) {
      const S y = width * (full.point[b] - 0.5);
      const int g = 4 * a + b;
      set_row<S>(element.gradient, g, r0_x + y * d_x);
      set_row<S>(element.gradient, PlateMesh::points + g, d);
      element.weight.row(g) << part_of(along[b]), part_of(across[b]), part_of(across[b]);
      element.metric[g] = part_of(metric);
    }
  }
}

}  // namespace

template <class S>
BeamEnergyT<S> beam_energy_at(const MeshNumbers<S>& mesh, const S& at) {
  return beam_energy<S>(mesh.shape().section, mesh.width * mesh.width_factor(at),
                        mesh.thickness * mesh.thickness_factor(at), mesh.poissons_ratio,
                        mesh.thickness, gauss_rule(4).point[2] - 0.5, mesh.shape().has_profile());
}

template <class S>
PlateShear<S> ElementNumbers<S>::beam_shear(int i) const {
  const S h = mesh_.x[i + 1] - mesh_.x[i];
  const GaussRule full = gauss_rule(4);
  std::array<S, 4> bent;
  S stiffness(0), compliance(0);
  PlateShear<S> shear;
  shear.along.setZero();
  shear.rest.setZero();
  for (int a = 0; a < 4; ++a) {
    const HermiteValuesT<S> X = hermite<S>(full.point[a], h);
    const BeamEnergyT<S> e = beam_energy_at<S>(mesh_, mesh_.x[i] + full.point[a] * h);
    bent[a] = full.weight[a] * (full.point[a] - 0.5) * h * h * e.bend;
    Row bend = beam_functions(X.curvature, 1, 0);
    if (mesh_.curved()) bend -= mesh_.rest(i, full.point[a]).along * beam_functions(X.slope, 1, 0);
    shear.along += bent[a] * bend;
    stiffness += 12.0 * full.weight[a] * e.bend * (full.point[a] - 0.5) * (full.point[a] - 0.5);
    compliance += full.weight[a] / (e.shear * e.area);
  }
  shear.per_x = 12.0 / (h * h * h);
  shear.compliance = h * compliance / (1.0 + compliance * stiffness * h * shear.per_x);
  shear.along = (shear.per_x * shear.along).eval();
  if (mesh_.curved()) {
    const HermiteValuesT<S> X = hermite<S>(0.5, h);
    const Row tangent = beam_functions(X.slope, 1, 0);
    const Row bend = beam_functions(X.curvature, 1, 0) - mesh_.rest(i, 0.5).along * tangent;
    shear.rest = shear.per_x * slope_of_natural(i, bent, tangent, bend);
  }
  return shear;
}

template <class S>
void ElementNumbers<S>::add_beam(PlateMesh::Element& element, CurvatureRows<S>& natural,
                                 const PlateShear<S>& shear, int i) const {
  const S h = mesh_.x[i + 1] - mesh_.x[i];
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  const BeamEnergyT<S> uniform = beam_energy_at<S>(mesh_, S(0));
  const auto section = [&](double along) {
    return mesh_.shape().has_profile() ? beam_energy_at<S>(mesh_, mesh_.x[i] + along * h) : uniform;
  };
  std::array<S, 4> bend_of_slope, warp_of_slope;  // against slopes of e11, over the stretch
  for (int a = 0; a < 4; ++a) {
    const HermiteValuesT<S> X = hermite<S>(full.point[a], h);
    const auto e = section(full.point[a]);
    bend_of_slope[a] = e.bend / e.stretch;
    warp_of_slope[a] = e.warp / e.stretch;
    const S weight(full.weight[a] * h);
    const auto add = [&](PlateMesh::Matrix16& A, const S& w, const std::array<S, 4>& of,
                         double middle, double across) {
      add_square(A, weight * w, beam_functions(of, middle, across));
    };
    Row bend = beam_functions(X.curvature, 1, 0);
    if (mesh_.curved()) {
      const Rest rest = mesh_.rest(i, full.point[a]);
      const S w = weight * e.bend;
      const Row r0_x = beam_functions(X.slope, 1, 0), d = beam_functions(X.value, 0, 1);
      bend -= rest.along * r0_x;
      add_natural(element, w, rest, r0_x, d);
      natural.add(S(-w * rest.normal), r0_x, d, against(bend, shear, S((full.point[a] - 0.5) * h)));
    }
    add_square(element.bending, weight * e.bend, bend);
    add(element.bending, e.twist, X.slope, 0, 1);
    add(element.bending, e.warp, X.curvature, 0, 1);
    add(element.mass, e.area, X.value, 1, 0);
    add(element.mass, e.rotary, X.value, 0, 1);
  }
  set_membrane<S>(element, mesh_, i, {section(membrane_x.point[0]), section(membrane_x.point[1])},
                  bend_of_slope, warp_of_slope);
}

#define INSTANTIATE(S)                                                              \
  template BeamEnergyT<S> beam_energy_at(const MeshNumbers<S>&, const S&);          \
  template PlateShear<S> ElementNumbers<S>::beam_shear(int) const;                  \
  template void ElementNumbers<S>::add_beam(PlateMesh::Element&, CurvatureRows<S>&, \
                                            const PlateShear<S>&, int) const;
INSTANTIATE(double)
INSTANTIATE(Dual1)
#undef INSTANTIATE

}  // namespace flexopt
