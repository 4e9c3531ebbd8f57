#include "core/reduction/tube/pattern_rows.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

namespace flexopt {
namespace {

constexpr int in_register = 8;  // rows in a register
using RowSingles = float __attribute__((vector_size(4 * in_register)));
using RowDoubles = double __attribute__((vector_size(8 * in_register)));

RowDoubles row_doubles(const float* from) {
  RowSingles x;
  std::memcpy(&x, from, sizeof x);
  return __builtin_convertvector(x, RowDoubles);
}

constexpr int product_columns = 4;
using RowSums = std::array<std::array<RowDoubles, 2>, product_columns>;

// Of a block of rows.
RowSums block_times(const float* rows, Eigen::Index patterns,
                    const std::array<const double*, product_columns>& columns) {
  RowSums sums{};
  for (Eigen::Index k = 0; k < patterns; ++k) {
    const RowDoubles low = row_doubles(rows + 2 * in_register * k),
                     high = row_doubles(rows + 2 * in_register * k + in_register);
    for (int j = 0; j < product_columns; ++j) {
      sums[j][0] += low * columns[j][k];
      sums[j][1] += high * columns[j][k];
    }
  }
  return sums;
}

}  // namespace

PatternRows::PatternRows(const MatrixXd& P)
    : rows_(P.rows()),
      patterns_(P.cols()),
      numbers_(static_cast<std::size_t>((rows_ + block - 1) / block * block * patterns_), 0.0F) {
  static_assert(block == 2 * in_register);
  for (Eigen::Index k = 0; k < patterns_; ++k)
    for (Eigen::Index i = 0; i < rows_; ++i)
      numbers_[static_cast<std::size_t>((i / block * patterns_ + k) * block + i % block)] =
          static_cast<float>(P(i, k));
}

MatrixXd PatternRows::times(Eigen::Index first, Eigen::Index count, const MatrixXd& A) const {
  assert(first >= 0 && first + count <= rows_ && A.rows() == patterns_ && A.cols() > 0);
  MatrixXd product(count, A.cols());
  for (Eigen::Index c = 0; c < A.cols(); c += product_columns) {
    std::array<const double*, product_columns> columns{};
    for (int j = 0; j < product_columns; ++j)
      columns[static_cast<std::size_t>(j)] = A.col(std::min(c + j, A.cols() - 1)).data();
    for (Eigen::Index at = first / block * block; at < first + count; at += block) {
      const RowSums sums = block_times(numbers_.data() + at * patterns_, patterns_, columns);
      const Eigen::Index begin = std::max(at, first), end = std::min(at + block, first + count);
      for (int j = 0; j < product_columns && c + j < A.cols(); ++j)
        for (Eigen::Index i = begin; i < end; ++i)
          product(i - first, c + j) =
              sums[static_cast<std::size_t>(j)][static_cast<std::size_t>((i - at) / in_register)]
                  [(i - at) % in_register];
    }
  }
  return product;
}

}  // namespace flexopt
