#include "core/response/stability/load_branch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/equilibrium/newton_equations.hpp"
#include "core/equilibrium/stroke_path.hpp"
#include "core/math/work_limit.hpp"

namespace flexopt {
namespace {

// One load alone grows; those that were growing stand still.
LoadCase with_growing(LoadCase loads, DeadLoad one, double growing) {
  for (DeadLoad still : loads.growing) {
    still.force *= growing;
    still.moment *= growing;
    loads.constant.push_back(std::move(still));
  }
  loads.growing = {std::move(one)};
  return loads;
}

// One of the constant loads alone grows.
LoadCase with_growing(LoadCase loads, std::size_t load, double growing) {
  DeadLoad one = loads.constant[load];
  loads.constant.erase(loads.constant.begin() + static_cast<std::ptrdiff_t>(load));
  return with_growing(std::move(loads), std::move(one), growing);
}

}  // namespace

LoadBranch::LoadBranch(System& system, LoadCase loads, double factor, DriveState drive,
                       const VectorXd& drive_loads, const NewtonOptions& options)
    : drive_(drive), strokes_(present_strokes(system)), options_(options) {
  system_ = system.on_full_leaves(std::move(loads));
  apply(factor);
  drive_forces_ = VectorXd::Zero(system.size());
  if (drive == DriveState::free)
    for (std::size_t k = 0; k < system.drives().size(); ++k)
      if (const auto& coordinate = system.drives()[k].coordinate;
          coordinate && !system.holds(k, DriveHold::named))
        drive_forces_[*coordinate] = drive_loads[static_cast<Eigen::Index>(k)];
  system_->assemble();
}

LoadBranch::LoadBranch(System& system, std::size_t load, double growing, DriveState drive,
                       const VectorXd& drive_loads, const NewtonOptions& options)
    : LoadBranch(system, with_growing(system.loads(), load, growing), 1, drive, drive_loads,
                 options) {}

LoadBranch::LoadBranch(System& system, const DeadLoad& more, double growing, DriveState drive,
                       const VectorXd& drive_loads, const NewtonOptions& options)
    : LoadBranch(system, with_growing(system.loads(), more, growing), 0, drive, drive_loads,
                 options) {}

BodyLoad LoadBranch::named() const {
  return acting_loads(system_->loads(), {.growing = 1}, system_->mechanism()).front();
}

VectorXd LoadBranch::load() const {
  VectorXd forces = forces_of({named()}, system_->poses());
  for (const int k : system_->held()) forces[k] = 0;
  return forces;
}

int LoadBranch::negative_pivots() const { return flexopt::negative_pivots(*system_, locked()); }

void LoadBranch::restore(const State& state) {
  system_->restore(state);
  system_->assemble();
}

void LoadBranch::apply(double factor) {
  LoadFactors factors = system_->load_factors();
  factors.growing = factor;
  system_->apply(factors);
}

Check LoadBranch::advance(const BranchDirection& along, double size, double weight) {
  const State kept = save();
  system_->move(size * along.bodies);
  apply(factor() + size * along.factor);
  system_->assemble();
  const VectorXd weights = (weight * system_->units().cwiseInverse()).cwiseAbs2();
  Check met = correct({along.bodies.cwiseProduct(weights), along.factor});
  if (!met) restore(kept);
  return met;
}

Check LoadBranch::advance_to(double factor) {
  return advance({VectorXd::Zero(system_->size()), 1}, factor - this->factor(), 0);
}

// The equations of Newton's method with the factor λ of the load P as one unknown more and the
// direction across which the branch is met as one row more: [… −P; c 0 0 c_λ].
Check LoadBranch::correct(const BranchDirection& across) {
  System& system = *system_;
  const int n = system.size();
  NewtonEquations equations(system, locked(), 1);  // drives free: but for those that stay held
  const int last = equations.behind();
  const VectorXd& scale = equations.scale();
  double previous = 0;
  for (int it = 0;; ++it) {
    count_iteration();
    VectorXd residual = system.load() + drive_forces_ - system.internal_force();
    for (const int k : system.held()) residual[k] = 0;
    equations.assemble(residual, strokes_);
    SparseMatrix& A = equations.matrix();
    // the factor in units that make its column as large as the others
    const VectorXd P = scale.cwiseProduct(load());
    const double unit = equations.energy() / std::max(P.cwiseAbs().maxCoeff(), 1e-300);
    const VectorXd border = scale.cwiseProduct(across.bodies);
    const double border_size =
        std::max(border.cwiseAbs().maxCoeff(), std::abs(across.factor * unit));
    for (int d = 0; d < n; ++d) {
      A.add(d, last, -P[d] * unit);
      A.add(last, d, border[d] / border_size);
    }
    A.add(last, last, across.factor * unit / border_size);
    const VectorXd x = equations.solve();
    const double step = equations.step(x),
                 of_factor = std::abs(x[last] * unit) / std::max(1.0, std::abs(factor()));
    const double size =
        std::max({step, system.correction(), of_factor, 1e4 * equations.violation()});
    if (!std::isfinite(size)) return Because("Newton met a singular tangent");
    const bool stalled = it > 1 && size < 1e-6 && size > 0.3 * previous;
    if (it > 0 && (size < options_.tolerance || stalled)) return {};
    if (step > 2 || it == options_.max_iterations)
      return Because(fmt::format("Newton stopped after {} iterations: step {:.1e} > {:.1e}", it,
                                 size, options_.tolerance));
    previous = size;
    system.move(equations.motion(x));
    if (equations.conditions() > 0) system.add_to_multipliers(equations.multipliers(x));
    apply(factor() + unit * x[last]);
    system.assemble();
  }
}

}  // namespace flexopt
