// Picks the library, finds a point to start from, and leaves the rest to the adapters.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/spec/spec_error.hpp"
#include "optim/solvers/trials.hpp"

namespace flexopt {
namespace {

std::string names_of(const std::vector<AlgorithmInfo>& algorithms, bool constraints) {
  std::string names;
  for (const AlgorithmInfo& a : algorithms)
    if (!constraints || a.constraining != Constraining::none)
      names += (names.empty() ? "" : ", ") + a.name;
  return names;
}

/// x0, or the first workable point on the way from it to the middle of the box.
bool find_start(Trials& trials, const VectorXd& x0) {
  const Problem& p = trials.problem();
  VectorXd middle = x0;
  for (Eigen::Index j = 0; j < x0.size(); ++j)
    if (std::isfinite(p.lower[j]) && std::isfinite(p.upper[j]))
      middle[j] = 0.5 * (p.lower[j] + p.upper[j]);
  for (const double step : {0.0, 0.25, 0.5, 0.75, 1.0})
    if (trials.at(x0 + step * (middle - x0), false).ok) return true;
  return false;
}

}  // namespace

const AlgorithmInfo& algorithm_of(const OptimiserOptions& options) {
  static const AlgorithmInfo ipopt{"", true, true, Constraining::own, {}};
  if (options.library == "ipopt") return ipopt;
  if (options.library != "nlopt")
    throw SpecError("/optimise/algorithm/library", options.library, "expected nlopt or ipopt");
  for (const AlgorithmInfo& a : nlopt_algorithms())
    if (a.name == options.name) return a;
  throw SpecError("/optimise/algorithm/name", options.name,
                  "expected one of " + names_of(nlopt_algorithms(), false));
}

std::vector<std::string> algorithms() {
  std::vector<std::string> all;
  for (const AlgorithmInfo& a : nlopt_algorithms()) all.push_back("nlopt " + a.name);
  all.push_back("ipopt");
  return all;
}

void check_takes_constraints(const OptimiserOptions& options) {
  if (algorithm_of(options).constraining == Constraining::none)
    throw SpecError("/optimise/algorithm/name", options.name,
                    "this algorithm takes no constraints; with constraints expected one of " +
                        names_of(nlopt_algorithms(), true) + ", or the library ipopt");
}

OptimiserSummary minimise(const Problem& problem, const VectorXd& x0,
                          const OptimiserOptions& options) {
  if (problem.constraints > 0) check_takes_constraints(options);
  const AlgorithmInfo& algorithm = algorithm_of(options);
  const std::vector<std::string>& locals = algorithm.locals;
  if (!options.local.empty() &&
      std::find(locals.begin(), locals.end(), options.local) == locals.end())
    throw SpecError("/optimise/algorithm/local", options.local,
                    locals.empty() ? "this algorithm runs no other inside"
                                   : fmt::format("expected one of {}", fmt::join(locals, ", ")));
  Trials trials(problem, options);
  bool started = false;
  try {
    started = find_start(trials, into_box(x0, problem.lower, problem.upper));
  } catch (const StopTrials&) {
    trials.rethrow();
  }
  if (!started)
    return trials.summary(StopReason::failed,
                          fmt::format("none of the {} points tried from the start to the middle of "
                                      "the box could be evaluated",
                                      trials.failures()));
  OptimiserSummary summary =
      options.library == "ipopt" ? minimise_ipopt(trials) : minimise_nlopt(trials);
  trials.rethrow();
  return summary;
}

}  // namespace flexopt
