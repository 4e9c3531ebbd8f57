#include <algorithm>
#include <cassert>
#include <map>
#include <nlohmann/json.hpp>

#include "optim/job/job_sections.hpp"
#include "optim/search/optimise.hpp"
#include "optim/search/stages.hpp"
#include "optim/solvers/parallel.hpp"
#include "optim/solvers/problem.hpp"
#include "optim/solvers/unit_points.hpp"

namespace flexopt {

namespace {

using nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr double nearly = 0.1;  // a design that misses no bound by more is nearly feasible
constexpr const char* missed_formulas = "formulas missed by more than half of their bounds";

/// One design of a screening.
struct Screened {
  bool known = false, ok = false;
  std::string reason;  ///< why not, without figures
  double objective = 0;
  std::vector<double> constraints;
  double violation = 0;  ///< by the scales of the whole screening; not in the log
};

std::string line_of(int number, const Screened& design) {
  if (!design.ok) return log_line(OrderedJson::array({number, design.reason}));
  return log_line(OrderedJson::array({number, design.objective, design.constraints}));
}

/// The number of the design, and what is known of it.
std::pair<int, Screened> parse_line(const std::string& line) {
  const json j = json::parse(line);
  Screened design;
  design.known = true;
  design.ok = j.at(1).is_number();
  if (design.ok) {
    j.at(1).get_to(design.objective);
    j.at(2).get_to(design.constraints);
  } else {
    j.at(1).get_to(design.reason);
  }
  return {j.at(0).get<int>(), std::move(design)};
}

/// The job as it is screened.
Job screened_job(Job job) {
  job.model = on_reduced_leaves(job.search_model.value_or(job.model));
  job.search_model.reset();
  job.optimise = without_margins(*job.optimise);  // each would cost derivatives
  return job;
}

class Screen {
 public:
  Screen(const Job& job, const OptimiseOptions& options);
  Screening run();

 private:
  /// Takes a line of the log.
  void read(const std::string& line);
  /// Whether all are known then.
  bool evaluate_all();
  Screened evaluate(int number, const Scales& scales) const;
  /// Computes the violations of all designs that have values.
  void weigh();
  ScreeningReport report() const;
  /// Places of the designs with values from the best to the worst.
  std::vector<int> ranked() const;
  Screening choose(ScreeningReport report) const;
  const Screened& design(int number) const { return designs_[number]; }
  const VectorXd& point(int number) const { return points_[number]; }
  bool feasible(const Screened& d) const {
    return d.violation <= problem_.spec().constraint_tolerance;
  }

