#include "core/equilibrium/free_motions.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "core/math/decompositions.hpp"

namespace flexopt {

FreeMotions::FreeMotions(const System& system, DriveHold held) : system_(&system), held_(held) {
  if (!system.analyses()) make_basis();
}

void FreeMotions::make_basis() {
  const System& system = *system_;
  const int n = system.size();
  const Constraints& c = system.constraints();
  const VectorXd& units = system.units();
  std::vector<int> fixed = system.held();
  for (const int k : system.driven_coordinates(held_)) fixed.push_back(k);
  const std::vector<int> holding = system.holding_conditions(held_);
  const auto conditions = static_cast<Eigen::Index>(holding.size());
  if (conditions == 0) {  // coordinates
    std::vector<int> kept;
    for (int k = 0; k < n; ++k)
      if (std::ranges::find(fixed, k) == fixed.end()) kept.push_back(k);
    basis_ = MatrixXd(units.asDiagonal())(Eigen::all, kept);
    return;
  }
  MatrixXd rows = MatrixXd::Zero(conditions + static_cast<Eigen::Index>(fixed.size()), n);
  rows.topRows(conditions) = (c.units().cwiseInverse().asDiagonal() * c.gradient() *
                              units.asDiagonal())(holding, Eigen::all);
  Eigen::Index row = conditions;
  for (const int k : fixed) rows(row++, k) = 1;
  basis_ = units.asDiagonal() * null_space_of_transpose(rows.transpose(), 1e-9);
}

int FreeMotions::count() const {
  return system_->analyses() ? system_->size() - rank_of_conditions(*system_, held_)
                             : static_cast<int>(basis_.cols());
}

std::array<bool, 6> FreeMotions::still(int body) const {
  std::array<bool, 6> still{};
  std::vector<int> coordinates;
  for (int d = 0; d < 6; ++d) coordinates.push_back(6 * body + d);
  if (system_->analyses()) {
    const std::vector<bool> found = still_coordinates(*system_, held_, coordinates);
    std::ranges::copy(found, still.begin());
  } else {
    for (const int k : coordinates)
      still[k - 6 * body] = !(basis_.row(k).norm() > 1e-9 * system_->units()[k]);
  }
  return still;
}

namespace {
// Unit diagonal: translations and rotations differ by many orders of magnitude.
MatrixXd scaled(const MatrixXd& K, bool symmetric, VectorXd& s) {
  s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return s.asDiagonal() * (symmetric ? MatrixXd(0.5 * (K + K.transpose())) : K) * s.asDiagonal();
}
}  // namespace

MatrixXd FreeMotions::answer(const MatrixXd& forces) const {
  if (system_->analyses()) return TangentFactor(*system_, held_).answer(forces);
  if (count() == 0) return MatrixXd::Zero(basis_.rows(), forces.cols());
  VectorXd s;
  const MatrixXd K =
      scaled(basis_.transpose() * (system_->tangent() * basis_), !system_->follows(), s);
  const MatrixXd F = s.asDiagonal() * (basis_.transpose() * forces);
  return basis_ * (s.asDiagonal() * Lu(K).solve(F));
}

int FreeMotions::negative_pivots() const {
  if (system_->analyses() && !system_->follows()) {
    if (const std::optional<int> negative = negative_pivots_sparse(*system_, held_))
      return *negative;
  }
  if (!system_->analyses()) return negative_eigenvalues();
  FreeMotions dense(*this);  // a pivot is zero, or the tangent not symmetric
  dense.make_basis();
  return dense.negative_eigenvalues();
}

int FreeMotions::negative_eigenvalues() const {
  if (basis_.cols() == 0) return 0;
  VectorXd s;
  const MatrixXd K =
      scaled(basis_.transpose() * (system_->tangent() * basis_), !system_->follows(), s);
  if (system_->follows()) return Lu(K).determinant() < 0 ? 1 : 0;
  const VectorXd values = symmetric_eigenvalues(K);
  // a motion without stiffness has a zero of either sign
  return static_cast<int>((values.array() < -1e-13 * values.cwiseAbs().maxCoeff()).count());
}

}  // namespace flexopt
