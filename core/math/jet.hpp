#pragma once
// Numbers along a path as scalars of Eigen: c[0] + c[1] s + c[2] s², cut off after s². What is
// written for any scalar becomes a series by them.
#include <cmath>
#include <concepts>
#include <type_traits>

#include "core/math/series.hpp"
#include "core/math/small_product.hpp"
#include "core/math/types.hpp"

namespace flexopt {

struct Jet {
  Series<double> c{};

  Jet() = default;
  Jet(double value) : c{value, 0, 0} {}
  Jet(double c0, double c1, double c2) : c{c0, c1, c2} {}

  Jet& operator+=(const Jet& b) {
    for (int o = 0; o < 3; ++o) c[o] += b.c[o];
    return *this;
  }
  Jet& operator-=(const Jet& b) {
    for (int o = 0; o < 3; ++o) c[o] -= b.c[o];
    return *this;
  }
  Jet& operator*=(const Jet& b) {
    c = {c[0] * b.c[0], c[0] * b.c[1] + c[1] * b.c[0],
         c[0] * b.c[2] + c[1] * b.c[1] + c[2] * b.c[0]};
    return *this;
  }
  Jet& operator*=(double b) {
    for (double& x : c) x *= b;
    return *this;
  }
  /// Division by a number that is not zero at the start of the path.
  Jet& operator/=(const Jet& b) {
    c[0] /= b.c[0];
    c[1] = (c[1] - c[0] * b.c[1]) / b.c[0];
    c[2] = (c[2] - c[0] * b.c[2] - c[1] * b.c[1]) / b.c[0];
    return *this;
  }

  friend Jet operator-(Jet a) { return a *= -1.0; }
  friend Jet operator+(Jet a, const Jet& b) { return a += b; }
  friend Jet operator-(Jet a, const Jet& b) { return a -= b; }
  friend Jet operator*(Jet a, const Jet& b) { return a *= b; }
  friend Jet operator*(Jet a, double b) { return a *= b; }
  friend Jet operator*(double a, Jet b) { return b *= a; }
  friend Jet operator/(Jet a, const Jet& b) { return a /= b; }
  friend bool operator==(const Jet&, const Jet&) = default;
  /// Square root of a number that is positive at the start of the path.
  friend Jet sqrt(const Jet& a) {
    const double root = std::sqrt(a.c[0]), rate = 0.5 * a.c[1] / root;
    return {root, rate, 0.5 * (a.c[2] - rate * rate) / root};
  }
};

}  // namespace flexopt

namespace Eigen {

template <>
struct NumTraits<flexopt::Jet> : GenericNumTraits<flexopt::Jet> {
  using Real = flexopt::Jet;
  using NonInteger = flexopt::Jet;
  using Nested = flexopt::Jet;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 3,
    AddCost = 3,
    MulCost = 9
  };
};

template <class Op>
struct ScalarBinaryOpTraits<flexopt::Jet, double, Op> {
  using ReturnType = flexopt::Jet;
};
template <class Op>
struct ScalarBinaryOpTraits<double, flexopt::Jet, Op> {
  using ReturnType = flexopt::Jet;
};

}  // namespace Eigen

namespace flexopt {

/// The coefficients of one order, in place; the entries of A must lie in columns one after another.
template <class Derived>
auto coefficients(Eigen::MatrixBase<Derived>& A, int order) {
  static_assert(std::same_as<typename Derived::Scalar, Jet>);
  using Step = Eigen::Stride<Eigen::Dynamic, 3>;
  return Eigen::Map<MatrixXd, 0, Step>(&A.derived().coeffRef(0, 0).c[order], A.rows(), A.cols(),
                                       Step(3 * A.derived().outerStride(), 3));
}
template <class Derived>
auto coefficients(const Eigen::MatrixBase<Derived>& A, int order) {
  static_assert(std::same_as<typename Derived::Scalar, Jet>);
  using Step = Eigen::Stride<Eigen::Dynamic, 3>;
  return Eigen::Map<const MatrixXd, 0, Step>(&A.derived().coeffRef(0, 0).c[order], A.rows(),
                                             A.cols(), Step(3 * A.derived().outerStride(), 3));
}

/// Matrix of jets from a series of matrices.
template <class Dense>
Eigen::Matrix<Jet, Dense::RowsAtCompileTime, Dense::ColsAtCompileTime> jets(
    const Series<Dense>& series) {
  Eigen::Matrix<Jet, Dense::RowsAtCompileTime, Dense::ColsAtCompileTime> A(series[0].rows(),
                                                                           series[0].cols());
  for (Eigen::Index j = 0; j < A.cols(); ++j)
    for (Eigen::Index i = 0; i < A.rows(); ++i)
      A(i, j) = {series[0](i, j), series[1](i, j), series[2](i, j)};
  return A;
}

/// C = A B of a small matrix A of numbers, by the orders where B has them.
template <class C, class A, class B>
void assign_product(C& c, const A& a, const B& b) {
  if constexpr (std::same_as<typename B::Scalar, double>) {
    assign_small_product(c, a, b);
  } else {
    c.resize(a.rows(), b.cols());
    for (int o = 0; o < 3; ++o) {
      auto of_order = coefficients(c, o);
      assign_small_product(of_order, a, coefficients(b, o));
    }
  }
}

/// Applies a linear map to a matrix, order by order where A is one of jets.
template <class S, class Map>
Eigen::MatrixX<S> by_orders(const Eigen::MatrixX<S>& A, const Map& map) {
  if constexpr (std::same_as<S, double>) {
    return map(A);
  } else {
    Series<MatrixXd> B;
    for (int o = 0; o < 3; ++o) B[o] = map(MatrixXd(coefficients(A, o)));
    return jets(B);
  }
}

/// Series of matrices from a matrix of jets.
template <int Rows, int Columns>
Series<Eigen::Matrix<double, Rows, Columns>> series(const Eigen::Matrix<Jet, Rows, Columns>& A) {
  Series<Eigen::Matrix<double, Rows, Columns>> result;
  for (int o = 0; o < 3; ++o) result[o] = coefficients(A, o);
  return result;
}

/// rotation_exp() along a path of rotation vectors, |θ| < π.
Matrix3<Jet> jet_rotation_exp(const Vector3<Jet>& theta);

}  // namespace flexopt
