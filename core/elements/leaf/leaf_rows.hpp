#pragma once
// The layout of a leaf's vectors once its edges are held by bodies.
#include <array>

#include "core/math/rotation.hpp"
#include "core/math/types.hpp"

namespace flexopt {

/// (internal unknowns of PlateLeaf, force at the material point if there is one, increments of the
/// base body (displacement of its reference point, spin) and of the tip body, displacement of the
/// point's body). Leaf axes, lengths over L. The row of the point's force is its condition.
struct LeafRows {
  int unknowns = 0;
  int point = 0;  ///< 3 with a material point
  /// Present vector from the reference point of each body to the middle of its edge; zero where
  /// grounded.
  std::array<Vector3d, 2> lever{Vector3d::Zero(), Vector3d::Zero()};

  int internal() const { return unknowns + point; }
  int body(int edge) const { return internal() + 6 * edge; }
  int point_body() const { return internal() + 12; }
  int size() const { return internal() + 12 + point; }

  /// Rows (unknowns, increments of the edges), as PlateLeaf has them, from rows of the bodies.
  MatrixXd edge_rows(const MatrixXd& Y) const {
    MatrixXd T(unknowns + 12, Y.cols());
    T << Y.topRows(unknowns), Y.middleRows(internal(), 12);
    for (int e = 0; e < 2; ++e)
      T.middleRows(unknowns + 6 * e, 3) -= hat(lever[e]) * Y.middleRows(body(e) + 3, 3);
    return T;
  }
  /// Rows of forces on the bodies from forces T on the edges.
  MatrixXd body_rows(const MatrixXd& T) const {
    MatrixXd Y = MatrixXd::Zero(size(), T.cols());
    Y.topRows(unknowns) = T.topRows(unknowns);
    Y.middleRows(internal(), 12) = T.bottomRows(12);
    for (int e = 0; e < 2; ++e)
      Y.middleRows(body(e) + 3, 3) += hat(lever[e]) * T.middleRows(unknowns + 6 * e, 3);
    return Y;
  }
};

}  // namespace flexopt
