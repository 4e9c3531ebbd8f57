#include "core/elements/leaf/chord_edges.hpp"

#include "core/elements/leaf/chord_path.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

using chord::edge_turn;

EdgePoses chord_edges(const Vector6d& e) {
  return {EdgePose{Vector3d::Zero(), rotation_exp(edge_turn(0) * e)},
          EdgePose{{1 + e[elongation], 0, 0}, rotation_exp(edge_turn(1) * e)}};
}

Rows12x6 chord_edge_map(const Vector6d& e) {
  Rows12x6 G = Rows12x6::Zero();
  G(6, elongation) = 1;
  for (int a = 0; a < 2; ++a)
    G.middleRows<3>(6 * a + 3) = rotation_left_tangent(edge_turn(a) * e) * edge_turn(a);
  return G;
}

Matrix6d chord_edge_curvature(const Vector6d& e, const Vector12d& f) {
  Matrix6d H = Matrix6d::Zero();
  for (int a = 0; a < 2; ++a) {
    const Vector3d theta = edge_turn(a) * e, moment = f.segment<3>(6 * a + 3);
    Matrix3d C;  // by polarisation of the quadratic form moment · ω′
    for (int i = 0; i < 3; ++i) C(i, i) = moment.dot(spin_rate(theta, Vector3d::Unit(i)));
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < i; ++j) {
        const double both = moment.dot(spin_rate(theta, Vector3d::Unit(i) + Vector3d::Unit(j)));
        C(i, j) = C(j, i) = 0.5 * (both - C(i, i) - C(j, j));
      }
    H += edge_turn(a).transpose() * C * edge_turn(a);
  }
  return H;
}

}  // namespace flexopt
