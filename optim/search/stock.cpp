#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>

#include "optim/search/stages.hpp"
#include "optim/solvers/parallel.hpp"

namespace flexopt {
namespace {

constexpr std::size_t most_considered = 64, most_searched = 8;

struct Neighbour {
  VectorXd x;           ///< scaled; other variables as at the optimum
  double distance = 0;  ///< from the optimum
  std::optional<Candidate> seen;
};

/// Scaled places of the next smaller and the next larger size; one where a size is hit.
std::vector<double> next_sizes(const DesignProblem& problem, std::size_t variable, double at) {
  const Variable& of = problem.spec().variables[variable];
  const double value = of.min + at * (of.max - of.min), near = 1e-9 * (of.max - of.min);
  const auto scaled = [&](double size) { return (size - of.min) / (of.max - of.min); };
  const auto above = std::lower_bound(of.stock.begin(), of.stock.end(), value - near);
  if (above == of.stock.end()) return {scaled(of.stock.back())};
  if (*above <= value + near || above == of.stock.begin()) return {scaled(*above)};
  return {scaled(*(above - 1)), scaled(*above)};
}

/// All combinations of available sizes, the nearest ones first.
std::vector<Neighbour> neighbours(const DesignProblem& problem, const VectorXd& x) {
  std::vector<Neighbour> all{{x, 0, {}}};
  const std::vector<Variable>& variables = problem.spec().variables;
  for (std::size_t j = 0; j < variables.size(); ++j) {
    if (variables[j].stock.empty()) continue;
    const auto column = static_cast<Eigen::Index>(j);
    std::vector<Neighbour> more;
    for (const double size : next_sizes(problem, j, x[column]))
      for (Neighbour n : all) {
        n.x[column] = size;
        n.distance += std::abs(size - x[column]);
        more.push_back(std::move(n));
      }
    std::stable_sort(more.begin(), more.end(), [](const Neighbour& a, const Neighbour& b) {
      return a.distance < b.distance;
    });
    // dropping the farthest half-way keeps a job of many stock variables bounded
    if (more.size() > most_considered) more.resize(most_considered);
    all = std::move(more);
  }
  // to the same bits as the sizes themselves
  for (Neighbour& n : all) {
    Variables values = problem.variables(n.x);
    for (std::size_t j = 0; j < variables.size(); ++j) {
      const std::vector<double>& stock = variables[j].stock;
      if (stock.empty()) continue;
      values[j] = *std::min_element(stock.begin(), stock.end(), [&](double a, double b) {
        return std::abs(a - values[j]) < std::abs(b - values[j]);
      });
    }
    n.x = problem.scaled(values);
  }
  return all;
}

int combinations(const DesignProblem& problem, const VectorXd& x) {
  double count = 1;
  for (std::size_t j = 0; j < problem.spec().variables.size(); ++j)
    if (!problem.spec().variables[j].stock.empty())
      count *= static_cast<double>(next_sizes(problem, j, x[static_cast<Eigen::Index>(j)]).size());
  return static_cast<int>(std::min(count, 1e9));
}

ParameterValues sizes_of(const DesignProblem& problem, const VectorXd& x) {
  ParameterValues sizes;
  const Variables values = problem.variables(x);
  for (std::size_t j = 0; j < values.size(); ++j)
    if (!problem.spec().variables[j].stock.empty())
      sizes[problem.spec().variables[j].parameter] = values[j];
  return sizes;
}

Pose held_at(const DesignProblem& problem, Pose pose, const VectorXd& x) {
  for (Eigen::Index j = 0; j < x.size(); ++j)
    if (!problem.spec().variables[static_cast<std::size_t>(j)].stock.empty())
      pose.lower[j] = pose.upper[j] = x[j];
  return pose;
}

StockDesign report_of(const DesignProblem& problem, const VectorXd& sizes, const SearchResult& r) {
  StockDesign design{end_of(problem, r), sizes_of(problem, sizes), {}};
  if (r.best) design.parameters = problem.parameters(problem.variables(r.best->x));
  return design;
}

/// Search from combination to combination of sizes, until none of the neighbours is better.
class Sizes {
 public:
  Sizes(const Campaign& campaign, const EvaluationBook& known, const Pose& pose)
      : campaign_(campaign),
        problem_(campaign.problem),
        spec_(campaign.problem.spec()),
        pose_(pose),
        book_(campaign.book(Stage::stock, 0, &known)) {}
  StockOutcome run(const Candidate& optimum);

