// Elements of a plate, core/elements/README.md (E1), (E2), (P1)–(P4), and of a beam, beams.md (B1).
#include "core/elements/plate/mesh_numbers.hpp"

#include <cassert>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

#include "core/elements/plate/beam_section.hpp"
#include "core/mechanism/profile.hpp"

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

// Of a plate at a point. The sum comes first, so that rigid motions cancel to the last digits.
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

double part(double x) { return x; }
double part(const Dual1& x) { return x.derivatives[0]; }

template <class S>
void set_row(Matrix16& A, int row, const Row<S>& a) {
  for (int k = 0; k < 16; ++k) A(row, k) = part(a[k]);
}

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
      element.curvature_weight[g] = part(point.weight);
      for (int k = 0; k < 16; ++k) {
        element.curvature(g, k) = part(point.x[k]);
        element.curvature(n + g, k) = part(point.y[k]);
        element.curvature(2 * n + g, k) = part(point.second[k]);
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

template <class S>
S number(double value, double rate) {
  if constexpr (std::is_same_v<S, double>)
    return value;
  else
    return {value, {rate}};
}

template <class S>
LeafFoldT<S> fold_of(const PlateShape& shape, const ShapeRate& rate) {
  const LeafFold fold = shape.fold.value_or(LeafFold{});
  return {number<S>(fold.place, rate.fold.place), number<S>(fold.angle, rate.fold.angle)};
}

// At a place that may move.
template <class S>
S profile(const std::vector<double>& numbers, const std::vector<double>& rates, const S& place,
          int order) {
  if constexpr (std::is_same_v<S, double>) {
    return profile_at(numbers, place, order);
  } else {
    double rate = rates.empty() ? 0 : profile_at(rates, place.value, order);
    if (place.derivatives[0] != 0)
      rate += place.derivatives[0] * profile_at(numbers, place.value, order + 1);
    return {profile_at(numbers, place.value, order), {rate}};
  }
}

constexpr double grading = 0.5;

}  // namespace

template <class S>
const ShapeRate& MeshNumbers<S>::constant() {
  static const ShapeRate none;
  return none;
}

template <class S>
MeshNumbers<S>::MeshNumbers(const PlateShape& shape, const ShapeRate& rate)
    : width(number<S>(shape.width, rate.size[0])),
      thickness(number<S>(shape.thickness, rate.size[1])),
      poissons_ratio(number<S>(shape.poissons_ratio, rate.size[2])),
      curve(number<S>(shape.curve.value_or(0), rate.curve)),
      fold(fold_of<S>(shape, rate)),
      shape_(&shape),
      rate_(&rate) {
  x = lines_along();
  set_lines();
}

template <class S>
MeshNumbers<S>::MeshNumbers(const PlateShape& shape, const std::vector<S>& lines)
    : width(shape.width),
      thickness(shape.thickness),
      poissons_ratio(shape.poissons_ratio),
      curve(shape.curve.value_or(0)),
      fold(fold_of<S>(shape, constant())),
      x(lines),
      shape_(&shape),
      rate_(&constant()) {
  set_lines();
}

template <class S>
void MeshNumbers<S>::set_lines() {
  for (std::size_t i = 0; i < x.size(); ++i)
    if (curved())
      middle.push_back(arc_point<S>(curve, x[i]));
    else if (folded() && static_cast<int>(i) > shape_->mesh[0])
      middle.push_back(leg_point<S>(fold.place, fold.angle, x[i]));
    else
      middle.push_back({x[i], S(0), S(1), S(0)});
  line_width.resize(x.size());
  if (shape_->is_beam()) {
    y = {S(0)};
    return;
  }
  for (const double place : graded_points(-0.5, 0.5, shape_->mesh[1], 0.7))
    y.push_back(place * width);
  if (!width_varies()) return;
  for (std::size_t i = 0; i < x.size(); ++i)
    line_width[i] = {width_factor(x[i]), width_factor(x[i], 1)};
}

