#include "optim/problem/robust_goals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace flexopt {

namespace {

// Modes change ranks between neighbours, places of largest stress too: the rows of `there` within
// each point's branches in the order of the nearest derivatives.
MatrixXd in_order_of(const MatrixXd& here, const MatrixXd& there, const std::vector<Goal>& goals,
                     const std::vector<GoalValues>& values) {
  MatrixXd ordered = there;
  Eigen::Index row = 0;
  for (std::size_t g = 0; g < goals.size(); ++g) {
    const Eigen::Index b = goals[g].branches, end = row + std::ssize(values[g]);
    for (; b > 1 && row < end; row += b) {
      const auto block = here.middleRows(row, b);
      const Eigen::RowVectorXd size = block.cwiseAbs().colwise().maxCoeff().cwiseMax(1e-300);
      std::vector<Eigen::Index> left(b);
      std::iota(left.begin(), left.end(), row);
      for (Eigen::Index i = row; i < row + b; ++i) {
        const auto nearest = std::ranges::min_element(left, {}, [&](Eigen::Index j) {
          return (there.row(j) - here.row(i)).cwiseQuotient(size).squaredNorm();
        });
        ordered.row(i) = there.row(*nearest);
        left.erase(nearest);
      }
    }
    row = end;
  }
  return ordered;
}

// The candidates of each point from the worst on, as a goal has them.
void sort_branches(const Goal& goal, GoalValues& values, Eigen::Ref<MatrixXd> rows) {
  const double sign = goal.over_stroke == OverStroke::max ? -1 : 1;
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  for (auto first = order.begin(); first != order.end(); first += goal.branches)
    std::ranges::stable_sort(first, first + goal.branches, {},
                             [&](std::size_t i) { return sign * values[i]; });
  const GoalValues old = values;
  std::ranges::transform(order, values.begin(), [&](std::size_t i) { return old[i]; });
  rows = MatrixXd(rows(order, Eigen::all));
}

// Step of a tolerance, small enough that the parameters change by a thousandth at most.
double step_along(const Tolerance& entry, const ParameterValues& parameters) {
  double largest = 0;
  for (const ToleranceTerm& term : entry.terms)
    if (const double value = term.value_in(parameters); value != 0)
      largest = std::max(largest, std::abs(term.change_of(value) / value));
  return largest > 0 ? std::min(1.0, 1e-3 / largest) : 1.0;
}

VectorXd standard_deviations(const std::vector<Tolerance>& entries) {
  VectorXd list(entries.size());
  for (std::size_t e = 0; e < entries.size(); ++e) list[e] = entries[e].standard_deviation();
  return list;
}

VectorXd variances(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  return slopes.cwiseProduct(standard_deviations(entries)).cwiseAbs2();
}

}  // namespace

double tolerance_margin(const ToleranceMargin& margin, const std::vector<Tolerance>& entries,
                        const ToleranceSlopes& slopes) {
  if (margin.kind == ToleranceMargin::Kind::worst) return farthest(slopes);
  return margin.deviations * standard_deviation(entries, slopes);
}

VectorXd margin_weights(const ToleranceMargin& margin, const std::vector<Tolerance>& entries,
                        const ToleranceSlopes& slopes) {
  const double m = tolerance_margin(margin, entries, slopes), k = margin.deviations;
  if (!(m > 0)) return VectorXd::Zero(slopes.size());
  if (margin.kind == ToleranceMargin::Kind::worst) return slopes.cwiseSign();
  const Eigen::ArrayXd sigma = standard_deviations(entries).array();
  return (k * k * slopes.array() * sigma * sigma / m).matrix();
}

