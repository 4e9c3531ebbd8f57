#pragma once
// Products of dense matrices of numbers, compiled once. Eigen builds the product of two matrices
// anew for every pair of expressions that it meets (blocks, transposes, multiples, …), which took
// half of the time that the mechanics took to compile. Here all of them lead to one function that
// sees numbers and strides; it computes by Eigen's own kernels.
//
// This stands on the place where Eigen 3.4 chooses its kernels (generic_product_impl), as Eigen's
// own use of a BLAS does. Products of small fixed size stay with Eigen.
#include <Eigen/Core>
#include <type_traits>

static_assert(EIGEN_WORLD_VERSION == 3 && EIGEN_MAJOR_VERSION == 4,
              "dense_products.hpp stands on internals of Eigen 3.4");

namespace flexopt::dense {

/// Numbers of a matrix in memory.
template <class Number>
struct Strided {
  Number* data;
  Eigen::Index rows, cols, row_step, col_step;  ///< steps from a row or a column to the next
};

enum class Write { set, add };

/// c = factor a b, or c += factor a b. c must share no memory with a or b.
void multiply(const Strided<double>& c, Write write, double factor, const Strided<const double>& a,
              const Strided<const double>& b);

template <class Number, class Matrix>
Strided<Number> strided(Number* data, const Matrix& a) {
  const Eigen::Index inner = a.innerStride(), outer = a.outerStride();
  if constexpr (Matrix::IsRowMajor) return {data, a.rows(), a.cols(), outer, inner};
  return {data, a.rows(), a.cols(), inner, outer};
}

}  // namespace flexopt::dense

namespace Eigen::internal {

/// What Eigen asks of the product of two expressions: c = a b and the like.
template <class Lhs, class Rhs>
struct product_of_numbers {
  using Scalar = double;

  template <class Dst>
  static void evalTo(Dst& c, const Lhs& a, const Rhs& b) {
    run(c, flexopt::dense::Write::set, 1, a, b);
  }
  template <class Dst>
  static void addTo(Dst& c, const Lhs& a, const Rhs& b) {
    run(c, flexopt::dense::Write::add, 1, a, b);
  }
  template <class Dst>
  static void subTo(Dst& c, const Lhs& a, const Rhs& b) {
    run(c, flexopt::dense::Write::add, -1, a, b);
  }
  template <class Dst>
  static void scaleAndAddTo(Dst& c, const Lhs& a, const Rhs& b, const double& factor) {
    run(c, flexopt::dense::Write::add, factor, a, b);
  }

 private:
  template <class Dst>
  static void run(Dst& c, flexopt::dense::Write write, double factor, const Lhs& a, const Rhs& b) {
    using flexopt::dense::strided;
    using L = blas_traits<Lhs>;
    using R = blas_traits<Rhs>;
    // the matrix of a multiple; evaluated where its numbers do not lie in memory
    const typename L::DirectLinearAccessType lhs = L::extract(a);
    const typename R::DirectLinearAccessType rhs = R::extract(b);
    flexopt::dense::multiply(strided(c.data(), c), write,
                             factor * L::extractScalarFactor(a) * R::extractScalarFactor(b),
                             strided(lhs.data(), lhs), strided(rhs.data(), rhs));
  }
};

template <class Lhs, class Rhs>
concept MatricesOfNumbers =
    std::is_same_v<typename Lhs::Scalar, double> && std::is_same_v<typename Rhs::Scalar, double>;

template <class Lhs, class Rhs>
requires MatricesOfNumbers<Lhs, Rhs>
struct generic_product_impl<Lhs, Rhs, DenseShape, DenseShape, GemmProduct>
    : product_of_numbers<Lhs, Rhs> {
};
template <class Lhs, class Rhs>
requires MatricesOfNumbers<Lhs, Rhs>
struct generic_product_impl<Lhs, Rhs, DenseShape, DenseShape, GemvProduct>
    : product_of_numbers<Lhs, Rhs> {
};

}  // namespace Eigen::internal
