#pragma once
// Rank and dependent rows of a sparse matrix, by a rank-revealing QR whose cost is that of its
// factor R, in the order of the rows.
#include <utility>
#include <vector>

#include "core/math/sparse_matrix.hpp"

namespace flexopt {

struct DependentRows {
  int rank = 0;
  /// One list for each row that is a combination of others: those rows with their factors (row,
  /// factor), then the row itself with the factor −1. Their sums are zero, and they span all such
  /// sums. Of rows that repeat each other, the last one counts as dependent.
  std::vector<std::vector<std::pair<int, double>>> sums;
};

/// A row counts as dependent where what those before it leave of it is shorter than `tolerance`
/// times its own length. A row without entries depends on no other.
DependentRows dependent_rows(int rows, int columns, const std::vector<SparseEntry>& entries,
                             double tolerance);

/// The rank alone.
int rank_of(int rows, int columns, const std::vector<SparseEntry>& entries, double tolerance);

}  // namespace flexopt
