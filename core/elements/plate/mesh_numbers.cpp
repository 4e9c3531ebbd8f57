// The mesh of a plate, core/elements/README.md (P1)–(P4), and what changes along it.
#include "core/elements/plate/mesh_numbers.hpp"

#include <cassert>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

#include "core/elements/plate/beam_section.hpp"
#include "core/mechanism/fold_corner.hpp"
#include "core/mechanism/profile.hpp"

namespace flexopt {
namespace {

template <class S>
S number(double value, double rate) {
  if constexpr (std::is_same_v<S, double>)
    return value;
  else
    return {value, {rate}};
}

template <class S>
LeafFoldT<S> fold_of(const PlateShape& shape, const ShapeRate& rate) {
  const auto [place, angle, radius] = shape.fold.value_or(LeafFold{});
  return {number<S>(place, rate.fold.place), number<S>(angle, rate.fold.angle),
          number<S>(radius, rate.fold.radius)};
}

// Factor of a profile at a place that may move.
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

/// g of the mesh towards the free edges, and of a wide leaf towards its clamps.
constexpr double grading = 0.7;

/// How far from the fold line the corner counts, over what it takes: the shares below add up to 1.
constexpr double corner_zone = 160.0 / 133;
/// Share of the corner's flexibility that lies within u of this length, and its moment. Its density
/// is 19/20, and less towards the end of the zone, 19/20 (1 − u⁷).
template <class S>
S corner_share(const S& u) {
  if (value_of(u) >= 1) return S(1);
  const S u2 = u * u, u4 = u2 * u2;
  return u * (8.0 - u * u2 * u4) / 7.0;
}
template <class S>
S corner_moment(const S& u) {
  if (value_of(u) >= 1) return S(4.0 / 9);
  const S u2 = u * u, u4 = u2 * u2;
  return u2 * (36.0 - 8.0 * u * u2 * u4) / 63.0;
}

// (E13), by the mean width over the length between the clamps
template <class S>
S grading_along(const S& aspect) {
  const S square = aspect * aspect / (0.06 * 0.06), fourth = square * square;
  return grading + (1 - grading) / (1.0 + fourth * fourth);
}

/// Lines at equal shares of ξ from 0 to 1, closer together towards both.
template <class S>
S graded_place(const S& xi, const S& g) {
  using std::cos;
  return 0.5 * (1.0 + (1.0 - g) * (2.0 * xi - 1.0) - g * cos(std::numbers::pi * xi));
}

// Density ρ of lines over ξ, the place on the graded mesh of a uniform leaf: t^(−3/4) as a short
// series of cosines, which stays positive when it is damped by Jackson's factors.
template <class S>
struct DensityOfLines {
  static constexpr int terms = 12, N = terms + 1, samples = 256;
  std::array<S, N> a{};
  bool uniform = true;

  template <class Thickness>
  explicit DensityOfLines(const Thickness& thickness) {
    using std::numbers::pi, std::pow;
    for (int m = 0; m < samples; ++m) {
      const double xi = (m + 0.5) / samples;
      const S density = pow(thickness(xi), -0.75);
      for (int k = 0; k <= terms; ++k) a[k] += density * std::cos(k * pi * xi);
    }
    for (int k = 1; k <= terms; ++k) {
      const double angle = k * pi / (N + 1);
      const double damping =
          ((N - k + 1) * std::cos(angle) + std::sin(angle) / std::tan(pi / (N + 1))) / (N + 1);
      a[k] = 2 * damping * a[k] / a[0];
      if (std::abs(value_of(a[k])) > 1e-12 || std::abs(part_of(a[k])) > 1e-12) uniform = false;
    }
  }

  // ∫ ρ from 0 to ξ over that of all, and ρ.
  std::pair<S, double> share(double xi) const {
    S sum(xi);
    double rate = 1;
    for (int k = 1; k <= terms; ++k) {
      const double angle = k * std::numbers::pi * xi;
      sum += a[k] * (std::sin(angle) / (k * std::numbers::pi));
      rate += value_of(a[k]) * std::cos(angle);
    }
    return {sum, rate};
  }