std::vector<MatrixXd> RobustGoals::slope_rates(const ParameterValues& parameters, const Look& look,
                                               DesignValues& here) const {
  std::vector<MatrixXd> rates;
  for (const Tolerance& entry : entries) {
    const double h = step_along(entry, parameters);
    const auto beside = [&](double z) {
      ParameterValues moved = parameters;
      for (const ToleranceTerm& term : entry.terms)
        moved[term.parameter] += z * term.change_in(parameters);
      return look(moved);
    };
    const DesignValues up = beside(h), down = beside(-h);
    for (const DesignValues* one : {&up, &down})
      if (one->gradient.rows() != here.gradient.rows()) {
        here.no_gradient = fmt::format("no derivatives where {} deviates: {}", entry.name,
                                       one->ok ? one->no_gradient : one->message);
        return {};
      }
    const auto ordered = [&](const DesignValues& one) {
      return in_order_of(here.gradient, one.gradient, goals, here.goals);
    };
    MatrixXd& rate = rates.emplace_back((ordered(up) - ordered(down)) / (2 * h));
    for (const ToleranceTerm& term : entry.terms) {
      // of one leaf: the limit grows with the parameter of all
      const auto all = std::ranges::find(names, parts_of_name(term.parameter).parameter),
                 own = std::ranges::find(names, term.parameter);
      if (!term.relative || all == names.end()) continue;
      const double growth = term.value_in(parameters) < 0 ? -term.change : term.change;
      rate.col(all - names.begin()) += growth * here.gradient.col(own - names.begin());
    }
  }
  return rates;
}

void RobustGoals::add_margins(const ParameterValues& parameters, bool gradient, const Look& look,
                              DesignValues& here) const {
  if (!here.ok) return;
  if (here.gradient.rows() == 0) {
    here.ok = false;
    here.reason = "tolerances cannot be counted";
    here.message = here.reason + ": " + here.no_gradient;
    here.goals.clear();
    return;
  }
  const MatrixXd slopes = here.gradient * tolerance_changes(entries, names, parameters);
  const std::vector<MatrixXd> rates =
      gradient ? slope_rates(parameters, look, here) : std::vector<MatrixXd>();
  Eigen::Index row = 0;
  for (std::size_t g = 0; g < goals.size(); ++g) {
    const Goal& goal = goals[g];
    GoalValues& values = here.goals[g];
    const auto count = std::ssize(values);
    for (Eigen::Index i = 0; goal.margin && i < count; ++i) {
      double& v = values[i];
      const ToleranceSlopes s = slopes.row(row + i).transpose();
      const double m = tolerance_margin(goal.margin, entries, s);
      const double way = goal.over_stroke == OverStroke::max_abs && v < 0 ? -1 : 1;
      const double side = goal.least ? -way : way;
      const bool none = goal.over_stroke == OverStroke::max_abs && goal.least && m > std::abs(v);
      v = none ? 0 : v + side * m;
      if (rates.empty()) continue;
      const VectorXd c = side * margin_weights(goal.margin, entries, s);
      for (std::size_t e = 0; e < rates.size(); ++e)
        here.gradient.row(row + i) += c[e] * rates[e].row(row + i);
      if (none) here.gradient.row(row + i).setZero();
    }
    if (goal.margin && goal.branches > 1)
      sort_branches(goal, values, here.gradient.middleRows(row, count));
    row += count;
  }
  if (rates.empty()) here.gradient.resize(0, 0);
}

MatrixXd tolerance_changes(const std::vector<Tolerance>& entries,
                           const std::vector<std::string>& names,
                           const ParameterValues& parameters) {
  MatrixXd changes = MatrixXd::Zero(names.size(), entries.size());
  for (std::size_t e = 0; e < entries.size(); ++e)
    for (const ToleranceTerm& term : entries[e].terms)
      if (const auto found = std::ranges::find(names, term.parameter); found != names.end())
        changes(found - names.begin(), e) += term.change_in(parameters);
  return changes;
}

double farthest(const ToleranceSlopes& slopes) { return slopes.cwiseAbs().sum(); }

double standard_deviation(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  return std::sqrt(variances(entries, slopes).sum());
}

VectorXd variance_shares(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  const VectorXd list = variances(entries, slopes);
  const double all = list.sum();
  return all > 0 ? VectorXd(list / all) : VectorXd::Zero(list.size());
}

}  // namespace flexopt