  const OptimiseOptions& options_;
  DesignProblem problem_;
  std::vector<VectorXd> points_;
  std::vector<Screened> designs_;    ///< by their numbers
  std::vector<std::string> beyond_;  ///< lines of designs beyond the job's
  LineLog log_;
};

std::vector<VectorXd> screened_points(const DesignProblem& problem) {
  const OptimiseSpec& spec = problem.spec();
  std::vector<VectorXd> points{own_point(problem)};
  for (VectorXd& x : sobol_points(problem.size(), spec.screened_designs - 1, spec.seed))
    points.push_back(std::move(x));
  return points;
}

// Values as modelled: exact derivatives, which would have them finished on full leaves, are for the
// searches.
Screen::Screen(const Job& job, const OptimiseOptions& options)
    : options_(options),
      problem_(screened_job(job), {options.evaluators.values, by_differences}),
      points_(screened_points(problem_)),
      designs_(problem_.spec().screened_designs) {
  if (!options.log.empty())
    log_.open(screening_log(options.log), log_identity(problem_.job(), options.version),
              options.overwrite_log, [this](const std::string& line) { read(line); });
}

void Screen::read(const std::string& line) {
  auto [number, design] = parse_line(line);
  if (static_cast<std::size_t>(number) < designs_.size())
    designs_[number] = std::move(design);
  else
    beyond_.push_back(line + "\n");
}

Screened Screen::evaluate(int number, const Scales& scales) const {
  Screened screened;
  screened.known = true;
  const Variables variables = problem_.variables(point(number));
  if (!problem_.near_formulas(variables, scales)) {
    screened.reason = missed_formulas;
    return screened;
  }
  const DesignValues values = problem_.evaluate(variables);
  screened.ok = values.ok;
  screened.reason = values.reason;
  if (!values.ok) return screened;
  screened.objective = problem_.objective(values);
  screened.constraints = problem_.constraints(values);
  return screened;
}

bool Screen::evaluate_all() {
  const Scales scales = problem_.scales(nullptr);
  Sharing nobody;
  Sharing& sharing = options_.sharing ? *options_.sharing : nobody;
  const auto count = static_cast<int>(points_.size());
  const bool complete = sharing.run(
      {.what = "screened designs",
       .count = count,
       .threads = options_.threads,
       .known =
           [&](int k) { return design(k).known ? std::optional(!design(k).ok) : std::nullopt; },
       .work = [&](int k) { return line_of(k, evaluate(k, scales)); },
       .keep =
           [&](const std::string& line) {
             log_.append(line);
             read(line);
           },
       .progress = options_.screening_progress});
  if (sharing.shard()) throw ShardEnds();
  if (!complete) return false;
  std::vector<std::string> lines;
  for (int k = 0; k < count; ++k) lines.push_back(line_of(k, design(k)));
  lines.insert(lines.end(), beyond_.begin(), beyond_.end());
  log_.finish(lines);
  return true;
}

void Screen::weigh() {
  const auto first = std::ranges::find(designs_, true, &Screened::ok);
  if (first == designs_.end()) return;
  // a bound of zero is weighed by what the first design reaches
  const auto number = static_cast<int>(first - designs_.begin());
  const DesignValues reference = problem_.evaluate(problem_.variables(point(number)));
  const Scales scales = problem_.scales(&reference);
  for (Screened& d : designs_)
    if (d.ok) d.violation = problem_.violation(d.constraints, scales);
}

/// Counts in descending order; equal ones by their names.
std::vector<ScreeningCount> sorted(const std::map<std::string, int>& counts) {
  std::vector<ScreeningCount> list;
  for (const auto& [what, designs] : counts) list.push_back({what, designs});
  std::ranges::stable_sort(list, std::greater<>(), &ScreeningCount::designs);
  return list;
}

ScreeningReport Screen::report() const {
  ScreeningReport report;
  std::map<std::string, int> failures, violated;
  const std::vector<Constraint>& constraints = problem_.spec().constraints;
  for (const Screened& d : designs_) {
    ++report.designs;
    if (!d.ok) {
      ++(d.reason == missed_formulas ? report.ruled_out : report.failed);
      ++failures[d.reason];
      continue;
    }
    ++report.evaluated;
    if (feasible(d)) ++report.feasible;
    if (!feasible(d) && d.violation <= nearly) ++report.nearly_feasible;
    for (std::size_t i = 0; i < problem_.own_constraints(); ++i)
      if (excess(d.constraints[i], constraints[i].min, constraints[i].max, 1) > 0)
        ++violated[constraints[i].label];
  }
  report.failures = sorted(failures);
  report.violated = sorted(violated);
  report.looked_up = problem_.job().model.atlas != nullptr;
  return report;
}

std::vector<int> Screen::ranked() const {
  std::vector<int> order;
  for (int k = 0; k < static_cast<int>(points_.size()); ++k)
    if (design(k).ok) order.push_back(k);
  const bool maximise = problem_.spec().objective.maximise;
  const double tolerated = problem_.spec().constraint_tolerance;
  std::ranges::stable_sort(
      order, [&](int i, int j) { return better(design(i), design(j), maximise, tolerated); });
  return order;
}

/// The clusters that starts are taken from: alternately the best one that is left and the one
/// furthest from anything better.
std::vector<PointCluster> spread_choice(std::vector<PointCluster> clusters, std::size_t count) {
  std::vector<PointCluster> chosen;
  while (chosen.size() < count && !clusters.empty()) {
    const auto next = chosen.size() % 2 == 0
                          ? clusters.begin()
                          : std::ranges::max_element(clusters, {}, &PointCluster::distance);
    chosen.push_back(*next);
    clusters.erase(next);
  }
  std::ranges::sort(chosen, {}, &PointCluster::best);
  return chosen;
}

/// Clusters of points sorted from the best to the worst; of smaller groups where there are too few.
std::vector<PointCluster> chosen_clusters(const std::vector<VectorXd>& good, std::size_t count,
                                          int& clusters) {
  constexpr double factor = 2;
  const NearestBetter better = nearest_better(good);
  std::vector<PointCluster> found = clusters_beyond(factor * better.mean, better);
  clusters = static_cast<int>(found.size());
  if (found.size() < count) {
    std::vector<double> distances = better.distance;
    std::ranges::sort(distances, std::greater<>());
    const double last = distances[std::min(count, good.size()) - 1];
    const auto next = std::ranges::find_if(distances, [&](double d) { return d < last; });
    found = clusters_beyond(next == distances.end() ? -1 : *next, better);
  }
  return spread_choice(std::move(found), count);
}

Screening Screen::choose(ScreeningReport report) const {
  constexpr std::size_t least = 1000, most = 20000;  // points whose clusters are looked for
  const std::vector<int> order = ranked();
  if (order.empty()) return {std::move(report), {point(0)}};
  const std::size_t part = std::min(order.size(), std::clamp(order.size() / 5, least, most));
  std::vector<VectorXd> good;
  for (std::size_t i = 0; i < part; ++i) good.push_back(point(order[i]));
  Screening screening;
  const auto starts = static_cast<std::size_t>(problem_.spec().starts);
  for (const PointCluster& of : chosen_clusters(good, starts, report.clusters)) {
    const int number = order[of.best];
    const Screened& best = design(number);
    screening.starts.push_back(point(number));
    report.searched.push_back({problem_.named(problem_.variables(point(number))), best.objective,
                               best.violation, feasible(best), of.size, of.distance});
  }
  screening.report = std::move(report);
  return screening;
}

Screening Screen::run() {
  if (!evaluate_all()) return {};
  weigh();
  return choose(report());
}

/// min |x − x0|² subject to the formulas, held with 0.1 % to spare.
VectorXd onto_formulas(const DesignProblem& problem, const Scales& scales, const VectorXd& x0) {
  constexpr double spare = 1e-3;
  const auto violation = [&](const VectorXd& x) {
    return problem.formula_violation(problem.variables(x), scales);
  };
  if (violation(x0) == 0.0) return x0;
  std::vector<std::size_t> formulas;
  for (std::size_t i = 0; i < problem.spec().constraints.size(); ++i)
    if (problem.goals()[i + 1].of_parameters()) formulas.push_back(i);
  Problem p;
  p.lower = VectorXd::Zero(x0.size());
  p.upper = VectorXd::Ones(x0.size());
  p.constraints = static_cast<int>(2 * formulas.size());
  p.evaluate = [&](const VectorXd& x, bool) {
    Problem::Value v;
    v.f = (x - x0).squaredNorm();
    v.c = VectorXd::Constant(p.constraints, -1.0);
    for (std::size_t k = 0; k < formulas.size(); ++k) {
      const Constraint& c = problem.spec().constraints[formulas[k]];
      const auto value = problem.formula(formulas[k] + 1, problem.variables(x));
      if (!value) return v;
      const double scale = scales.constraints[formulas[k]];
      const auto row = static_cast<Eigen::Index>(2 * k);
      if (c.max) v.c[row] = excess(*value, {}, c.max, scale) + spare;
      if (c.min) v.c[row + 1] = excess(*value, c.min, {}, scale) + spare;
      // An equality in disguise leaves nothing to spare.
      if (c.min && c.max && *c.max - *c.min < 2 * spare * scale)
        v.c.segment(row, 2).array() -= spare;
    }
    v.ok = true;
    return v;
  };
  OptimiserOptions options;
  options.max_evaluations = 2000;
  options.constraint_tolerance = 1e-6;
  const OptimiserSummary nearest = minimise(p, x0, options);
  const auto before = violation(x0), after = nearest.x.size() ? violation(nearest.x) : std::nullopt;
  return after && (!before || *after < *before) ? nearest.x : x0;
}

std::vector<VectorXd> spread(const DesignProblem& problem, int count) {
  const OptimiseSpec& spec = problem.spec();
  return spec.spread == Spread::sobol ? sobol_points(problem.size(), count, spec.seed)
                                      : latin_hypercube_points(problem.size(), count, spec.seed);
}

}  // namespace

Screening screen(const Job& job, const OptimiseOptions& options) {
  assert(job.optimise && job.optimise->search == SearchKind::global);
  return Screen(job, options).run();
}

std::filesystem::path screening_log(const std::filesystem::path& log) {
  std::filesystem::path beside = log;
  return beside.replace_extension(".screening.jsonl");
}

void check_screening_log(const Job& job, const std::filesystem::path& log,
                         const std::string& version) {
  const LineLog own(log, log_identity(screened_job(job), version), false,
                    [](const std::string& line) { parse_line(line); });
}

int screened_so_far(const std::filesystem::path& log) {
  return static_cast<int>(read_log_lines(log).size());
}

VectorXd own_point(const DesignProblem& problem) {
  Variables own;
  for (const Variable& v : problem.spec().variables)
    own.push_back(v.start.value_or(problem.job().design.parameters.at(v.parameter)));
  return problem.scaled(own);
}

std::vector<VectorXd> start_points(const DesignProblem& problem, const Scales& scales) {
  std::vector<VectorXd> points{own_point(problem)};
  for (VectorXd& x : spread(problem, problem.spec().starts - 1)) points.push_back(std::move(x));
  for (VectorXd& x : points) x = onto_formulas(problem, scales, x);
  return points;
}

}  // namespace flexopt
