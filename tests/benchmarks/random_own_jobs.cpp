// Random mechanisms of their own, every number found in two ways: tests/support/differences.hpp.
// Every mechanism is looked at by full accuracy, by its frequencies and by every third other law,
// in turn.
//
// Arguments: how many, the first seed, a folder for findings, processes at a time (2). The folder
// gets log.jsonl, to which every seed adds a line as it ends (seeds that are in it are not run
// again), and of each finding the job and the one that it was compared with. "table LOG...": the
// table of all seeds in these. "show SEED": its job. "look SEED [quick]": what the laws say of it.
//
// A seed that crashes, or takes more than two minutes of the processor, costs its process and is
// counted.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "support/differences.hpp"
#include "support/random_jobs.hpp"
#include "tests/benchmarks/campaign/campaign.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

constexpr double slow_point = 0.1;  // [s] of a job's evaluation, per point

const char* name_of(Difference::End end) {
  constexpr const char* names[] = {"skipped", "no_answer", "kept", "broken"};
  return names[static_cast<int>(end)];
}

void write_json(const std::filesystem::path& file, const json& job) {
  std::ofstream(file) << job.dump(1) << '\n';
}

json line_of(int seed, const std::filesystem::path& folder) {
  const auto number = static_cast<unsigned long long>(seed);
  json job;
  try {
    job = random_own_job(number);
  } catch (const std::exception& error) {
    return {{"seed", seed}, {"status", "not drawn"}, {"message", error.what()}};
  }
  const Differences found = differences_of(job, number, Laws::quick);
  json line{{"seed", seed},
            {"status", found.status},
            {"message", found.message},
            {"seconds", found.seconds},
            {"points", found.points},
            {"leaves", found.leaves},
            {"full_leaves", found.full_leaves},
            {"laws", json::array()}};
  for (const Difference& d : found.laws) {
    json one{{"law", d.law}, {"end", name_of(d.end)}};
    if (d.end == Difference::End::kept || d.end == Difference::End::broken) one["error"] = d.error;
    if (d.end == Difference::End::no_answer) one["message"] = d.message;
    if (d.end == Difference::End::broken) {
      one["what"] = d.what;
      if (!folder.empty()) {
        std::string law = d.law;
        std::ranges::replace_if(
            law, [](char c) { return c == ' ' || c == ','; }, '_');
        write_json(folder / fmt::format("{}.json", seed), job);
        write_json(folder / fmt::format("{}_{}.json", seed, law), d.other);
      }
    }
    line["laws"].push_back(one);
  }
  return line;
}

void print_findings(const json& line) {
  const int seed = line["seed"];
  if (line.contains("crashed"))
    fmt::print(stderr, "seed {}: {}\n", seed, line["crashed"].get<std::string>());
  if (!line.contains("laws")) return;
  for (const json& law : line["laws"])
    if (law["end"] == "broken")
      fmt::print(stderr, "seed {}, {}, {:.2g} times: {}\n", seed, law["law"].get<std::string>(),
                 law["error"].get<double>(), law["what"].get<std::string>());
}

void print_table(const SeedLines& lines) {
  std::map<std::string, int> statuses;
  struct Count {
    int kept = 0, broken = 0, no_answer = 0;
    double most = 0;
  };
  std::map<std::string, Count> laws;
  int slow = 0, timed = 0;
  std::vector<std::pair<double, int>> seconds;
  for (const auto& [seed, line] : lines) {
    ++statuses[line["status"]];
    if (!line.contains("laws")) continue;
    if (const int points = line["points"]; points > 0) {
      const double each = line["seconds"].get<double>() / points;
      seconds.emplace_back(each, seed);
      ++timed;
      slow += each > slow_point && line["leaves"] <= 3;
    }
    for (const json& law : line["laws"]) {
      Count& count = laws[law["law"]];
      const std::string end = law["end"];
      count.kept += end == "kept";
      count.broken += end == "broken";
      count.no_answer += end == "no_answer";
      if (end == "kept") count.most = std::max(count.most, law["error"].get<double>());
    }
  }
  const PageTable page("random_own_jobs differences");
  fmt::print("{} mechanisms:", lines.size());
  for (const auto& [status, count] : statuses) fmt::print(" {} {},", count, status);
  std::ranges::sort(seconds);
  if (!seconds.empty())
    fmt::print(
        " a point takes {:.3f} s at half of them, {:.3f} s at 99 %, {:.2f} s at most (seed {}); {} "
        "of {} with "
        "three leaves or fewer take more than {} s.",
        seconds[seconds.size() / 2].first, seconds[seconds.size() * 99 / 100].first,
        seconds.back().first, seconds.back().second, slow, timed, slow_point);
  fmt::print(
      "\n\n| law | kept | broken | no answer | largest error that is kept, over the allowed one "
      "|\n|---|---|---|---|---|\n");
  for (const auto& [law, count] : laws)
    fmt::print("| {} | {} | {} | {} | {:.2f} |\n", law, count.kept, count.broken, count.no_answer,
               count.most);
}

void look(int seed, Laws laws) {
  const auto number = static_cast<unsigned long long>(seed);
  const json job = random_own_job(number);
  const Differences found = differences_of(job, number, laws);
  fmt::print("{}: {}\n{} points, {} leaves, {} full, {:.3f} s\n", found.status, found.message,
             found.points, found.leaves, found.full_leaves, found.seconds);
  for (const Difference& d : found.laws)
    fmt::print("{:26} {:10} {:8.2g} {} {}\n", d.law, name_of(d.end), d.error, d.what, d.message);
}

}  // namespace

int main(int arguments, char** values) {
  const std::string mode = arguments > 2 ? values[1] : "";
  if (mode == "show") {
    fmt::print("{}\n", random_own_job(std::strtoull(values[2], nullptr, 10)).dump(1));
    return 0;
  }
  if (mode == "look") {
    look(std::atoi(values[2]), arguments > 3 ? Laws::quick : Laws::all);
    return 0;
  }
  if (mode == "table") {
    const SeedLines lines = read_logs({values + 2, values + arguments});
    for (const auto& [seed, line] : lines) print_findings(line);
    print_table(lines);
    return 0;
  }
  const std::filesystem::path folder =
      arguments > 3 ? std::filesystem::path(values[3])
                    : std::filesystem::temp_directory_path() / "flexopt_own_jobs";
  std::filesystem::create_directories(folder);
  print_table(run({.first = arguments > 2 ? std::atoi(values[2]) : 0,
                   .count = arguments > 1 ? std::atoi(values[1]) : 1000,
                   .log = folder / "log.jsonl",
                   .processes = arguments > 4 ? std::atoi(values[4]) : 2,
                   .most_seconds = 120,
                   .line_of = [&](int seed) { return line_of(seed, folder); },
                   .print_findings = print_findings}));
  return 0;
}
