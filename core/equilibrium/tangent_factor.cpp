#include "core/equilibrium/free_motions.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/math/sparse_rank.hpp"

namespace flexopt {
namespace {

// Unit diagonal: translations and rotations differ by many orders of magnitude. Bodies that hang on
// joints alone have no stiffness of their own: where there are conditions, one energy for all.
VectorXd scale_of(const System& system) {
  const Constraints& c = system.constraints();
  const VectorXd diagonal = system.tangent().diagonal();
  if (c.count() == 0) return diagonal.cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const VectorXd& unit = system.units();
  const double energy = diagonal.cwiseProduct(unit.cwiseAbs2()).cwiseAbs().maxCoeff();
  VectorXd scale(system.size() + c.count());
  scale << unit / std::sqrt(energy), std::sqrt(energy) * c.units().cwiseInverse();
  return scale;
}

// Rows that become rows of the identity, in addition to the held coordinates.
std::vector<int> released_rows(const System& system, DriveHold held) {
  std::vector<int> rows = system.driven_coordinates(held);
  for (std::size_t k = 0; k < system.drives().size(); ++k)
    if (const auto& row = system.drives()[k].condition; row && !system.holds(k, held))
      rows.push_back(system.size() + *row);
  return rows;
}

void add_conditions(const System& system, const VectorXd& scale, SparseMatrix& A) {
  const std::vector<Constraints::Row>& rows = system.constraints().rows();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const int row = system.size() + static_cast<int>(k);
    rows[k].each([&](int column, double value) {
      A.add(row, column, scale[row] * value * scale[column]);
      A.add(column, row, scale[column] * value * scale[row]);
    });
    A.add(row, row, 0);
  }
}

// Entries (coordinate, value) of each condition that holds, on both of its bodies, in scaled units.
using ScaledRow = std::vector<std::pair<int, double>>;
std::vector<ScaledRow> scaled_rows(const System& system, DriveHold held) {
  const Constraints& c = system.constraints();
  VectorXd unit = system.units();
  for (const int k : system.driven_coordinates(held)) unit[k] = 0;
  std::vector<ScaledRow> all;
  for (const int k : system.holding_conditions(held)) {
    ScaledRow& row = all.emplace_back();
    c.rows()[k].each(
        [&](int at, double value) { row.emplace_back(at, value * unit[at] / c.units()[k]); });
  }
  return all;
}

// Coordinates of bodies that cannot move.
std::vector<int> fixed_coordinates(const System& system, DriveHold held) {
  std::vector<int> fixed = system.held();
  std::ranges::copy(system.driven_coordinates(held), std::back_inserter(fixed));
  return fixed;
}

}  // namespace

TangentFactor::TangentFactor(const System& system, DriveHold held)
    : bodies_(system.size()), scale_(scale_of(system)) {
  SparseMatrix A(static_cast<int>(scale_.size()));
  A.add(system.tangent(), scale_, scale_);
  add_conditions(system, scale_, A);
  const std::vector<int> released = released_rows(system, held);
  A.release(released);
  solver_ = LinearSolver(A, system.analyses());
  still_ = system.held();
  still_.insert(still_.end(), released.begin(), released.end());
}

MatrixXd TangentFactor::solve(MatrixXd B) const {
  for (const int row : still_) B.row(row).setZero();
  return scale_.asDiagonal() * solver_.solve(MatrixXd(scale_.asDiagonal() * B));
}

MatrixXd TangentFactor::answer(const MatrixXd& forces) const {
  MatrixXd B = MatrixXd::Zero(scale_.size(), forces.cols());
  B.topRows(bodies_) = forces;
  return solve(std::move(B)).topRows(bodies_);
}

// Number of negative pivots by a sparse factorisation. With the conditions' squares added to K the
// bodies can be eliminated first: what hangs on joints alone has a pivot then. Every condition
// follows the later of its bodies, and has a negative pivot.
std::optional<int> negative_pivots_sparse(const System& system, DriveHold held) {
  const Constraints& c = system.constraints();
  const VectorXd scale = scale_of(system);
  const int n = system.size();
  SparseMatrix A(static_cast<int>(scale.size()));
  A.add(system.tangent(), scale, scale);
  add_conditions(system, scale, A);
  A.release(released_rows(system, held));
  const std::vector<ScaledRow> rows = scaled_rows(system, held);
  for (const ScaledRow& row : rows)
    for (const auto& [i, value] : row)
      for (const auto& [j, other] : row) A.add(i, j, value * other);

  std::vector<int> order;
  if (c.count() > 0) {
    std::vector<std::pair<int, int>> ties;
    for (const Constraints::Row& row : c.rows())
      if (row.body[0] >= 0 && row.body[1] >= 0) ties.emplace_back(row.body[0], row.body[1]);
    const std::vector<int> bodies = elimination_order(system.tangent(), ties);
    std::vector<std::size_t> place(bodies.size());
    for (std::size_t k = 0; k < bodies.size(); ++k) place[bodies[k]] = k;
    std::vector<std::vector<int>> after(bodies.size());
    for (int k = 0; k < c.count(); ++k) {
      std::size_t last = 0;
      for (const int b : c.rows()[k].body)
        if (b >= 0) last = std::max(last, place[b]);
      after[last].push_back(n + k);
    }
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      for (int d = 0; d < 6; ++d) order.push_back(6 * bodies[k] + d);
      order.insert(order.end(), after[k].begin(), after[k].end());
    }
  }
  const std::optional<int> negative = negative_eigenvalues(A, order, *system.analyses());
  if (!negative) return std::nullopt;
  return *negative - static_cast<int>(rows.size());
}

// e − Ψᵀ(ΨΨᵀ)⁻¹Ψ e from [1, Ψᵀ; Ψ, 0]: nothing is left of a coordinate that cannot move.
std::vector<bool> still_coordinates(const System& system, DriveHold held,
                                    const std::vector<int>& coordinates) {
  const std::vector<ScaledRow> rows = scaled_rows(system, held);
  const int n = system.size(), m = static_cast<int>(rows.size());
  const std::vector<int> fixed = fixed_coordinates(system, held);
  std::vector<bool> still;
  for (const int k : coordinates) still.push_back(std::ranges::find(fixed, k) != fixed.end());
  if (m == 0) return still;
  SparseMatrix A(n + m);
  for (int k = 0; k < n; ++k) A.add(k, k, 1);
  for (int k = 0; k < m; ++k) {
    for (const auto& [i, value] : rows[k]) {
      A.add(n + k, i, value);
      A.add(i, n + k, value);
    }
    A.add(n + k, n + k, 0);
  }
  MatrixXd unit = MatrixXd::Zero(n + m, coordinates.size());
  for (std::size_t k = 0; k < coordinates.size(); ++k) unit(coordinates[k], k) = 1;
  const MatrixXd left = LinearSolver(A, system.analyses()).solve(unit).topRows(n);
  for (std::size_t k = 0; k < coordinates.size(); ++k)
    still[k] = still[k] || !(left.col(k).norm() > 1e-9);
  return still;
}

int rank_of_conditions(const System& system, DriveHold held) {
  std::vector<SparseEntry> entries;
  int row = 0;
  for (const ScaledRow& scaled : scaled_rows(system, held)) {
    for (const auto& [i, value] : scaled) entries.push_back({row, i, value});
    ++row;
  }
  const int fixed = static_cast<int>(fixed_coordinates(system, held).size());
  return row == 0 ? fixed : fixed + rank_of(row, system.size(), entries, 1e-9);
}

}  // namespace flexopt
