#include "optim/search/optimise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>

#include "optim/numerics/parallel.hpp"
#include "optim/search/pareto.hpp"
#include "optim/search/search.hpp"
#include "optim/search/start_points.hpp"
#include "optim/search/stock.hpp"
#include "optim/search/verification.hpp"

namespace flexopt {
namespace {

/// One start from begin to end.
struct Start {
  std::unique_ptr<EvaluationBook> book;
  VectorXd from;
  SearchResult result;
};

StartSummary summarise(const DesignProblem& problem, const Start& start, int index) {
  StartSummary s;
  s.index = index;
  s.from = problem.named(problem.variables(start.from));
  s.status = word_of(start.result.summary.reason);
  s.stop_reason = start.result.summary.message;
  s.kkt = start.result.summary.kkt;
  s.evaluations = static_cast<int>(start.book->evaluations().size());
  s.failed_evaluations = start.book->failures();
  if (const auto& best = start.result.best) {
    s.to = problem.named(problem.variables(best->x));
    s.objective = best->objective;
    s.violation = best->violation;
    s.feasible = s.violation <= problem.spec().constraint_tolerance;
  }
  return s;
}

/// Starts whose feasible ends are as good as the best one.
int mark_agreeing(std::vector<StartSummary>& starts, const StartSummary& best) {
  constexpr double near = 1e-3;
  int count = 0;
  for (StartSummary& s : starts) {
    s.agrees = best.feasible && s.feasible &&
               std::abs(s.objective - best.objective) <= near * std::abs(best.objective);
    count += s.agrees ? 1 : 0;
  }
  return count;
}

std::vector<ConstraintState> states(const DesignProblem& problem, const Scales& scales,
                                    const DesignValues& design) {
  const std::vector<double> values = problem.constraints(design);
  std::vector<ConstraintState> result;
  for (std::size_t i = 0; i < problem.own_constraints(); ++i) {
    const Constraint& c = problem.spec().constraints[i];
    ConstraintState s;
    s.label = c.label;
    s.value = values[i];
    s.min = c.min;
    s.max = c.max;
    s.margin = -excess(values[i], c.min, c.max, 1.0);
    s.active = std::abs(s.margin) <= problem.spec().constraint_tolerance * scales.constraints[i];
    result.push_back(std::move(s));
  }
  return result;
}

std::string what_stops(const std::vector<ConstraintState>& constraints, const Scales& scales) {
  std::size_t worst = 0;
  for (std::size_t i = 0; i < constraints.size(); ++i)
    if (constraints[i].margin / scales.constraints[i] <
        constraints[worst].margin / scales.constraints[worst])
      worst = i;
  const ConstraintState& c = constraints[worst];
  const bool above = c.max && c.value > *c.max;
  return fmt::format("{} = {:.6g} where {} {:.6g} is asked for ({:.2g} % beyond)", c.label, c.value,
                     above ? "at most" : "at least", above ? *c.max : *c.min,
                     -100 * c.margin / scales.constraints[worst]);
}

/// What the stages hand on: the design that is the answer, and how it was posed.
struct Chosen {
  Pose pose;
  Candidate best;
  std::vector<double> multipliers;  ///< of the goals 1, 2, …; empty where unknown
};

/// Sensitivities of the objective and the active constraints, and multipliers of the constraints,
/// at the answer: from the derivatives of all goals there.
void add_derivatives(const DesignProblem& problem, EvaluationBook& book, const Chosen& answer,
                     Optimum& optimum) {
  int cost = 0;
  const VectorXd& x = answer.best.x;
  std::optional<MatrixXd> derivatives = book.derivatives(x, cost);
  if (!derivatives) return;
  const DesignValues own = book.at(problem.variables(x), cost);
  VectorXd values = flattened(own);
  if (answer.pose.correction) answer.pose.correction->apply(x, values, &*derivatives);
  const OptimiseSpec& spec = problem.spec();
  Eigen::Index first = 0;
  for (std::size_t g = 0; g <= problem.own_constraints(); ++g) {
    if (g == 0 || optimum.constraints[g - 1].active) {
      const Extreme e = extreme(problem.goals()[g], answer.best.values.goals[g]);
      for (std::size_t j = 0; j < spec.variables.size(); ++j) {
        const auto column = static_cast<Eigen::Index>(j);
        optimum.sensitivities.push_back(
            {problem.goals()[g].label, spec.variables[j].parameter,
             e.sign * (*derivatives)(first + static_cast<Eigen::Index>(e.entry), column) /
                 problem.range(column)});
      }
    }
    first += static_cast<Eigen::Index>(own.goals[g].size());
  }
  std::vector<double> multipliers = answer.multipliers;
  if (multipliers.empty()) multipliers = multipliers_at(problem, book, answer.pose, answer.best);
  for (std::size_t i = 0; i < optimum.constraints.size() && i < multipliers.size(); ++i)
    optimum.constraints[i].multiplier = multipliers[i];
}

double difference(double reduced, double full) {
  return full == 0 ? reduced - full : reduced / full - 1;
}

ModelOptions at_full_accuracy(ModelOptions model) {
  model.accuracy = Accuracy::full;
  return model;
}

/// The optimum's path, by the model that its values are of, and the verification.
void add_paths(const DesignProblem& problem, const Variables& variables, const DesignValues& own,
               int threads, Optimum& optimum) {
  const Job& job = problem.job();
  StrokeRequest request = job.request;
  request.outputs.remove(Output::shapes);
  Verification& v = optimum.verified.emplace();
  if (optimum.at_full_accuracy) {
    optimum.response = problem.respond(variables, at_full_accuracy(job.model), job.request);
    v.response = optimum.response;
    for (PathPoint& point : v.response.path) point.shapes.clear();
  } else {
    parallel_for(2, threads, [&](int i) {
      if (i == 0) optimum.response = problem.respond(variables, job.model, job.request);
      if (i == 1) v.response = problem.respond(variables, at_full_accuracy(job.model), request);
    });
  }
  const DesignValues full = problem.read(variables, v.response, request);
  if (!full.ok) {
    if (v.response.message.empty()) v.response.message = full.message;
    return;
  }
  v.objective = problem.objective(full);
  v.constraints = problem.constraints(full);
  v.constraints.resize(problem.own_constraints());
  v.objective_difference = difference(problem.objective(own), v.objective);
  const std::vector<double> own_constraints = problem.constraints(own);
  for (std::size_t i = 0; i < v.constraints.size(); ++i)
    v.constraint_differences.push_back(difference(own_constraints[i], v.constraints[i]));
}

/// The starts, each with its book; the scales come from the first that can be evaluated, before the
/// starts go their own ways.
std::vector<Start> make_starts(Campaign& campaign) {
  const DesignProblem& problem = campaign.problem;
  std::vector<Start> starts;
  for (VectorXd& x : start_points(problem, campaign.scales)) {
    Start start;
    start.book = std::make_unique<EvaluationBook>(
        campaign.book(Stage::search, static_cast<int>(starts.size())));
    start.from = std::move(x);
    starts.push_back(std::move(start));
  }
  for (Start& start : starts) {
    int cost = 0;
    const DesignValues& values = start.book->at(problem.variables(start.from), cost);
    if (!values.ok) continue;
    campaign.scales = problem.scales(&values);
    break;
  }
  for (Start& start : starts) start.book->set_scales(campaign.scales);
  return starts;
}

/// The best feasible end, else the least violated one; −1 where there is none.
int best_of(const DesignProblem& problem, const std::vector<Start>& starts) {
  const double tolerated = problem.spec().constraint_tolerance;
  const bool maximise = problem.spec().objective.maximise;
  int best = -1;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const auto& mine = starts[i].result.best;
    if (!mine) continue;
    if (best >= 0) {
      const Candidate& other = *starts[static_cast<std::size_t>(best)].result.best;
      const bool a = mine->violation <= tolerated, b = other.violation <= tolerated;
      const bool better = a != b     ? a
                          : !a       ? mine->violation < other.violation
                          : maximise ? mine->objective > other.objective
                                     : mine->objective < other.objective;
      if (!better) continue;
    }
    best = static_cast<int>(i);
  }
  return best;
}

/// Optimality, feasibility and what they rest on.
void judge(const DesignProblem& problem, const Scales& scales, const Chosen& answer, bool converged,
           Optimum& optimum) {
  optimum.parameters = problem.parameters(problem.variables(answer.best.x));
  optimum.objective = answer.best.objective;
  optimum.constraints = states(problem, scales, answer.best.values);
  const bool feasible = answer.best.violation <= problem.spec().constraint_tolerance;
  optimum.status = !feasible   ? OptimumStatus::infeasible
                   : converged ? OptimumStatus::optimal
                               : OptimumStatus::feasible;
}

void add(std::vector<LoggedEvaluation>& all, const std::vector<LoggedEvaluation>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

Optimum optimise(const Job& job, const OptimiseOptions& options) {
  assert(job.optimise);
  const OptimiseSpec& spec = *job.optimise;
  const DesignProblem problem(job, options.evaluators);
  EvaluationLog log = options.log.empty()
                          ? EvaluationLog(job)
                          : EvaluationLog(job, options.log, options.version, options.overwrite_log);
  ProgressBoard board(options.progress, spec.starts, spec.objective.maximise,
                      spec.constraint_tolerance);
  Campaign campaign{problem, log, board, problem.scales(nullptr), options.threads};

  std::vector<Start> starts = make_starts(campaign);
  const auto count = static_cast<int>(starts.size());
  const int together = std::clamp(options.threads, 1, count);
  parallel_for(count, together, [&](int i) {
    Start& start = starts[static_cast<std::size_t>(i)];
    start.book->set_threads(std::max(1, options.threads / together));
    start.result = search(problem, *start.book, job_pose(problem), start.from,
                          {spec.max_evaluations, false, {}});
  });

  Optimum optimum;
  for (int i = 0; i < count; ++i)
    optimum.starts.push_back(summarise(problem, starts[static_cast<std::size_t>(i)], i));
  const int best = best_of(problem, starts);
  optimum.best_start = std::max(best, 0);
  Start& chosen = starts[static_cast<std::size_t>(optimum.best_start)];
  chosen.book->set_threads(options.threads);
  std::vector<LoggedEvaluation> later;  // of the stages behind the starts
  std::string why_differences_at_end;
  if (best < 0) {
    optimum.status = OptimumStatus::failed;
    optimum.stop_reason = optimum.starts.front().stop_reason;
  } else {
    optimum.agreeing_starts =
        mark_agreeing(optimum.starts, optimum.starts[static_cast<std::size_t>(best)]);
    Chosen answer{job_pose(problem), *chosen.result.best, chosen.result.multipliers};
    judge(problem, campaign.scales, answer, chosen.result.summary.reason == StopReason::converged,
          optimum);
    optimum.stop_reason = chosen.result.summary.message;
    if (optimum.status == OptimumStatus::infeasible)
      optimum.stop_reason =
          fmt::format("no feasible design in {} start{}; the least violated one has {}. {}", count,
                      count == 1 ? "" : "s", what_stops(optimum.constraints, campaign.scales),
                      chosen.result.summary.message);
    EvaluationBook* book = chosen.book.get();  // what knows the answer best
    EvaluationBook last = campaign.book(Stage::verification, 1);
    const bool feasible = optimum.status != OptimumStatus::infeasible;

    if (feasible && spec.pareto) {
      ParetoOutcome front = search_front(campaign, *book, chosen.result);
      optimum.pareto = std::move(front.report);
      add(later, front.evaluations);
    }
    std::vector<LoggedEvaluation> stock_evaluations;
    if (feasible && has_stock(spec)) {
      StockOutcome stock = search_stock(campaign, *book, answer.pose, answer.best);
      stock_evaluations = std::move(stock.evaluations);
      if (stock.report.chosen >= 0) {
        answer = {stock.pose, *stock.chosen.best, stock.chosen.multipliers};
        judge(problem, campaign.scales, answer,
              optimum.status == OptimumStatus::optimal &&
                  stock.chosen.summary.reason == StopReason::converged,
              optimum);
        optimum.stop_reason = fmt::format("stock sizes: {}", stock.chosen.summary.message);
      } else {
        optimum.status = OptimumStatus::infeasible;
        optimum.stop_reason = fmt::format(
            "none of the {} neighbouring stock designs tried is feasible; shown is the optimum of "
            "any size",
            stock.report.designs.size());
      }
      optimum.stock = std::move(stock.report);
    }
    std::optional<VerificationLoop> loop;
    const DesignValues own_values = answer.best.values;
    if (spec.verify && optimum.status != OptimumStatus::infeasible) {
      VerificationOutcome found = verify_optimum(campaign, *book, answer.pose, answer.best);
      add(later, found.evaluations);
      if (found.best) {
        answer = {found.pose, *found.best, {}};
        judge(problem, campaign.scales, answer,
              optimum.status == OptimumStatus::optimal && found.report.converged, optimum);
        optimum.at_full_accuracy = true;
        if (optimum.status == OptimumStatus::infeasible)
          optimum.stop_reason =
              fmt::format("at full accuracy: {}. {}",
                          what_stops(optimum.constraints, campaign.scales), found.report.message);
      } else {
        optimum.status = OptimumStatus::feasible;
        optimum.stop_reason = found.report.message;
      }
      loop = std::move(found.report);
    }
    add(later, stock_evaluations);

    // neighbours for differences go to the start's own evaluations where it is still its design
    const bool moved = optimum.stock || loop;
    if (moved) last.adopt(*book);
    EvaluationBook& knows = moved ? last : *book;
    add_derivatives(problem, knows, answer, optimum);
    const Variables variables = problem.variables(answer.best.x);
    int cost = 0;
    const DesignValues own = optimum.at_full_accuracy ? knows.at(variables, cost) : own_values;
    if (moved) add(later, last.evaluations());
    why_differences_at_end = last.why_differences();
    add_paths(problem, variables, own, options.threads, optimum);
    optimum.verified->loop = std::move(loop);
  }
  const bool gradients = needs_gradients(optimiser_options(spec));
  bool differences = false;
  for (const Start& start : starts) {
    differences = differences || start.book->used_differences();
    if (optimum.gradients_message.empty())
      optimum.gradients_message = start.book->why_differences();
  }
  if (optimum.gradients_message.empty()) optimum.gradients_message = why_differences_at_end;
  optimum.gradients = !gradients ? "none" : !differences ? "exact" : "central differences";

  std::vector<LoggedEvaluation> all;
  for (const Start& start : starts) add(all, start.book->evaluations());
  add(all, later);
  for (const LoggedEvaluation& e : all) {
    optimum.history.push_back(e.record);
    if (!e.record.ok) ++optimum.failed_evaluations;
  }
  optimum.evaluations = static_cast<int>(all.size());
  log.finish(all);
  return optimum;
}

}  // namespace flexopt