// Equal shares of ∫ ρ dξ, ξ the place on the graded mesh of a uniform leaf, ρ = t^(−3/4) as a short
// series of cosines, which stays positive when it is damped by Jackson's factors.
template <class S>
std::vector<S> MeshNumbers<S>::lines_along() const {
  using std::numbers::pi, std::pow;
  const int n = shape_->mesh[0];
  constexpr int terms = 12, samples = 256;
  const std::vector<double> graded = graded_points(0, 1, n, grading);
  std::vector<S> lines(graded.begin(), graded.end());
  if (folded()) {  // both legs alike
    lines.clear();
    for (const double place : graded) lines.push_back(place * fold.place);
    for (const double place : graded) lines.push_back(fold.place + place * (1.0 - fold.place));
    return lines;
  }
  if (shape_->thickness_profile.empty()) return lines;
  const auto place = [](const auto& xi) {
    using std::cos;
    return 0.5 * (1.0 + (1 - grading) * (2.0 * xi - 1.0) - grading * cos(pi * xi));
  };
  std::array<S, terms + 1> a{};
  for (int m = 0; m < samples; ++m) {
    const double xi = (m + 0.5) / samples;
    const S density = pow(thickness_factor(S(place(xi))), -0.75);
    for (int k = 0; k <= terms; ++k) a[k] += density * std::cos(k * pi * xi);
  }
  constexpr int N = terms + 1;
  bool uniform = true;
  for (int k = 1; k <= terms; ++k) {
    const double angle = k * pi / (N + 1);
    const double damping =
        ((N - k + 1) * std::cos(angle) + std::sin(angle) / std::tan(pi / (N + 1))) / (N + 1);
    a[k] = 2 * damping * a[k] / a[0];
    if (std::abs(value_of(a[k])) > 1e-12 || std::abs(part(a[k])) > 1e-12) uniform = false;
  }
  if (uniform) return lines;
  const auto share = [&](double xi) {
    S sum(xi);
    double rate = 1;
    for (int k = 1; k <= terms; ++k) {
      sum += a[k] * (std::sin(k * pi * xi) / (k * pi));
      rate += value_of(a[k]) * std::cos(k * pi * xi);
    }
    return std::pair{sum, rate};
  };
  for (int i = 1; i < n; ++i) {
    const double wanted = static_cast<double>(i) / n;
    double low = 0, high = 1;
    for (int k = 0; k < 20; ++k) {
      const double middle = 0.5 * (low + high);
      (value_of(share(middle).first) < wanted ? low : high) = middle;
    }
    S xi(0.5 * (low + high));
    for (int k = 0; k < 4; ++k) {  // the last step of Newton's method brings the derivative too
      const auto [sum, rate] = share(value_of(xi));
      xi = value_of(xi) - (sum - wanted) / rate;
    }
    lines[i] = place(xi);
  }
  return lines;
}

template <class S>
S MeshNumbers<S>::width_factor(const S& place, int order) const {
  if (!width_varies()) return S(order == 0 ? 1 : 0);
  return profile<S>(shape_->width_profile, rate_->width_profile, place, order);
}

template <class S>
S MeshNumbers<S>::thickness_factor(const S& place) const {
  if (shape_->thickness_profile.empty()) return S(1);
  return profile<S>(shape_->thickness_profile, rate_->thickness_profile, place, 0);
}

template <class S>
WidthMap<S> MeshNumbers<S>::map(int i, double s) const {
  if (!width_varies()) return {};
  const HermiteValuesT<S> X = hermite<S>(s, x[i + 1] - x[i]);
  const LineWidth &a = line_width[i], &b = line_width[i + 1];
  const auto sum = [&](const std::array<S, 4>& h) {
    return S(h[0] * a.factor + h[1] * a.slope + h[2] * b.factor + h[3] * b.slope);
  };
  const S f = sum(X.value);
  return {f, sum(X.slope) / f, sum(X.curvature) / f};
}

