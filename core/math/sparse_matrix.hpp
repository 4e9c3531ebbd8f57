#pragma once
// Matrices as lists of their entries.
#include <vector>

#include "core/math/block_matrix.hpp"

namespace flexopt {

/// An entry of a sparse matrix; entries at the same place are added.
struct SparseEntry {
  int row = 0, column = 0;
  double value = 0;
};

/// A square matrix. Entries that are zero count in its pattern: one that is assembled again the
/// same way has the same pattern.
class SparseMatrix {
 public:
  explicit SparseMatrix(int size) : size_(size) {}

  int size() const { return size_; }
  const std::vector<SparseEntry>& entries() const { return entries_; }

  void add(int row, int column, double value) { entries_.push_back({row, column, value}); }
  /// Adds diag(left) A diag(right) to the upper left part; its size is at least that of A.
  void add(const BlockMatrix& A, const VectorXd& left, const VectorXd& right);
  /// Sets rows and columns to those of the identity. Afterwards their diagonal has at least one
  /// entry.
  void release(const std::vector<int>& rows);

  MatrixXd dense() const;

 private:
  int size_;
  std::vector<SparseEntry> entries_;
};

}  // namespace flexopt
