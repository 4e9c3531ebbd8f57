#include <fmt/format.h>

#include <cmath>

#include "core/response/stability/branch_tracer.hpp"

namespace flexopt {
namespace {

// How far just below and just above a factor are, over the way to it.
constexpr double trial_margin = 1e-3;
// The load is put on in so many steps; the shortest step, over the way.
constexpr int trial_steps = 10;
constexpr double least_trial_step = 1e-5;
// Motion of the bodies over that of the same step before, where it leads to another branch.
constexpr double most_jump = 4;

// Places and rotations of the bodies, lengths over the longest leaf.
VectorXd places(const System& system) {
  VectorXd all(2 * static_cast<Eigen::Index>(system.size()));
  for (int b = 0; 12 * b < all.size(); ++b) {
    const JointBody& pose = system.pose(b);
    all.segment<3>(12 * b) = pose.position / system.length();
    all.segment<9>(12 * b + 3) = Eigen::Map<const VectorXd>(pose.rotation.data(), 9);
  }
  return all;
}

}  // namespace

bool BranchTracer::stands_within() const {
  LoadBranch& branch = *branch_;
  return branch.negative_pivots() == 0 && (!limit_ || limit_(branch.system()) <= 0);
}

BranchTracer::Trial BranchTracer::put_on(const LoadBranch::State& begin, double factor) {
  branch_->restore(begin);
  Trial trial{branch_->factor(), {}};
  const double way = factor - branch_->factor(),
               margin =
                   trial_margin * std::copysign(std::max(std::abs(way), std::abs(factor)), way);
  const double below = std::abs(way) > std::abs(margin) ? factor - margin : trial.stable_to;
  const double longest = way / trial_steps;
  double step = longest;
  while (std::abs(below - trial.stable_to) > 1e-9 * std::abs(way)) {
    const LoadBranch::State kept = branch_->save();
    const bool ends = std::abs(below - trial.stable_to) <= std::abs(step);
    const double next = ends ? below : trial.stable_to + step;
    if (branch_->advance_to(next) && stands_within()) {
      trial.stable_to = next;
      if (std::abs(step) < std::abs(longest)) step *= 2;
      continue;
    }
    branch_->restore(kept);
    step /= 2;
    if (std::abs(step) > least_trial_step * std::abs(way)) continue;
    trial.doubt = fmt::format(
        "the branch was followed to {}, but put on step by step the load has no stable equilibrium "
        "within its limits beyond {}",
        shown(factor), shown(trial.stable_to));
    return trial;
  }
  if (at_limit_) return trial;
  // another branch beyond a singular state is farther away than a step on this one
  const LoadBranch::State under = branch_->save();
  const VectorXd here = places(branch_->system());
  if (!branch_->advance_to(below - 2 * margin)) {
    branch_->restore(under);
    return trial;
  }
  const double usual = (here - places(branch_->system())).norm();
  branch_->restore(under);
  const double above = factor + margin;
  if (branch_->advance_to(above) && stands_within() &&
      (places(branch_->system()) - here).norm() < most_jump * usual) {
    trial.stable_to = above;
    trial.doubt = fmt::format("the branch was followed to {}, but it goes on, stable, to {}",
                              shown(factor), shown(above));
  }
  return trial;
}

}  // namespace flexopt