template <class S>
auto MeshNumbers<S>::rest(int i, double s) const -> Rest {
  if (!curved()) return {};
  const HermiteValuesT<S> X = hermite<S>(s, x[i + 1] - x[i]);
  const ArcPoint<S>&a = middle[i], &b = middle[i + 1];
  const auto derivative = [&](const std::array<S, 4>& h, const S& from, const S& slope, const S& to,
                              const S& next) -> S {
    return h[2] * (to - from) + h[1] * slope + h[3] * next;  // h[0] = −h[2]
  };
  const S tx = derivative(X.slope, a.x, a.cosine, b.x, b.cosine),
          tz = derivative(X.slope, a.z, a.sine, b.z, b.sine),
          kx = derivative(X.curvature, a.x, a.cosine, b.x, b.cosine),
          kz = derivative(X.curvature, a.z, a.sine, b.z, b.sine);
  Rest rest;
  rest.metric = tx * tx + tz * tz;
  rest.along = (tx * kx + tz * kz) / rest.metric;
  rest.normal = (tx * kz - tz * kx) / rest.metric;
  return rest;
}

template <class S>
S MeshNumbers<S>::rest_curvature(int i, double s) const {
  using std::sqrt;
  const Rest at = rest(i, s);
  return -at.normal * sqrt(at.metric);
}

template <class S>
std::array<Vector3<S>, 4> MeshNumbers<S>::reference_node(int line, int node) const {
  const LineWidth& w = line_width[line];
  const S zero(0), from_middle = y[node] * w.factor, slope = y[node] * w.slope;
  return {Vector3<S>(zero, from_middle, zero), Vector3<S>(S(1), slope, zero),
          Vector3<S>(zero, w.factor, zero), Vector3<S>(zero, w.slope, zero)};
}

template <class S>
std::array<Vector3<S>, 4> MeshNumbers<S>::undeflected_node(int line, int node) const {
  std::array<Vector3<S>, 4> nodal = reference_node(line, node);
  const ArcPoint<S>& at = middle[line];
  for (Vector3<S>& v : nodal) v = Vector3<S>(at.cosine * v[0], v[1], at.sine * v[0]);
  nodal[0] += Vector3<S>(at.x, S(0), at.z);
  return nodal;
}

// |n|² = |r,x|² + g |r,y|² − g to first order of the metric about that at rest, diag(g, 1).
template <class S>
void MeshNumbers<S>::add_natural(PlateMesh::Element& element, const S& w, const Rest& rest,
                                 const Row<S>& Nx, const Row<S>& Ny) const {
  const S weight = w * rest.normal * rest.normal;
  add_square(element.bending, weight, Nx);
  add_square(element.bending, S(weight * rest.metric), Ny);
  element.rest_energy -= part(S(0.5 * weight * rest.metric));
}

template <class S>
S MeshNumbers<S>::free_edge(const S& at_thickness, const S& width_factor,
                            const S& size_along) const {
  if (!shape_->free_edge_torsion) return S(0);
  S c(free_edge_coefficient);
  const S across = (y[1] - y[0]) * width_factor / (least_edge_element * at_thickness),
          along = size_along / at_thickness;
  if (across < 1.0) c *= across;
  if (along < 1.0) c *= along;
  return c;
}

template <class S>
S MeshNumbers<S>::excess_of_bending_in_plane(const S& at_thickness, const S& width_factor,
                                             const S& size_along) const {
  if (shape_->linear) return S(0);
  S ratio = at_thickness / (width * width_factor);
  if (ratio > 0.5) ratio = S(0.5);
  const S &nu = poissons_ratio, square = ratio * ratio;
  const S bending = (3.0 - 2.0 * nu + 3.0 * nu * nu) / (12.0 * (1.0 - nu * nu));
  return square *
         (bending - free_edge(at_thickness, width_factor, size_along) / (1.0 + nu) * ratio);
}

