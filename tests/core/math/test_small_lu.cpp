// Small systems: the product with the solution is the right side.
#include <catch2/catch.hpp>

#include "core/math/small_lu.hpp"

using namespace flexopt;

namespace {

template <int n>
void check_solution(const Eigen::Matrix<double, n, n>& A) {
  const SmallLu<n> lu(A);
  Eigen::Matrix<double, n, Eigen::Dynamic> B(n, 4);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 4; ++j) B(i, j) = std::sin(1.0 + 3 * i + 7 * j);
  const auto X = lu.solve_columns(B);
  CHECK((A * X - B).norm() < 1e-13 * A.norm() * X.norm());
  for (int j = 0; j < 4; ++j)
    CHECK((lu.solve(B.col(j)) - X.col(j)).norm() < 1e-13 * A.norm() * X.norm());
}

}  // namespace

TEST_CASE("a small system is solved whatever the order of its rows") {
  Matrix3d A;
  A << 0, 2, 1, 3, 0, 1e-9, 1, 5, 0;  // no pivot on the diagonal
  check_solution<3>(A);
  Matrix6d B;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) B(i, j) = std::cos(2.0 + i * j + 5 * i + 0.3 * j);
  B.diagonal().setZero();
  check_solution<6>(B);
}
