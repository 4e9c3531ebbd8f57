#pragma once
// Rows of a matrix P of single numbers, of which products with a few columns are wanted again and
// again.
#include <vector>

#include "core/math/types.hpp"
#include "core/math/wide.hpp"

namespace flexopt {

class PatternRows {
 public:
  /// The numbers of P are stored in single precision.
  explicit PatternRows(const MatrixXd& P);

  Eigen::Index rows() const { return rows_; }
  Eigen::Index patterns() const { return patterns_; }
  /// `count` rows of P from `first` on, times A; sums are double.
  MatrixXd times(Eigen::Index first, Eigen::Index count, const MatrixXd& A) const;
  /// A row of P, pattern by pattern, as it was given.
  const double* row(Eigen::Index i) const { return by_rows_.col(i).data(); }

  static constexpr Eigen::Index block = 2 * wide;  ///< rows that stand together, pattern by pattern

 private:
  template <int columns, int blocks>
  void add_times(Eigen::Index first, Eigen::Index count, const MatrixXd& A, Eigen::Index column,
                 MatrixXd& product) const;

  Eigen::Index rows_, patterns_;
  std::vector<float> numbers_;
  MatrixXd by_rows_;  ///< Pᵀ
};

}  // namespace flexopt
