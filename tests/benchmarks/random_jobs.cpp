// Jobs of random designs of all families against invariants that each must keep.
//
// Those of tests/support/job_invariants.hpp. Arguments: how many instead of 2000, the first.
// A third one is a log, to which every job adds a line as it ends; jobs that are in it already are
// not run again. "table LOG...": the table of all jobs in these, of each seed the last.
// "show SEED [FACTOR]": the job of a seed, so many times as large. "paths COUNT [FIRST]": a line a
// job of how its points ended and after how many Newton iterations, to compare two programs.
//
// Each hundred run in a process of their own, so that a crash costs one job and is counted.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/math/work_count.hpp"
#include "core/spec/spec_error.hpp"
#include "designs/family.hpp"
#include "optim/job/job.hpp"
#include "support/job_invariants.hpp"
#include "support/random_jobs.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

constexpr int batch = 100;
constexpr int longest = 100000;  // Newton iterations of one evaluation: more are findings

struct Count {
  int jobs = 0, refused = 0, no_equilibrium = 0, too_long = 0, ok = 0, crashed = 0, broken = 0,
      rounded = 0;
  int points = 0, converged = 0, unstable = 0, energies = 0, scales = 0, fulls = 0;
  double energy_error = 0, scale_error = 0, twice_error = 0, mirror_error = 0, slowest = 0;
};

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Jobs [first, last), a line for each: what is begun, then how it ended.
[[noreturn]] void run_batch(int first, int last, const std::set<int>& done, std::FILE* out) {
  for (int seed = first; seed < last; ++seed) {
    if (done.contains(seed)) continue;
    fmt::print(out, "{}\n", seed);
    std::fflush(out);
    json job = random_job(static_cast<unsigned long long>(seed));
    job["limits"] = {{"iterations", longest}};
    const double begin = now();
    JobVerdict verdict;
    try {
      verdict = verdict_of(job);
    } catch (const std::exception& error) {
      verdict.broken.push_back(std::string("exception: ") + error.what());
    }
    const json line{{"end", static_cast<int>(verdict.end)}, {"points", verdict.points},
                    {"converged", verdict.converged},       {"stable", verdict.stable},
                    {"energy", verdict.energy_checked},     {"scale", verdict.scale_checked},
                    {"energy_error", verdict.energy_error}, {"scale_error", verdict.scale_error},
                    {"full", verdict.full_checked},         {"twice_error", verdict.twice_error},
                    {"mirror_error", verdict.mirror_error}, {"seconds", now() - begin},
                    {"rounded", verdict.rounded},           {"broken", verdict.broken}};
    fmt::print(out, "{}\n", line.dump());
    std::fflush(out);
  }
  std::_Exit(0);
}

void add(const json& line, Count& count) {
  ++count.jobs;
  if (line.contains("crashed")) {
    ++count.crashed;
    return;
  }
  switch (static_cast<JobVerdict::End>(line["end"].get<int>())) {
    case JobVerdict::End::refused:
      ++count.refused;
      break;
    case JobVerdict::End::no_equilibrium:
      ++count.no_equilibrium;
      break;
    case JobVerdict::End::limit_reached:
      ++count.too_long;
      break;
    case JobVerdict::End::ok:
      ++count.ok;
  }
  count.points += line["points"].get<int>();
  count.converged += line["converged"].get<int>();
  count.unstable += line["converged"].get<int>() - line["stable"].get<int>();
  count.energies += line["energy"].get<bool>();
  count.scales += line["scale"].get<bool>();
  count.fulls += line["full"].get<bool>();
  count.broken += !line["broken"].empty();
  count.rounded += !line["rounded"].empty();
  const auto most = [&](double& of, const char* key) {
    if (line[key].is_number()) of = std::max(of, line[key].get<double>());
  };
  most(count.energy_error, "energy_error");
  most(count.scale_error, "scale_error");
  most(count.twice_error, "twice_error");
  most(count.mirror_error, "mirror_error");
  most(count.slowest, "seconds");
}

// + stable, - unstable, x no equilibrium, . not reached, ! limit.
char sign_of(const PathPoint& point) {
  switch (point.status) {
    case PointStatus::converged:
      return point.stable ? '+' : '-';
    case PointStatus::no_equilibrium:
      return 'x';
    case PointStatus::limit_reached:
      return '!';
    default:
      return '.';
  }
}