template <class S>
auto MeshNumbers<S>::membrane() const -> Membrane {
  const S stretch = 12.0 / (thickness * thickness);
  if (!shape_->is_beam())
    return {stretch, poissons_ratio * stretch, 0.5 * (1.0 - poissons_ratio) * stretch};
  const S shear = beam_section<S>(shape_->section, width, thickness, poissons_ratio).shear;
  return {stretch, S(0), shear * shear_ratio(poissons_ratio) * stretch};
}

template <class S>
S MeshNumbers<S>::bending_stiffness() const {
  const auto at = [&](double place) -> S {
    const S t = thickness_factor(S(place)), w = width * width_factor(S(place));
    if (!shape_->is_beam()) return w * t * t * t;
    return 12.0 / (thickness * thickness * thickness) *
           beam_section<S>(shape_->section, w, thickness * t, poissons_ratio).I_weak;
  };
  if (!shape_->has_profile()) return at(0);
  S compliance(0);
  constexpr int parts = 96;
  for (int k = 0; k < parts; ++k) compliance += 1.0 / parts / at((k + 0.5) / parts);
  return 1.0 / compliance;
}

template <class S>
PlateMesh::Element MeshNumbers<S>::element(int i, int j) const {
  if (folded() && i == shape_->mesh[0]) {
    PlateMesh::Element none;
    none.gradient.setZero();
    none.weight.setZero();
    none.bending.setZero();
    none.mass.setZero();
    none.metric.setOnes();
    if constexpr (!std::is_same_v<S, double>) none.metric.setZero();
    return none;
  }
  return shape_->is_beam() ? beam_element(i) : plate_element(i, j);
}

template <class S>
PlateMesh::Element MeshNumbers<S>::plate_element(int i, int j) const {
  const int ny = shape_->mesh[1];
  const S& nu = poissons_ratio;
  const S hx = x[i + 1] - x[i];
  const S hy = y[j + 1] - y[j];
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  // Equation (E2) over D.
  const S edge = 6.0 * (1.0 - nu) * thickness;

  PlateMesh::Element element;
  element.bending.setZero();
  element.mass.setZero();
  CurvatureRows<S> natural;
  for (int a = 0; a < 4; ++a) {
    const HermiteValuesT<S> X = hermite<S>(full.point[a], hx);
    const WidthMap<S> map = this->map(i, full.point[a]);
    const Rest rest = this->rest(i, full.point[a]);
    const S t = thickness_factor(S(x[i] + full.point[a] * hx)), cube = t * t * t;
    const auto second = [&](const S& place, const HermiteValuesT<S>& Y) {
      MappedDerivatives<Row<S>> N;
      N.xx = hermite_products(X.curvature, Y.value);
      N.yy = hermite_products(X.value, Y.curvature);
      N.xy = hermite_products(X.slope, Y.slope);
      if (!width_varies() && !curved()) return N;
      N.x = hermite_products(X.slope, Y.value);
      N.y = hermite_products(X.value, Y.slope);
      if (width_varies()) N = mapped<S, Row<S>>(map, place, N.x, N.y, N.xx, N.xy, N.yy);
      if (curved()) N.xx -= rest.along * N.x;
      return N;
    };
    for (int b = 0; b < 4; ++b) {
      const HermiteValuesT<S> Y = hermite<S>(full.point[b], hy);
      const auto N = second(y[j] + full.point[b] * hy, Y);
      const S area = full.weight[a] * full.weight[b] * hx * hy * map.factor, w = area * cube;
      add_bending(element.bending, w, nu, N);
      if (curved()) {
        add_natural(element, w, rest, N.x, N.y);
        natural.add(S(-w * rest.normal), N.x, N.y, Row<S>(N.xx + nu * N.yy));
      }
      add_square(element.mass, area * t, hermite_products(X.value, Y.value));
    }
    for (int side = 0; side < 2; ++side) {
      if (side == 0 ? j != 0 : j != ny - 1) continue;
      const S& place = y[j + side];
      const auto N = second(place, hermite<S>(side, hy));
      S w =
          -edge * free_edge(S(thickness * t), map.factor, hx) * (full.weight[a] * hx) * (cube * t);
      Row<S> twist = N.xy;
      S bent(0);             // part of the bending along in it
      if (width_varies()) {  // along the edge and normal to it: it slopes by m
        using std::sqrt;
        const S m = place * map.slope * map.factor, per = 1.0 / (1.0 + m * m);
        const S both = (1.0 - m * m) * per, one = m * per;
        twist = both * N.xy + one * (N.yy - N.xx);
        w *= sqrt(S(1.0 + m * m));
        bent = -one;
      }
      add_square(element.bending, w, twist);
      if (curved() && width_varies()) {
        add_natural(element, S(w * bent * bent), rest, N.x, N.y);
        natural.add(S(-w * bent * rest.normal), N.x, N.y, twist);
      }
    }
  }
  for (int a = 0; a < 2; ++a) {
    const HermiteValuesT<S> X = hermite<S>(membrane_x.point[a], hx);
    const WidthMap<S> map = this->map(i, membrane_x.point[a]);
    const S t = thickness_factor(S(x[i] + membrane_x.point[a] * hx)),
            metric = rest(i, membrane_x.point[a]).metric,
            excess = excess_of_bending_in_plane(S(thickness * t), map.factor, hx);
    for (int b = 0; b < 4; ++b) {
      const HermiteValuesT<S> Y = hermite<S>(full.point[b], hy);
      const int g = 4 * a + b;
      Row<S> Nx = hermite_products(X.slope, Y.value), Ny = hermite_products(X.value, Y.slope);
      if (width_varies()) {
        const S slide = -(y[j] + full.point[b] * hy) * map.slope, per = 1.0 / map.factor;
        Nx += slide * Ny;
        Ny = (per * Ny).eval();
      }
      set_row<S>(element.gradient, g, Nx);
      set_row<S>(element.gradient, PlateMesh::points + g, Ny);
      const S across = (y[j] + full.point[b] * hy) / width;
      const S share = 1.0 - 180.0 * excess * (across * across - 1.0 / 12);
      const S area = membrane_x.weight[a] * full.weight[b] * hx * hy * map.factor;
      element.weight[g] = part(S(area * t * share));
      element.metric[g] = part(metric);
    }
  }
  natural.give(element);
  return element;
}

