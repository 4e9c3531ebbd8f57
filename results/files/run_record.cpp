#include "results/files/run_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

namespace flexopt {

namespace {

std::string plural(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

void conclude_evaluation(RunRecord& record) {
  const auto& path = record.response.path;
  const auto converged = static_cast<std::size_t>(std::ranges::count(
      path, PointStatus::converged, [](const PathPoint& point) { return point.status; }));
  if (record.response.status == Status::ok && converged == path.size()) {
    record.status = "ok";
    record.message =
        fmt::format("Equilibrium found at {}, {} accuracy.", plural(path.size(), "stroke point"),
                    name_of(record.job.model.accuracy));
    return;
  }
  record.status = "no_equilibrium";
  record.message = record.response.message;
  if (record.message.empty())
    record.message =
        fmt::format("{} of {} converged", converged, plural(path.size(), "stroke point"));
  record.message += ".";
}

void conclude_optimisation(RunRecord& record) {
  const Optimum& optimum = *record.optimum;
  const char* verdict = nullptr;
  switch (optimum.status) {
    case OptimumStatus::optimal:
      record.status = "ok";
      verdict = "A feasible optimum was found";
      break;
    case OptimumStatus::feasible:
      record.status = "not_converged";
      verdict = "The best design is feasible but the search had not converged";
      break;
    case OptimumStatus::infeasible:
      record.status = "infeasible";
      verdict = "No design met every constraint; the least violating one is given";
      break;
    case OptimumStatus::failed:
      record.status = "failed";
      verdict = "No design could be evaluated";
      break;
  }
  assert(verdict);
  record.message = fmt::format("{} in {}", verdict,
                               plural(static_cast<std::size_t>(optimum.evaluations), "evaluation"));
  if (optimum.failed_evaluations > 0)
    record.message += fmt::format(" ({} failed)", optimum.failed_evaluations);
  record.message += optimum.stop_reason.empty() ? "." : "; " + optimum.stop_reason;
  if (optimum.verified && optimum.verified->response.status != Status::ok) {
    if (record.status == "ok") record.status = "not_verified";
    record.message +=
        " At full accuracy it has no equilibrium: " + optimum.verified->response.message;
  }
}

void conclude_comparison(RunRecord& record) {
  const Comparison& comparison = *record.comparison;
  int failures = 0, fallbacks = 0;
  bool compared = false;
  for (const ModelComparison& model : comparison.models) {
    failures += model.failures;
    fallbacks += model.fallback_designs;
    compared = compared || !model.errors.empty();
  }
  record.status = compared ? "ok" : "failed";
  record.message = compared ? fmt::format("{} compared with full accuracy over {}",
                                          plural(comparison.models.size(), "model"),
                                          plural(comparison.designs.size(), "design"))
                            : fmt::format("None of {} could be compared",
                                          plural(comparison.designs.size(), "design"));
  if (comparison.failed_designs > 0)
    record.message +=
        fmt::format("; {} not to the end at full accuracy",
                    plural(static_cast<std::size_t>(comparison.failed_designs), "design"));
  if (failures > 0)
    record.message += fmt::format("; the models failed {} on their own",
                                  failures == 1 ? "once" : fmt::format("{} times", failures));
  if (fallbacks > 0)
    record.message += fmt::format("; {} with leaves evaluated at full accuracy instead",
                                  plural(static_cast<std::size_t>(fallbacks), "path"));
  for (const ComparedDesign& design : comparison.designs)
    if (!compared && !design.message.empty()) {
      record.message += ": " + design.message;
      break;
    }
  record.message += ".";
}

}  // namespace

void conclude(RunRecord& record) {
  if (record.comparison)
    conclude_comparison(record);
  else if (record.optimum)
    conclude_optimisation(record);
  else
    conclude_evaluation(record);
}

const StrokeResponse& response_of(const RunRecord& record) {
  return record.optimum ? record.optimum->response : record.response;
}

std::string name_of(JobKind kind) {
  switch (kind) {
    case JobKind::evaluate:
      return "evaluate";
    case JobKind::optimise:
      return "optimise";
    case JobKind::compare:
      return "compare";
  }
  assert(false);
  return {};
}

std::string name_of(Accuracy accuracy) {
  return accuracy == Accuracy::reduced ? "reduced" : "full";
}

std::string name_of(PointStatus status) {
  switch (status) {
    case PointStatus::converged:
      return "converged";
    case PointStatus::no_equilibrium:
      return "no_equilibrium";
    case PointStatus::not_reached:
      return "not_reached";
  }
  assert(false);
  return {};
}

std::string name_of(ModeKind kind) {
  switch (kind) {
    case ModeKind::drive:
      return "drive";
    case ModeKind::end_effector:
      return "end_effector";
    case ModeKind::intermediate_body:
      return "intermediate_body";
    case ModeKind::leaf:
      return "leaf";
  }
  assert(false);
  return {};
}

std::string name_of(OverStroke over) {
  switch (over) {
    case OverStroke::min:
      return "min";
    case OverStroke::max:
      return "max";
    case OverStroke::max_abs:
      return "max_abs";
    case OverStroke::first:
      return "first";
    case OverStroke::last:
      return "last";
  }
  assert(false);
  return {};
}

std::string name_of(OptimumStatus status) {
  switch (status) {
    case OptimumStatus::optimal:
      return "optimal";
    case OptimumStatus::feasible:
      return "feasible";
    case OptimumStatus::infeasible:
      return "infeasible";
    case OptimumStatus::failed:
      return "failed";
  }
  assert(false);
  return {};
}

}  // namespace flexopt
