#include "core/response/path/branch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <utility>

#include "core/response/models/leaf_models.hpp"
#include "core/response/path/full_finish.hpp"

namespace flexopt {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<std::unique_ptr<LeafElement>> make_leaves(const Mechanism& mechanism,
                                                      const ModelOptions& model,
                                                      const StrokeRequest& request) {
  if (model.accuracy == Accuracy::full) return make_full_leaves(mechanism, model);
  double largest = 0;
  for (const double s : request.points) largest = std::max(largest, std::abs(s));
  if (request.load_path)
    return make_reduced_leaves(mechanism, model, std::nullopt,
                               request.load + largest * *request.load_path);
  return make_reduced_leaves(mechanism, model, largest, request.load);
}

using Solve = std::function<Equilibrium()>;

// Where no equilibrium is found with reduced leaves, full ones take over.
Equilibrium solve_again_on_full_leaves(System& system, const Solve& solve,
                                       Equilibrium equilibrium) {
  bool replaced = false;
  for (int i = 0; i < system.leaves(); ++i)
    if (auto full = system.leaf(i).full_model("no equilibrium with reduced leaves")) {
      system.replace_leaf(i, std::move(full));
      replaced = true;
    }
  return replaced ? solve() : equilibrium;
}

// Solves, then again as long as a leaf of limited range wants its model changed.
Equilibrium solve_refined(System& system, const Solve& solve) {
  Equilibrium equilibrium = solve();
  if (!equilibrium.converged)
    equilibrium = solve_again_on_full_leaves(system, solve, std::move(equilibrium));
  for (int round = 0; equilibrium.converged && round < 8; ++round) {
    bool changed = false;
    for (int i = 0; i < system.leaves(); ++i) {
      LeafElement::Refinement refinement = system.leaf(i).refine();
      changed |= refinement.changed;
      if (refinement.replacement) system.replace_leaf(i, std::move(refinement.replacement));
    }
    if (!changed) break;
    system.invalidate();  // a tube has grown or was replaced
    const int before = equilibrium.iterations;
    equilibrium = solve();
    equilibrium.iterations += before;
  }
  return equilibrium;
}

// The system on its way outward.
class Branch {
 public:
  Branch(const Mechanism& mechanism, const ModelOptions& model, const StrokeRequest& request)
      : request_(&request), system_(mechanism, make_leaves(mechanism, model, request)) {}

  System& system() { return system_; }

  // The dead load that stays, without stroke.
  Equilibrium apply_load() {
    return solve_refined(system_, [&] {
      return request_->load_path ? follow_load(request_->load)
                                 : step_load(system_, request_->load, request_->newton);
    });
  }

  // To a stroke, or to a factor of the load path.
  Equilibrium advance(double stroke) {
    return solve_refined(system_, [&] {
      return request_->load_path ? follow_load(request_->load + stroke * *request_->load_path)
                                 : step_to(system_, stroke, request_->load, request_->newton);
    });
  }

 private:
  Equilibrium follow_load(const Vector6d& load) {
    const Equilibrium reached = step_free_load(system_, present_, load, request_->newton);
    if (reached.converged) present_ = load;
    return reached;
  }

  const StrokeRequest* request_;
  System system_;
  Vector6d present_ = Vector6d::Zero();  ///< dead load reached, where nothing is driven
};

}  // namespace

void follow_branch(const Mechanism& mechanism, const ModelOptions& model,
                   const StrokeRequest& request, const std::vector<int>& order,
                   DifferentiablePath* differentiable, StrokeResponse& response) {
  auto start = Clock::now();
  Branch branch(mechanism, model, request);
  response.seconds_coefficients += seconds_since(start);
  start = Clock::now();

  PointOutputs outputs(mechanism, model, request, differentiable);
  const bool reduced_leads = differentiable && model.accuracy == Accuracy::reduced &&
                             model.method == Reduction::mixed_potential;
  std::optional<std::string> lost;  // why the path has ended
  if (!request.load.isZero())
    if (const Equilibrium loaded = branch.apply_load(); !loaded.converged) lost = loaded.message;
  for (const int k : order) {
    PathPoint& point = response.path[k];
    if (lost) {
      point.message = *lost;
      continue;
    }
    Equilibrium equilibrium = branch.advance(point.stroke);
    std::unique_ptr<System> full;
    if (reduced_leads && equilibrium.converged)
      full = finish_on_full_leaves(branch.system(), model, request, point.stroke, equilibrium);
    if (!equilibrium.converged) {
      point.status = PointStatus::no_equilibrium;
      point.message = equilibrium.message;
      point.newton_iterations = equilibrium.iterations;
      lost = fmt::format("the path ended before: {}", equilibrium.message);
      continue;
    }
    const bool gradients = differentiable && !differentiable->directions.empty();
    outputs.evaluate(full ? *full : branch.system(), equilibrium, point,
                     gradients ? &differentiable->gradients.path[k] : nullptr);
  }
  response.seconds_path += seconds_since(start);
}

}  // namespace flexopt
