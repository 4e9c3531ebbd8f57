// Elements of a plate: core/elements/README.md (E1), (E2), (E9), (E10), (E15).
#include "core/elements/plate/element_numbers.hpp"

#include <cmath>
#include <numbers>

#include "core/elements/plate/element_rows.hpp"

namespace flexopt {
namespace {

// Adds the bending operator of a plate at a point, with the weight w. The sum of the curvatures
// comes first, so that rigid motions cancel to the last digits.
void add_bending(PlateMesh::Matrix16& A, double w, double nu,
                 const MappedDerivatives<ElementRow<double>>& N) {
  const ElementRow<double> laplace = N.xx + N.yy;
  A += w * ((1 - nu) *
                (N.xx * N.xx.transpose() + N.yy * N.yy.transpose() + 2 * N.xy * N.xy.transpose()) +
            nu * laplace * laplace.transpose());
}
void add_bending(PlateMesh::Matrix16& A, const Dual1& w, const Dual1& nu,
                 const MappedDerivatives<ElementRow<Dual1>>& N) {
  add_square(A, w * (1.0 - nu), N.xx);
  add_square(A, w * (1.0 - nu), N.yy);
  add_square(A, 2.0 * w * (1.0 - nu), N.xy);
  add_square(A, w * nu, ElementRow<Dual1>(N.xx + N.yy));
}

}  // namespace

// |n|² = |r,x|² + g |r,y|² − g to first order of the metric about that at rest, diag(g, 1).
template <class S>
void ElementNumbers<S>::add_natural(PlateMesh::Element& element, const S& w, const Rest& rest,
                                    const Row& Nx, const Row& Ny) const {
  const S weight = w * rest.normal * rest.normal;
  add_square(element.bending, weight, Nx);
  add_square(element.bending, S(weight * rest.metric), Ny);
  element.rest_energy -= part_of(S(0.5 * weight * rest.metric));
}

template <class S>
S ElementNumbers<S>::excess_of_bending_in_plane(const S& at_thickness,
                                                const S& width_factor) const {
  if (mesh_.shape().linear) return S(0);
  S ratio = at_thickness / (mesh_.width * width_factor);
  if (ratio > 0.5) ratio = S(0.5);
  const S &nu = mesh_.poissons_ratio, plane = 1.0 / (1.0 - nu * nu);
  const double edge = mesh_.shape().free_edge_torsion ? free_edge_coefficient : 0;
  const S bending = (3.0 - 2.0 * nu + 3.0 * nu * nu) / 12.0 * plane,
          held = ratio * ratio * (bending - edge / (1.0 + nu) * ratio);
  // what the section gives way by in layers along its edges
  const S layers = nu * nu * plane / (3 * std::numbers::sqrt3) * (1.0 + 15.0 * held);
  return held - ratio * ratio * ratio * layers;
}

template <class S>
S ElementNumbers<S>::excess_of_shear_in_plane(const S& at_thickness, const S& width_factor) const {
  if (mesh_.shape().linear) return S(0);
  const S& nu = mesh_.poissons_ratio;
  const S ratio = at_thickness / (mesh_.width * width_factor);
  return ratio * ratio / (1.65 + 9.3 * nu * nu + 20.8 * ratio);
}

template <class S>
S ElementNumbers<S>::softer_at_clamps(int i, const S& at_thickness, const S& width_factor) const {
  const PlateShape& shape = mesh_.shape();
  const bool base = i == 0, tip = i + 2 == static_cast<int>(mesh_.x.size());
  // a folded leaf's solids are met without it: in their frequencies as well
  if (shape.linear || mesh_.folded() || !(base || tip)) return S(1);
  const S& nu = mesh_.poissons_ratio;
  const S longer = 0.28 * nu * nu * at_thickness / (1.0 + 0.5 * mesh_.width * width_factor);
  const S own = mesh_.x[i + 1] - mesh_.x[i];
  return own / (own + longer);
}

template <class S>
PlateMesh::Element ElementNumbers<S>::element(int i, int j) const {
  PlateMesh::Element element;
  element.gradient.setZero();
  element.weight.setZero();
  element.bending.setZero();
  element.mass.setZero();
  element.metric.setConstant(part_of(S(1)));
  if (mesh_.folded() && i == mesh_.shape().mesh[0]) return element;
  const bool beam = mesh_.shape().is_beam();
  CurvatureRows<S> natural;
  PlateShear<S> shear;
  if (has_shear()) {
    shear = beam ? beam_shear(i) : plate_shear(i, j);
    add_shear(element, shear);
  }
  if (beam) {
    add_beam(element, natural, shear, i);
  } else {
    add_plate_bending(element, natural, shear, i, j);
    set_plate_membrane(element, i, j);
  }
  natural.give(element);
  return element;
}

// Derivatives of the plate's functions at a place in element (i, j); `place`: y0.
template <class S>
auto ElementNumbers<S>::derivatives(int i, double along, const S& place, const HermiteValuesT<S>& X,
                                    const HermiteValuesT<S>& Y) const -> Derivatives {
  Derivatives N;
  N.xx = hermite_products(X.curvature, Y.value);
  N.yy = hermite_products(X.value, Y.curvature);
  N.xy = hermite_products(X.slope, Y.slope);
  if (!mesh_.width_varies() && !mesh_.curved()) return N;
  N.x = hermite_products(X.slope, Y.value);
  N.y = hermite_products(X.value, Y.slope);
  if (mesh_.width_varies())
    N = mapped<S, Row>(mesh_.map(i, along), place, N.x, N.y, N.xx, N.xy, N.yy);
  if (mesh_.curved()) N.xx -= mesh_.rest(i, along).along * N.x;
  return N;
}

template <class S>
auto ElementNumbers<S>::corner_bend(const Corner& corner, int j, double across, const S& hx,
                                    const S& hy) const -> Row {
  const auto N = derivatives(0, 0, S(mesh_.y[j] + across * hy), hermite<S, S>(corner.place, hx),
                             hermite<S>(across, hy));
  return N.xx + mesh_.poissons_ratio * N.yy;
}

// Slope along the undeflected leaf of the natural curvature field, with the normal n = (−t_z, t_x).
// In the middle of the element b n is r,xx − Γ r,x.
template <class S>
auto ElementNumbers<S>::slope_of_natural(int i, const std::array<S, 4>& weight, const Row& along,
                                         const Row& bend) const -> Row {
  const GaussRule full = gauss_rule(4);
  const Rest middle = mesh_.rest(i, 0.5);
  const auto [x, z] = mesh_.rest_tangent(i, 0.5);
  S along_t(0), along_n(0);
  for (int a = 0; a < 4; ++a) {
    const auto [tx, tz] = mesh_.rest_tangent(i, full.point[a]);
    const S w = weight[a] * mesh_.rest(i, full.point[a]).normal / middle.metric;
    along_t += w * (tx * z - tz * x);
    along_n += w * (tx * x + tz * z);
  }
  Row slope = along_t * along;
  if (value_of(middle.normal) != 0) slope += (along_n / middle.normal) * bend;
  return slope;
}

template <class S>
PlateShear<S> ElementNumbers<S>::plate_shear(int i, int j) const {
  const S &nu = mesh_.poissons_ratio, hx = mesh_.x[i + 1] - mesh_.x[i],
          hy = mesh_.y[j + 1] - mesh_.y[j];
  const GaussRule full = gauss_rule(4);
  Row bend = Row::Zero();                         // moments of M_xx about the middle
  S area(0), volume(0), moment(0), stiffness(0);  // moment: I_x, stiffness: J_x
  std::array<S, 4> bent{};
  for (int a = 0; a < 4; ++a) {
    const HermiteValuesT<S> X = hermite<S>(full.point[a], hx);
    const WidthMap<S> map = mesh_.map(i, full.point[a]);
    const S t = mesh_.thickness_factor(S(mesh_.x[i] + full.point[a] * hx)),
            dx = (full.point[a] - 0.5) * hx;
    for (int b = 0; b < 4; ++b) {
      const HermiteValuesT<S> Y = hermite<S>(full.point[b], hy);
      const auto N = derivatives(i, full.point[a], S(mesh_.y[j] + full.point[b] * hy), X, Y);
      const S dA = full.weight[a] * full.weight[b] * hx * hy * map.factor, w = dA * t * t * t * dx;
      bend += w * Row(N.xx + nu * N.yy);
      bent[a] += w;
      area += dA;
      volume += dA * t;
      moment += dA * dx * dx;
      stiffness += w * dx;
    }
  }
  if (const Corner corner = mesh_.corner(i); value_of(corner.stiffness) != 0) {
    const S dx = (corner.place - 0.5) * hx;
    for (int b = 0; b < 4; ++b)
      bend += S(full.weight[b] * hy * corner.stiffness * dx) *
              corner_bend(corner, j, full.point[b], hx, hy);
    stiffness += hy * corner.stiffness * dx * dx;
  }
  // A D / κ G t L² at the thickness 1
  const S compliance =
      area * area / volume * (mesh_.thickness * mesh_.thickness / (5.0 * (1.0 - nu)));
  PlateShear<S> shear;
  shear.per_x = 1.0 / moment;
  shear.compliance = compliance / (1.0 + compliance * stiffness * shear.per_x * shear.per_x);
  shear.along = shear.per_x * bend;
  shear.rest.setZero();
  if (mesh_.curved()) {
    const auto N =
        derivatives(i, 0.5, S(mesh_.y[j] + 0.5 * hy), hermite<S>(0.5, hx), hermite<S>(0.5, hy));
    shear.rest = shear.per_x * slope_of_natural(i, bent, N.x, N.xx);
  }
  return shear;
}

// Takes from the bending what the transverse shear gives back, and adds the slope of the natural
// curvature to the rows that stand against n.
template <class S>
void ElementNumbers<S>::add_shear(PlateMesh::Element& element, const PlateShear<S>& shear) const {
  add_square(element.bending, S(-shear.compliance), shear.along);
  if (mesh_.curved()) add_square(element.bending, shear.compliance, shear.rest);
  for (int k = 0; k < 16; ++k) element.shear.force[k] = part_of(S(shear.along[k] - shear.rest[k]));
  element.shear.per_x = part_of(S(shear.compliance * shear.per_x));
}

template <class S>
auto ElementNumbers<S>::against(const Row& bend, const PlateShear<S>& shear,
                                const S& from_middle) const -> Row {
  if (!has_shear()) return bend;
  const S slope = shear.compliance * shear.per_x * from_middle;
  return bend - slope * Row(shear.along - shear.rest);
}

// Equation (E2) over D, on the part of the layers of both free edges that lies in the element.
template <class S>
void ElementNumbers<S>::add_free_edges(PlateMesh::Element& element, CurvatureRows<S>& natural,
                                       int i, int j) const {
  const int ny = mesh_.shape().mesh[1];
  if (!mesh_.shape().free_edge_torsion) return;
  const S hx = mesh_.x[i + 1] - mesh_.x[i], hy = mesh_.y[j + 1] - mesh_.y[j];
  const S edge = 6.0 * free_edge_coefficient * (1.0 - mesh_.poissons_ratio) * mesh_.thickness;
  const GaussRule full = gauss_rule(4);
  const S twisted = mesh_.corner(i).twist;
  for (int a = 0; a < 4; ++a) {
    const HermiteValuesT<S> X = hermite<S>(full.point[a], hx);
    const WidthMap<S> map = mesh_.map(i, full.point[a]);
    const S t = mesh_.thickness_factor(S(mesh_.x[i] + full.point[a] * hx));
    S layer = free_edge_layer * mesh_.thickness * t / map.factor;
    if (layer > 0.5 * mesh_.width) layer = 0.5 * mesh_.width;
    for (const double side : {-1.0, 1.0}) {
      // distances from the edge
      const S near = side < 0 ? S(mesh_.y[j] - mesh_.y[0]) : S(mesh_.y[ny] - mesh_.y[j + 1]);
      if (near >= layer) continue;
      const S depth = near + hy < layer ? hy : S(layer - near);
      for (int b = 0; b < 4; ++b) {
        const S from_edge = full.point[b] * depth / hy, at = side < 0 ? from_edge : 1.0 - from_edge;
        const S place = mesh_.y[j] + at * hy;
        const Derivatives N = derivatives(i, full.point[a], place, X, hermite<S>(at, hy));
        S w = -edge * (full.weight[a] * hx) * (t * t * t * t) * (full.weight[b] * depth / layer);
        if (mesh_.folded()) w *= twisted;
        Row twist = N.xy;
        S bent(0);                   // part of the bending along in it
        if (mesh_.width_varies()) {  // along the edge and normal to it: it slopes by m
          using std::sqrt;
          const S m = place * map.slope * map.factor, per = 1.0 / (1.0 + m * m);
          const S both = (1.0 - m * m) * per, one = m * per;
          twist = both * N.xy + one * (N.yy - N.xx);
          w *= sqrt(S(1.0 + m * m));
          bent = -one;
        }
        add_square(element.bending, w, twist);
        if (!mesh_.curved() || !mesh_.width_varies()) continue;
        const Rest rest = mesh_.rest(i, full.point[a]);
        add_natural(element, S(w * bent * bent), rest, N.x, N.y);
        natural.add(S(-w * bent * rest.normal), N.x, N.y, twist);
      }
    }
  }
}

template <class S>
void ElementNumbers<S>::add_plate_bending(PlateMesh::Element& element, CurvatureRows<S>& natural,
                                          const PlateShear<S>& shear, int i, int j) const {
  const S &nu = mesh_.poissons_ratio, hx = mesh_.x[i + 1] - mesh_.x[i],
          hy = mesh_.y[j + 1] - mesh_.y[j];
  const Corner corner = mesh_.corner(i);
  const GaussRule full = gauss_rule(4);
  for (int a = 0; a < 4; ++a) {
    const HermiteValuesT<S> X = hermite<S>(full.point[a], hx);
    const WidthMap<S> map = mesh_.map(i, full.point[a]);
    const Rest rest = mesh_.rest(i, full.point[a]);
    const S t = mesh_.thickness_factor(S(mesh_.x[i] + full.point[a] * hx)), cube = t * t * t;
    for (int b = 0; b < 4; ++b) {
      const HermiteValuesT<S> Y = hermite<S>(full.point[b], hy);
      const Derivatives N = derivatives(i, full.point[a], S(mesh_.y[j] + full.point[b] * hy), X, Y);
      const S area = full.weight[a] * full.weight[b] * hx * hy * map.factor, w = area * cube;
      add_bending(element.bending, w, nu, N);
      if (value_of(corner.twist) != 1)
        add_square(element.bending, S(2.0 * w * (1.0 - nu) * (corner.twist - 1.0)), N.xy);
      if (mesh_.curved()) {
        add_natural(element, w, rest, N.x, N.y);
        const Row bend = N.xx + nu * N.yy;
        natural.add(S(-w * rest.normal), N.x, N.y,
                    against(bend, shear, S((full.point[a] - 0.5) * hx)));
      }
      add_square(element.mass, area * t * corner.mass, hermite_products(X.value, Y.value));
    }
  }
  if (value_of(corner.stiffness) != 0)
    for (int b = 0; b < 4; ++b)
      add_square(element.bending, S(full.weight[b] * hy * corner.stiffness),
                 corner_bend(corner, j, full.point[b], hx, hy));
  add_free_edges(element, natural, i, j);
}

template <class S>
void ElementNumbers<S>::set_plate_membrane(PlateMesh::Element& element, int i, int j) const {
  const S hx = mesh_.x[i + 1] - mesh_.x[i], hy = mesh_.y[j + 1] - mesh_.y[j];
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  for (int a = 0; a < 2; ++a) {
    const HermiteValuesT<S> X = hermite<S>(membrane_x.point[a], hx);
    const WidthMap<S> map = mesh_.map(i, membrane_x.point[a]);
    const S t = mesh_.thickness_factor(S(mesh_.x[i] + membrane_x.point[a] * hx)),
            metric = mesh_.rest(i, membrane_x.point[a]).metric,
            excess = excess_of_bending_in_plane(S(mesh_.thickness * t), map.factor),
            shear_excess = excess_of_shear_in_plane(S(mesh_.thickness * t), map.factor),
            softer = softer_at_clamps(i, S(mesh_.thickness * t), map.factor);
    for (int b = 0; b < 4; ++b) {
      const HermiteValuesT<S> Y = hermite<S>(full.point[b], hy);
      const int g = 4 * a + b;
      Row Nx = hermite_products(X.slope, Y.value), Ny = hermite_products(X.value, Y.slope);
      if (mesh_.width_varies()) {
        const S slide = -(mesh_.y[j] + full.point[b] * hy) * map.slope, per = 1.0 / map.factor;
        Nx += slide * Ny;
        Ny = (per * Ny).eval();
      }
      set_row<S>(element.gradient, g, Nx);
      set_row<S>(element.gradient, PlateMesh::points + g, Ny);
      const S across = (mesh_.y[j] + full.point[b] * hy) / mesh_.width,
              parabola = 180.0 * (across * across - 1.0 / 12);
      const S area = softer * t * membrane_x.weight[a] * full.weight[b] * hx * hy * map.factor,
              stretch = area * (1.0 - excess * parabola),
              shearing = area * (1.0 + shear_excess * parabola);
      element.weight.row(g) << part_of(stretch), part_of(stretch), part_of(shearing);
      element.metric[g] = part_of(metric);
    }
  }
}

Vector3d section_turn(const PlateMesh& mesh, int i, int j, const Eigen::Matrix<double, 16, 3>& U,
                      double along) {
  const PlateMesh::Element::Shear& shear = mesh.element(i, j).shear;
  const double dx = (along - 0.5) * (mesh.x()[i + 1] - mesh.x()[i]);
  return shear.per_x * dx * (U.transpose() * shear.force);
}

Vector3<Dual1> section_turn(const MeshNumbers<Dual1>& mesh, int i, int j,
                            const Eigen::Matrix<Dual1, 16, 3>& U, double along) {
  const ElementNumbers<Dual1> elements(mesh);
  Vector3<Dual1> turn = Vector3<Dual1>::Zero();
  if (!elements.has_shear()) return turn;
  const PlateShear<Dual1> shear =
      mesh.shape().is_beam() ? elements.beam_shear(i) : elements.plate_shear(i, j);
  const Dual1 per = shear.compliance * shear.per_x * (along - 0.5) * (mesh.x[i + 1] - mesh.x[i]);
  for (int f = 0; f < 16; ++f)
    for (int c = 0; c < 3; ++c) turn[c] += per * (shear.along[f] - shear.rest[f]) * U(f, c);
  return turn;
}

template class ElementNumbers<double>;
template class ElementNumbers<Dual1>;

}  // namespace flexopt
