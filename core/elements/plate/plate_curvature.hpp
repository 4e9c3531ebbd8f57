#pragma once
// The cubic part of the bending energy of a curved leaf,
//
//     U = Σ c a1 · (a2 × a3)
//
// over the bending points of an element: a1 = r,x, a2 = r,y and a3 a combination of second
// derivatives. Equations (L2), (L3) of core/elements/README.md. The rows of a field are a1 at all
// points, then a2, then a3.
#include "core/elements/plate/plate_mesh.hpp"
#include "core/math/jet.hpp"

namespace flexopt::plate {

template <class S>
using CurvatureField = Eigen::Matrix<S, Eigen::Dynamic, 3>;

/// c (a_l × b_m + b_l × a_m) against a_k, for k, l, m = 1, 2, 3 in turn: the second derivative of U
/// times a and b. ∂U/∂a is half of that of a and a.
template <class A, class B>
CurvatureField<typename A::Scalar> curvature_product(const Eigen::ArrayXd& c, const A& a,
                                                     const B& b) {
  const Eigen::Index n = c.size();
  CurvatureField<typename A::Scalar> result(3 * n, 3);
  for (Eigen::Index g = 0; g < n; ++g)
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::Index l = g + (k + 1) % 3 * n, m = g + (k + 2) % 3 * n;
      for (int x = 0; x < 3; ++x) {
        const int y = (x + 1) % 3, z = (x + 2) % 3;
        result(g + k * n, x) =
            c[g] * (a(l, y) * b(m, z) - a(l, z) * b(m, y) + b(l, y) * a(m, z) - b(l, z) * a(m, y));
      }
    }
  return result;
}

/// The field of nodal values, the leading columns of `rows` being those of its functions.
template <class U>
auto curvature_field(const MatrixXd& rows, const U& nodal) {
  const auto by = rows.leftCols(nodal.rows());
  Eigen::Matrix<typename U::Scalar, Eigen::Dynamic, Eigen::Dynamic> a(rows.rows(), nodal.cols());
  if constexpr (std::is_same_v<typename U::Scalar, double>)
    a.noalias() = by * nodal;
  else
    for (int o = 0; o < 3; ++o) coefficients(a, o) = by * MatrixXd(coefficients(nodal, o));
  return a;
}

/// What stands against the nodal values: the transposed map.
template <class F>
auto curvature_force(const MatrixXd& rows, Eigen::Index functions, const F& field) {
  const auto by = rows.leftCols(functions).transpose();
  Eigen::Matrix<typename F::Scalar, Eigen::Dynamic, Eigen::Dynamic> f(functions, field.cols());
  if constexpr (std::is_same_v<typename F::Scalar, double>)
    f.noalias() = by * field;
  else
    for (int o = 0; o < 3; ++o) coefficients(f, o) = by * MatrixXd(coefficients(field, o));
  return f;
}

}  // namespace flexopt::plate
