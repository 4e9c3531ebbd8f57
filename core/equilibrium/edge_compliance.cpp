#include "core/equilibrium/edge_compliance.hpp"

#include <array>

namespace flexopt {

std::optional<Matrix12d> EdgeCompliance::of(int leaf) {
  if (!motions_) {
    motions_.emplace(*system_, true);
    stable_ = system_->negative_pivots() + motions_->negative_pivots() == 0;
  }
  if (!stable_) return std::nullopt;
  const LeafSpring& spring = system_->mechanism().leaves[static_cast<std::size_t>(leaf)];
  const std::array<int, 2> body{spring.base, spring.tip};
  MatrixXd forces = MatrixXd::Zero(system_->size(), 12);
  for (int e = 0; e < 2; ++e)
    if (body[e] >= 0)
      forces.block<6, 6>(6 * body[e], 6 * e) = system_->edge_map(leaf, e).transpose();
  const Matrix12d C = forces.transpose() * motions_->answer(forces);
  return 0.5 * (C + C.transpose());
}

}  // namespace flexopt
