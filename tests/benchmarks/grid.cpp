// The best design of a grid over the variables of a job, by default stiff_guide.json (no table).
//
// What an optimiser must at least reach.
//   bench_grid [JOB.json] [N1 N2 …]      points per variable, ends included (7)
#include <fmt/format.h>

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "optim/problem/design_problem.hpp"

using namespace flexopt;

int main(int argc, char** argv) {
  const DesignProblem problem(
      read_job(argc > 1 ? argv[1] : FLEXOPT_SOURCE_DIR "/designs/jobs/stiff_guide.json"));
  const int n = problem.size();
  std::vector<int> points(n, 7);
  for (int k = 0; k < n && k + 2 < argc; ++k) points[k] = std::max(2, std::atoi(argv[k + 2]));
  long total = 1;
  for (const int p : points) total *= p;

  const bool maximise = problem.spec().objective.maximise;
  const Scales scales = problem.scales(nullptr);
  std::atomic<long> next{0};
  std::mutex lock;
  long feasible = 0, failed = 0;
  double best = 0;
  Variables best_variables;
  auto work = [&] {
    for (long i = next++; i < total; i = next++) {
      VectorXd x(n);
      long rest = i;
      for (int k = 0; k < n; ++k) {
        x[k] = static_cast<double>(rest % points[k]) / (points[k] - 1);
        rest /= points[k];
      }
      const Variables variables = problem.variables(x);
      if (problem.ruled_out(variables, scales)) continue;
      const DesignValues values = problem.evaluate(variables);
      const std::lock_guard guard(lock);
      if (!values.ok) {
        ++failed;
        continue;
      }
      if (problem.violation(values, scales) > problem.spec().constraint_tolerance) continue;
      ++feasible;
      const double f = problem.objective(values);
      if (best_variables.empty() || (maximise ? f > best : f < best)) {
        best = f;
        best_variables = variables;
      }
    }
  };
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < std::max(1u, std::thread::hardware_concurrency()); ++t)
    threads.emplace_back(work);
  for (std::thread& t : threads) t.join();

  fmt::print("{} designs, {} feasible, {} without equilibrium; best objective {:.6g}\n", total,
             feasible, failed, best);
  for (int k = 0; k < n && !best_variables.empty(); ++k)
    fmt::print("  {:16} {:.6g}\n", problem.spec().variables[k].parameter, best_variables[k]);
}
