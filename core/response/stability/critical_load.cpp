#include "core/response/stability/critical_load.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace flexopt {
namespace {

constexpr double largest_factor = no_critical_factor;  // farther estimates are rounding

// Where the tangent of a state is not definite: to where it is, with less of
// the load.
bool unload_to_stable(LoadBranch& branch) {
  if (branch.negative_pivots() == 0) return true;
  double step = 0.25;
  while (branch.factor() > 0 && step > 1e-4) {
    if (branch.advance_to(std::max(0.0, branch.factor() - step))) {
      if (branch.negative_pivots() == 0) return true;
    } else {
      step /= 2;
    }
  }
  return false;
}

}  // namespace

CriticalLoadResult find_critical_load(LoadBranch& branch, const ModelOptions& model,
                                      DesignDirections* design, bool driven, double largest) {
  CriticalLoadResult result;
  const bool stable = branch.negative_pivots() == 0;
  MatrixXd of_drives;
  if (design) of_drives = drive_load_rates(branch, model, *design, driven);
  if (!stable && !unload_to_stable(branch)) {
    result.load.reason = "the state is unstable, and stays so without the load";
    return result;
  }
  BranchTracer tracer(branch, model);
  const LoadBranch::State begin = branch.save();
  const double at = branch.factor();
  BranchTracer::Look first = tracer.look(1, {}, true);
  const auto estimate = [&](const std::optional<SoftMode>& mode) -> std::optional<double> {
    if (!mode || std::abs(first.estimate(at, *mode)) > largest_factor) return std::nullopt;
    return first.estimate(at, *mode);
  };
  const std::optional<double> ahead = estimate(first.ahead), behind = estimate(first.behind);
  if (!ahead) first.ahead.reset();
  const VectorXd known_behind = first.behind ? first.behind->mode : VectorXd();
  double bound = 100;
  for (const auto& e : {ahead, behind})
    if (e) bound = std::max(bound, 10 * std::abs(*e - at));
  const auto no_factor = [&](std::string reason) {
    result.gradient.reset();
    result.load.factor.reset();
    result.load.fold = false;
    result.load.mode.clear();
    result.load.reason = std::move(reason);
  };
  // the derivative is that of the state where the branch stands: before the load is put on
  const auto follow = [&](int side) {
    result.load =
        tracer.follow(side, std::move(first), std::min(bound, std::max(0.0, largest - side * at)));
    if (!result.load.factor) return;
    const Check held = tracer.check_bodies();
    if (held && design) result.gradient = tracer.gradient(*design, of_drives);
    const std::string doubt = held ? tracer.put_on(begin, *result.load.factor).doubt : held.error();
    if (!doubt.empty()) no_factor("a singular tangent is not confirmed: " + doubt);
  };
  follow(1);
  const bool to_largest = result.load.none && branch.factor() >= largest;
  if (!result.load.factor && stable) {
    const std::string reason = result.load.reason;
    const bool none = result.load.none;
    branch.restore(begin);
    first = tracer.look(-1, known_behind);
    if (!behind) first.ahead.reset();
    follow(-1);
    // the load itself may have a factor that was not found
    if (result.load.factor && !none)
      no_factor(
          fmt::format("the tangent of the reversed load becomes singular at a factor of {:.4g}",
                      *result.load.factor));
    if (!result.load.factor) {
      result.load.none = none && result.load.none;
      result.load.reason = reason + "; " + result.load.reason;
    }
  }
  if (stable && result.load.factor.value_or(-1) < 0 && to_largest) result.load.at_least = largest;
  if (stable) result.load.linearised = ahead ? ahead : behind;
  return result;
}

}  // namespace flexopt
