// Random mechanisms of their own, every number found in two ways: tests/support/differences.hpp.
//
// Arguments: how many, the first seed, a folder for findings, processes at a time (2). The folder
// gets log.jsonl, to which every seed adds a line as it ends (seeds that are in it are not run
// again), and of each finding the job and the one that it was compared with. "table LOG...": the
// table of all seeds in these. "show SEED": its job. "look SEED [quick]": what the laws say of it.
//
// A seed that crashes, or takes more than two minutes of the processor, costs its process and is
// counted.
#include <fmt/format.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "support/differences.hpp"
#include "support/random_jobs.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

constexpr unsigned most_seconds = 120;
constexpr double slow_point = 0.1;  // [s] of a job's evaluation, per point

using Lines = std::map<int, json>;

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
  const Differences found = differences_of(job, number, Laws::all);
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

Lines read_log(const std::filesystem::path& name) {
  Lines lines;
  std::ifstream in(name);
  for (std::string text; std::getline(in, text);) {
    json line = json::parse(text, nullptr, false);
    if (!line.is_discarded()) lines[line["seed"]] = line;
  }
  return lines;
}

std::string read_line(std::FILE* in) {
  std::string line;
  for (int c = 0; (c = std::fgetc(in)) != EOF && c != '\n';) line += static_cast<char>(c);
  return line;
}

class Campaign {
 public:
  Campaign(int first, int count, std::filesystem::path folder)
      : next_(first), end_(first + count), folder_(std::move(folder)) {
    std::filesystem::create_directories(folder_);
    lines_ = read_log(folder_ / "log.jsonl");
    std::erase_if(lines_, [&](const auto& one) { return one.first < first || one.first >= end_; });
    log_ = std::fopen((folder_ / "log.jsonl").c_str(), "a");
    if (!log_) std::abort();
  }
  ~Campaign() { std::fclose(log_); }
  Campaign(const Campaign&) = delete;
  Campaign& operator=(const Campaign&) = delete;

  Lines run(int processes) {
    std::vector<std::thread> threads;
    for (int k = 0; k < processes; ++k) threads.emplace_back([this] { work(); });
    for (std::thread& one : threads) one.join();
    return lines_;
  }

 private:
  static constexpr int batch = 10;

  // Batches, each in a process of its own.
  void work() {
    for (;;) {
      const int first = next_.fetch_add(batch);
      if (first >= end_) return;
      const int last = std::min(end_, first + batch);
      for (int seed = first; seed < last;) seed = run_until_crash(seed, last);
    }
  }

  int run_until_crash(int first, int last) {
    std::vector<int> seeds;
    {
      const std::lock_guard lock(mutex_);
      for (int seed = first; seed < last; ++seed)
        if (!lines_.contains(seed)) seeds.push_back(seed);
    }
    int ends[2];
    if (pipe(ends) != 0) std::abort();
    const pid_t child = fork();
    if (child == 0) {
      close(ends[0]);
      std::FILE* out = fdopen(ends[1], "w");
      for (const int seed : seeds) {
        // processor time: others may be at work beside
        const itimerval limit{{}, {most_seconds, 0}};
        setitimer(ITIMER_PROF, &limit, nullptr);
        fmt::print(out, "{}\n", seed);
        std::fflush(out);
        fmt::print(out, "{}\n", line_of(seed, folder_).dump());
        std::fflush(out);
      }
      std::_Exit(0);
    }
    close(ends[1]);
    std::FILE* in = fdopen(ends[0], "r");
    int next = last, begun_seed = -1;
    for (std::string begun = read_line(in); !begun.empty(); begun = read_line(in)) {
      begun_seed = std::atoi(begun.c_str());
      const std::string ended = read_line(in);
      if (ended.empty()) break;
      add(begun_seed, json::parse(ended));
      begun_seed = -1;
    }
    std::fclose(in);
    int status = 0;
    waitpid(child, &status, 0);
    if (begun_seed >= 0) {
      const bool late = WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF;
      add(begun_seed, {{"seed", begun_seed},
                       {"status", late ? "too long" : "crashed"},
                       {"crashed", late ? "took too long" : "crashed"}});
      next = begun_seed + 1;
    }
    return next;
  }

  void add(int seed, json line) {
    const std::lock_guard lock(mutex_);
    fmt::print(log_, "{}\n", line.dump());
    std::fflush(log_);
    print_findings(line);
    lines_[seed] = std::move(line);
    if (lines_.size() % 100 == 0) fmt::print(stderr, "{} done\n", lines_.size());
  }

  std::atomic<int> next_;
  int end_;
  std::filesystem::path folder_;
  Lines lines_;
  std::mutex mutex_;
  std::FILE* log_ = nullptr;
};

void print_table(const Lines& lines) {
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
    Lines lines;
    for (int k = 2; k < arguments; ++k)
      for (auto& [seed, line] : read_log(values[k])) lines[seed] = line;
    for (const auto& [seed, line] : lines) print_findings(line);
    print_table(lines);
    return 0;
  }
  const int count = arguments > 1 ? std::atoi(values[1]) : 1000;
  const int first = arguments > 2 ? std::atoi(values[2]) : 0;
  const std::filesystem::path folder =
      arguments > 3 ? std::filesystem::path(values[3])
                    : std::filesystem::temp_directory_path() / "flexopt_own_jobs";
  print_table(Campaign(first, count, folder).run(arguments > 4 ? std::atoi(values[4]) : 2));
  return 0;
}
