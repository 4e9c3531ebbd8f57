// Elements of a plate, core/elements/README.md (E1), (E2), (E9), (E10), (E15), and of a beam,
// beams.md (B1).
#include "core/elements/plate/element_numbers.hpp"

#include <cmath>
#include <numbers>
#include <type_traits>

#include "core/elements/plate/beam_section.hpp"

namespace flexopt {
namespace {

using Matrix16 = PlateMesh::Matrix16;
template <class S>
using Row = Eigen::Matrix<S, 16, 1>;

// A sum of squares, or its derivative: A += w a aᵀ.
void add_square(Matrix16& A, double w, const Row<double>& a) {
  A.noalias() += (w * a) * a.transpose();
}
void add_square(Matrix16& A, const Dual1& w, const Row<Dual1>& a) {
  Row<double> value, half;
  for (int k = 0; k < 16; ++k) {
    value[k] = a[k].value;
    half[k] = w.value * a[k].derivatives[0] + 0.5 * w.derivatives[0] * a[k].value;
  }
  A.noalias() += half * value.transpose();
  A.noalias() += value * half.transpose();
}

// Adds the bending operator of a plate at a point, with the weight w. The sum of the curvatures
// comes first, so that rigid motions cancel to the last digits.
void add_bending(Matrix16& A, double w, double nu, const MappedDerivatives<Row<double>>& N) {
  const Row<double> laplace = N.xx + N.yy;
  A += w * ((1 - nu) *
                (N.xx * N.xx.transpose() + N.yy * N.yy.transpose() + 2 * N.xy * N.xy.transpose()) +
            nu * laplace * laplace.transpose());
}
void add_bending(Matrix16& A, const Dual1& w, const Dual1& nu,
                 const MappedDerivatives<Row<Dual1>>& N) {
  add_square(A, w * (1.0 - nu), N.xx);
  add_square(A, w * (1.0 - nu), N.yy);
  add_square(A, 2.0 * w * (1.0 - nu), N.xy);
  add_square(A, w * nu, Row<Dual1>(N.xx + N.yy));
}

template <class S>
void set_row(Matrix16& A, int row, const Row<S>& a) {
  for (int k = 0; k < 16; ++k) A(row, k) = part_of(a[k]);
}

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

}  // namespace

// The operators of plate_curvature.hpp, point by point.
template <class S>
class CurvatureRows {
 public:
  void add(const S& weight, const Row<S>& x, const Row<S>& y, const Row<S>& second) {
    points_.push_back({weight, x, y, second});
  }
  void give(PlateMesh::Element& element) const {
    const auto n = static_cast<Eigen::Index>(points_.size());
    element.curvature.resize(3 * n, 16);
    element.curvature_weight.resize(n);
    for (Eigen::Index g = 0; g < n; ++g) {
      const Point& point = points_[static_cast<std::size_t>(g)];
      element.curvature_weight[g] = part_of(point.weight);
      for (int k = 0; k < 16; ++k) {
        element.curvature(g, k) = part_of(point.x[k]);
        element.curvature(n + g, k) = part_of(point.y[k]);
        element.curvature(2 * n + g, k) = part_of(point.second[k]);
      }
    }
  }

 private:
  struct Point {
    S weight;
    Row<S> x, y, second;
  };
  std::vector<Point> points_;
};

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
  if (mesh_.folded() && i == mesh_.shape().mesh[0]) {
    PlateMesh::Element none;
    none.gradient.setZero();
    none.weight.setZero();
    none.bending.setZero();
    none.mass.setZero();
    none.metric.setOnes();
    if constexpr (!std::is_same_v<S, double>) none.metric.setZero();
    return none;
  }
  return mesh_.shape().is_beam() ? beam_element(i) : plate_element(i, j);
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
PlateMesh::Element ElementNumbers<S>::plate_element(int i, int j) const {
  const S& nu = mesh_.poissons_ratio;
  const S hx = mesh_.x[i + 1] - mesh_.x[i];
  const S hy = mesh_.y[j + 1] - mesh_.y[j];
  const Corner corner = mesh_.corner(i);
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);

