#include "core/elements/plate/strain_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "core/elements/plate/element_numbers.hpp"

namespace flexopt {
namespace {

// Strains at a station (a, b) of element (i, j) with the nodal values U; `turn`: (E11). Adds
// `weight` times the slope of 2 e12 along to `shear_slope`.
template <class S>
StrainsT<S> strains(const MeshNumbers<S>& mesh, const Eigen::Matrix<S, 16, 3>& U, int i, int j,
                    double a, double b, const Vector3<S>& turn, const S& weight, S& shear_slope) {
  const S hx = mesh.x[i + 1] - mesh.x[i], hy = mesh.y[j + 1] - mesh.y[j];
  const HermiteValuesT<S> X = hermite<S>(a, hx), Y = hermite<S>(b, hy);
  const auto at = [&](const std::array<S, 4>& x, const std::array<S, 4>& y) {
    Vector3<S> r = Vector3<S>::Zero();
    for (int f = 0; f < 16; ++f) {
      const S N = y[2 * (f / 4 % 2) + f % 4 / 2] * x[2 * (f / 8) + f % 2];
      for (int c = 0; c < 3; ++c) r[c] += N * U(f, c);
    }
    return r;
  };
  MappedDerivatives<Vector3<S>> r{at(X.slope, Y.value), at(X.value, Y.slope),
                                  at(X.curvature, Y.value), at(X.slope, Y.slope),
                                  at(X.value, Y.curvature)};
  if (mesh.width_varies())
    r = mapped<S, Vector3<S>>(mesh.map(i, a), S(mesh.y[j] + b * hy), r.x, r.y, r.xx, r.xy, r.yy);
  Vector3<S> r11 = r.xx - turn;
  // of a folded leaf: (E15)
  if (const auto corner = mesh.corner(i); value_of(corner.stiffness) != 0) {
    const S d = corner.place - 0.5;
    const double here = a - 0.5;
    const HermiteValuesT<S> there = hermite<S, S>(corner.place, hx);
    const Vector3<S> bent = at(there.curvature, Y.value) - (d / here) * turn +
                            mesh.poissons_ratio * at(there.value, Y.curvature);
    r11 += S(corner.stiffness / hx * (1.0 + 12.0 * here * d)) * bent;
  }
  const Vector3<S>&a1 = r.x, &a2 = r.y;
  const Vector3<S> m = a1.cross(a2);
  using std::sqrt;
  const Vector3<S> n = m / sqrt(m.squaredNorm());
  shear_slope += weight * (r11.dot(a2) + a1.dot(r.xy));
  StrainsT<S> e;
  // a fibre on the side of the normal is stretched by −r,ab · n
  e << 0.5 * (a1.squaredNorm() - mesh.rest(i, a).metric), 0.5 * (a2.squaredNorm() - 1.0),
      a1.dot(a2), -r11.dot(n) - mesh.rest_curvature(i, a), -r.yy.dot(n), -2.0 * r.xy.dot(n);
  return e;
}

// Strains at the stations across that lie at the share a of the elements i along, with (E18).
// `nodes(j)`: nodal values of the elements; `turn(j, U)`: (E11).
template <class S, class Nodes, class Turn>
std::vector<StrainsT<S>> strains_across(const MeshNumbers<S>& mesh, int i, double a,
                                        const Nodes& nodes, const Turn& turn) {
  std::vector<StrainsT<S>> e;
  S mean(0);
  const int elements = static_cast<int>(mesh.y.size()) - 1;
  for (int j = 0; j < elements; ++j) {
    const Eigen::Matrix<S, 16, 3> U = nodes(j);
    const Vector3<S> turned = turn(j, U);
    const S weight = 0.5 * (mesh.y[j + 1] - mesh.y[j]) / mesh.width;
    for (const double b : station)
      e.push_back(strains<S>(mesh, U, i, j, a, b, turned, weight, mean));
  }
  const S along = mesh.x[i] + a * (mesh.x[i + 1] - mesh.x[i]), factor = mesh.width_factor(along),
          share = line_share<S>(mesh.thickness * mesh.thickness_factor(along), mesh.width * factor,
                                mesh.poissons_ratio);
  for (std::size_t k = 0; k < e.size(); ++k) {
    const std::size_t j = k / 2;
    const S y = factor * (mesh.y[j] + station[k % 2] * (mesh.y[j + 1] - mesh.y[j]));
    e[k][0] -= share * mean * y;
  }
  return e;
}

template <class S>
std::vector<S> gauss_stations(const std::vector<S>& points) {
  std::vector<S> s;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    for (const double a : station)
      if (value_of(points[i + 1]) > value_of(points[i]))  // none between the lines of a fold
        s.push_back(points[i] + a * (points[i + 1] - points[i]));
  return s;
}

}  // namespace

FoldSplit fold_split(const PlateShape& shape) {
  if (!shape.fold) return {};
  return {2 * shape.mesh[0], shape.fold->place};
}

std::pair<int, double> station_interval(const std::vector<double>& points, double s,
                                        const FoldSplit& split) {
  const bool behind = split.stations > 0 && s > split.place;
  const int end = split.stations > 0 && !behind ? split.stations : static_cast<int>(points.size()),
            last = end - 2;
  const auto first = points.begin();
  const auto next =
      std::lower_bound(first + (behind ? split.stations : 0) + 1, first + last + 1, s);
  const auto i = static_cast<int>(next - first) - 1;
  return {i, (s - points[i]) / (points[i + 1] - points[i])};
}

Eigen::Matrix<double, 16, 3> element_nodes(const PlateMesh& mesh,
                                           const std::vector<MatrixXd>& nodal, int i, int j) {
  const int side = mesh.functions_per_side();
  Eigen::Matrix<double, 16, 3> U = Eigen::Matrix<double, 16, 3>::Zero();
  U.topRows(side) = nodal[i].middleRows(4 * j, side);
  U.middleRows(side, side) = nodal[i + 1].middleRows(4 * j, side);
  return U;
}

// Second derivatives of a cubic are superconvergent at the Gauss stations. (They jump from element
// to element; read anywhere else, they are a saw-tooth.)
StrainField recovered_strains(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal) {
  std::vector<Strains> values;
  const MeshNumbers<double>& numbers = mesh.numbers();
  for (int i = 0; i < mesh.elements_along(); ++i)
    for (const double a : station) {
      if (i == mesh.fold_line()) continue;
      const std::vector<Strains> across = strains_across<double>(
          numbers, i, a, [&](int j) { return element_nodes(mesh, nodal, i, j); },
          [&](int j, const auto& U) { return section_turn(mesh, i, j, U, a); });
      values.insert(values.end(), across.begin(), across.end());
    }
  return {gauss_stations(mesh.x()), gauss_stations(mesh.y()), values, fold_split(mesh.shape())};
}

std::vector<double> strain_stations(const std::vector<double>& lines) {
  return gauss_stations(lines);
}
std::vector<Dual1> strain_stations(const std::vector<Dual1>& lines) {
  return gauss_stations(lines);
}

StrainField::StrainField(std::vector<double> x, std::vector<double> y,
                         const std::vector<Strains>& values, FoldSplit split)
    : x_(std::move(x)), y_(std::move(y)), values_(x_.size() * y_.size(), 6), split_(split) {
  assert(values.size() == x_.size() * y_.size());
  for (std::size_t i = 0; i < x_.size(); ++i)
    for (std::size_t j = 0; j < y_.size(); ++j)
      values_.row(static_cast<Eigen::Index>(i + x_.size() * j)) =
          values[i * y_.size() + j].transpose();
}

StrainField::StrainField(std::vector<double> x, std::vector<double> y, MatrixXd values,
                         FoldSplit split)
    : x_(std::move(x)), y_(std::move(y)), values_(std::move(values)), split_(split) {
  assert(values_.rows() == static_cast<Eigen::Index>(x_.size() * y_.size()) && values_.cols() == 6);
}

Strains StrainField::at(double x, double y) const {
  const auto [i, s] = station_interval(x_, x, split_);
  const auto [j, t] = station_interval(y_, y);
  const auto n = static_cast<Eigen::Index>(x_.size()), low = i + n * j, high = low + n;
  return (1 - s) * ((1 - t) * values_.row(low) + t * values_.row(high)) +
         s * ((1 - t) * values_.row(low + 1) + t * values_.row(high + 1));
}

MovingStations moving_stations(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const StressRate& rate) {
  const MeshNumbers<Dual1> numbers(mesh.shape(), rate.shape);
  std::map<int, std::vector<StrainsT<Dual1>>> known;
  const auto strains_at = [&mesh, &nodal, &rate, numbers, known](int x, int y) mutable {
    std::vector<StrainsT<Dual1>>& across = known[x];
    if (!across.empty()) return across[static_cast<std::size_t>(y)];
    const int i = x / 2 + (mesh.fold_line() >= 0 && x / 2 >= mesh.fold_line() ? 1 : 0);
    const double a = station[x % 2];
    across = strains_across<Dual1>(
        numbers, i, a,
        [&](int j) {
          return moving(element_nodes(mesh, nodal, i, j), element_nodes(mesh, rate.nodal, i, j));
        },
        [&](int j, const auto& U) { return section_turn(numbers, i, j, U, a); });
    return across[static_cast<std::size_t>(y)];
  };
  return {gauss_stations(numbers.x), gauss_stations(mesh.y()), strains_at};
}

}  // namespace flexopt
