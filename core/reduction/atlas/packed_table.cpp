#include "core/reduction/atlas/packed_table.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace flexopt {

MatrixXd PackedTable::look_up(const ShapeWeights& weights) const {
  const MatrixXd x = coordinates.at(directions, weights);
  const int blocks = CompressedTable::blocks(numbers), first = coarse_directions();
  const MatrixXd y = direction_sums(coarse, first, blocks, x.leftCols(first));
  MatrixXd z = MatrixXd::Zero(y.rows(), y.cols());  // tables of few directions have no fine ones
  if (fine_directions() > 0)
    z = direction_sums(fine, fine_directions(), blocks, x.rightCols(fine_directions()));
  MatrixXd found = MatrixXd::Zero(all, y.cols());
  for (Eigen::Index j = 0; j < y.cols(); ++j)
    for (int i = 0; i < numbers; ++i)
      found(places[i], j) = sizes[i].value() * y(i, j) + sizes[numbers + i].value() * z(i, j);
  return found;
}

PackedNumbers pack(MatrixXd values, const VectorXd& weights, double tolerance) {
  constexpr double negligible = 0.3;  // of the tolerance: such a number is left out
  assert(values.rows() == weights.size() && values.rows() <= 65536);
  PackedNumbers made;
  made.all = static_cast<int>(values.rows());
  made.shapes = static_cast<int>(values.cols());
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    if (weights[i] * values.row(i).cwiseAbs().maxCoeff() < negligible * tolerance) continue;
    values.row(static_cast<Eigen::Index>(made.places.size())) = weights[i] * values.row(i);
    made.places.push_back(static_cast<std::uint16_t>(i));
  }
  made.numbers = static_cast<int>(made.places.size());
  const auto kept = values.topRows(made.numbers);
  const MatrixXd V = leading_directions(kept, tolerance, 4), basis = kept * V;
  made.directions = static_cast<int>(V.cols());

  const int coarse = made.table().coarse_directions(), fine = made.table().fine_directions();
  const auto rows =
      static_cast<std::size_t>(CompressedTable::blocks(made.numbers) * direction_block);
  made.coarse.resize(rows * static_cast<std::size_t>(coarse));
  made.fine.resize(rows * static_cast<std::size_t>(fine));
  made.sizes.resize(2 * made.places.size());
  for (Eigen::Index i = 0; i < made.numbers; ++i) {
    const auto put = [i](const auto& row, auto& numbers) {
      using Whole = typename std::decay_t<decltype(numbers)>::value_type;
      const ShortNumber unit(whole_unit<Whole>(row));
      put_row(numbers, i, row, unit.value());
      return unit;
    };
    const auto row = static_cast<std::size_t>(i);
    const double per_weight = 1 / weights[made.places[row]];
    const VectorXd all = per_weight * basis.row(i).transpose();
    made.sizes[row] = put(all.head(coarse), made.coarse);
    made.sizes[made.places.size() + row] = put(all.tail(fine), made.fine);
  }
  made.coordinates = MadeCoordinates(V.transpose());
  return made;
}

}  // namespace flexopt
