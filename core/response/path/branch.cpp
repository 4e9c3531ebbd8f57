#include "core/response/path/branch_walk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/equilibrium/continuity.hpp"
#include "core/equilibrium/edge_compliance.hpp"
#include "core/math/work_limit.hpp"
#include "core/response/models/leaf_models.hpp"

namespace flexopt {

bool refine_leaves(System& system) {
  bool changed = false;
  EdgeCompliance compliance(system);
  for (int i = 0; i < system.leaves(); ++i) {
    LimitedRange* leaf = system.leaf(i).limited_range();
    if (!leaf) continue;
    LimitedRange::Refinement refinement = leaf->refine([&] { return compliance.of(i); });
    changed |= refinement.changed;
    if (refinement.replacement) system.replace_leaf(i, std::move(refinement.replacement));
  }
  if (changed) system.invalidate();  // a tube has grown or was replaced
  return changed;
}

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// At how many of the points reduced leaves are asked for their dynamics. Modes that are drawn need
// the leaves' own motions, which condensing gives.
int points_with_dynamics(const ModelOptions& model, const StrokeRequest& request,
                         std::size_t points, bool differentiable) {
  const bool asked = request.wants_frequencies() || request.wants_harmonic_answers() ||
                     (request.state_space && request.outputs.has(Output::state_space));
  const bool of_tables =
      model.mass == LeafMass::consistent &&
      (differentiable || (!request.outputs.has(Output::shapes) && model.leaf_modes > 0));
  return asked && of_tables ? static_cast<int>(points) : 0;
}

bool moves_poissons_ratio(const std::vector<Mechanism>& directions) {
  return std::ranges::any_of(directions, [](const Mechanism& direction) {
    return std::ranges::any_of(
        direction.leaves, [](const LeafSpring& leaf) { return leaf.material.poissons_ratio != 0; });
  });
}

std::vector<std::unique_ptr<LeafElement>> make_leaves(const Mechanism& mechanism,
                                                      const ModelOptions& model,
                                                      const StrokeRequest& request,
                                                      std::size_t points,
                                                      const DifferentiablePath* path) {
  const bool differentiable = path != nullptr;
  if (model.accuracy == Accuracy::full) return make_full_leaves(mechanism, model);
  double largest = 0;
  for (const double s : request.points) largest = std::max(largest, std::abs(s));
  std::vector<VectorXd> several;
  if (mechanism.drives.size() > 1)
    for (std::size_t k = 0; k < request.points.size(); ++k)
      several.push_back(request.strokes_at(k, mechanism.drives.size()));
  auto leaves = make_reduced_leaves(mechanism, model, largest, request.loads, several,
                                    path && moves_poissons_ratio(path->design.list));
  const int dynamics = points_with_dynamics(model, request, points, differentiable);
  // derivatives of leaves that have none of their own are those of full ones
  const auto wants_tables = [&](LeafElement& leaf) {
    return !differentiable || leaf.check_interior({});
  };
  if (dynamics > 0 && std::ranges::all_of(leaves, [&](const auto& l) { return wants_tables(*l); }))
    for (const auto& leaf : leaves) leaf->expect_dynamics(dynamics);
  return leaves;
}

bool has_limited_range(System& system) {
  for (int i = 0; i < system.leaves(); ++i)
    if (system.leaf(i).limited_range()) return true;
  return false;
}

constexpr const char* no_equilibrium = "no equilibrium with reduced leaves";
constexpr const char* unbelieved_crossing =
    "reduced leaves that are not believed lost their stability on the way";
constexpr const char* sharp_turn =
    "the way turns sharply, where what reduced leaves are off by may decide on the branch";

// Evaluates point k. Where exact modes and derivatives are wanted that the leaves do not have, full
// ones take over, which are returned; the equilibrium is then theirs.
std::unique_ptr<System> evaluate_point(System& system, const ModelOptions& model,
                                       const StrokeRequest& request, std::size_t k,
                                       bool differentiable, PointOutputs& outputs,
                                       Equilibrium& equilibrium, PathPoint& point,
                                       PointGradients* gradients) {
  const PathPoint before = point;
  Check good = differentiable ? check_interior(system, request, k, true) : Check();
  if (good) good = outputs.evaluate(system, equilibrium, k, point, gradients);
  if (good) good = check_reduced(system, point);
  if (good) return nullptr;
  point = before;
  auto full = finish_on_full_leaves(system, model, request, k, good, equilibrium);
  if (equilibrium.converged) outputs.evaluate(*full, equilibrium, k, point, gradients);
  return full;
}

}  // namespace