template <class S>
PlateMesh::Element MeshNumbers<S>::beam_element(int i) const {
  const S h = x[i + 1] - x[i];
  const GaussRule full = gauss_rule(4), membrane_x = gauss_rule(2);
  std::array<double, 4> place;
  for (int b = 0; b < 4; ++b) place[b] = full.point[b] - 0.5;
  const auto section_at = [&](const S& at) {
    return beam_energy<S>(shape_->section, width * width_factor(at),
                          thickness * thickness_factor(at), poissons_ratio, thickness, place,
                          shape_->has_profile());
  };
  const BeamEnergyT<S> uniform = section_at(S(0));
  const auto section = [&](const S& at) {
    return shape_->has_profile() ? section_at(at) : uniform;
  };
  PlateMesh::Element element;
  element.bending.setZero();
  element.mass.setZero();
  element.gradient.setZero();
  CurvatureRows<S> natural;
  for (int a = 0; a < 4; ++a) {
    const HermiteValuesT<S> X = hermite<S>(full.point[a], h);
    const auto e = section(S(x[i] + full.point[a] * h));
    const S weight(full.weight[a] * h);
    const auto add = [&](Matrix16& A, const S& w, const std::array<S, 4>& of, double middle,
                         double across) {
      add_square(A, weight * w, beam_functions(of, middle, across));
    };
    Row<S> bend = beam_functions(X.curvature, 1, 0);
    if (curved()) {
      const Rest rest = this->rest(i, full.point[a]);
      const S w = weight * e.bend;
      const Row<S> r0_x = beam_functions(X.slope, 1, 0), d = beam_functions(X.value, 0, 1);
      bend -= rest.along * r0_x;
      add_natural(element, w, rest, r0_x, d);
      natural.add(S(-w * rest.normal), r0_x, d, bend);
    }
    add_square(element.bending, weight * e.bend, bend);
    add(element.bending, e.twist, X.slope, 0, 1);
    add(element.bending, e.warp, X.curvature, 0, 1);
    add(element.mass, e.area, X.value, 1, 0);
    add(element.mass, e.rotary, X.value, 0, 1);
  }
  for (int a = 0; a < 2; ++a) {
    const HermiteValuesT<S> X = hermite<S>(membrane_x.point[a], h);
    const S at = x[i] + membrane_x.point[a] * h;
    const auto e = section(at);
    const S metric = rest(i, membrane_x.point[a]).metric;
    const Row<S> r0_x = beam_functions(X.slope, 1, 0), d_x = beam_functions(X.slope, 0, 1),
                 d = beam_functions(X.value, 0, 1);
    for (int b = 0; b < 4; ++b) {
      const S y = width * width_factor(at) * place[b];
      const int g = 4 * a + b;
      set_row<S>(element.gradient, g, r0_x + y * d_x);
      set_row<S>(element.gradient, PlateMesh::points + g, d);
      element.weight[g] = part(S(membrane_x.weight[a] * h * e.across[b]));
      element.metric[g] = part(metric);
    }
  }
  natural.give(element);
  return element;
}

