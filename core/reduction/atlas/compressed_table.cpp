#include "core/reduction/atlas/compressed_table.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/math/chebyshev.hpp"
#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

constexpr int most_power = 16;  // doubled

// (w/L)^(p/2) for all p from −16 to 16.
std::array<double, 2 * most_power + 1> half_powers(double log_size) {
  std::array<double, 2 * most_power + 1> powers;
  for (int k = -most_power; k <= most_power; ++k)
    powers[k + most_power] = std::exp(0.5 * k * log_size);
  return powers;
}

}  // namespace

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
  const auto product = [&](int slope) {
    const auto of = [&](int a) -> const std::vector<double>& {
      return a == slope ? axis[a].slope : axis[a].value;
    };
    VectorXd all(grid.size());
    Eigen::Index n = 0;
    for (const double v : of(2))
      for (const double x : of(0))
        for (const double y : of(1)) all[n++] = v * x * y;
    return all;
  };
  ShapeWeights weights{place, product(-1), {}};
  if (slopes == ShapeSlopes::none) return weights;
  for (int a = 0; a < 2; ++a) weights.slope[a] = product(a);
  weights.slope[2] =
      slopes == ShapeSlopes::all ? product(2) : VectorXd(VectorXd::Zero(grid.size()));
  return weights;
}

Vector3d place_in_grid(const PlateShape& shape) {
  return {std::log(shape.width), std::log(shape.thickness), shape.poissons_ratio};
}
Vector3d slope_units(const PlateShape& shape) { return {1 / shape.width, 1 / shape.thickness, 1}; }

namespace {

// A power law and the size of each number, in the places of all.
template <class Put>
void put_in_place(const CompressedTable& table, const ShapeWeights& weights, int count,
                  const Put& put) {
  const auto width = half_powers(weights.place[0]), thickness = half_powers(weights.place[1]);
  for (int i = 0; i < count; ++i)
    put(i, table.places[i],
        static_cast<double>(table.sizes[i]) * width[table.exponents[2 * i] + most_power] *
            thickness[table.exponents[2 * i + 1] + most_power]);
}

}  // namespace

int CompressedTable::count_of(int first) const {
  assert(first <= all);
  return static_cast<int>(std::lower_bound(places, places + numbers, first) - places);
}

VectorXd ShapeCoordinates::at(int directions, const VectorXd& weights) const {
  using Whole = Eigen::Matrix<std::int16_t, Eigen::Dynamic, Eigen::Dynamic>;
  const Eigen::Map<const Whole> at_shapes(numbers, directions, weights.size());
  VectorXd x = VectorXd::Zero(directions);
  for (Eigen::Index k = 0; k < weights.size(); ++k)
    if (weights[k] != 0) x += weights[k] * at_shapes.col(k).cast<double>();
  return x.cwiseProduct(Eigen::Map<const Eigen::VectorXf>(units, directions).cast<double>());
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

VectorXd CompressedTable::look_up(const ShapeWeights& weights, int first) const {
  const int count = count_of(first);
  const MatrixXd y = direction_sums<1>(basis, directions, blocks(count),
                                       coordinates.at(directions, weights.value).transpose());
  VectorXd numbers_in_place = VectorXd::Zero(first);
  put_in_place(*this, weights, count,
               [&](int i, int place, double size) { numbers_in_place[place] = y(i, 0) * size; });
  return numbers_in_place;
}

Eigen::MatrixX4d CompressedTable::look_up_slopes(const ShapeWeights& weights, int first) const {
  const int count = count_of(first);
  Eigen::Matrix4Xd x(4, directions);
  x.row(0) = coordinates.at(directions, weights.value).transpose();
  for (int a = 0; a < 3; ++a)
    x.row(1 + a) = coordinates.at(directions, weights.slope[a]).transpose();
  const MatrixXd y = direction_sums<4>(basis, directions, blocks(count), x);
  Eigen::MatrixX4d in_place = Eigen::MatrixX4d::Zero(first, 4);
  put_in_place(*this, weights, count, [&](int i, int place, double size) {
    for (int a = 0; a < 4; ++a) in_place(place, a) = size * y(i, a);
    for (int a = 0; a < 2; ++a)
      in_place(place, 1 + a) += 0.5 * exponents[2 * i + a] * in_place(place, 0);
  });
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
        std::clamp(static_cast<int>(std::lround(2 * p)), -most_power, most_power));
  };
  return {rounded(x[1]), rounded(x[2])};
}

namespace {

// Of the columns `columns` of `values`: directions that leave no number of a column of the share 1
// with a rest above `tolerance`, and their coordinates.
struct Directions {
  MatrixXd basis, coordinates;
};
Directions directions_of(const MatrixXd& values, const VectorXd& share, double tolerance) {
  const int shapes = static_cast<int>(values.cols());
  const MatrixXd scaled = values * share.asDiagonal();
  // the left singular vectors, by those of VᵀV
  const MatrixXd V = SymmetricEigen(scaled.transpose() * scaled).eigenvectors().rowwise().reverse();
  MatrixXd rest = scaled;
  int directions = 0;
  while (directions < shapes && (directions == 0 || rest.cwiseAbs().maxCoeff() > tolerance)) {
    const int more = std::min(8, shapes - directions);
    const MatrixXd W = V.middleCols(directions, more);
    rest.noalias() -= (rest * W) * W.transpose();
    directions += more;
  }
  return {scaled * V.leftCols(directions),
          V.leftCols(directions).transpose() * share.cwiseInverse().asDiagonal()};
}

}  // namespace

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
  const Directions found = directions_of(values.topRows(numbers), share, tolerance);
  const Eigen::Index directions = found.basis.cols();
  made.numbers = static_cast<int>(numbers);
  made.directions = static_cast<int>(directions);
  constexpr Eigen::Index block = CompressedTable::block;
  made.basis.resize(static_cast<std::size_t>(CompressedTable::blocks(made.numbers) * block) *
                    static_cast<std::size_t>(directions));
  for (Eigen::Index i = 0; i < numbers;
       ++i) {  // to whole numbers, the unit of each row in its size
    const double unit = whole_unit<std::int16_t>(found.basis.row(i));
    made.sizes.push_back(static_cast<float>(sizes[static_cast<std::size_t>(i)] * unit));
    for (Eigen::Index k = 0; k < directions; ++k)
      made.basis[static_cast<std::size_t>((i / block * directions + k) * block + i % block)] =
          static_cast<std::int16_t>(std::lround(found.basis(i, k) / unit));
  }
  made.coordinates = MadeCoordinates(found.coordinates);
  return made;
}

}  // namespace flexopt
