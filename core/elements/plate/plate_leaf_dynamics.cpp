// Rates of the nodal values, mass and modes of a plate leaf with its edges held.
#include <utility>

#include "core/elements/plate/plate_leaf.hpp"
#include "core/math/lanczos.hpp"

namespace flexopt {

MatrixXd PlateLeaf::nodal_rates(int line, const MatrixXd& T) const {
  const int n = mesh_->functions_per_line();
  if (is_second_of_fold(line))
    return fold_jacobian_ * T.middleRows(block_offset(line), fold_unknowns());
  if (!is_rigid_edge(line)) return T.middleRows(block_offset(line), 3 * n);
  const int e = edge_of(line);
  const int m = mesh_->edge_unknowns();
  MatrixXd rates = edge_jacobian_[e].leftCols(m) * T.middleRows(block_offset(line), m);
  if (T.rows() == unknowns() + 12)
    rates.noalias() += edge_jacobian_[e].rightCols<6>() * T.middleRows(unknowns() + 6 * e, 6);
  return rates;
}

MatrixXd PlateLeaf::mass(const MatrixXd& T) const {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines();
  MatrixXd M = MatrixXd::Zero(T.cols(), T.cols());
  MatrixXd previous;
  for (int i = 0; i < lines; ++i) {
    MatrixXd rates = nodal_rates(i, T);
    for (int c = 0; c < 3; ++c) {
      const auto R = rates.middleRows(c * n, n);
      M.noalias() += R.transpose() * (mesh_->mass_diagonal(i) * R);
      if (i == 0) continue;
      const MatrixXd X = R.transpose() * (mesh_->mass_below(i - 1) * previous.middleRows(c * n, n));
      M += X + X.transpose();
    }
    previous = std::move(rates);
  }
  return M;
}

MatrixXd PlateLeaf::station_rates(const MatrixXd& T) const {
  const int n = mesh_->functions_per_line(), inner = mesh_->lines() - 2;
  const int middle = 4 * (mesh_->nodes_per_line() / 2);
  MatrixXd rates(6 * inner, T.cols());
  for (int i = 0; i < inner; ++i)
    for (int c = 0; c < 3; ++c) {
      const int row = block_offset(i + 1) + c * n + middle;
      rates.row(6 * i + c) = T.row(row);
      rates.row(6 * i + 3 + c) = 0.5 * mesh_->shape().width * T.row(row + 2);
    }
  return rates;
}

MatrixXd PlateLeaf::mass_times(const MatrixXd& V) const {
  const int n = mesh_->functions_per_line(), lines = mesh_->lines();
  const int m = static_cast<int>(V.cols());
  std::vector<MatrixXd> R(lines);  // functions × (3 components of each column)
  for (int i = 0; i < lines; ++i) R[i] = nodal_rates(i, V).reshaped(n, 3 * m);
  const bool edges = V.rows() == unknowns() + 12;
  MatrixXd result(V.rows(), m), F;
  if (edges) result.bottomRows(12).setZero();
  for (int i = 0; i < lines; ++i) {
    F.noalias() = mesh_->mass_diagonal(i) * R[i];
    if (i > 0) F.noalias() += mesh_->mass_below(i - 1) * R[i - 1];
    if (i + 1 < lines) F.noalias() += mesh_->mass_below(i).transpose() * R[i + 1];
    const auto rows = F.reshaped(3 * n, m);
    if (is_rigid_edge(i)) {
      const int u = mesh_->edge_unknowns();
      const MatrixXd& J = edge_jacobian_[edge_of(i)];
      result.middleRows(block_offset(i), u).noalias() = J.leftCols(u).transpose() * rows;
      if (edges)
        result.middleRows(unknowns() + 6 * edge_of(i), 6).noalias() =
            J.rightCols<6>().transpose() * rows;
    } else if (is_second_of_fold(i)) {
      result.middleRows(block_offset(i), fold_unknowns()).noalias() +=
          fold_jacobian_.transpose() * rows;
    } else {
      if (i == mesh_->fold_line()) result.middleRows(block_offset(i), fold_unknowns()).setZero();
      result.middleRows(block_offset(i), 3 * n) = rows;
    }
  }
  return result;
}

std::vector<PlateLeaf::Mode> PlateLeaf::modes(int count, double tolerance) const {
  std::vector<Mode> result;
  if (count == 0) return result;
  // a round or square wire bends in two planes alike
  const ModesWanted wanted{.count = count,
                           .negative = negative_pivots(),
                           .in_pairs = mesh_->shape().is_beam(),
                           .tolerance = tolerance};
  const LowestPairs pairs = lowest_modes(
      unknowns(), wanted,
      [this](MatrixXd X) {
        solve(X);
        return X;
      },
      [this](const MatrixXd& X) { return mass_times(X); });
  if (!pairs.converged) return result;
  for (int k = 0; k < static_cast<int>(pairs.values.size()); ++k)
    result.push_back({pairs.values[k], pairs.vectors.col(k)});
  return result;
}

}  // namespace flexopt
