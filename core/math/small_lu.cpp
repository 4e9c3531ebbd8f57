#include "core/math/small_lu.hpp"

namespace flexopt {

template <int n>
SmallLu<n>::SmallLu(const Matrix& A) : lu_(A) {}

template <int n>
typename SmallLu<n>::Vector SmallLu<n>::solve(const Vector& b) const {
  return lu_.solve(b);
}

template <int n>
typename SmallLu<n>::Columns SmallLu<n>::solve_columns(const Columns& B) const {
  return lu_.solve(B);
}

template class SmallLu<3>;
template class SmallLu<6>;

}  // namespace flexopt
