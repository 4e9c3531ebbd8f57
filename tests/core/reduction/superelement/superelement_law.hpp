#pragma once
// What the data of every superelement fulfil.
#include <catch2/catch.hpp>

#include "core/math/rotation.hpp"
#include "core/reduction/superelement/superelement.hpp"

namespace flexopt::bodies {

/// K and M are symmetric, boundary and vibration modes do not mix, rigid motions of the nodes have
/// no energy and carry the frame along.
inline void check_superelement(const SuperelementModel& model) {
  const int n = model.coordinates(), vibration = static_cast<int>(model.stiffness.rows()) - n;
  REQUIRE(model.nodes.size() >= 2);
  REQUIRE(vibration >= 0);
  REQUIRE(model.mass.rows() == n + vibration);
  REQUIRE(model.frame_modes.rows() == 6);
  REQUIRE(model.frame_modes.cols() == n);
  // lengths in units of the size, so that entries compare
  VectorXd unit = VectorXd::Ones(n + vibration);
  for (int a = 0; a < n; a += 6) unit.segment<3>(a).setConstant(model.size());
  const Vector6d unit6 = unit.head<6>();
  const MatrixXd K = unit.asDiagonal() * model.stiffness * unit.asDiagonal(),
                 M = unit.asDiagonal() * model.mass * unit.asDiagonal();
  CHECK((K - K.transpose()).norm() < 1e-9 * K.norm());
  CHECK((M - M.transpose()).norm() < 1e-9 * M.norm());
  CHECK(K.topRightCorner(n, vibration).norm() < 1e-9 * K.norm());
  MatrixXd rigid(n, 6);
  for (int a = 0; a < n; a += 6) {
    rigid.middleRows<6>(a).setIdentity();
    rigid.block<3, 3>(a, 3) = -hat(model.nodes[static_cast<std::size_t>(a / 6)]);
  }
  const MatrixXd scaled = unit.head(n).cwiseInverse().asDiagonal() * rigid * unit6.asDiagonal();
  CHECK((K.topLeftCorner(n, n) * scaled).norm() < 1e-7 * K.norm());
  const Matrix6d carried =
      unit6.cwiseInverse().asDiagonal() * (model.frame_modes * rigid) * unit6.asDiagonal();
  CHECK((carried - Matrix6d::Identity()).norm() < 1e-7);
}

}  // namespace flexopt::bodies
