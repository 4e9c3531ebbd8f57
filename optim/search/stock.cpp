#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <set>

#include "optim/search/stages.hpp"
#include "optim/solvers/parallel.hpp"

namespace flexopt {
namespace {

constexpr std::size_t most_considered = 64, most_searched = 8;

struct Neighbour {
  Variables values;     ///< other variables as at the optimum
  double distance = 0;  ///< from the optimum
  VectorXd x = {};      ///< scaled, to the same bits as the sizes themselves
  std::optional<Candidate> seen = {};
};

/// A size that a variable may have, and how far it is.
struct Size {
  double size = 0, distance = 0;
};

/// Places of the variables that carry sizes.
std::vector<std::size_t> stock_variables(const OptimiseSpec& spec) {
  std::vector<std::size_t> places;
  for (std::size_t j = 0; j < spec.variables.size(); ++j)
    if (!spec.variables[j].stock.empty()) places.push_back(j);
  return places;
}

/// The next smaller and the next larger size; one where a size is hit.
std::vector<Size> next_sizes(const Variable& of, double at) {
  const double value = of.min + at * (of.max - of.min), near = 1e-9 * (of.max - of.min);
  const auto size = [&](double next) {
    return Size{next, std::abs((next - of.min) / (of.max - of.min) - at)};
  };
  const auto above = std::lower_bound(of.stock.begin(), of.stock.end(), value - near);
  if (above == of.stock.end()) return {size(of.stock.back())};
  if (*above <= value + near || above == of.stock.begin()) return {size(*above)};
  return {size(*(above - 1)), size(*above)};
}

/// The size itself, and those one step from it.
std::vector<Size> sizes_a_step_from(const Variable& of, double value) {
  const auto here = std::ranges::find(of.stock, value);
  assert(here != of.stock.end());
  std::vector<Size> sizes{{value, 0}};
  if (here != of.stock.begin()) sizes.push_back({*(here - 1), 1});
  if (here + 1 != of.stock.end()) sizes.push_back({*(here + 1), 1});
  return sizes;
}

/// Search from combination to combination of sizes, until none of the neighbours is better.
class Sizes {
 public:
  Sizes(const Campaign& campaign, const EvaluationBook& known, const Pose& pose)
      : campaign_(campaign),
        problem_(campaign.problem),
        spec_(campaign.problem.spec()),
        pose_(pose),
        stock_(stock_variables(spec_)),
        book_(campaign.book(Stage::stock, 0, &known)) {}
  StockOutcome run(const Candidate& optimum);