void BranchWalk::begin() {
  away_.reset();
  done_.clear();
  other_branch_.reset();
  lost_ = not_loaded_;
  bifurcation_passed_ = !under_loads_.empty();
  if (home_) {
    if (lost_.empty()) home_->return_home();
    return;
  }
  const auto start = Clock::now();
  home_ = std::make_unique<System>(
      mechanism_, make_leaves(mechanism_, model_, request_, points_, differentiable_),
      request_.loads);
  response_.seconds_coefficients += seconds_since(start);
  home_->stay_home();
  load();
  lost_ = not_loaded_;
  bifurcation_passed_ = !under_loads_.empty();
  home_->stay_home();
}

void BranchWalk::load() {
  if (!home_->loaded_at_rest()) return;
  Equilibrium loaded = advance({});
  // where all leaves have become full ones, the way of fresh ones is known
  if (!loaded.converged && !system().all_full()) loaded = on_fresh_full_leaves({});
  if (away_) home_ = std::move(away_);
  if (!loaded.converged) not_loaded_ = loaded.message;
  under_loads_ = loaded.crossings;
}

Equilibrium BranchWalk::step(Stage stage) {
  if (!stage) return mount(system(), request_.newton);
  if (!request_.loads.driven())
    return step_load(system(), request_.loads.mounted(request_.points[*stage]), request_.newton);
  return step_to(system(), request_.strokes_at(*stage, mechanism_.drives.size()), request_.newton);
}

// Steps, then again as long as a leaf of limited range wants its model changed: where there is an
// equilibrium, or where the way to it has ended. Where leaves have merely got more bent states the
// step is made anew: without them it has led anywhere. Where leaves have become full ones all of
// the way is, and all leaves become full where the ones that were not believed lost their
// stability, or where the way turns sharply. Other reduced models go on from where the last ones
// have led, and have to find an equilibrium nearby.
Equilibrium BranchWalk::advance(Stage stage) {
  constexpr int most_rounds = 12, most_failures = 2;
  const System::Snapshot before = system().save();
  const System* const begun = &system();
  const int replacements = begun->replacements();
  const auto full_leaves = [&] {
    int count = 0;
    for (int i = 0; i < system().leaves(); ++i) count += system().leaf(i).is_full();
    return count;
  };
  Equilibrium equilibrium = step(stage);
  int failures = 0;
  for (int round = 0; round < most_rounds; ++round) {
    if (!equilibrium.converged && (equilibrium.beyond_reach || ++failures > most_failures)) break;
    const Place here = place_of(system());
    const int full = full_leaves();
    if (!refine_leaves(system())) break;
    const Equilibrium last = std::move(equilibrium);
    if (&system() == begun && begun->replacements() == replacements) {
      system().restore(before);
      equilibrium = step(stage);
    } else if (full_leaves() > full && !away_) {
      equilibrium = go_again(stage);
    } else if (!last.crossings.empty() && !away_) {
      equilibrium = go_again(stage, unbelieved_crossing);
    } else {
      equilibrium = step(stage);
      if (equilibrium.crossings.empty()) equilibrium.crossings = last.crossings;
      if (equilibrium.converged && last.converged && !is_near(system(), here, similar_energy)) {
        equilibrium.converged = false;
        equilibrium.left_branch = true;
        equilibrium.message = "with other models of its leaves the mechanism moves far";
      }
    }
    equilibrium.iterations += last.iterations;
    equilibrium.turns_sharply = equilibrium.turns_sharply || last.turns_sharply;
    if (equilibrium.left_branch) break;
  }
  if (equilibrium.converged && equilibrium.turns_sharply && !away_ && has_limited_range(system())) {
    const int iterations = equilibrium.iterations;
    equilibrium = go_again(stage, sharp_turn);
    equilibrium.iterations += iterations;
  }
  return equilibrium;
}

