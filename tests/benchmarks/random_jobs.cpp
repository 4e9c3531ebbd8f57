// Jobs of random designs of all families against invariants that each must keep.
//
// Those of tests/support/job_invariants.hpp. Arguments: how many instead of 2000, the first.
// A third one is a log, to which every job adds a line as it ends; jobs that are in it already are
// not run again. "table LOG...": the table of all jobs in these, of each seed the last.
// "show SEED [FACTOR]": the job of a seed, so many times as large. A job that crashes is counted.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "designs/family.hpp"
#include "support/job_invariants.hpp"
#include "support/random_jobs.hpp"
#include "tests/benchmarks/campaign/campaign.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

constexpr int longest = 100000;  // Newton iterations of one evaluation: more are findings

// How many jobs of a family ended how and were looked at, and the largest of what was measured.
using Count = std::map<std::string, double>;
constexpr const char* measured[] = {"energy_error", "scale_error", "twice_error", "mirror_error",
                                    "seconds"};

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

json line_of(int seed) {
  json job = random_job(static_cast<unsigned long long>(seed));
  job["limits"] = {{"iterations", longest}};
  const double begin = now();
  JobVerdict verdict;
  try {
    verdict = verdict_of(job);
  } catch (const std::exception& error) {
    verdict.broken.push_back(std::string("exception: ") + error.what());
  }
  return {{"end", static_cast<int>(verdict.end)}, {"points", verdict.points},
          {"converged", verdict.converged},       {"stable", verdict.stable},
          {"energy", verdict.energy_checked},     {"scale", verdict.scale_checked},
          {"energy_error", verdict.energy_error}, {"scale_error", verdict.scale_error},
          {"full", verdict.full_checked},         {"twice_error", verdict.twice_error},
          {"mirror_error", verdict.mirror_error}, {"seconds", now() - begin},
          {"rounded", verdict.rounded},           {"broken", verdict.broken}};
}

void add(const json& line, Count& count) {
  ++count["jobs"];
  if (line.contains("crashed")) {
    ++count["crashed"];
    return;
  }
  constexpr const char* ends[] = {"refused", "no_equilibrium", "limit_reached", "ok"};
  ++count[ends[line["end"].get<std::size_t>()]];
  count["converged"] += line["converged"].get<int>();
  count["unstable"] += line["converged"].get<int>() - line["stable"].get<int>();
  for (const char* law : {"energy", "scale", "full"}) count[law] += line[law].get<bool>();
  for (const char* list : {"broken", "rounded"}) count[list] += !line[list].empty();
  for (const char* key : measured)
    if (line[key].is_number()) count[key] = std::max(count[key], line[key].get<double>());
}

void print_findings(const json& line) {
  const int seed = line["seed"];
  if (line.contains("crashed")) {
    fmt::print(stderr, "seed {}: crashed\n", seed);
    return;
  }
  if (line["end"] == static_cast<int>(JobVerdict::End::limit_reached))
    fmt::print(stderr, "seed {}: more than {} iterations\n", seed, longest);
  for (const char* list : {"broken", "rounded"})
    for (std::size_t k = 0; k < std::min<std::size_t>(line[list].size(), 3); ++k)
      fmt::print(stderr, "seed {}, {}: {}\n", seed, list, line[list][k].get<std::string>());
}

void print_table(const SeedLines& lines) {
  std::map<std::string, Count> counts;
  for (const auto& [seed, line] : lines)
    add(line, counts[families()[static_cast<std::size_t>(seed) % families().size()].name]);
  const PageTable page("random_jobs invariants");
  fmt::print(
      "| family | jobs | refused | no equilibrium | ok | crashed | above {} iterations | points | "
      "of them unstable | work = energy: jobs, largest error | four times as large: jobs, largest "
      "error | full leaves: jobs, twice as large, mirrored | of these beyond 1e-6 by rounding | "
      "invariants broken | "
      "slowest |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      longest);
  Count all;
  const auto row = [](const std::string& name, Count& c) {
    fmt::print(
        "| {} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.0f}, "
        "{:.1e} | {:.0f}, {:.1e} | {:.0f}, {:.1e}, {:.1e} | {:.0f} | {:.0f} | {:.1f} s |\n",
        name, c["jobs"], c["refused"], c["no_equilibrium"], c["ok"], c["crashed"],
        c["limit_reached"], c["converged"], c["unstable"], c["energy"], c["energy_error"],
        c["scale"], c["scale_error"], c["full"], c["twice_error"], c["mirror_error"], c["rounded"],
        c["broken"], c["seconds"]);
  };
  for (auto& [name, c] : counts) {
    row(name, c);
    for (const auto& [key, value] : c)
      all[key] = std::ranges::find(measured, key) == std::end(measured) ? all[key] + value
                                                                        : std::max(all[key], value);
  }
  row("all", all);
}

}  // namespace

int main(int arguments, char** values) {
  const std::string mode = arguments > 2 ? values[1] : "";
  if (mode == "show") {
    const double factor = arguments > 3 ? std::atof(values[3]) : 1;
    const json job = random_job(std::strtoull(values[2], nullptr, 10));
    fmt::print("{}\n", scaled_job(job, factor).dump(2));
    return 0;
  }
  if (mode == "table") {
    const SeedLines lines = read_logs({values + 2, values + arguments});
    for (const auto& [seed, line] : lines) print_findings(line);
    print_table(lines);
    return 0;
  }
  print_table(run({.first = arguments > 2 ? std::atoi(values[2]) : 0,
                   .count = arguments > 1 ? std::atoi(values[1]) : 2000,
                   .log = arguments > 3 ? values[3] : "",
                   .line_of = line_of,
                   .print_findings = print_findings}));
  return 0;
}
