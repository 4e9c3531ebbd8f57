// Reduced leaves against full ones of random mechanisms of one body, any direction held or driven.
//
// Arguments: how many (1000), the first seed (0), the limit of a difference that is told (0.01).
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <vector>

#include "support/own_leaves.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

double seconds_of(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double quantile(std::vector<double>& sizes, double share) {
  if (sizes.empty()) return 0;
  std::ranges::sort(sizes);
  return sizes[static_cast<std::size_t>(share * static_cast<double>(sizes.size() - 1))];
}

}  // namespace

int main(int arguments, char** values) {
  const int count = arguments > 1 ? std::atoi(values[1]) : 1000;
  const int begin = arguments > 2 ? std::atoi(values[2]) : 0;
  const double limit = arguments > 3 ? std::atof(values[3]) : 0.01;
  std::vector<double> errors, times;
  int beyond = 0, failed = 0, lost = 0;
  long points = 0, leaves = 0, replaced = 0;
  for (int seed = begin; seed < begin + count; ++seed) {
    OwnLeaves own = own_leaves(static_cast<unsigned>(seed));
    StrokeResponse reduced, full;
    if (std::getenv("MEASURE")) fmt::print(stderr, "S {}\n", seed);  // DEBUG
    const double time =
        seconds_of([&] { reduced = evaluate_stroke(own.mechanism, own.model, own.request); });
    own.model.accuracy = Accuracy::full;
    const double of_full =
        seconds_of([&] { full = evaluate_stroke(own.mechanism, own.model, own.request); });
    times.push_back(time / of_full);
    if (full.status != Status::ok) ++failed;
    if (full.status == Status::ok && reduced.status != Status::ok) {
      ++lost;
      fmt::print(stderr, "seed {}: lost, {}; {}\n", seed, reduced.message, own.what);
    }
    std::string models;
    for (const PathPoint& p : reduced.path)
      for (const LeafReport& leaf : p.leaves) {
        const bool whole = leaf.replaced || leaf.model == "full";
        ++leaves;
        replaced += whole;
        models += whole ? 'f' : leaf.degree == 7 ? '7' : leaf.reason.empty() ? 'r' : 'c';
      }
    points += static_cast<long>(reduced.path.size());
    const Disagreement worst = largest_disagreement(reduced, full);
    errors.push_back(worst.relative);
    if (!(worst.relative <= limit)) {
      ++beyond;
      fmt::print(stderr,
                 "seed {}: {:.2g}, {} at point {} is {:.4g} in place of {:.4g} ({} {}/{}); {}\n",
                 seed, worst.relative, worst.number, worst.point, worst.found, worst.expected,
                 models, reduced.path[worst.point].stable ? "stable" : "unstable",
                 full.path[worst.point].stable ? "stable" : "unstable", own.what);
    }
  }
  const PageTable page("belief mechanisms");
  fmt::print(
      "| mechanisms | without equilibrium on full leaves | on reduced alone | beyond {:g} % | "
      "median "
      "| 99 % | largest | leaves that are full | time over that of full ones |\n"
      "|---|---|---|---|---|---|---|---|---|\n",
      100 * limit);
  fmt::print(
      "| {} | {} | {} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1f} % | {:.2f} |\n", count, failed, lost,
      beyond, quantile(errors, 0.5), quantile(errors, 0.99), quantile(errors, 1),
      100.0 * static_cast<double>(replaced) / static_cast<double>(leaves), quantile(times, 0.5));
}
