#include "core/equilibrium/edge_compliance.hpp"

#include <array>

#include "core/math/decompositions.hpp"

namespace flexopt {

MatrixXd EdgeCompliance::edges(int leaf, const MatrixXd& motions) const {
  MatrixXd moved(12, motions.cols());
  for (Eigen::Index k = 0; k < moved.cols(); ++k)
    moved.col(k) = system_->edge_increment(leaf, motions.col(k));
  return moved;
}

void EdgeCompliance::look() {
  motions_.emplace(*system_, true);
  stable_ = system_->negative_pivots() + motions_->negative_pivots() == 0;
  if (!stable_) return;
  const MatrixXd E = system_->drive_forces();
  const Eigen::Index drives = E.cols();
  common_.drive_stiffness.resize(drives, drives);
  common_.drive_loads = common_.parts_of_load = common_.parts_of_stiffness = VectorXd::Zero(drives);
  strokes_.resize(system_->size(), drives);
  if (drives == 0) return;
  const MatrixXd answers = FreeMotions(*system_, false).answer(E);
  const MatrixXd stiffness = Lu(MatrixXd(E.transpose() * answers)).inverse();
  common_.drive_stiffness = 0.5 * (stiffness + stiffness.transpose());
  strokes_.noalias() = answers * stiffness;
  for (Eigen::Index k = 0; k < drives; ++k) common_.drive_loads[k] = system_->drive_load(k);
  for (int i = 0; i < system_->leaves(); ++i) {
    const LeafEvaluation& leaf = system_->leaf(i).evaluation();
    const MatrixXd moved = edges(i, strokes_);
    common_.parts_of_load += (moved.transpose() * leaf.force).cwiseAbs();
    common_.parts_of_stiffness +=
        moved.cwiseProduct(leaf.tangent * moved).colwise().sum().cwiseAbs();
  }
}

std::optional<EdgeSurroundings> EdgeCompliance::of(int leaf) {
  if (!motions_) look();
  if (!stable_) return std::nullopt;
  const LeafSpring& spring = system_->mechanism().leaves[leaf];
  const std::array<int, 2> body{spring.base, spring.tip};
  MatrixXd forces = MatrixXd::Zero(system_->size(), 12);
  for (int e = 0; e < 2; ++e)
    if (body[e] >= 0)
      forces.block<6, 6>(6 * body[e], 6 * e) = system_->edge_map(leaf, e).transpose();
  EdgeSurroundings of = common_;
  const Matrix12d C = forces.transpose() * motions_->answer(forces);
  of.compliance = 0.5 * (C + C.transpose());
  of.strokes = edges(leaf, strokes_);
  return of;
}

}  // namespace flexopt
