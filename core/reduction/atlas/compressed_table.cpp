#include "core/reduction/atlas/compressed_table.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/math/chebyshev.hpp"
#include "core/math/decompositions.hpp"

namespace flexopt {

HalfPowers::HalfPowers(const Vector3d& place) {
  for (int k = -most; k <= most; ++k) {
    width_[k + most] = std::exp(0.5 * k * place[0]);
    thickness_[k + most] = std::exp(0.5 * k * place[1]);
  }
}

Vector3d ShapeGrid::shape(int k) const {
  const int thick = static_cast<int>(log_thickness.size()),
            flat = static_cast<int>(log_width.size()) * thick;
  return {log_width[static_cast<std::size_t>(k % flat / thick)],
          log_thickness[static_cast<std::size_t>(k % thick)],
          poissons_ratios[static_cast<std::size_t>(k / flat)]};
}

ShapeWeights shape_weights(const ShapeGrid& grid, const Vector3d& place, ShapeSlopes slopes) {
  const std::array<PointWeights, 3> axis{polynomial_weights(grid.log_width, place[0]),
                                         polynomial_weights(grid.log_thickness, place[1]),
                                         polynomial_weights(grid.poissons_ratios, place[2])};
  ShapeWeights weights{place, MatrixXd(grid.size(), 1 + slope_count(slopes))};
  for (int column = 0; column < weights.of.cols(); ++column) {
    const auto along = [&](int a) -> const std::vector<double>& {
      return a == column - 1 ? axis[a].slope : axis[a].value;
    };
    Eigen::Index n = 0;
    for (const double v : along(2))
      for (const double x : along(0))
        for (const double y : along(1)) weights.of(n++, column) = v * x * y;
  }
  return weights;
}

Vector3d place_in_grid(const PlateShape& shape) {
  return {std::log(shape.width), std::log(shape.thickness), shape.poissons_ratio};
}
Vector3d slope_units(const PlateShape& shape) { return {1 / shape.width, 1 / shape.thickness, 1}; }

MatrixXd ShapeCoordinates::at(int directions, const ShapeWeights& weights) const {
  const MatrixXd x =
      weighted_sums(weights, directions, [&](Eigen::Index k) { return numbers + k * directions; });
  return x.transpose() *
         Eigen::Map<const Eigen::VectorXf>(units, directions).cast<double>().asDiagonal();
}

MadeCoordinates::MadeCoordinates(const MatrixXd& coordinates)
    : numbers(static_cast<std::size_t>(coordinates.size())) {
  for (Eigen::Index k = 0; k < coordinates.rows(); ++k) {
    const double unit = whole_unit<std::int16_t>(coordinates.row(k));
    units.push_back(static_cast<float>(unit));
    for (Eigen::Index shape = 0; shape < coordinates.cols(); ++shape)
      numbers[static_cast<std::size_t>(k + coordinates.rows() * shape)] =
          static_cast<std::int16_t>(std::lround(coordinates(k, shape) / unit));
  }
}

MatrixXd CompressedTable::look_up(const ShapeWeights& weights, int first) const {
  assert(first <= all);
  const auto count = static_cast<int>(std::lower_bound(places, places + numbers, first) - places);
  const MatrixXd y =
      direction_sums(basis, directions, blocks(count), coordinates.at(directions, weights));
  // a power law and the size of each number, in the places of all
  const HalfPowers law(weights.place);
  MatrixXd in_place = MatrixXd::Zero(first, y.cols());
  for (int i = 0; i < count; ++i) {
    const double size = static_cast<double>(sizes[i]) * law(exponents + 2 * i);
    for (Eigen::Index a = 0; a < y.cols(); ++a) in_place(places[i], a) = size * y(i, a);
    if (y.cols() == 1) continue;
    for (int a = 0; a < 2; ++a)
      in_place(places[i], 1 + a) += 0.5 * exponents[2 * i + a] * in_place(places[i], 0);
  }
  return in_place;
}

std::array<std::int8_t, 2> power_law(const MatrixXd& log_shapes, const VectorXd& sizes) {
  std::vector<int> rows;
  for (int k = 0; k < sizes.size(); ++k)
    if (sizes[k] > 1e-290) rows.push_back(k);
  if (rows.size() < 8) return {0, 0};
  const int n = static_cast<int>(rows.size());
  MatrixXd A(n, 3);
  VectorXd b(n);
  for (int k = 0; k < n; ++k) {
    A.row(k) << 1, log_shapes(rows[k], 0), log_shapes(rows[k], 1);
    b[k] = std::log(sizes[rows[k]]);
  }
  const VectorXd x = Lu(A.transpose() * A).solve(A.transpose() * b);
  const auto rounded = [&](double p) {
    return static_cast<std::int8_t>(
        std::clamp(static_cast<int>(std::lround(2 * p)), -HalfPowers::most, HalfPowers::most));
  };
  return {rounded(x[1]), rounded(x[2])};
}

MatrixXd leading_directions(const MatrixXd& values, double tolerance, int at_a_time) {
  // the right singular vectors
  const MatrixXd V = SymmetricEigen(values.transpose() * values).eigenvectors().rowwise().reverse();
  MatrixXd rest = values;
  Eigen::Index directions = 0;
  while (directions < V.cols() && (directions == 0 || rest.cwiseAbs().maxCoeff() > tolerance)) {
    const Eigen::Index more = std::min<Eigen::Index>(at_a_time, V.cols() - directions);
    const MatrixXd W = V.middleCols(directions, more);
    rest.noalias() -= (rest * W) * W.transpose();
    directions += more;
  }
  return V.leftCols(directions);
}

CompressedNumbers compress(const ShapeGrid& grid, MatrixXd values, const MatrixXd& weights,
                           const std::vector<bool>& trusted, double tolerance) {
  constexpr double negligible = 0.3;     // of the tolerance: such a number is left out
  constexpr double share_beyond = 1e-3;  // of shapes for which nobody asks
  const int shapes = grid.size(), all = static_cast<int>(values.rows());
  assert(values.cols() == shapes && weights.rows() == all && weights.cols() == shapes);
  assert(all <= 65536);
  MatrixXd log_shapes(shapes, 2);
  VectorXd share(shapes);
  for (int k = 0; k < shapes; ++k) {
    log_shapes.row(k) = grid.shape(k).head<2>().transpose();
    share[k] = trusted[static_cast<std::size_t>(k)] ? 1 : share_beyond;
  }
  CompressedNumbers made;
  made.all = all;
  made.shapes = shapes;
  std::vector<double> sizes;
  for (int i = 0; i < all; ++i) {
    // the law of the unit in which an error of this number counts
    const auto power = power_law(log_shapes, weights.row(i).cwiseInverse().transpose());
    const VectorXd law =
        (0.5 * (power[0] * log_shapes.col(0) + power[1] * log_shapes.col(1))).array().exp();
    const double weight = std::exp((weights.row(i).transpose().array() * law.array()).log().mean());
    values.row(i).array() *= weight / law.transpose().array();
    const double most = (values.row(i).transpose().array().abs() * share.array()).maxCoeff();
    if (most < negligible * tolerance) continue;
    const double size = std::max(most, 1.0);
    values.row(static_cast<Eigen::Index>(sizes.size())) = values.row(i) / size;
    made.places.push_back(static_cast<std::uint16_t>(i));
    for (const std::int8_t p : power) made.exponents.push_back(p);
    sizes.push_back(size / weight);
  }
  const auto numbers = static_cast<Eigen::Index>(sizes.size());
  // what is left of any number, times the share of its shape, is at most the tolerance
  const MatrixXd scaled = values.topRows(numbers) * share.asDiagonal(),
                 V = leading_directions(scaled, tolerance, 8), basis = scaled * V;
  made.numbers = static_cast<int>(numbers);
  made.directions = static_cast<int>(V.cols());
  made.basis.resize(
      static_cast<std::size_t>(CompressedTable::blocks(made.numbers) * CompressedTable::block) *
      static_cast<std::size_t>(made.directions));
  for (Eigen::Index i = 0; i < numbers; ++i) {  // the unit of each row goes into its size
    const double unit = whole_unit<std::int16_t>(basis.row(i));
    made.sizes.push_back(static_cast<float>(sizes[static_cast<std::size_t>(i)] * unit));
    put_row(made.basis, i, basis.row(i), unit);
  }
  made.coordinates = MadeCoordinates(V.transpose() * share.cwiseInverse().asDiagonal());
  return made;
}

}  // namespace flexopt