 private:
  /// Evaluates combinations that were not tried yet, and searches from the best of them.
  void try_all(std::vector<Neighbour> these);
  void search_from(const std::vector<Neighbour>& these);
  /// Designs that were not tried whose sizes differ from this one's by at most one step each, with
  /// its other variables.
  std::vector<Neighbour> beside(const Candidate& at);
  /// Moves one size further and further away, with any values of the other sizes. Where that is
  /// better than the best, the combinations round it are tried. Returns whether one of them is
  /// better.
  bool look_further();
  bool spent(std::size_t more) const {
    return static_cast<int>(book_.evaluations().size() + more) > spec_.max_evaluations;
  }
  void tell(std::size_t beside);

  const Campaign& campaign_;
  const DesignProblem& problem_;
  const OptimiseSpec& spec_;
  const Pose& pose_;
  EvaluationBook book_;
  std::set<std::vector<double>> tried_;  ///< scaled sizes
  std::optional<Candidate> best_;        ///< best of all: feasible, or the least violated
  StockOutcome outcome_;
};

std::vector<double> key_of(const DesignProblem& problem, const VectorXd& x) {
  std::vector<double> key;
  for (std::size_t j = 0; j < problem.spec().variables.size(); ++j)
    if (!problem.spec().variables[j].stock.empty()) key.push_back(x[static_cast<Eigen::Index>(j)]);
  return key;
}

void Sizes::search_from(const std::vector<Neighbour>& these) {
  const Posing posing(problem_, book_, pose_, true);
  const auto count = static_cast<int>(these.size());
  if (count == 0) return;
  const auto first = static_cast<int>(outcome_.report.designs.size());
  std::vector<std::unique_ptr<EvaluationBook>> books;
  std::vector<SearchResult> results(these.size());
  const int together = std::clamp(campaign_.threads, 1, count);
  for (int i = 0; i < count; ++i) {
    books.push_back(
        std::make_unique<EvaluationBook>(campaign_.book(Stage::stock, first + i + 1, &book_)));
    books.back()->set_threads(std::max(1, campaign_.threads / together));
  }
  parallel_for(count, together, [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    results[k] = search(problem_, *books[k], held_at(problem_, pose_, these[k].x), these[k].x,
                        {spec_.max_evaluations, true});
  });
  for (std::size_t k = 0; k < these.size(); ++k) {
    outcome_.evaluations.insert(outcome_.evaluations.end(), books[k]->evaluations().begin(),
                                books[k]->evaluations().end());
    SearchResult& r = results[k];
    if (r.best)
      r.best = weigh(problem_, campaign_.scales, pose_, VectorXd(r.best->x),
                     DesignValues(r.best->values));
    StockDesign design = report_of(problem_, these[k].x, r);
    const bool better = r.best && (!best_ || posing.better(*r.best, *best_));
    if (better) best_ = r.best;
    if (better && design.feasible) {
      outcome_.report.chosen = first + static_cast<int>(k);
      outcome_.chosen = r;
      outcome_.pose = held_at(problem_, pose_, these[k].x);
    }
    outcome_.report.designs.push_back(std::move(design));
  }
}

void Sizes::try_all(std::vector<Neighbour> these) {
  const Posing posing(problem_, book_, pose_, true);
  int cost = 0;
  for (Neighbour& n : these) {
    n.seen = posing.assess(n.x, cost);
    tried_.insert(key_of(problem_, n.x));
  }
  std::stable_sort(these.begin(), these.end(), [&](const Neighbour& a, const Neighbour& b) {
    if (!a.seen || !b.seen) return a.seen.has_value() && !b.seen.has_value();
    return posing.better(*a.seen, *b.seen);
  });
  if (these.size() > most_searched) these.resize(most_searched);
  search_from(these);
}

std::vector<Neighbour> Sizes::beside(const Candidate& at) {
  std::vector<Neighbour> all{{at.x, 0, {}}};
  const std::vector<Variable>& variables = spec_.variables;
  const Variables values = problem_.variables(at.x);
  for (std::size_t j = 0; j < variables.size(); ++j) {
    const std::vector<double>& stock = variables[j].stock;
    if (stock.empty()) continue;
    const auto here = std::ranges::find(stock, values[j]);
    assert(here != stock.end());
    std::vector<Neighbour> more;
    for (const Neighbour& n : all)
      for (const int step : {0, -1, 1}) {
        if ((step < 0 && here == stock.begin()) || (step > 0 && here + 1 == stock.end())) continue;
        Variables moved = problem_.variables(n.x);
        moved[j] = *(here + step);
        more.push_back({problem_.scaled(moved), n.distance + std::abs(step), {}});
      }
    std::ranges::stable_sort(more, {}, &Neighbour::distance);
    if (more.size() > most_considered) more.resize(most_considered);
    all = std::move(more);
  }
  std::erase_if(all, [&](const Neighbour& n) { return tried_.contains(key_of(problem_, n.x)); });
  return all;
}

bool Sizes::look_further() {
  const Candidate from = *best_;
  const std::vector<Variable>& variables = spec_.variables;
  if (std::ranges::count_if(variables, [](const Variable& v) { return !v.stock.empty(); }) < 2)
    return false;
  const Variables values = problem_.variables(from.x);
  for (std::size_t j = 0; j < variables.size(); ++j) {
    const std::vector<double>& stock = variables[j].stock;
    if (stock.empty()) continue;
    const auto here = std::ranges::find(stock, values[j]) - stock.begin();
    for (const std::ptrdiff_t side : {-1, 1}) {
      VectorXd x = from.x;
      for (std::ptrdiff_t k = here + side; k >= 0 && k < std::ssize(stock); k += side) {
        if (spent(1)) return false;
        Variables moved = problem_.variables(x);
        moved[j] = stock[static_cast<std::size_t>(k)];
        x = problem_.scaled(moved);
        Pose held = pose_;
        const auto column = static_cast<Eigen::Index>(j);
        held.lower[column] = held.upper[column] = x[column];
        const SearchResult any = search(problem_, book_, held, x, {spec_.max_evaluations, true});
        book_.set_scales(campaign_.scales);
        if (!any.best) break;
        const Candidate relaxed =
            weigh(problem_, campaign_.scales, pose_, any.best->x, any.best->values);
        if (!Posing(problem_, book_, pose_, true).better(relaxed, *best_)) break;
        std::vector<Neighbour> round = neighbours(problem_, relaxed.x);
        std::erase_if(round,
                      [&](const Neighbour& n) { return tried_.contains(key_of(problem_, n.x)); });
        try_all(std::move(round));
        if (best_->x != from.x) return true;
        x = relaxed.x;
      }
    }
  }
  return false;
}

void Sizes::tell(std::size_t beside) {
  StockSearch& report = outcome_.report;
  report.tried = static_cast<int>(tried_.size());
  const bool all_held =
      std::ranges::none_of(spec_.variables, [](const Variable& v) { return v.stock.empty(); });
  report.message = fmt::format(
      "{} combinations of sizes tried{}: {}{}", report.tried,
      all_held
          ? ""
          : fmt::format(", {} of them with the other variables searched", report.designs.size()),
      report.settled
          ? "none that is a step beside the chosen one in any of the sizes is better"
          : fmt::format("the evaluations are spent, {} beside the chosen one are not tried",
                        beside),
      all_held ? "" : "; " + outcome_.chosen.summary.message);
}

StockOutcome Sizes::run(const Candidate& optimum) {
  outcome_.report.continuous = problem_.parameters(problem_.variables(optimum.x));
  outcome_.report.continuous_objective = optimum.objective;
  outcome_.report.neighbours = combinations(problem_, optimum.x);
  try_all(neighbours(problem_, optimum.x));
  std::size_t untried = 0;
  while (best_ && !outcome_.report.settled) {
    const VectorXd here = best_->x;
    std::vector<Neighbour> more = beside(*best_);
    untried = more.size();
    if (spent(untried)) break;
    try_all(std::move(more));
    untried = 0;
    if (best_->x != here || look_further()) continue;
    outcome_.report.settled = !spent(1);
    break;
  }
  tell(untried);
  outcome_.evaluations.insert(outcome_.evaluations.begin(), book_.evaluations().begin(),
                              book_.evaluations().end());
  return std::move(outcome_);
}

}  // namespace

bool has_stock(const OptimiseSpec& spec) {
  return std::any_of(spec.variables.begin(), spec.variables.end(),
                     [](const Variable& v) { return !v.stock.empty(); });
}

StockOutcome search_stock(const Campaign& campaign, const EvaluationBook& known, const Pose& pose,
                          const Candidate& optimum) {
  return Sizes(campaign, known, pose).run(optimum);
}

}  // namespace flexopt
