#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "optim/search/stages.hpp"
#include "optim/solvers/parallel.hpp"

namespace flexopt {

namespace {

StartSummary summarise(const DesignProblem& problem, const Start& start, int index) {
  StartSummary s{end_of(problem, start.result)};
  s.index = index;
  s.from = problem.named(problem.variables(start.from));
  s.kkt = start.result.summary.kkt;
  s.evaluations = static_cast<int>(start.book->evaluations().size());
  s.failed_evaluations = start.book->failures();
  if (s.ok) s.to = problem.named(problem.variables(start.result.best->x));
  return s;
}

/// Marks the starts whose feasible ends are as good as the best one, and returns their number.
int mark_agreeing(std::vector<StartSummary>& starts, const StartSummary& best) {
  int count = 0;
  for (StartSummary& s : starts) {
    s.agrees = best.feasible && s.feasible && objectives_agree(s.objective, best.objective);
    count += s.agrees;
  }
  return count;
}

/// The starts, each with its book.
std::vector<Start> make_starts(const Campaign& campaign, const std::vector<VectorXd>& points) {
  std::vector<Start> starts(points.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    starts[k].book =
        std::make_unique<EvaluationBook>(campaign.book(Stage::search, static_cast<int>(k)));
    starts[k].from = points[k];
  }
  return starts;
}

/// The feasible ends that are worse than the best one, in words; empty where there are none.
std::string other_ends(const std::vector<StartSummary>& starts) {
  std::vector<std::string> ends;
  int agree = 0;
  for (const StartSummary& s : starts) {
    agree += s.agrees;
    if (s.feasible && !s.agrees) ends.push_back(fmt::format("{} at {:.6g}", s.index, s.objective));
  }
  if (ends.empty()) return "";
  const std::size_t count = ends.size(), most = 8;
  if (count > most) ends.resize(most);
  return fmt::format("{} of {} starts agree with it, other starts end elsewhere: start {}{}", agree,
                     starts.size(), fmt::join(ends, ", start "), count > most ? ", ..." : "");
}

/// The ends of the starts; null where there is none.
std::vector<const Candidate*> ends_of(const std::vector<Start>& starts) {
  std::vector<const Candidate*> ends;
  for (const Start& start : starts)
    ends.push_back(start.result.best ? &*start.result.best : nullptr);
  return ends;
}

void add(std::vector<LoggedEvaluation>& all, const std::vector<LoggedEvaluation>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

/// A job's optimisation, stage by stage.
class Optimisation {
 public:
  Optimisation(const Job& job, const OptimiseOptions& options);
  Optimum run();

 private:
  /// Scaled variables of the starts; of a global search after its screening.
  std::vector<VectorXd> points();
  void search_from_starts();
  /// Searches from the starts of a shard, which ends with them.
  [[noreturn]] void search_own_starts(Sharing& sharing);
  SearchResult search_from(Start& start, int threads);
  /// Compares the different ends of a global search at full accuracy and returns the best of them.
  int compare_optima(int best);
  /// The best start's end is the answer so far; nothing where no design could be evaluated.
  std::optional<Chosen> best_end();
  /// Status of a start's end, where it is feasible.
  OptimumStatus verdict(int best);
  void follow_front(const Start& start);
  /// Replaces the answer by the best design of stock sizes.
  void take_stock_sizes(const Start& start, Chosen& answer);
  /// Moves the answer to the optimum of full accuracy.
  std::optional<VerificationLoop> correct(const VerifySpec& rules, const Start& start,
                                          Chosen& answer);
  /// Completes the answer from the best end.
  void finish(Start& start, Chosen answer);
  void tell_gradients();
  void close_log();

  bool feasible() const { return optimum_.status != OptimumStatus::infeasible; }
  /// The present status if this holds.
  OptimumStatus kept_if(bool holds) const {
    return holds ? optimum_.status : OptimumStatus::feasible;
  }
  Start& best_start() { return starts_[optimum_.best_start]; }

  const Job& job_;
  const OptimiseSpec& spec_;
  const OptimiseOptions& options_;
  DesignProblem problem_;
  EvaluationLog log_;
  ProgressBoard board_;
  Campaign campaign_;
  std::vector<Start> starts_;
  Confirmation confirmation_;
  Optimum optimum_;
  std::vector<LoggedEvaluation> later_;  ///< evaluations of the stages behind the starts
  std::vector<LoggedEvaluation> stock_;  ///< those of stock sizes stand behind the correction's
  std::string why_differences_at_end_;   ///< why the answer's derivatives are differences
};

Optimisation::Optimisation(const Job& job, const OptimiseOptions& options)
    : job_(job),
      spec_(*job.optimise),
      options_(options),
      problem_(job, options.evaluators),
      log_(job, options.log, options.version, options.overwrite_log),
      board_(options.progress, spec_.starts, spec_.objective.maximise, spec_.constraint_tolerance),
      campaign_{problem_,
                log_,
                board_,
                problem_.scales(nullptr),
                options.sharing ? options.sharing->threads(options.threads) : options.threads,
                options.sharing ? options.sharing->workers() : nullptr} {}

std::vector<VectorXd> Optimisation::points() {
  if (spec_.search == SearchKind::starts) return start_points(problem_, campaign_.scales);
  Screening found = screen(job_, options_);
  optimum_.screening = std::move(found.report);
  return std::move(found.starts);
}

void Optimisation::search_from_starts() {
  starts_ = make_starts(campaign_, points());
  if (options_.sharing && options_.sharing->shard()) search_own_starts(*options_.sharing);
  const auto count = static_cast<int>(starts_.size());
  const int together = std::clamp(campaign_.threads, 1, count);
  parallel_for(count, together, [&](int i) {
    Start& start = starts_[i];
    start.result = search_from(start, std::max(1, campaign_.threads / together));
  });
  for (Start& start : starts_) start.book->set_threads(campaign_.threads);
  confirmation_ = confirm(campaign_, starts_);
  for (int i = 0; i < count; ++i) optimum_.starts.push_back(summarise(problem_, starts_[i], i));
}

SearchResult Optimisation::search_from(Start& start, int threads) {
  start.book->set_threads(threads);
  return search(*start.book, job_pose(problem_), start.from, spec_.max_evaluations);
}

void Optimisation::search_own_starts(Sharing& sharing) {
  const std::vector<int> own = sharing.own("starts", static_cast<int>(starts_.size()));
  parallel_for(static_cast<int>(own.size()), options_.threads,
               [&](int i) { search_from(starts_[own[i]], 1); });
  throw ShardEnds();
}

int Optimisation::compare_optima(int best) {
  const bool maximise = spec_.objective.maximise;
  const auto groups = different_ends(ends_of(starts_), maximise, spec_.constraint_tolerance);
  const auto count = static_cast<int>(groups.size());
  optimum_.optima.resize(groups.size());
  std::vector<EvaluationBook> books;
  for (const std::vector<int>& group : groups)
    books.push_back(
        campaign_.book(Stage::verification, 2 + group.front(), starts_[group.front()].book.get()));
  parallel_for(count, campaign_.threads, [&](int k) {
    FoundOptimum& of = optimum_.optima[k];
    of.start = groups[k].front();
    of.starts = groups[k];
    std::ranges::sort(of.starts);
    int cost = 0;
    const VectorXd& x = starts_[of.start].result.best->x;
    const DesignValues& full = books[k].full(problem_.variables(x), cost);
    of.ok = full.ok;
    if (!full.ok) return;
    of.objective = problem_.objective(full);
    of.violation = problem_.violation(problem_.constraints(full), campaign_.scales);
  });
  // what the models differ by makes none infeasible
  const double tolerated =
      std::max(spec_.constraint_tolerance, spec_.verify.value_or(VerifySpec()).tolerance);
  const FoundOptimum* chosen = nullptr;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const FoundOptimum& of = optimum_.optima[k];
    starts_[of.start].book->adopt(books[k]);
    add(later_, books[k].evaluations());
    const bool feasible = optimum_.starts[of.start].feasible;
    if (feasible && of.ok && of.violation <= tolerated &&
        (!chosen || better({of.objective, 0}, {chosen->objective, 0}, maximise, 0)))
      chosen = &of;
  }
  return chosen ? chosen->start : best;
}

std::optional<Chosen> Optimisation::best_end() {
  int best = confirmation_.best;
  if (best >= 0 && optimum_.screening) best = compare_optima(best);
  optimum_.best_start = std::max(best, 0);
  if (best < 0) {
    optimum_.status = OptimumStatus::failed;
    optimum_.stop_reason = optimum_.starts.front().stop_reason;
    return std::nullopt;
  }
  optimum_.agreeing_starts = mark_agreeing(optimum_.starts, optimum_.starts[best]);
  const SearchResult& end = best_start().result;
  Chosen answer{job_pose(problem_), *end.best, end.multipliers};
  optimum_.stop_reason = end.summary.message;
  optimum_.kkt = end.summary.kkt;
  judge(problem_, campaign_.scales, answer, verdict(best), optimum_);
  if (!feasible())
    optimum_.stop_reason = fmt::format(
        "no feasible design in {} start{}{}; {}. {}", starts_.size(),
        starts_.size() == 1 ? "" : "s",
        optimum_.screening ? fmt::format(" of {} screened designs", optimum_.screening->designs)
                           : "",
        what_stops(*best_start().book, campaign_.scales, answer, optimum_), end.summary.message);
  return answer;
}

OptimumStatus Optimisation::verdict(int best) {
  std::string& told = optimum_.stop_reason;
  if (best != confirmation_.best)  // a global search ranks its ends by full accuracy
    return best_start().result.summary.reason == StopReason::converged ? OptimumStatus::optimal
                                                                       : OptimumStatus::feasible;
  if (!confirmation_.message.empty()) told += "; " + confirmation_.message;
  if (!confirmation_.holds) return OptimumStatus::feasible;
  const std::string others = optimum_.screening ? "" : other_ends(optimum_.starts);
  if (!others.empty()) told += "; " + others;
  return others.empty() && confirmation_.confirmed ? OptimumStatus::optimal : OptimumStatus::local;
}

void Optimisation::follow_front(const Start& start) {
  ParetoOutcome front = search_front(campaign_, *start.book, start.result);
  optimum_.pareto = std::move(front.report);
  add(later_, front.evaluations);
}

void Optimisation::take_stock_sizes(const Start& start, Chosen& answer) {
  StockOutcome stock = search_stock(campaign_, *start.book, answer.pose, answer.best);
  stock_ = std::move(stock.evaluations);
  if (stock.report.chosen >= 0) {
    answer = {stock.pose, *stock.chosen.best, stock.chosen.multipliers};
    judge(problem_, campaign_.scales, answer,
          kept_if(stock.report.settled && stock.chosen.summary.reason == StopReason::converged),
          optimum_);
    optimum_.stop_reason = stock.report.message;
  } else {
    optimum_.status = OptimumStatus::infeasible;
    optimum_.stop_reason = fmt::format(
        "none of the {} neighbouring stock designs tried is feasible; shown is the optimum of any "
        "size",
        stock.report.designs.size());
  }
  optimum_.stock = std::move(stock.report);
}

std::optional<VerificationLoop> Optimisation::correct(const VerifySpec& rules, const Start& start,
                                                      Chosen& answer) {
  VerificationOutcome found =
      verify_optimum(campaign_, rules, *start.book, answer.pose, answer.best);
  add(later_, found.evaluations);
  if (found.best) {
    answer = {found.pose, *found.best, {}};
    judge(problem_, campaign_.scales, answer, kept_if(found.report.converged), optimum_);
    optimum_.at_full_accuracy = true;
    if (found.report.kkt) optimum_.kkt = found.report.kkt;
    if (!feasible())
      optimum_.stop_reason =
          fmt::format("at full accuracy: {}. {}",
                      violated_words(optimum_.constraints, campaign_.scales), found.report.message);
  } else {
    optimum_.status = OptimumStatus::feasible;
    optimum_.stop_reason = found.report.message;
  }
  return std::move(found.report);
}

void Optimisation::finish(Start& start, Chosen answer) {
  const bool reached = feasible();
  if (reached && spec_.pareto) follow_front(start);
  if (reached && has_stock(spec_)) take_stock_sizes(start, answer);
  const DesignValues own_values = answer.best.values;
  std::optional<VerificationLoop> loop;
  // a search on reduced leaves is finished on full ones, that the answer be optimal for these
  std::optional<VerifySpec> rules = spec_.verify;
  if (!rules && (own_values.of_reduced_leaves || problem_.job().search_model)) rules.emplace();
  if (rules && feasible()) loop = correct(*rules, start, answer);
  add(later_, stock_);

  // neighbours for differences go to the start's own evaluations where it is still its design
  const bool moved = optimum_.stock || loop;
  EvaluationBook last = campaign_.book(Stage::verification, 1, moved ? start.book.get() : nullptr);
  EvaluationBook& knows = moved ? last : *start.book;
  add_derivatives(knows, answer, optimum_);
  const Variables variables = problem_.variables(answer.best.x);
  int cost = 0;
  const DesignValues own = optimum_.at_full_accuracy ? knows.at(variables, cost) : own_values;
  if (moved) add(later_, last.evaluations());
  why_differences_at_end_ = last.why_differences();
  add_paths(problem_, variables, own, options_.threads, optimum_);
  optimum_.verified->loop = std::move(loop);
}

void Optimisation::tell_gradients() {
  bool differences = false;
  for (const Start& start : starts_) {
    differences = differences || start.book->used_differences();
    for (const LoggedEvaluation& e : start.book->evaluations())
      optimum_.of_reduced_leaves |= e.values.of_reduced_leaves;
    if (optimum_.gradients_message.empty())
      optimum_.gradients_message = start.book->why_differences();
  }
  if (optimum_.gradients_message.empty()) optimum_.gradients_message = why_differences_at_end_;
  const bool gradients = algorithm_of(optimiser_options(spec_)).gradients;
  optimum_.gradients = !gradients ? "none" : !differences ? "exact" : "central differences";
}

void Optimisation::close_log() {
  std::vector<LoggedEvaluation> all;
  for (const Start& start : starts_) add(all, start.book->evaluations());
  add(all, later_);
  for (const LoggedEvaluation& e : all) {
    optimum_.history.push_back(e.record);
    if (!e.record.ok) ++optimum_.failed_evaluations;
  }
  optimum_.evaluations = static_cast<int>(all.size());
  log_.finish(all);
}

Optimum Optimisation::run() {
  search_from_starts();
  if (std::optional<Chosen> answer = best_end()) finish(best_start(), *std::move(answer));
  if (campaign_.workers) campaign_.workers->end_stage();
  tell_gradients();
  close_log();
  return std::move(optimum_);
}

/// The work of a process that follows: designs as the leader asks for them.
void help_optimise(const Job& job, const OptimiseOptions& options) {
  if (job.optimise->search == SearchKind::global) screen(job, options);
  answer_evaluations(*options.sharing->workers(), DesignProblem(job, options.evaluators));
}

}  // namespace

Optimum optimise(const Job& job, const OptimiseOptions& options) {
  assert(job.optimise);
  if (!options.sharing || !options.sharing->follows()) return Optimisation(job, options).run();
  help_optimise(job, options);
  return {};
}

}  // namespace flexopt
