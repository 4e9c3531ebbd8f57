#include "core/elements/plate/strain_field.hpp"

#include <Eigen/Geometry>
#include <cassert>
#include <cmath>

#include "core/elements/plate/element_numbers.hpp"

namespace flexopt {
namespace {

using Gradient = Eigen::Matrix<double, 16, 3>;

Gradient dofs(const std::vector<MatrixXd>& nodal, int i, int j) {
  Gradient U;
  U << nodal[i].middleRows<8>(4 * j), nodal[i + 1].middleRows<8>(4 * j);
  return U;
}

// |r,x|² and the curvature along of the undeflected leaf.
template <class S>
struct RestT {
  S metric = S(1), curvature = S(0);
};
template <class S>
RestT<S> rest_of(const MeshNumbers<S>& numbers, int i, double s) {
  if (!numbers.curved()) return {};
  return {numbers.rest(i, s).metric, numbers.rest_curvature(i, s)};
}

/// What the bending of the sections differs by from that of the surface of the nodal values.
template <class S>
struct SectionT {
  Vector3<S> turn;           ///< (E11)
  const MeshNumbers<S>* of;  ///< of a folded leaf: (E15)
  int element = 0;           ///< along
  double along = 0;          ///< share of it
};

// `map` and `y0`: null where the width does not vary.
template <class S>
StrainsT<S> strains(const Eigen::Matrix<S, 16, 3>& U, const HermiteValuesT<S>& X,
                    const HermiteValuesT<S>& Y, const RestT<S>& rest, const WidthMap<S>* map,
                    const S& y0, const SectionT<S>& section) {
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
  if (map) r = mapped<S, Vector3<S>>(*map, y0, r.x, r.y, r.xx, r.xy, r.yy);
  const Vector3<S>&a1 = r.x, &a2 = r.y;
  Vector3<S> r11 = r.xx - section.turn;
  if (section.of) {
    const auto corner = section.of->corner(section.element);
    if (value_of(corner.stiffness) != 0) {
      const MeshNumbers<S>& mesh = *section.of;
      const S h = mesh.x[section.element + 1] - mesh.x[section.element], d = corner.place - 0.5;
      const double here = section.along - 0.5;
      const HermiteValuesT<S> there = hermite<S, S>(corner.place, h);
      const Vector3<S> bent = at(there.curvature, Y.value) - (d / here) * section.turn +
                              mesh.poissons_ratio * at(there.value, Y.curvature);
      r11 += S(corner.stiffness / h * (1.0 + 12.0 * here * d)) * bent;
    }
  }
  const Vector3<S> m = a1.cross(a2);
  using std::sqrt;
  const Vector3<S> n = m / sqrt(m.squaredNorm());
  StrainsT<S> e;
  // a fibre on the side of the normal is stretched by −r,ab · n
  e << 0.5 * (a1.squaredNorm() - rest.metric), 0.5 * (a2.squaredNorm() - 1.0), a1.dot(a2),
      -r11.dot(n) - rest.curvature, -r.yy.dot(n), -2.0 * r.xy.dot(n);
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
  int i = behind ? split.stations : 0;
  while (i < last && s > points[i + 1]) ++i;
  return {i, (s - points[i]) / (points[i + 1] - points[i])};
}

// Second derivatives of a cubic are superconvergent at the Gauss stations. (They jump from element
// to element; read anywhere else, they are a saw-tooth.)
StrainField recovered_strains(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal) {
  std::vector<Strains> values;
  const MeshNumbers<double> numbers(mesh.shape(), mesh.x());
  for (int i = 0; i < mesh.elements_along(); ++i)
    for (const double a : station) {
      if (i == mesh.fold_line()) continue;
      const HermiteValues X = hermite(a, mesh.x()[i + 1] - mesh.x()[i]);
      const WidthMap<double> map = numbers.map(i, a);
      for (int j = 0; j < mesh.elements_across(); ++j) {
        const Gradient U = dofs(nodal, i, j);
        const double hy = mesh.y()[j + 1] - mesh.y()[j];
        for (const double b : station)
          values.push_back(strains<double>(
              U, X, hermite(b, hy), rest_of(numbers, i, a), numbers.width_varies() ? &map : nullptr,
              mesh.y()[j] + b * hy,
              {section_turn(mesh, i, j, U, a), numbers.folded() ? &numbers : nullptr, i, a}));
      }
    }
  return {gauss_stations(mesh.x()), gauss_stations(mesh.y()), std::move(values),
          fold_split(mesh.shape())};
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

MatrixXd StrainField::on(const std::vector<double>& x, const std::vector<double>& y) const {
  const auto n = static_cast<Eigen::Index>(x_.size()),
             places_x = static_cast<Eigen::Index>(x.size()),
             places_y = static_cast<Eigen::Index>(y.size());
  std::vector<std::pair<int, double>> along;
  for (const double place : x) along.push_back(station_interval(x_, place, split_));
  MatrixXd values(places_x * places_y, 6);
  Eigen::ArrayXd line(n);  // at a place across
  for (Eigen::Index b = 0; b < places_y; ++b) {
    const auto [j, t] = station_interval(y_, y[static_cast<std::size_t>(b)]);
    for (Eigen::Index k = 0; k < 6; ++k) {
      line = (1 - t) * values_.col(k).segment(n * j, n).array() +
             t * values_.col(k).segment(n * (j + 1), n).array();
      double* const to = &values(places_x * b, k);
      for (Eigen::Index a = 0; a < places_x; ++a) {
        const auto [i, s] = along[static_cast<std::size_t>(a)];
        to[a] = (1 - s) * line[i] + s * line[i + 1];
      }
    }
  }
  return values;
}

MovingStations moving_stations(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const StressRate& rate) {
  const PlateShape& shape = mesh.shape();
  const MeshNumbers<Dual1> numbers(shape, rate.shape);
  const auto strains_at = [&nodal, &rate, &shape, numbers](int a, int b) {
    const int ei = a / 2 + (shape.fold && a / 2 >= shape.mesh[0] ? 1 : 0), ej = b / 2;
    Eigen::Matrix<Dual1, 16, 3> U;
    for (int f = 0; f < 16; ++f)
      for (int c = 0; c < 3; ++c)
        U(f, c) = {nodal[ei + f / 8](4 * ej + f % 8, c),
                   {rate.nodal[ei + f / 8](4 * ej + f % 8, c)}};
    const Dual1 hx = numbers.x[ei + 1] - numbers.x[ei], hy = numbers.y[ej + 1] - numbers.y[ej];
    const double sx = station[a % 2], sy = station[b % 2];
    const WidthMap<Dual1> map = numbers.map(ei, sx);
    const StrainsT<Dual1> e = strains<Dual1>(
        U, hermite<Dual1>(sx, hx), hermite<Dual1>(sy, hy), rest_of(numbers, ei, sx),
        numbers.width_varies() ? &map : nullptr, numbers.y[ej] + sy * hy,
        {section_turn(numbers, ei, ej, U, sx), numbers.folded() ? &numbers : nullptr, ei, sx});
    StrainRate result;
    for (int k = 0; k < 6; ++k) {
      result.value[k] = e[k].value;
      result.rate[k] = e[k].derivatives[0];
    }
    return result;
  };
  return {gauss_stations(numbers.x), gauss_stations(mesh.y()), strains_at};
}

}  // namespace flexopt
