#include "core/reduction/tube/pattern_rows.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace flexopt {
namespace {

// Sums for a number of columns and of blocks of rows. They fill eight registers or more, so that
// one sum need not wait for another.
template <int columns, int blocks>
using RowSums = std::array<std::array<Wide, 2 * blocks>, columns>;

// `rows`: the first of the blocks, each of so many patterns.
template <int columns, int blocks>
RowSums<columns, blocks> block_times(const float* rows, Eigen::Index patterns,
                                     const std::array<const double*, columns>& A) {
  RowSums<columns, blocks> sums{};
  for (Eigen::Index k = 0; k < patterns; ++k)
    for (int b = 0; b < blocks; ++b)
      for (int half = 0; half < 2; ++half) {
        const Wide row = load_wide(rows + PatternRows::block * (b * patterns + k) + wide * half);
        for (int j = 0; j < columns; ++j) sums[j][2 * b + half] += row * A[j][k];
      }
  return sums;
}

}  // namespace

PatternRows::PatternRows(const MatrixXd& P)
    : rows_(P.rows()),
      patterns_(P.cols()),
      numbers_(static_cast<std::size_t>((rows_ + block - 1) / block * block * patterns_), 0.0F),
      by_rows_(P.transpose()) {
  for (Eigen::Index k = 0; k < patterns_; ++k)
    for (Eigen::Index i = 0; i < rows_; ++i)
      numbers_[static_cast<std::size_t>((i / block * patterns_ + k) * block + i % block)] =
          static_cast<float>(P(i, k));
}

template <int columns, int blocks>
void PatternRows::add_times(Eigen::Index first, Eigen::Index count, const MatrixXd& A,
                            Eigen::Index column, MatrixXd& product) const {
  std::array<const double*, columns> of{};
  for (int j = 0; j < columns; ++j)
    of[static_cast<std::size_t>(j)] = A.col(std::min(column + j, A.cols() - 1)).data();
  const auto put = [&](Eigen::Index at, const auto& sums, int b) {
    const Eigen::Index begin = std::max(at, first), end = std::min(at + block, first + count);
    for (int j = 0; j < columns && column + j < A.cols(); ++j)
      for (Eigen::Index i = begin; i < end; ++i)
        product(i - first, column + j) =
            sums[static_cast<std::size_t>(j)][static_cast<std::size_t>(2 * b + (i - at) / wide)]
                [(i - at) % wide];
  };
  Eigen::Index at = first / block * block;
  for (; at + blocks * block <= (rows_ + block - 1) / block * block && at < first + count;
       at += blocks * block) {
    const auto sums = block_times<columns, blocks>(numbers_.data() + at * patterns_, patterns_, of);
    for (int b = 0; b < blocks; ++b) put(at + b * block, sums, b);
  }
  for (; at < first + count; at += block)
    put(at, block_times<columns, 1>(numbers_.data() + at * patterns_, patterns_, of), 0);
}

MatrixXd PatternRows::times(Eigen::Index first, Eigen::Index count, const MatrixXd& A) const {
  assert(first >= 0 && first + count <= rows_ && A.rows() == patterns_ && A.cols() > 0);
  MatrixXd product(count, A.cols());
  for (Eigen::Index c = 0; c < A.cols();) {
    if (A.cols() - c > 2) {
      add_times<4, 1>(first, count, A, c, product);
      c += 4;
    } else {
      add_times<2, 2>(first, count, A, c, product);
      c += 2;
    }
  }
  return product;
}

}  // namespace flexopt
