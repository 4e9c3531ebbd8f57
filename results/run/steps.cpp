#include "results/run/steps.hpp"

#include <fmt/format.h>

#include <cmath>

#include "optim/problem/evaluation_book.hpp"
#include "results/files/units.hpp"

namespace flexopt {

BestSoFar::BestSoFar(const OptimiseSpec& spec, const DriveList& drives) : spec_(spec) {
  if (!spec.objective.quantity.empty()) unit_ = quantity_unit(spec.objective.quantity, drives);
}

void BestSoFar::add(const EvaluationRecord& evaluation) {
  if (!evaluation.ok || evaluation.difference || evaluation.full) return;
  const auto merit = [](const EvaluationRecord& e) { return Merit{e.objective, e.violation}; };
  if (!best_ || better(merit(evaluation), merit(*best_), spec_.objective.maximise,
                       spec_.constraint_tolerance))
    best_ = evaluation;
}

std::string BestSoFar::text() const {
  if (!best_) return "";
  const Objective& goal = spec_.objective;
  std::string text =
      fmt::format("best {}{} {:.5g}{}{}", goal.quantity.empty() ? goal.expression : goal.quantity,
                  label_suffix(goal.margin, goal.worst_assembly), best_->objective,
                  unit_.empty() || unit_ == "1" ? "" : " ", unit_ == "1" ? "" : unit_);
  if (const auto& worst = best_->worst; worst && worst->place < spec_.constraints.size())
    text += fmt::format(", worst {} {:+.2g} %", spec_.constraints[worst->place].label,
                        100 * (std::abs(worst->excess) < 1e-6 ? 0 : worst->excess));
  return text;
}

RunStep step_of(const Progress& progress, int total, const BestSoFar& best) {
  RunStep step{.done = progress.evaluations,
               .total = total,
               .what = "evaluations",
               .text = fmt::format("evaluations at most, {} start{}", progress.starts,
                                   progress.starts == 1 ? "" : "s"),
               .goals = best.text(),
               .replayed = progress.replayed,
               .at_most = true};
  if (progress.failed > 0) step.text += fmt::format(", {} failed", progress.failed);
  if (progress.replayed > 0) step.text += fmt::format(", {} from the log", progress.replayed);
  if (progress.best)
    step.text += fmt::format(", best {:.6g}{}{}", *progress.best, best.unit().empty() ? "" : " ",
                             best.unit());
  return step;
}

RunStep step_of(const ScreeningProgress& progress, double seconds) {
  RunStep step{.done = progress.screened,
               .total = progress.designs,
               .what = "designs screened",
               .text = "designs screened",
               .replayed = progress.replayed};
  if (progress.failed > 0) step.goals = fmt::format("{} without values", progress.failed);
  if (progress.failed > 0) step.text += ", " + step.goals;
  if (progress.replayed > 0) step.text += fmt::format(", {} from the log", progress.replayed);
  const int fresh = progress.screened - progress.replayed;
  if (fresh > 0 && seconds > 1) step.text += fmt::format(", {:.0f} a second", fresh / seconds);
  return step;
}

RunStep step_of(const CompareProgress& progress) {
  RunStep step{.done = progress.evaluations,
               .total = progress.total,
               .what = "evaluations",
               .text = "evaluations",
               .replayed = progress.replayed};
  if (progress.failed > 0) step.goals = fmt::format("{} failed", progress.failed);
  if (progress.failed > 0) step.text += ", " + step.goals;
  if (progress.replayed > 0) step.text += fmt::format(", {} from the log", progress.replayed);
  return step;
}

LoopProgress counted(RunListener& listener, const std::string& what) {
  return [&listener, what](int done, int total) {
    listener.step({.done = done, .total = total, .what = what});
  };
}

}  // namespace flexopt
