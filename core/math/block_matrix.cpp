#include "core/math/block_matrix.hpp"

#include <algorithm>

namespace flexopt {
namespace {
constexpr auto column_of = [](const std::pair<int, int>& entry) { return entry.first; };
}

int BlockMatrix::find(int row, int column) const {
  const Row& entries = rows_[row];
  const auto at = std::ranges::lower_bound(entries, column, {}, column_of);
  return at != entries.end() && at->first == column ? at->second : -1;
}

int BlockMatrix::make(int row, int column) {
  Row& entries = rows_[row];
  const auto at = std::ranges::lower_bound(entries, column, {}, column_of);
  const int place = static_cast<int>(blocks_.size());
  entries.insert(at, {column, place});
  blocks_.push_back(Matrix6d::Zero());
  return place;
}

Matrix6d& BlockMatrix::block(int row, int column) {
  int at = find(row, column);
  if (at < 0) {
    if (row != column) make(column, row);
    at = make(row, column);
  }
  return blocks_[at];
}

void BlockMatrix::set_zero() {
  for (Matrix6d& block : blocks_) block.setZero();
}

void BlockMatrix::release(const std::vector<int>& coordinates, bool columns) {
  for (const int k : coordinates) {
    const int b = k / 6, d = k % 6;
    for (const auto& [c, at] : rows_[b]) {
      blocks_[at].row(d).setZero();
      if (columns) blocks_[find(c, b)].col(d).setZero();
    }
    block(b, b)(d, d) = 1;
  }
}

double BlockMatrix::operator()(int row, int column) const {
  const int at = find(row / 6, column / 6);
  return at < 0 ? 0 : blocks_[at](row % 6, column % 6);
}

VectorXd BlockMatrix::diagonal() const {
  VectorXd result = VectorXd::Zero(size());
  for (int b = 0; b < bodies(); ++b)
    if (const int at = find(b, b); at >= 0) result.segment<6>(6 * b) = blocks_[at].diagonal();
  return result;
}

MatrixXd BlockMatrix::dense() const {
  MatrixXd result = MatrixXd::Zero(size(), size());
  for_each([&](int r, int c, const Matrix6d& block) { result.block<6, 6>(6 * r, 6 * c) = block; });
  return result;
}

MatrixXd BlockMatrix::operator*(const Eigen::Ref<const MatrixXd>& X) const {
  MatrixXd Y = MatrixXd::Zero(size(), X.cols());
  for_each([&](int r, int c, const Matrix6d& block) {
    Y.middleRows<6>(6 * r) += block.lazyProduct(X.middleRows<6>(6 * c));
  });
  return Y;
}

}  // namespace flexopt
