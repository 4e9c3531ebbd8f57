#include "core/math/sparse_matrix.hpp"

namespace flexopt {

void SparseMatrix::add(const BlockMatrix& A, const VectorXd& left, const VectorXd& right) {
  A.for_each([&](int r, int c, const Matrix6d& block) {
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 6; ++i)
        add(6 * r + i, 6 * c + j, left[6 * r + i] * block(i, j) * right[6 * c + j]);
  });
}

void SparseMatrix::release(const std::vector<int>& rows) {
  if (rows.empty()) return;
  std::vector<bool> released(static_cast<std::size_t>(size_), false);
  for (const int row : rows) released[row] = true;
  for (SparseEntry& e : entries_)
    if (released[e.row] || released[e.column]) e.value = 0;
  for (const int row : rows) add(row, row, 1);
}

MatrixXd SparseMatrix::dense() const {
  MatrixXd A = MatrixXd::Zero(size_, size_);
  for (const SparseEntry& e : entries_) A(e.row, e.column) += e.value;
  return A;
}

}  // namespace flexopt
