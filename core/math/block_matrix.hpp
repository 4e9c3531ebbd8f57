#pragma once
// Square matrices over the coordinates (displacement, rotation) of bodies, of which only the blocks
// of bodies that something ties to each other differ from zero.
#include <utility>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// 6 × 6 blocks. Where there is block (a, b) there is block (b, a).
class BlockMatrix {
 public:
  explicit BlockMatrix(int bodies = 0) : rows_(static_cast<std::size_t>(bodies)) {}

  int bodies() const { return static_cast<int>(rows_.size()); }
  int size() const { return 6 * bodies(); }

  /// Block of two bodies; made, with zeros, where there was none. Not valid after another is made.
  Matrix6d& block(int row, int column);
  /// Sets all blocks to zero and keeps the pattern.
  void set_zero();
  /// Sets the rows of these coordinates, and with `columns` their columns, to those of the
  /// identity.
  void release(const std::vector<int>& coordinates, bool columns);

  double operator()(int row, int column) const;
  VectorXd diagonal() const;
  MatrixXd dense() const;
  /// A X, X: size × any number.
  MatrixXd operator*(const Eigen::Ref<const MatrixXd>& X) const;
  /// f(row of blocks, column of blocks, block) of every block, row by row.
  template <class F>
  void for_each(const F& f) const {
    for (int r = 0; r < bodies(); ++r)
      for (const auto& [c, at] : rows_[r]) f(r, c, blocks_[at]);
  }

 private:
  using Row = std::vector<std::pair<int, int>>;  ///< (column, place in blocks_), ascending
  int find(int row, int column) const;           ///< place, or −1
  int make(int row, int column);

  std::vector<Row> rows_;
  std::vector<Matrix6d> blocks_;
};

}  // namespace flexopt
