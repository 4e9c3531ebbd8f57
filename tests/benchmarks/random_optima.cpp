// Random optimisations on four algorithms against a dense search: is what is called optimal the
// best?
//
// Those of tests/support/random_searches.hpp. Arguments: how many jobs instead of 200, the first.
#include <fmt/format.h>

#include <cstdlib>
#include <map>
#include <string>

#include "support/random_searches.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

// Beyond it a worse objective is another design: constraints may be missed by 1e-4.
constexpr double same = 1e-3;

struct Row {
  std::map<OptimumStatus, int> ends;
  int wrong = 0, missed = 0;  // optimal, or of any other feasible status, but not the best
  double worst = 0;           // shortfall of what is called optimal
  long evaluations = 0;
};

}  // namespace

int main(int arguments, char** values) {
  const int count = arguments > 1 ? std::atoi(values[1]) : 200,
            first = arguments > 2 ? std::atoi(values[2]) : 0;
  const std::string names[] = {"ipopt", "LD_SLSQP", "LD_MMA", "LN_COBYLA"};
  std::map<std::string, Row> rows;
  for (int seed = first; seed < first + count; ++seed) {
    std::map<std::string, Optimum> found;
    const RandomSearch reference = random_search(static_cast<unsigned>(seed), "LD_SLSQP");
    std::optional<double> best = dense_search(reference, 4096, 12);
    for (const std::string& name : names) {
      const RandomSearch search = random_search(static_cast<unsigned>(seed), name);
      OptimiseOptions options;
      options.evaluators = closed_forms(search.breaks_at);
      Optimum o = optimise(parse_job(search.job), options);
      const bool feasible =
          o.status != OptimumStatus::infeasible && o.status != OptimumStatus::failed;
      if (feasible && (!best || shortfall(search, o.objective, *best) < 0)) best = o.objective;
      found.emplace(name, std::move(o));
    }
    for (const std::string& name : names) {
      const Optimum& o = found.at(name);
      Row& row = rows[name];
      ++row.ends[o.status];
      row.evaluations += o.evaluations;
      if (o.status == OptimumStatus::infeasible || o.status == OptimumStatus::failed) {
        if (best)
          fmt::print(stderr, "seed {} {}: nothing feasible: {}\n", seed, name, o.stop_reason);
        continue;
      }
      const double off = shortfall(reference, o.objective, *best);
      if (o.status == OptimumStatus::optimal) row.worst = std::max(row.worst, off);
      if (off > same) {
        ++(o.status == OptimumStatus::optimal ? row.wrong : row.missed);
        fmt::print(stderr, "seed {} {} status {}: {:.6g} of {:.6g}, off by {:.2g}: {}\n", seed,
                   name, static_cast<int>(o.status), o.objective, *best, off, o.stop_reason);
      } else if (o.status == OptimumStatus::feasible)
        fmt::print(stderr, "seed {} {} only feasible: off {:.2g}: {}\n", seed, name, off,
                   o.stop_reason);
    }
  }
  const PageTable page("random_optima verdicts");
  fmt::print(
      "| algorithm | jobs | optimal | local | feasible | infeasible | failed | \"optimal\" but "
      "worse than the best by 0.1 % | the same of local and feasible ones | largest shortfall of "
      "an optimal one | evaluations a job |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string& name : names) {
    Row& row = rows[name];
    fmt::print("| `{}` | {} | {} | {} | {} | {} | {} | {} | {} | {:.0e} | {} |\n", name, count,
               row.ends[OptimumStatus::optimal], row.ends[OptimumStatus::local],
               row.ends[OptimumStatus::feasible], row.ends[OptimumStatus::infeasible],
               row.ends[OptimumStatus::failed], row.wrong, row.missed, row.worst,
               row.evaluations / count);
  }
  return 0;
}
