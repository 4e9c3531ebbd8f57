#pragma once
// Products of gradients and stresses at the membrane points of an element, for any scalar.
#include "core/elements/plate/plate_mesh_rate.hpp"

namespace flexopt::plate {

constexpr int points = PlateMesh::points;
using PointArray = Eigen::Array<double, points, 1>;
template <class S>
using Gradient = Eigen::Matrix<S, 16, 3>;
template <class S>
using Stress = Eigen::Array<S, points, 3>;

// a b of gradients at the points: (a1·b1, a2·b2, a1·b2 + a2·b1).
template <class A, class B>
Stress<typename A::Scalar> strain_product(const A& a, const B& b) {
  Stress<typename A::Scalar> e = Stress<typename A::Scalar>::Zero();
  for (int c = 0; c < 3; ++c) {
    const auto a1 = a.col(c).template head<points>().array(),
               a2 = a.col(c).template tail<points>().array();
    const auto b1 = b.col(c).template head<points>().array(),
               b2 = b.col(c).template tail<points>().array();
    e.col(0) += a1 * b1;
    e.col(1) += a2 * b2;
    e.col(2) += a1 * b2 + a2 * b1;
  }
  return e;
}

template <class S>
Stress<S> stress_of(const PlateMesh::Membrane& A, const Stress<S>& e) {
  Stress<S> n;
  n.col(0) = A.A11 * e.col(0) + A.A12 * e.col(1);
  n.col(1) = A.A12 * e.col(0) + A.A11 * e.col(1);
  n.col(2) = A.A33 * e.col(2);
  return n;
}

template <class S>
Stress<S> weighted(const Stress<S>& n, const PlateMesh::Weights& w) {
  Stress<S> result;
  for (int c = 0; c < 3; ++c) result.col(c) = n.col(c) * w.col(c);
  return result;
}

// Σ n_ab r,b: the force conjugate to r,a.
template <class S, class A>
Gradient<S> stress_times(const Stress<S>& n, const A& a) {
  Gradient<S> s;
  for (int c = 0; c < 3; ++c) {
    const auto a1 = a.col(c).template head<points>().array(),
               a2 = a.col(c).template tail<points>().array();
    s.col(c).template head<points>() = n.col(0) * a1 + n.col(2) * a2;
    s.col(c).template tail<points>() = n.col(2) * a1 + n.col(1) * a2;
  }
  return s;
}

template <class S>
S sum(const Stress<S>& a, const Stress<S>& b) {
  return (a * b).sum();
}

// Nodal values of an element: functions × columns.
template <int Side, class Matrix>
Eigen::Matrix<typename Matrix::Scalar, 2 * Side, Eigen::Dynamic> gather(const Matrix& low,
                                                                        const Matrix& high, int j) {
  Eigen::Matrix<typename Matrix::Scalar, 2 * Side, Eigen::Dynamic> U(2 * Side, low.cols());
  U << low.template middleRows<Side>(4 * j), high.template middleRows<Side>(4 * j);
  return U;
}

// Stress times weight of strains that a changed metric of the undeflected leaf leaves.
template <class S>
Stress<S> metric_stress(const PlateMesh& mesh, const PointArray& metric,
                        const PlateMesh::Weights& weight) {
  Stress<S> e = Stress<S>::Zero();
  for (int g = 0; g < points; ++g) e(g, 0) = -0.5 * metric[g];
  return weighted(stress_of(mesh.membrane(), e), weight);
}

/// An undeflected element with its present strains and stresses.
template <class S>
struct DeflectedElement {
  int index = 0;
  const PlateMesh::Element& operators;
  const Gradient<S>& a0;
  const Stress<S>&strain, &stress;   ///< stress times weight
  const Eigen::MatrixX<S>& natural;  ///< of a curved leaf
};

inline bool changes(const PlateMesh::Membrane& rate) {
  return rate.A11 != 0 || rate.A12 != 0 || rate.A33 != 0;
}

// Change of the stress times weight at constant strains.
template <class S>
Stress<S> stress_rate(const PlateMesh& mesh, const PlateMeshRate::Shape& by,
                      const DeflectedElement<S>& e, const Stress<S>& strain) {
  Stress<S> n = Stress<S>::Zero();
  if (changes(by.membrane)) n = weighted(stress_of(by.membrane, strain), e.operators.weight);
  if (!by.weight.empty()) n += weighted(stress_of(mesh.membrane(), strain), by.weight[e.index]);
  return n;
}

}  // namespace flexopt::plate