  PlateMesh::Element element;
  element.bending.setZero();
  element.mass.setZero();
  CurvatureRows<S> natural;
  PlateShear<S> shear;
  if (has_shear()) {
    shear = plate_shear(i, j);
    add_shear(element, shear);
  }
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
  natural.give(element);
  return element;
}

template <class S>
BeamEnergyT<S> ElementNumbers<S>::section(const S& at) const {
  return beam_energy<S>(mesh_.shape().section, mesh_.width * mesh_.width_factor(at),
                        mesh_.thickness * mesh_.thickness_factor(at), mesh_.poissons_ratio,
                        mesh_.thickness, gauss_rule(4).point[2] - 0.5, mesh_.shape().has_profile());
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
    const BeamEnergyT<S> e = section(S(mesh_.x[i] + full.point[a] * h));
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
PlateMesh::Element ElementNumbers<S>::beam_element(int i) const {
  const S h = mesh_.x[i + 1] - mesh_.x[i];
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  const BeamEnergyT<S> uniform = section(S(0));
  const auto section_at = [&](const S& at) {
    return mesh_.shape().has_profile() ? section(at) : uniform;
  };
  PlateMesh::Element element;
  element.bending.setZero();
  element.mass.setZero();
  element.gradient.setZero();
  CurvatureRows<S> natural;
  PlateShear<S> shear;
  if (has_shear()) {
    shear = beam_shear(i);
    add_shear(element, shear);
  }
  std::array<S, 4> bend_of_slope, warp_of_slope;  // against slopes of e11, over the stretch
  for (int a = 0; a < 4; ++a) {
    const HermiteValuesT<S> X = hermite<S>(full.point[a], h);
    const auto e = section_at(S(mesh_.x[i] + full.point[a] * h));
    bend_of_slope[a] = e.bend / e.stretch;
    warp_of_slope[a] = e.warp / e.stretch;
    const S weight(full.weight[a] * h);
    const auto add = [&](Matrix16& A, const S& w, const std::array<S, 4>& of, double middle,
                         double across) {
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
  const auto membrane_place = [&](int a) { return S(mesh_.x[i] + membrane_x.point[a] * h); };
  const BeamEnergyT<S> first = section_at(membrane_place(0)), last = section_at(membrane_place(1));
  const auto area_relief = relief_of_slope<S>(h, bend_of_slope, {first.area, last.area}),
             second_relief = relief_of_slope<S>(h, warp_of_slope, {first.strong, last.strong});
  for (int a = 0; a < 2; ++a) {
    const HermiteValuesT<S> X = hermite<S>(membrane_x.point[a], h);
    const BeamEnergyT<S>& e = a == 0 ? first : last;
    const S metric = mesh_.rest(i, membrane_x.point[a]).metric;
    const Row r0_x = beam_functions(X.slope, 1, 0), d_x = beam_functions(X.slope, 0, 1),
              d = beam_functions(X.value, 0, 1);
    const S width = mesh_.width * mesh_.width_factor(membrane_place(a)),
            inner = width * (full.point[2] - 0.5), outer = width * (full.point[3] - 0.5),
            area = membrane_x.weight[a] * h * e.area, second = membrane_x.weight[a] * h * e.second;
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
  natural.give(element);
  return element;
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
  const PlateShear<Dual1> shear = elements.plate_shear(i, j);
  const Dual1 per = shear.compliance * shear.per_x * (along - 0.5) * (mesh.x[i + 1] - mesh.x[i]);
  for (int f = 0; f < 16; ++f)
    for (int c = 0; c < 3; ++c) turn[c] += per * (shear.along[f] - shear.rest[f]) * U(f, c);
  return turn;
}

template class ElementNumbers<double>;
template class ElementNumbers<Dual1>;

}  // namespace flexopt