// From the beginning of the way, with full leaves where there are such now, or everywhere.
Equilibrium BranchWalk::go_again(Stage stage, const char* all_full_because) {
  std::vector<std::optional<std::string>> reasons(mechanism_.leaves.size());
  for (int i = 0; i < home_->leaves(); ++i)
    if (home_->leaf(i).is_full())
      reasons[i] = home_->leaf(i).report().reason;
    else if (all_full_because)
      reasons[i] = all_full_because;
  home_->return_home();
  home_->assemble();
  const Place home = place_of(*home_);
  for (int i = 0; i < home_->leaves(); ++i)
    if (reasons[i] && !home_->leaf(i).is_full())
      home_->replace_leaf(i, home_->leaf(i).full_model(*reasons[i]));
  std::optional<VectorXd> strokes;
  if (request_.loads.driven() && stage) strokes = present_strokes(*home_);
  Equilibrium equilibrium = solve_equilibrium(*home_, strokes, request_.newton);
  if (!equilibrium.converged || !is_near(*home_, home, same_energy))
    return on_fresh_full_leaves(stage);
  for (const std::size_t k : done_)
    if (equilibrium.converged) equilibrium = step(k);
  if (equilibrium.converged) equilibrium = step(stage);
  return equilibrium;
}

// From the undeflected state, where reduced leaves lead nowhere under the constant loads alone.
Equilibrium BranchWalk::on_fresh_full_leaves(Stage stage) {
  away_ = std::make_unique<System>(mechanism_, make_full_leaves(mechanism_, model_, no_equilibrium),
                                   request_.loads);
  return stage ? step_from_rest(*away_, request_, *stage) : step({});
}

// From where the way stands or, of other branches, by another way.
Equilibrium BranchWalk::reach(std::size_t k) {
  Equilibrium equilibrium = advance(k);
  if (!equilibrium.converged && !system().all_full()) equilibrium = go_again(k, no_equilibrium);
  if (!equilibrium.converged && other_branch_) {
    auto again = lead_to_stable_branch(system(), *other_branch_, model_, request_, k);
    if (again) {
      away_ = std::move(again->system);
      equilibrium = again->equilibrium;
    }
  }
  if (request_.in_order) done_.push_back(k);
  return equilibrium;
}

// What follows other branches from the point. Where a limit of work ends that, the point keeps what
// is known of it.
void BranchWalk::add_branching(System& system, Equilibrium& equilibrium, std::size_t k,
                               PathPoint& point, PointGradients* own) try {
  if (request_.loads.follow())
    return outputs_.miss_branching("loads that follow their bodies have no potential", point);
  const auto whole = finish_on_full_leaves(system, model_, request_, k, check_full(system),
                                           equilibrium);  // reduced leaves do not reach so far
  if (!equilibrium.converged) return outputs_.miss_branching(equilibrium.message, point);
  System& loaded = whole ? *whole : system;
  if (request_.outputs.has(Output::stable_states))
    point.stable_states = stable_states(loaded, other_branch_, model_, request_, k);
  if (request_.growing_load()) outputs_.add_buckling(loaded, equilibrium, k, point, own);
  if (request_.wants_capacity()) outputs_.add_load_capacity(loaded, equilibrium, k, point, own);
} catch (const WorkLimitReached& reached) {
  cut_short_ = reached.what();
  outputs_.miss_branching(*cut_short_, point);
  response_.message = "critical loads and load capacities are missing: " + *cut_short_;
}

