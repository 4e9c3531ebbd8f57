#include "core/reduction/atlas/shape_grid.hpp"

#include <algorithm>
#include <cmath>

#include "core/math/chebyshev.hpp"
#include "core/math/decompositions.hpp"

namespace flexopt {

namespace {

bool is_inner(const ShapeGrid& grid, std::size_t ratio) {
  return ratio > 0 && ratio + 1 < grid.poissons_ratios.size();
}

// The places of an axis at which the shapes of an inner ratio stand, among all of them.
std::vector<std::size_t> inner_places(const std::vector<double>& axis) {
  const std::size_t step = axis.size() >= 5 && axis.size() % 2 == 1 ? 2 : 1;
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < axis.size(); k += step) places.push_back(k);
  return places;
}

std::vector<double> at_places(const std::vector<double>& axis,
                              const std::vector<std::size_t>& places) {
  std::vector<double> some;
  for (const std::size_t k : places) some.push_back(axis[k]);
  return some;
}

}  // namespace

int ShapeGrid::size() const {
  const std::size_t full = log_width.size() * log_thickness.size(),
                    inner = inner_places(log_width).size() * inner_places(log_thickness).size();
  std::size_t size = 0;
  for (std::size_t v = 0; v < poissons_ratios.size(); ++v)
    size += is_inner(*this, v) ? inner : full;
  return static_cast<int>(size);
}

Vector3d ShapeGrid::shape(int k) const {
  auto left = static_cast<std::size_t>(k);
  for (std::size_t v = 0;; ++v) {
    const bool inner = is_inner(*this, v);
    const std::vector<double> x = inner ? at_places(log_width, inner_places(log_width)) : log_width,
                              y = inner ? at_places(log_thickness, inner_places(log_thickness))
                                        : log_thickness;
    if (left < x.size() * y.size())
      return {x[left / y.size()], y[left % y.size()], poissons_ratios[v]};
    left -= x.size() * y.size();
  }
}

MatrixXd ShapeGrid::log_sizes() const {
  MatrixXd sizes(size(), 2);
  for (int k = 0; k < size(); ++k) sizes.row(k) = shape(k).head<2>().transpose();
  return sizes;
}

// On the shapes of the first and the last ratio a number is interpolated linearly in ν. On those of
// the ratios between it is known how far it is from that, which is interpolated on their own
// points.
MatrixXd shape_weights(const ShapeGrid& grid, const Vector3d& place, ShapeSlopes slopes) {
  const std::vector<double>& ratios = grid.poissons_ratios;
  std::vector<double> ends{ratios.front()};
  if (ratios.size() > 1) ends.push_back(ratios.back());
  const std::vector<std::size_t> inner_x = inner_places(grid.log_width),
                                 inner_y = inner_places(grid.log_thickness);
  const PointWeights x = polynomial_weights(grid.log_width, place[0]),
                     y = polynomial_weights(grid.log_thickness, place[1]),
                     of_inner_x = polynomial_weights(at_places(grid.log_width, inner_x), place[0]),
                     of_inner_y =
                         polynomial_weights(at_places(grid.log_thickness, inner_y), place[1]),
                     between_ends = polynomial_weights(ends, place[2]),
                     through_all = polynomial_weights(ratios, place[2]);
  const Eigen::Index thick = static_cast<Eigen::Index>(grid.log_thickness.size()),
                     full = static_cast<Eigen::Index>(grid.log_width.size()) * thick,
                     last = grid.size() - full;  // the first shape of the last ratio
  MatrixXd weights = MatrixXd::Zero(grid.size(), 1 + slope_count(slopes));
  for (Eigen::Index column = 0; column < weights.cols(); ++column) {
    const auto along = [&](const PointWeights& of, int axis) -> const std::vector<double>& {
      return axis == column - 1 ? of.slope : of.value;
    };
    for (std::size_t e = 0; e < ends.size(); ++e)
      for (std::size_t i = 0; i < grid.log_width.size(); ++i)
        for (std::size_t j = 0; j < grid.log_thickness.size(); ++j)
          weights((e == 0 ? 0 : last) + static_cast<Eigen::Index>(i) * thick +
                      static_cast<Eigen::Index>(j),
                  column) = along(between_ends, 2)[e] * along(x, 0)[i] * along(y, 1)[j];
    Eigen::Index at = full;
    for (std::size_t v = 1; v + 1 < ratios.size(); ++v) {
      const PointWeights here = polynomial_weights(ends, ratios[v]);
      for (std::size_t i = 0; i < inner_x.size(); ++i)
        for (std::size_t j = 0; j < inner_y.size(); ++j) {
          const double weight =
              along(through_all, 2)[v] * along(of_inner_x, 0)[i] * along(of_inner_y, 1)[j];
          weights(at++, column) = weight;
          const Eigen::Index same =
              static_cast<Eigen::Index>(inner_x[i]) * thick + static_cast<Eigen::Index>(inner_y[j]);
          weights(same, column) -= weight * here.value[0];
          weights(last + same, column) -= weight * here.value[1];
        }
    }
  }
  return weights;
}

Vector3d place_in_grid(const PlateShape& shape) {
  return {std::log(shape.width), std::log(shape.thickness), shape.poissons_ratio};
}
Vector3d slope_units(const PlateShape& shape) { return {1 / shape.width, 1 / shape.thickness, 1}; }

HalfPowers::HalfPowers(const Vector3d& place) {
  for (int k = -most; k <= most; ++k) {
    width_[k + most] = std::exp(0.5 * k * place[0]);
    thickness_[k + most] = std::exp(0.5 * k * place[1]);
  }
}

PowerLaw power_law(const MatrixXd& log_sizes, const VectorXd& sizes) {
  std::vector<int> rows;
  for (int k = 0; k < sizes.size(); ++k)
    if (sizes[k] > 1e-290) rows.push_back(k);
  if (rows.size() < 8) return {0, 0};
  const int n = static_cast<int>(rows.size());
  MatrixXd A(n, 3);
  VectorXd b(n);
  for (int k = 0; k < n; ++k) {
    A.row(k) << 1, log_sizes.row(rows[k]);
    b[k] = std::log(sizes[rows[k]]);
  }
  const VectorXd x = Lu(A.transpose() * A).solve(A.transpose() * b);
  const auto rounded = [&](double p) {
    return static_cast<std::int8_t>(
        std::clamp(static_cast<int>(std::lround(2 * p)), -HalfPowers::most, HalfPowers::most));
  };
  return {rounded(x[1]), rounded(x[2])};
}

VectorXd law_at(const MatrixXd& log_sizes, const PowerLaw& law) {
  return (0.5 * (law[0] * log_sizes.col(0) + law[1] * log_sizes.col(1))).array().exp();
}

}  // namespace flexopt