template <class S>
auto MeshNumbers<S>::point_weights(double along, double across, std::array<int, 2> derivative) const
    -> std::vector<Weight> {
  assert(derivative[0] <= 1 && derivative[1] <= 1);
  const auto locate = [](const std::vector<S>& points, double s) {
    int i = 0;
    while (i + 2 < static_cast<int>(points.size()) && s > value_of(points[i + 1])) ++i;
    return i;
  };
  // of an element of the size h at the place s in it, the derivative times `size`
  const auto functions = [](const S& s, const S& h, int order, const S& size) {
    const HermiteValuesT<S> at = hermite<S>(value_of(s), h);
    std::array<S, 4> f;
    for (int k = 0; k < 4; ++k)
      f[k] = order == 0 ? S(at.value[k] + (s - value_of(s)) * h * at.slope[k])
                        : S(size * (at.slope[k] + (s - value_of(s)) * h * at.curvature[k]));
    return f;
  };
  std::vector<Weight> weights;
  const auto add = [&](int line, int function, const S& weight) {
    const bool moves = !std::is_same_v<S, double> && part(weight) != 0;
    if (std::abs(value_of(weight)) > 1e-14 || moves) weights.push_back({line, function, weight});
  };
  const int i = locate(x, along);
  const S hx = x[i + 1] - x[i], sx = (along - x[i]) / hx;
  const std::array<S, 4> X = functions(sx, hx, derivative[0], S(1));
  if (shape_->is_beam()) {  // r0 + y d, the width at the place
    const double part_of_width = derivative[1] == 0 ? across - 0.5 : 1.0;
    const S beside = part_of_width * width * width_factor(S(along));
    S widening(0);
    if (derivative[0] == 1) widening = part_of_width * width * width_factor(S(along), 1);
    const std::array<S, 4> value = functions(sx, hx, 0, S(1));
    for (int p = 0; p < 2; ++p)
      for (int k = 0; k < 2; ++k) {
        const int f = 2 * p + k;
        if (derivative[1] == 0) add(i + p, k, X[f]);
        add(i + p, 2 + k, beside * X[f] + widening * value[f]);
      }
    return weights;
  }
  const S size = y.back() - y.front(), place = y.front() + across * size;
  const int j = locate(y, value_of(place));
  const S hy = y[j + 1] - y[j], sy = (place - y[j]) / hy;
  const auto N = hermite_products(X, functions(sy, hy, derivative[1], size));
  for (int f = 0; f < 16; ++f) add(i + f / 8, 4 * j + f % 8, N[f]);
  return weights;
}

template class MeshNumbers<double>;
template class MeshNumbers<Dual1>;

}  // namespace flexopt