void BranchWalk::visit(std::size_t k) {
  PathPoint& point = response_.path[k];
  Equilibrium equilibrium = reach(k);
  Check left;  // an unstable branch, if the path was on one
  if (equilibrium.converged && request_.branch == BranchChoice::stable &&
      negative_pivots(system(), request_.loads.stable_with_all_held()) > 0)
    left = leave_branch(system(), away_, model_, request_, k, equilibrium, other_branch_);
  StrokeGradients* gradients = gradients_of(differentiable_);
  PointGradients* own = gradients && k < gradients->path.size() ? &gradients->path[k] : nullptr;
  std::unique_ptr<System> full;
  if (equilibrium.converged)
    full = evaluate_point(system(), model_, request_, k, differentiable_ != nullptr, outputs_,
                          equilibrium, point, own);
  if (!equilibrium.converged) {
    point.status = equilibrium.left_branch ? PointStatus::left_branch : PointStatus::no_equilibrium;
    point.message = equilibrium.message;
    point.newton_iterations = equilibrium.iterations;
    lost_ = fmt::format("the way ended before: {}", equilibrium.message);
    return;
  }
  if (!differentiable_ && (request_.wants_harmonic_answers() || request_.wants_state_space(k))) {
    // reduced leaves that know no interior leave the dynamics to full ones
    Equilibrium there = equilibrium;
    auto whole = finish_on_full_leaves(system(), model_, request_, k,
                                       check_interior(system(), request_, k, false), there);
    Check believed;
    if (there.converged) believed = outputs_.add_dynamics(whole ? *whole : system(), k, point);
    if (!believed) {  // nor do those whose tables end too early
      whole = finish_on_full_leaves(system(), model_, request_, k, believed, there);
      if (there.converged) believed = outputs_.add_dynamics(*whole, k, point);
    }
    if (!believed) {
      point.status = PointStatus::no_equilibrium;
      point.message = believed.error();
    }
  }
  point.other_branch = other_branch_.has_value();
  if (const Check holds = check_degree(system().mechanism(), point); !holds) {
    point.status = PointStatus::no_equilibrium;
    point.message = holds.error();
  }
  if (!left && point.status == PointStatus::converged)
    point.message = "the stable branch was not found: " + left.error();
  if (point.message.empty())
    point.message = equilibrium.crossings.empty() ? under_loads_ : equilibrium.crossings;
  // where full leaves have taken over at the point itself no step has seen it
  if (!equilibrium.crossings.empty() ||
      (request_.loads.held.none() ? point.negative_pivots : negative_pivots(system(), true)) > 0)
    bifurcation_passed_ = true;
  point.bifurcation_passed = bifurcation_passed_;
  if ((request_.growing_load() || request_.wants_capacity() ||
       request_.outputs.has(Output::stable_states)) &&
      point.status == PointStatus::converged)
    add_branching(full ? *full : system(), equilibrium, k, point, own);
}

bool follow_ways(const Mechanism& mechanism, const ModelOptions& model,
                 const StrokeRequest& request, const std::vector<std::vector<int>>& ways,
                 DifferentiablePath* differentiable, StrokeResponse& response) {
  const auto start = Clock::now();
  const double coefficients = response.seconds_coefficients;
  BranchWalk walk(mechanism, model, request, request.points.size(), differentiable, response);
  std::optional<std::string> limit;  // which limit of work has ended the evaluation
  const auto within_limits = [&](int k, const auto& work) {
    PathPoint& point = response.path[k];
    const PathPoint before = point;
    try {
      work();
    } catch (const WorkLimitReached& reached) {
      limit = reached.what();
      point = before;
      point.status = PointStatus::limit_reached;
      point.message = *limit;
      if (StrokeGradients* gradients = gradients_of(differentiable)) gradients->path[k] = {};
    }
  };
  for (const std::vector<int>& way : ways) {
    if (!limit) within_limits(way.front(), [&] { walk.begin(); });
    for (const int k : way) {
      PathPoint& point = response.path[k];
      if (point.status == PointStatus::limit_reached) continue;
      if (limit || !walk.lost().empty()) {
        point.message = limit ? "the path ended before: " + *limit : walk.lost();
        continue;
      }
      within_limits(k, [&] { walk.visit(static_cast<std::size_t>(k)); });
      if (walk.cut_short()) limit = walk.cut_short();
    }
  }
  response.seconds_path += seconds_since(start) - (response.seconds_coefficients - coefficients);
  return limit.has_value();
}

}  // namespace flexopt
