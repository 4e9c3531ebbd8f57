#include "core/response/buckling/load_branch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/equilibrium/stroke_path.hpp"
#include "core/math/sparse_solver.hpp"

namespace flexopt {
namespace {

// The load alone grows; loads that were growing stand still.
LoadCase with_growing(const LoadCase& loads, std::size_t load, double growing) {
  LoadCase own = loads;
  own.constant.erase(own.constant.begin() + static_cast<std::ptrdiff_t>(load));
  for (DeadLoad still : loads.growing) {
    still.force *= growing;
    still.moment *= growing;
    own.constant.push_back(std::move(still));
  }
  own.growing = {loads.constant[load]};
  return own;
}

}  // namespace

LoadBranch::LoadBranch(System& system, std::size_t load, double growing, DriveState drive,
                       const VectorXd& drive_loads, const NewtonOptions& options)
    : drive_(drive), strokes_(present_strokes(system)), options_(options) {
  std::vector<std::unique_ptr<LeafElement>> leaves;
  State state = system.save();
  state.leaves.clear();
  state.factors.growing = 1;
  for (int i = 0; i < system.leaves(); ++i) {
    leaves.push_back(system.leaf(i).full_model({}));
    state.leaves.push_back(leaves.back()->save());
  }
  system_ = std::make_unique<System>(system.mechanism(), std::move(leaves),
                                     with_growing(system.loads(), load, growing));
  system_->restore(state);
  drive_forces_ = VectorXd::Zero(system.size());
  if (drive == DriveState::free)
    for (std::size_t k = 0; k < system.drives().size(); ++k)
      if (const auto& coordinate = system.drives()[k].coordinate)
        drive_forces_[*coordinate] = drive_loads[static_cast<Eigen::Index>(k)];
  system_->assemble();
}

BodyLoad LoadBranch::named() const {
  return acting_loads(system_->loads(), {.growing = 1}, system_->mechanism()).front();
}

VectorXd LoadBranch::load() const {
  std::vector<BodyPose> poses;
  for (int b = 0; b < system_->size() / 6; ++b) poses.push_back(system_->pose(b));
  VectorXd forces = forces_of({named()}, poses);
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

LoadBranch::Step LoadBranch::advance(const BranchDirection& along, double size, double weight) {
  const State kept = save();
  system_->move(size * along.bodies);
  apply(factor() + size * along.factor);
  system_->assemble();
  BranchDirection across = along;
  const double L = system_->length();
  for (int b = 0; b < system_->size(); b += 6) across.bodies.segment<3>(b) /= L * L;
  across.bodies *= weight * weight;
  Step step = correct(across);
  if (!step.converged) restore(kept);
  return step;
}

LoadBranch::Step LoadBranch::advance_to(double factor) {
  return advance({VectorXd::Zero(system_->size()), 1}, factor - this->factor(), 0);
}

// [K̃ −e Ψ_qᵀ −P; h 0 0 0; Ψ_q 0 0 0; c 0 0 c_λ] (dq, dF, dμ, dλ) = (load + F − f, s − stroke, −Ψ,
// 0), drives free: without dF, and dμ of their conditions zero.
LoadBranch::Step LoadBranch::correct(const BranchDirection& across) {
  System& system = *system_;
  const int n = system.size(), conditions = system.constraints().count();
  const double L = system.length();
  VectorXd scale = VectorXd::Ones(n);
  for (int b = 0; b < n; b += 6) scale.segment<3>(b).setConstant(L);
  std::vector<int> owned;  // drives of a coordinate
  if (locked())
    for (std::size_t k = 0; k < system.drives().size(); ++k)
      if (system.drives()[k].coordinate) owned.push_back(static_cast<int>(k));
  const int loads = static_cast<int>(owned.size()), first = n + loads, last = first + conditions;
  double previous = 0;
  for (int it = 0;; ++it) {
    const double energy =
        system.tangent().diagonal().cwiseProduct(scale.cwiseAbs2()).cwiseAbs().maxCoeff();
    SparseMatrix A(last + 1);
    VectorXd b = VectorXd::Zero(last + 1);
    A.add(system.residual_tangent(), scale, scale);
    b.head(n) = scale.cwiseProduct(system.load() + drive_forces_ - system.internal_force());
    for (const int k : system.held()) b[k] = 0;
    const MatrixXd H = stroke_gradients(system);
    const VectorXd present = present_strokes(system);
    const auto add_stroke = [&](int row, int k, double unit) {
      const Drive& drive = system.mechanism().drives[static_cast<std::size_t>(k)];
      for (const int body : {drive.body, drive.other})
        if (body >= 0)
          for (int d = 6 * body; d < 6 * body + 6; ++d) A.add(row, d, H(k, d) * scale[d] / unit);
      b[row] = (strokes_[k] - present[k]) / unit;
    };
    for (int j = 0; j < loads; ++j) {
      const int k = owned[static_cast<std::size_t>(j)];
      const int d = *system.drives()[static_cast<std::size_t>(k)].coordinate;
      A.add(d, n + j, -energy);
      add_stroke(n + j, k, scale[d]);
    }
    const Constraints& c = system.constraints();
    VectorXd reaction;
    double violation = 0;
    if (conditions > 0) reaction = energy * c.units().cwiseInverse();
    for (int j = 0; j < conditions; ++j) {
      const Constraints::Row& row = c.rows()[static_cast<std::size_t>(j)];
      const bool joint = j < c.joints();
      for (int e = 0; e < 2; ++e)
        for (int i = 0; i < 6 && row.body[e] >= 0; ++i) {
          const int d = 6 * row.body[e] + i;
          const double value = row.gradient[6 * e + i];
          A.add(d, first + j, scale[d] * value * reaction[j]);
          if (joint) A.add(first + j, d, value * scale[d] / c.units()[j]);
        }
      if (joint)
        b[first + j] = -c.value()[j] / c.units()[j];
      else if (locked())
        add_stroke(first + j, c.drives()[static_cast<std::size_t>(j - c.joints())], c.units()[j]);
      else
        A.add(first + j, first + j, 1);
      violation = std::max(violation, std::abs(b[first + j]));
    }
    // the factor in units that make its column as large as the others
    const VectorXd P = scale.cwiseProduct(load());
    const double unit = energy / std::max(P.cwiseAbs().maxCoeff(), 1e-300);
    VectorXd border = scale.cwiseProduct(across.bodies);
    const double border_size =
        std::max(border.cwiseAbs().maxCoeff(), std::abs(across.factor * unit));
    for (int d = 0; d < n; ++d) {
      A.add(d, last, -P[d] * unit);
      A.add(last, d, border[d] / border_size);
    }
    A.add(last, last, across.factor * unit / border_size);
    const VectorXd x = LinearSolver(A, system.analyses()).solve(b);
    const double step = x.head(n).cwiseAbs().maxCoeff(),
                 of_factor = std::abs(x[last] * unit) / std::max(1.0, std::abs(factor()));
    const double size = std::max({step, system.correction(), of_factor, 1e4 * violation});
    if (!std::isfinite(size)) return {false, "Newton met a singular tangent"};
    const bool stalled = it > 1 && size < 1e-6 && size > 0.3 * previous;
    if (it > 0 && (size < options_.tolerance || stalled)) return {true, {}};
    if (step > 2 || it == options_.max_iterations)
      return {false, fmt::format("Newton stopped after {} iterations: step {:.1e} > {:.1e}", it,
                                 size, options_.tolerance)};
    previous = size;
    system.move(scale.cwiseProduct(x.head(n)));
    if (conditions > 0)
      system.add_to_multipliers(reaction.cwiseProduct(x.segment(first, conditions)));
    apply(factor() + unit * x[last]);
    system.assemble();
  }
}

}  // namespace flexopt