  // The ξ up to which a share of ∫ ρ lies.
  S place(double wanted) const {
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
    return xi;
  }
};

}  // namespace

template <class S>
MeshNumbers<S>::MeshNumbers(const PlateShape& shape, const ShapeRate& rate)
    : width(number<S>(shape.width, rate.size[0])),
      thickness(number<S>(shape.thickness, rate.size[1])),
      poissons_ratio(number<S>(shape.poissons_ratio, rate.size[2])),
      curve(number<S>(shape.curve.value_or(0), rate.curve)),
      fold(fold_of<S>(shape, rate)),
      shape_(shape),
      rate_(rate) {
  x = lines_along();
  for (std::size_t i = 0; i < x.size(); ++i)
    if (curved())
      middle.push_back(arc_point<S>(curve, x[i]));
    else if (folded() && static_cast<int>(i) > shape_.mesh[0])
      middle.push_back(leg_point<S>(fold.place, fold.angle, x[i]));
    else
      middle.push_back({x[i], S(0), S(1), S(0)});
  line_width.resize(x.size());
  if (shape_.is_beam()) {
    y = {S(0)};
    return;
  }
  for (const double place : graded_points(-0.5, 0.5, shape_.mesh[1], grading))
    y.push_back(place * width);
  for (std::size_t i = 0; i < x.size(); ++i)
    line_width[i] = {width_factor(x[i]), width_factor(x[i], 1)};
}

template <class S>
std::vector<S> MeshNumbers<S>::lines_along() const {
  const int n = shape_.mesh[0];
  const std::vector<double>& by = rate_.width_profile;
  const S mean_width = width_varies() ? S(width * number<S>(profile_mean(shape_.width_profile),
                                                            by.empty() ? 0 : profile_mean(by)))
                                      : width;
  const auto grading_of = [&](const S& length) {
    return shape_.is_beam() || shape_.linear ? S(grading) : grading_along<S>(mean_width / length);
  };
  const auto graded = [n](const S& from, const S& length, const S& g) {
    std::vector<S> lines(n + 1, from);
    lines[n] += length;
    for (int i = 1; 2 * i <= n; ++i) {  // symmetric: equal from both ends, to rounding
      const S place = length * graded_place(S(static_cast<double>(i) / n), g);
      lines[i] += place;
      if (2 * i < n) lines[n - i] = lines[n] - place;
    }
    return lines;
  };
  if (folded()) {
    const S other = 1.0 - fold.place;
    std::vector<S> lines = graded(S(0), fold.place, grading_of(fold.place));
    for (const S& line : graded(fold.place, other, grading_of(other))) lines.push_back(line);
    lines.back() = S(1);
    return lines;
  }
  const S g = grading_of(S(1));
  std::vector<S> lines = graded(S(0), S(1), g);
  if (shape_.thickness_profile.empty()) return lines;
  const DensityOfLines<S> density(
      [&](double xi) { return thickness_factor(graded_place(S(xi), g)); });
  for (int i = 1; i < n && !density.uniform; ++i)
    lines[i] = graded_place(density.place(static_cast<double>(i) / n), g);
  return lines;
}

template <class S>
S MeshNumbers<S>::width_factor(const S& place, int order) const {
  if (!width_varies()) return S(order == 0 ? 1 : 0);
  return profile<S>(shape_.width_profile, rate_.width_profile, place, order);
}

template <class S>
S MeshNumbers<S>::thickness_factor(const S& place) const {
  if (shape_.thickness_profile.empty()) return S(1);
  return profile<S>(shape_.thickness_profile, rate_.thickness_profile, place, 0);
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
auto MeshNumbers<S>::corner(int i) const -> Corner {
  const int line = shape_.mesh[0];
  Corner corner;
  if (!folded() || i == line) return corner;
  const bool first = i < line;
  const S near = first ? S(fold.place - x[i + 1]) : S(x[i] - fold.place), h = x[i + 1] - x[i],
          far = near + h;
  const S reach = corner_reach<S>(fold.angle, fold.radius, thickness),
          missing = corner_shortening<S>(fold.angle, fold.radius, thickness);
  if (value_of(missing) == 0) return corner;  // with its derivative
  const auto share_within = [&](const S& zone) {
    return S(corner_share(S(far / zone)) - corner_share(S(near / zone)));
  };
  const S beside = share_within(S(corner_zone * reach)) / h;
  corner.twist -= beside * corner_shortening_of_twist<S>(fold.angle, fold.radius, thickness);
  corner.mass -= beside * corner_cut<S>(fold.angle, fold.radius, thickness);
  const S zone = corner_zone * missing, share = share_within(zone);
  if (value_of(share) == 0) return corner;
  const S moment = corner_moment(S(far / zone)) - corner_moment(S(near / zone)),
          from_line = (zone * moment / share - near) / h,
          d = (first ? 0.5 - from_line : from_line - 0.5);
  const S own = missing * share;
  corner.place = 0.5 + d;
  corner.stiffness = own / (1.0 - own / h * (1.0 + 12.0 * d * d));
  return corner;
}

template <class S>
std::array<S, 2> MeshNumbers<S>::rest_along(int i, const std::array<S, 4>& functions) const {
  const ArcPoint<S>&a = middle[i], &b = middle[i + 1];
  // the functions of both values sum up to nothing
  return {functions[2] * (b.x - a.x) + functions[1] * a.cosine + functions[3] * b.cosine,
          functions[2] * (b.z - a.z) + functions[1] * a.sine + functions[3] * b.sine};
}

template <class S>
std::array<S, 2> MeshNumbers<S>::rest_tangent(int i, double s) const {
  return rest_along(i, hermite<S>(s, x[i + 1] - x[i]).slope);
}

template <class S>
auto MeshNumbers<S>::rest(int i, double s) const -> Rest {
  if (!curved()) return {};
  const HermiteValuesT<S> X = hermite<S>(s, x[i + 1] - x[i]);
  const auto [tx, tz] = rest_along(i, X.slope);
  const auto [kx, kz] = rest_along(i, X.curvature);
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

template <class S>
auto MeshNumbers<S>::membrane() const -> Membrane {
  const S stretch = 12.0 / (thickness * thickness);
  if (!shape_.is_beam())
    return {stretch, poissons_ratio * stretch, 0.5 * (1.0 - poissons_ratio) * stretch};
  const S shear = beam_section<S>(shape_.section, width, thickness, poissons_ratio).shear;
  return {stretch, S(0), shear * shear_ratio(poissons_ratio) * stretch};
}

template <class S>
S MeshNumbers<S>::bending_stiffness() const {
  const auto at = [&](double place) -> S {
    const S t = thickness_factor(S(place)), w = width * width_factor(S(place));
    if (!shape_.is_beam()) return w * t * t * t;
    return 12.0 / (thickness * thickness * thickness) *
           beam_section<S>(shape_.section, w, thickness * t, poissons_ratio).I_weak;
  };
  if (!shape_.has_profile()) return at(0);
  S compliance(0);
  constexpr int parts = 96;
  for (int k = 0; k < parts; ++k) compliance += 1.0 / parts / at((k + 0.5) / parts);
  return 1.0 / compliance;
}

template <class S>
auto MeshNumbers<S>::point_weights(double along, double across, std::array<int, 2> derivative) const
    -> std::vector<NodalWeightT<S>> {
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
  std::vector<NodalWeightT<S>> weights;
  const auto add = [&](int line, int function, const S& weight) {
    const bool moves = !std::is_same_v<S, double> && part_of(weight) != 0;
    if (std::abs(value_of(weight)) > 1e-14 || moves) weights.push_back({line, function, weight});
  };
  const int i = locate(x, along);
  const S hx = x[i + 1] - x[i], sx = (along - x[i]) / hx;
  const std::array<S, 4> X = functions(sx, hx, derivative[0], S(1));
  if (shape_.is_beam()) {  // r0 + y d, the width at the place
    const S part = (derivative[1] == 0 ? across - 0.5 : 1.0) * width,
            beside = part * width_factor(S(along)),
            widening = derivative[0] == 1 ? S(part * width_factor(S(along), 1)) : S(0);
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
