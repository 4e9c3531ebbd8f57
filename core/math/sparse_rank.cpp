#include "core/math/sparse_rank.hpp"

#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>

namespace flexopt {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

// Aᵀ, each column over its length.
Sparse transposed(int columns, const std::vector<SparseEntry>& given,
                  const std::vector<double>& lengths) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(given.size());
  for (const SparseEntry& e : given) {
    const double length = lengths[static_cast<std::size_t>(e.row)];
    if (e.value != 0 && length != 0) entries.emplace_back(e.column, e.row, e.value / length);
  }
  Sparse A(columns, static_cast<Eigen::Index>(lengths.size()));
  A.setFromTriplets(entries.begin(), entries.end());
  A.makeCompressed();
  return A;
}

// Lengths of the rows.
std::vector<double> lengths_of(int rows, const std::vector<SparseEntry>& entries) {
  std::vector<double> lengths(static_cast<std::size_t>(rows), 0.0);
  for (const SparseEntry& e : entries)
    lengths[static_cast<std::size_t>(e.row)] += e.value * e.value;
  for (double& length : lengths) length = std::sqrt(length);
  return lengths;
}

}  // namespace

// The columns of Aᵀ, in their order, are columns of Q times those of R = [R1 R2]. Those of R2
// depend on those of R1, with the factors R1⁻¹ R2.
DependentRows dependent_rows(int rows, int columns, const std::vector<SparseEntry>& entries,
                             double tolerance) {
  DependentRows result;
  if (rows == 0) return result;
  const std::vector<double> lengths = lengths_of(rows, entries);
  Eigen::SparseQR<Sparse, Eigen::NaturalOrdering<int>> qr;
  qr.setPivotThreshold(tolerance);
  qr.compute(transposed(columns, entries, lengths));
  const Eigen::Index rank = qr.rank();
  result.rank = static_cast<int>(rank);
  const Sparse R = Eigen::SparseMatrix<double, Eigen::RowMajor>(qr.matrixR());  // sorted by the way
  const auto original = [&](Eigen::Index k) { return qr.colsPermutation().indices()[k]; };
  std::vector<double> x(static_cast<std::size_t>(rank));
  for (Eigen::Index d = rank; d < rows; ++d) {
    std::fill(x.begin(), x.end(), 0.0);
    for (Sparse::InnerIterator e(R, d); e; ++e)
      if (e.row() < rank) x[static_cast<std::size_t>(e.row())] = e.value();
    const double own = lengths[static_cast<std::size_t>(original(d))];
    std::vector<std::pair<int, double>> sum;
    for (Eigen::Index k = rank - 1; k >= 0; --k) {
      double& factor = x[static_cast<std::size_t>(k)];
      if (factor == 0) continue;
      factor /= R.coeff(k, k);
      for (Sparse::InnerIterator e(R, k); e; ++e)
        if (e.row() < k) x[static_cast<std::size_t>(e.row())] -= e.value() * factor;
      const int of = original(k);
      sum.emplace_back(of, factor * own / lengths[static_cast<std::size_t>(of)]);
    }
    sum.emplace_back(original(d), -1.0);
    result.sums.push_back(std::move(sum));
  }
  return result;
}

int rank_of(int rows, int columns, const std::vector<SparseEntry>& entries, double tolerance) {
  if (rows == 0) return 0;
  Eigen::SparseQR<Sparse, Eigen::COLAMDOrdering<int>> qr;
  qr.setPivotThreshold(tolerance);
  qr.compute(transposed(columns, entries, lengths_of(rows, entries)));
  return static_cast<int>(qr.rank());
}

}  // namespace flexopt
