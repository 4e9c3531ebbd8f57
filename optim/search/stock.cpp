#include "optim/search/stock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "optim/numerics/parallel.hpp"

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

/// All combinations, the nearest ones first.
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
  StockDesign design;
  design.sizes = sizes_of(problem, sizes);
  design.status = word_of(r.summary.reason);
  design.stop_reason = r.summary.message;
  design.evaluations = r.evaluations;
  if (!r.best) return design;
  design.ok = true;
  design.parameters = problem.parameters(problem.variables(r.best->x));
  design.objective = r.best->objective;
  design.violation = r.best->violation;
  design.feasible = r.best->violation <= problem.spec().constraint_tolerance;
  return design;
}

}  // namespace

bool has_stock(const OptimiseSpec& spec) {
  return std::any_of(spec.variables.begin(), spec.variables.end(),
                     [](const Variable& v) { return !v.stock.empty(); });
}

StockOutcome search_stock(const Campaign& campaign, const EvaluationBook& known, const Pose& pose,
                          const Candidate& optimum) {
  const DesignProblem& problem = campaign.problem;
  const OptimiseSpec& spec = problem.spec();
  StockOutcome outcome;
  outcome.report.continuous = problem.parameters(problem.variables(optimum.x));
  outcome.report.continuous_objective = optimum.objective;
  outcome.report.neighbours = combinations(problem, optimum.x);

  std::vector<Neighbour> all = neighbours(problem, optimum.x);
  EvaluationBook first = campaign.book(Stage::stock, 0, &known);
  const Posing posing(problem, first, pose, true);
  int cost = 0;
  for (Neighbour& n : all) n.seen = posing.assess(n.x, cost);
  std::stable_sort(all.begin(), all.end(), [&](const Neighbour& a, const Neighbour& b) {
    if (!a.seen || !b.seen) return a.seen.has_value() && !b.seen.has_value();
    return posing.better(*a.seen, *b.seen);
  });
  if (all.size() > most_searched) all.resize(most_searched);
  const auto keep = [&](const EvaluationBook& book) {
    outcome.evaluations.insert(outcome.evaluations.end(), book.evaluations().begin(),
                               book.evaluations().end());
  };
  keep(first);

  const auto count = static_cast<int>(all.size());
  std::vector<std::unique_ptr<EvaluationBook>> books;
  std::vector<SearchResult> results(all.size());
  const int together = std::clamp(campaign.threads, 1, count);
  for (int i = 0; i < count; ++i) {
    books.push_back(std::make_unique<EvaluationBook>(campaign.book(Stage::stock, i + 1, &first)));
    books.back()->set_threads(std::max(1, campaign.threads / together));
  }
  parallel_for(count, together, [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    results[k] = search(problem, *books[k], held_at(problem, pose, all[k].x), all[k].x,
                        {spec.max_evaluations, true, {}});
  });
  for (std::size_t k = 0; k < all.size(); ++k) {
    keep(*books[k]);
    const SearchResult& r = results[k];
    StockDesign design = report_of(problem, all[k].x, r);
    if (design.feasible &&
        (outcome.report.chosen < 0 || posing.better(*r.best, *outcome.chosen.best))) {
      outcome.report.chosen = static_cast<int>(k);
      outcome.chosen = r;
      outcome.pose = held_at(problem, pose, all[k].x);
    }
    outcome.report.designs.push_back(std::move(design));
  }
  return outcome;
}

}  // namespace flexopt
