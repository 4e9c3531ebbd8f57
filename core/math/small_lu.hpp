#pragma once
// Eigen's linear equations of fixed small size, compiled once.
#include <Eigen/LU>

#include "core/math/types.hpp"

namespace flexopt {

/// A x = b with partial pivoting, n = 3 or 6.
template <int n>
class SmallLu {
 public:
  using Matrix = Eigen::Matrix<double, n, n>;
  using Vector = Eigen::Matrix<double, n, 1>;
  using Columns = Eigen::Matrix<double, n, Eigen::Dynamic>;

  explicit SmallLu(const Matrix& A);
  Vector solve(const Vector& b) const;
  Columns solve_columns(const Columns& B) const;

 private:
  Eigen::PartialPivLU<Matrix> lu_;
};

extern template class SmallLu<3>;
extern template class SmallLu<6>;

}  // namespace flexopt
