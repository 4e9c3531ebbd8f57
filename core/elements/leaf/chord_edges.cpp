#include "core/elements/leaf/chord_edges.hpp"

#include "core/elements/leaf/chord_frame.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

// Deformations that are the components of the rotation of an edge, and their factors.
constexpr int component[2][3] = {{twist, theta1y, theta1z}, {twist, theta2y, theta2z}};
constexpr double factor[2] = {-0.5, 0.5};  // of the twist

Vector3d rotation_of(const Vector6d& e, int edge) {
  return {factor[edge] * e[twist], e[component[edge][1]], e[component[edge][2]]};
}

}  // namespace

EdgePoses chord_edges(const Vector6d& e) {
  return {EdgePose{Vector3d::Zero(), rotation_exp(rotation_of(e, 0))},
          EdgePose{{1 + e[elongation], 0, 0}, rotation_exp(rotation_of(e, 1))}};
}

Rows12x6 chord_edge_map(const Vector6d& e) {
  Rows12x6 G = Rows12x6::Zero();
  G(6, elongation) = 1;
  for (int a = 0; a < 2; ++a) {
    const Matrix3d J = rotation_left_tangent(rotation_of(e, a));
    for (int c = 0; c < 3; ++c)
      G.block<3, 1>(6 * a + 3, component[a][c]) = (c == 0 ? factor[a] : 1.0) * J.col(c);
  }
  return G;
}

Matrix6d chord_edge_curvature(const Vector6d& e, const Vector12d& f) {
  Matrix6d H = Matrix6d::Zero();
  for (int a = 0; a < 2; ++a) {
    const Vector3d theta = rotation_of(e, a), moment = f.segment<3>(6 * a + 3);
    Matrix3d C;  // by polarisation of the quadratic form moment · ω′
    for (int i = 0; i < 3; ++i) C(i, i) = moment.dot(spin_rate(theta, Vector3d::Unit(i)));
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < i; ++j) {
        const double both = moment.dot(spin_rate(theta, Vector3d::Unit(i) + Vector3d::Unit(j)));
        C(i, j) = C(j, i) = 0.5 * (both - C(i, i) - C(j, j));
      }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        H(component[a][i], component[a][j]) +=
            (i == 0 ? factor[a] : 1.0) * (j == 0 ? factor[a] : 1.0) * C(i, j);
  }
  return H;
}

}  // namespace flexopt
