#pragma once
// A leaf seen from its other end: tables of one bending ray serve the ray of the turned leaf.
#include "core/math/types.hpp"

namespace flexopt {

/// Which end of a leaf its tables call the base. Seen from the tip a leaf is turned by 180° about
/// its normal: base and tip, and so θ1y and θ2y, M1 and M2, change places. Where `mirrored`, it is
/// also seen in the mirror of its thickness.
struct TubeView {
  bool from_tip = false, mirrored = false;

  /// Signs that (v, ω) of the base, the rates of (θ1y, θ2y, φ) and those of (N, M1, M2) take after
  /// the ends have changed places.
  Eigen::Matrix<double, 12, 1> signs() const {
    Eigen::Matrix<double, 12, 1> s;
    if (!from_tip)
      s.setOnes();
    else if (mirrored)
      s << -1, -1, -1, 1, 1, 1, 1, 1, -1, 1, 1, 1;
    else
      s << -1, -1, 1, -1, -1, 1, -1, -1, 1, 1, 1, 1;
    return s;
  }

  /// Motion of stations, six rows each (of the place, of half the width across): as seen from the
  /// base, in its order.
  MatrixXd seen_from_base(const MatrixXd& stations) const {
    if (!from_tip) return stations;
    const Vector3d place = signs().head<3>(), across = -place;
    MatrixXd turned(stations.rows(), stations.cols());
    for (Eigen::Index i = 0; i < stations.rows(); i += 6) {
      const Eigen::Index from = stations.rows() - 6 - i;
      turned.middleRows<3>(i) = place.asDiagonal() * stations.middleRows<3>(from);
      turned.middleRows<3>(i + 3) = across.asDiagonal() * stations.middleRows<3>(from + 3);
    }
    return turned;
  }
};

}  // namespace flexopt
