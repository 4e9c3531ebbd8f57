#include "results/library/runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "core/spec/spec_error.hpp"
#include "optim/solvers/parallel.hpp"
#include "results/files/folder.hpp"

namespace flexopt {

namespace {

constexpr std::size_t remembered = 32;

/// The job as one that is searched with exact derivatives: its values are then those that these
/// belong to.
Job differentiated(Job job) {
  if (!job.optimise) throw SpecError("/optimise", "missing", "expected variables and an objective");
  demand_one_design(job, "expected a job of one design");
  job.optimise->pareto.reset();
  job.optimise->algorithm = {"nlopt", "LD_SLSQP", {}};
  return job;
}

/// Whether a limit of the goal is one of each of its entries.
bool holds_everywhere(const Goal& goal, bool upper) {
  if (goal.of_parameters()) return false;
  if (goal.over_stroke == OverStroke::max_abs) return upper;
  return goal.over_stroke == (upper ? OverStroke::max : OverStroke::min);
}

}  // namespace

Job as_kind(const Job& job, JobKind kind) {
  demand_one_design(job, "expected a job of one design; the command line runs those of several");
  if (job.kind == kind) return job;
  nlohmann::json document = document_of(job);
  document["job"] = name_of(kind);
  document["expect"] = nlohmann::json::array();  // they are of the job as it was
  return parse_job(document);
}

FinishedRun run(const Job& job, const RunOptions& options, RunListener& listener) {
  const auto begin = std::chrono::steady_clock::now();
  static const int hardware =  // asking takes long
      static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  FinishedRun finished;
  RunOptions how = options;
  if (how.threads <= 0) how.threads = hardware;
  if (!options.along.empty()) {
    finished.through = std::make_shared<const ThroughFormulas>(
        through_formulas(job, job.design.parameters, options.along));
    how.along = finished.through->names;
  }
  std::optional<OutputFolder> folder;
  if (!options.folder.empty()) folder.emplace(options.folder);
  try {
    RunRecord record = run_any(job, how, listener);
    record.timings["total"] = seconds_since(begin);
    if (folder)
      finished.failed_expectations = write_run(folder->path(), record).failed_expectations;
    finished.record = std::make_shared<const RunRecord>(std::move(record));
  } catch (const Interrupted&) {
    if (folder) folder->keep();
    throw;
  }
  if (folder) folder->keep();
  return finished;
}

PosedGoals::PosedGoals(const Job& job, bool scaled, bool pointwise)
    : problem_(differentiated(job)), scaled_(scaled) {
  VectorXd x(problem_.size());
  for (int j = 0; j < problem_.size(); ++j) {
    const Variable& v = problem_.spec().variables[j];
    x[j] = v.start.value_or(problem_.job().design.parameters.at(v.parameter));
  }
  const auto first = design({x.data(), x.data() + x.size()}, true);
  with_gradients_ = false;  // nobody else has asked yet
  scales_ = problem_.scales(first->ok ? first.get() : nullptr);
  const Goal& objective = problem_.goals()[0];
  if (first->ok) start_slack_ = aggregate(objective, first->goals[0]) / scale(0);
  start_ = x;
  const bool maximise = problem_.spec().objective.maximise;
  if (pointwise && holds_everywhere(objective, !maximise)) {
    slack_ = true;
    add_rows(0, true, maximise ? 0 : -infinity, maximise ? infinity : 0, 1);
    if (objective.over_stroke == OverStroke::max_abs) add_rows(0, true, 0, infinity, -1);
  }
  for (std::size_t k = 0; k < problem_.own_constraints(); ++k) add_constraint(k + 1, pointwise);
}

void PosedGoals::add_constraint(std::size_t number, bool pointwise) {
  const Goal& goal = problem_.goals()[number];
  const Constraint& c = problem_.spec().constraints[number - 1];
  const double by = scale(number);
  const double lower = c.min ? *c.min / by : -infinity, upper = c.max ? *c.max / by : infinity;
  if (!pointwise) return add_rows(number, false, lower, upper, 0);
  const bool above = c.max && holds_everywhere(goal, true);
  const bool below = c.min && holds_everywhere(goal, false);
  const bool both_ways = above && goal.over_stroke == OverStroke::max_abs;
  if (above) add_rows(number, true, both_ways ? -upper : -infinity, upper, 0);
  if (below) add_rows(number, true, lower, infinity, 0);
  if ((c.max && !above) || (c.min && !below))
    add_rows(number, false, below ? -infinity : lower, above ? infinity : upper, 0);
}

void PosedGoals::add_rows(std::size_t goal, bool each, double lower, double upper, double slack) {
  const Goal& of = problem_.goals()[goal];
  if (!each) {
    rows_.push_back({goal, -1, lower, upper, 0, of.label});
    return;
  }
  const auto entries = static_cast<int>(of.points()) * of.branches;
  for (int entry = 0; entry < entries; ++entry) {
    std::string place = fmt::format("{}", entry / of.branches);
    if (of.branches > 1) place += fmt::format(", {}", entry % of.branches);
    rows_.push_back({goal, entry, lower, upper, slack, fmt::format("{} [{}]", of.label, place)});
  }
}

double PosedGoals::scale(std::size_t goal) const {
  if (!scaled_) return 1;
  const double scale = goal == 0 ? scales_.objective : scales_.constraints[goal - 1];
  return scale > 0 && std::isfinite(scale) ? scale : 1;
}

std::vector<std::string> PosedGoals::names() const {
  std::vector<std::string> all;
  for (const Variable& v : problem_.spec().variables) all.push_back(v.parameter);
  if (slack_) all.emplace_back("t");
  return all;
}

VectorXd PosedGoals::with_slack(VectorXd x, double t) const {
  if (!slack_) return x;
  x.conservativeResize(x.size() + 1);
  x[x.size() - 1] = t;
  return x;
}

VectorXd PosedGoals::start() const {
  return with_slack(
      scaled_ ? problem_.scaled({start_.data(), start_.data() + start_.size()}) : start_,
      start_slack_);
}

VectorXd PosedGoals::bounds(double Variable::*own, double scaled, double of_slack) const {
  VectorXd x = VectorXd::Constant(problem_.size(), scaled);
  for (int j = 0; j < problem_.size() && !scaled_; ++j) x[j] = problem_.spec().variables[j].*own;
  return with_slack(x, of_slack);
}

std::vector<std::string> PosedGoals::constraint_names() const {
  std::vector<std::string> all;
  for (const Row& row : rows_) all.push_back(row.name);
  return all;
}

VectorXd PosedGoals::of_rows(double Row::*number) const {
  VectorXd all(static_cast<Eigen::Index>(rows_.size()));
  for (Eigen::Index i = 0; i < all.size(); ++i) all[i] = rows_[i].*number;
  return all;
}

Variables PosedGoals::variables(const VectorXd& x) const {
  const int n = problem_.size();
  const int expected = n + (slack_ ? 1 : 0);
  if (x.size() != expected)
    throw SpecError("x", fmt::format("{} numbers", x.size()), fmt::format("expected {}", expected));
  if (!x.allFinite()) throw SpecError("x", "not finite", "expected finite numbers");
  if (!scaled_) return {x.data(), x.data() + n};
  Variables inside = problem_.variables(x.head(n));
  for (int j = 0; j < n; ++j)
    if (x[j] < 0 || x[j] > 1)
      inside[j] = problem_.spec().variables[j].min + x[j] * problem_.range(j);
  return inside;
}

std::shared_ptr<const DesignValues> PosedGoals::design(const Variables& variables,
                                                       bool gradient) const {
  {
    const std::scoped_lock lock(mutex_);
    with_gradients_ |= gradient;
    gradient = with_gradients_;
    for (const Known& known : known_)
      if (known.at == variables && (known.gradient || !gradient)) return known.values;
  }
  auto values = std::make_shared<const DesignValues>(problem_.evaluate(variables, gradient));
  const std::scoped_lock lock(mutex_);
  known_.push_front({variables, gradient, values});
  if (known_.size() > remembered) known_.pop_back();
  return values;
}

std::shared_ptr<const PosedValues> PosedGoals::at(const VectorXd& x, bool gradient) const {
  const auto values = design(variables(x), gradient);
  if (!values->ok) throw NotConverged(values->message, values->reached);
  if (gradient && !values->no_gradient.empty()) throw NoGradient(values->no_gradient);
  return std::make_shared<const PosedValues>(posed(x, *values, gradient));
}

PosedValues PosedGoals::posed(const VectorXd& x, const DesignValues& values, bool gradient) const {
  const int n = problem_.size();
  const double sense = problem_.spec().objective.maximise ? -1 : 1;
  std::vector<Eigen::Index> first{0};  // first value of each goal among all values
  for (const GoalValues& goal : values.goals)
    first.push_back(first.back() + static_cast<Eigen::Index>(goal.size()));
  /// Value, and derivatives by x, of a row.
  const auto read = [&](std::size_t goal, int entry, auto slopes) {
    const GoalValues& all = values.goals[goal];
    const Extreme at = entry < 0 ? extreme(problem_.goals()[goal], all)
                                 : Extreme{static_cast<std::size_t>(entry), 1};
    if (gradient) {
      slopes.head(n) = at.sign / scale(goal) *
                       values.gradient.row(first[goal] + static_cast<Eigen::Index>(at.entry));
      for (int j = 0; j < n && scaled_; ++j) slopes[j] *= problem_.range(j);
    }
    return at.sign * all[at.entry] / scale(goal);
  };
  PosedValues out;
  const auto rows = static_cast<Eigen::Index>(rows_.size());
  out.g.resize(rows);
  if (gradient) {
    out.df.setZero(x.size());
    out.dg.setZero(rows, x.size());
  }
  MatrixXd slopes = MatrixXd::Zero(1, x.size());
  out.f = sense * (slack_ ? x[n] : read(0, -1, slopes.row(0)));
  if (gradient) out.df = sense * slopes.row(0).transpose();
  if (gradient && slack_) out.df[n] = sense;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Row& row = rows_[i];
    slopes.setZero();
    out.g[i] = read(row.goal, row.entry, slopes.row(0)) - (slack_ ? row.slack * x[n] : 0);
    if (!gradient) continue;
    out.dg.row(i) = slopes.row(0);
    if (slack_) out.dg(i, n) -= row.slack;
  }
  return out;
}

double PosedGoals::objective(const VectorXd& x) const {
  const auto values = design(variables(x), false);
  if (!values->ok) throw NotConverged(values->message, values->reached);
  return problem_.objective(*values);
}

}  // namespace flexopt