void print_path(int seed) {
  const json document = random_job(static_cast<unsigned long long>(seed));
  std::string signs = "refused";
  const long long before = counted_iterations();
  try {
    const Job job = parse_job(document);
    const StrokeResponse response =
        evaluate_stroke(make_mechanism(job, job.design.parameters), job.model, job.request);
    signs.clear();
    for (const PathPoint& point : response.path) signs += sign_of(point);
  } catch (const SpecError&) {
  }
  fmt::print("{} {} {} {} {}\n", seed, document["design"]["family"].get<std::string>(),
             document["model"]["accuracy"].get<std::string>(), signs,
             counted_iterations() - before);
  std::fflush(stdout);
}

std::string read_line(std::FILE* in) {
  std::string line;
  for (int c = 0; (c = std::fgetc(in)) != EOF && c != '\n';) line += static_cast<char>(c);
  return line;
}

void print_findings(int seed, const json& line) {
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

// How the jobs ended, by their seeds.
using Lines = std::map<int, json>;

Lines read_log(const std::string& name) {
  Lines lines;
  std::ifstream in(name);
  for (std::string line; std::getline(in, line);) {
    json one = json::parse(line, nullptr, false);
    if (one.is_discarded()) continue;  // its end was not written
    const int seed = one["seed"];
    lines[seed] = std::move(one);
  }
  return lines;
}

// The first job that has not run.
int run_until_crash(int first, int last, const std::set<int>& done, std::FILE* log, Lines& lines) {
  int ends[2];
  if (pipe(ends) != 0) std::abort();
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    run_batch(first, last, done, fdopen(ends[1], "w"));
  }
  close(ends[1]);
  std::FILE* in = fdopen(ends[0], "r");
  int next = last;
  for (std::string begun = read_line(in); !begun.empty(); begun = read_line(in)) {
    const int seed = std::atoi(begun.c_str());
    const std::string ended = read_line(in);
    json line = ended.empty() ? json{{"crashed", true}} : json::parse(ended);
    line["seed"] = seed;
    if (log) {
      fmt::print(log, "{}\n", line.dump());
      std::fflush(log);
    }
    print_findings(seed, line);
    lines[seed] = std::move(line);
    if (!ended.empty()) continue;
    next = seed + 1;
    break;
  }
  std::fclose(in);
  waitpid(child, nullptr, 0);
  return next;
}

void print_table(const Lines& lines) {
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
  const auto row = [](const std::string& name, const Count& c) {
    fmt::print(
        "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {}, {:.1e} | {}, {:.1e} | {}, {:.1e}, "
        "{:.1e} | {} | {} | {:.1f} s "
        "|\n",
        name, c.jobs, c.refused, c.no_equilibrium, c.ok, c.crashed, c.too_long, c.converged,
        c.unstable, c.energies, c.energy_error, c.scales, c.scale_error, c.fulls, c.twice_error,
        c.mirror_error, c.rounded, c.broken, c.slowest);
  };
  for (const auto& [name, c] : counts) {
    row(name, c);
    for (int Count::*member :
         {&Count::jobs, &Count::refused, &Count::no_equilibrium, &Count::ok, &Count::crashed,
          &Count::too_long, &Count::points, &Count::converged, &Count::unstable, &Count::energies,
          &Count::scales, &Count::fulls, &Count::rounded, &Count::broken})
      all.*member += c.*member;
    for (double Count::*member : {&Count::energy_error, &Count::scale_error, &Count::twice_error,
                                  &Count::mirror_error, &Count::slowest})
      all.*member = std::max(all.*member, c.*member);
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
  if (mode == "paths") {
    const int first = arguments > 3 ? std::atoi(values[3]) : 0;
    for (int seed = first; seed < first + std::atoi(values[2]); ++seed) print_path(seed);
    return 0;
  }
  if (mode == "table") {
    Lines lines;
    for (int k = 2; k < arguments; ++k)
      for (auto& [seed, line] : read_log(values[k])) lines[seed] = line;
    for (const auto& [seed, line] : lines) print_findings(seed, line);
    print_table(lines);
    return 0;
  }
  const int count = arguments > 1 ? std::atoi(values[1]) : 2000;
  const int begin = arguments > 2 ? std::atoi(values[2]) : 0;
  Lines lines;
  std::set<int> done;
  std::FILE* log = nullptr;
  if (arguments > 3) {
    for (auto& [seed, line] : read_log(values[3]))
      if (seed >= begin && seed < begin + count) {
        done.insert(seed);
        lines[seed] = std::move(line);
      }
    log = std::fopen(values[3], "a");
    if (!log) std::abort();
  }
  for (int seed = begin; seed < begin + count;) {
    const int last = std::min(begin + count, seed + batch);
    while (seed < last) seed = run_until_crash(seed, last, done, log, lines);
    fmt::print(stderr, "{} done\n", seed - begin);
  }
  if (log) std::fclose(log);
  print_table(lines);
  return 0;
}