 private:
  /// Evaluates combinations that were not tried yet, and searches from the best of them.
  void try_all(std::vector<Neighbour> these);
  void search_from(const std::vector<Neighbour>& these);
  /// Combinations that were not tried of the sizes that each variable may have, with the other
  /// variables of x, the nearest ones first.
  std::vector<Neighbour> combined(
      const VectorXd& x, const std::function<std::vector<Size>(std::size_t variable)>& sizes) const;
  /// Combinations of the next smaller and the next larger sizes.
  std::vector<Neighbour> neighbours(const VectorXd& x) const;
  /// Combinations of sizes that differ from those of x by at most one step each.
  std::vector<Neighbour> beside(const VectorXd& x) const;
  std::vector<double> key_of(const VectorXd& x) const;
  Pose held_at(const VectorXd& x) const;
  StockDesign report_of(const VectorXd& sizes, const SearchResult& r) const;
  int combinations(const VectorXd& x) const;
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
  std::vector<std::size_t> stock_;  ///< variables that carry sizes
  EvaluationBook book_;
  std::set<std::vector<double>> tried_;  ///< scaled sizes
  std::optional<Candidate> best_;        ///< best of all: feasible, or the least violated
  StockOutcome outcome_;
};

std::vector<double> Sizes::key_of(const VectorXd& x) const {
  std::vector<double> key;
  for (const std::size_t j : stock_) key.push_back(x[j]);
  return key;
}

Pose Sizes::held_at(const VectorXd& x) const {
  Pose pose = pose_;
  for (const std::size_t j : stock_) pose.lower[j] = pose.upper[j] = x[j];
  return pose;
}

StockDesign Sizes::report_of(const VectorXd& sizes, const SearchResult& r) const {
  StockDesign design{end_of(problem_, r), {}, {}};
  const Variables values = problem_.variables(sizes);
  for (const std::size_t j : stock_) design.sizes[spec_.variables[j].parameter] = values[j];
  if (r.best) design.parameters = problem_.parameters(problem_.variables(r.best->x));
  return design;
}

int Sizes::combinations(const VectorXd& x) const {
  double count = 1;
  for (const std::size_t j : stock_)
    count *= static_cast<double>(next_sizes(spec_.variables[j], x[j]).size());
  return static_cast<int>(std::min(count, 1e9));
}

void Sizes::search_from(const std::vector<Neighbour>& these) {
  const Posing posing(book_, pose_, true);
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
  parallel_for(count, together, [&](int k) {
    results[k] = search(*books[k], held_at(these[k].x), these[k].x, spec_.max_evaluations, true);
  });
  for (std::size_t k = 0; k < these.size(); ++k) {
    outcome_.evaluations.insert(outcome_.evaluations.end(), books[k]->evaluations().begin(),
                                books[k]->evaluations().end());
    SearchResult& r = results[k];
    if (r.best) weigh(problem_, campaign_.scales, pose_, *r.best);
    StockDesign design = report_of(these[k].x, r);
    const bool better = r.best && (!best_ || posing.better(*r.best, *best_));
    if (better) best_ = r.best;
    if (better && design.feasible) {
      outcome_.report.chosen = first + static_cast<int>(k);
      outcome_.chosen = r;
      outcome_.pose = held_at(these[k].x);
    }
    outcome_.report.designs.push_back(std::move(design));
  }
}

void Sizes::try_all(std::vector<Neighbour> these) {
  const Posing posing(book_, pose_, true);
  int cost = 0;
  for (Neighbour& n : these) {
    n.seen = posing.assess(n.x, cost);
    tried_.insert(key_of(n.x));
  }
  std::stable_sort(these.begin(), these.end(), [&](const Neighbour& a, const Neighbour& b) {
    if (!a.seen || !b.seen) return a.seen.has_value() && !b.seen.has_value();
    return posing.better(*a.seen, *b.seen);
  });
  if (these.size() > most_searched) these.resize(most_searched);
  search_from(these);
}

std::vector<Neighbour> Sizes::combined(
    const VectorXd& x, const std::function<std::vector<Size>(std::size_t)>& sizes) const {
  std::vector<Neighbour> all{{problem_.variables(x)}};
  for (const std::size_t j : stock_) {
    std::vector<Neighbour> more;
    for (const Neighbour& n : all)
      for (const auto& [size, distance] : sizes(j)) {
        more.push_back(n);
        more.back().values[j] = size;
        more.back().distance += distance;
      }
    std::ranges::stable_sort(more, {}, &Neighbour::distance);
    // dropping the farthest half-way keeps a job of many stock variables bounded
    if (more.size() > most_considered) more.resize(most_considered);
    all = std::move(more);
  }
  for (Neighbour& n : all) n.x = problem_.scaled(n.values);
  std::erase_if(all, [&](const Neighbour& n) { return tried_.contains(key_of(n.x)); });
  return all;
}

std::vector<Neighbour> Sizes::neighbours(const VectorXd& x) const {
  return combined(x, [&](std::size_t j) { return next_sizes(spec_.variables[j], x[j]); });
}

std::vector<Neighbour> Sizes::beside(const VectorXd& x) const {
  const Variables values = problem_.variables(x);
  return combined(x,
                  [&](std::size_t j) { return sizes_a_step_from(spec_.variables[j], values[j]); });
}

bool Sizes::look_further() {
  const Candidate from = *best_;
  if (stock_.size() < 2) return false;
  const Variables values = problem_.variables(from.x);
  for (const std::size_t j : stock_) {
    const std::vector<double>& stock = spec_.variables[j].stock;
    const auto here = std::ranges::find(stock, values[j]) - stock.begin();
    for (const std::ptrdiff_t side : {-1, 1}) {
      VectorXd x = from.x;
      for (std::ptrdiff_t k = here + side; k >= 0 && k < std::ssize(stock); k += side) {
        if (spent(1)) return false;
        Variables moved = problem_.variables(x);
        moved[j] = stock[k];
        x = problem_.scaled(moved);
        Pose held = pose_;
        held.lower[j] = held.upper[j] = x[j];
        const SearchResult any = search(book_, held, x, spec_.max_evaluations, true);
        book_.set_scales(campaign_.scales);
        if (!any.best) break;
        const Candidate relaxed =
            weigh(problem_, campaign_.scales, pose_, any.best->x, any.best->values);
        if (!Posing(book_, pose_, true).better(relaxed, *best_)) break;
        try_all(neighbours(relaxed.x));
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
  const bool all_held = stock_.size() == spec_.variables.size();
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
  outcome_.report.neighbours = combinations(optimum.x);
  try_all(neighbours(optimum.x));
  std::size_t untried = 0;
  while (best_ && !outcome_.report.settled) {
    const VectorXd here = best_->x;
    std::vector<Neighbour> more = beside(best_->x);
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

bool has_stock(const OptimiseSpec& spec) { return !stock_variables(spec).empty(); }

StockOutcome search_stock(const Campaign& campaign, const EvaluationBook& known, const Pose& pose,
                          const Candidate& optimum) {
  return Sizes(campaign, known, pose).run(optimum);
}

}  // namespace flexopt
