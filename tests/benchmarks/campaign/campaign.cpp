#include "tests/benchmarks/campaign/campaign.hpp"

#include <fmt/format.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <thread>

namespace flexopt {
namespace {

using nlohmann::json;

std::string read_line(std::FILE* in) {
  std::string line;
  for (int c = 0; (c = std::fgetc(in)) != EOF && c != '\n';) line += static_cast<char>(c);
  return line;
}

class Run {
 public:
  explicit Run(const Campaign& of) : of_(of), next_(of.first), end_(of.first + of.count) {
    if (of.log.empty()) return;
    lines_ = read_logs({of.log});
    std::erase_if(lines_,
                  [&](const auto& one) { return one.first < of.first || one.first >= end_; });
    log_ = std::fopen(of.log.c_str(), "a");
    if (!log_) std::abort();
  }
  ~Run() {
    if (log_) std::fclose(log_);
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  SeedLines lines() {
    std::vector<std::thread> threads;
    for (int k = 0; k < of_.processes; ++k) threads.emplace_back([this] { work(); });
    for (std::thread& one : threads) one.join();
    return lines_;
  }

 private:
  static constexpr int batch = 10;

  void work() {
    for (;;) {
      const int first = next_.fetch_add(batch);
      if (first >= end_) return;
      const int last = std::min(end_, first + batch);
      for (int seed = first; seed < last;) seed = run_until_crash(seed, last);
    }
  }

  // In the child: two lines for each seed, which is begun, then how it ended.
  [[noreturn]] void run_seeds(const std::vector<int>& seeds, std::FILE* out) const {
    for (const int seed : seeds) {
      // processor time: others may be at work beside
      const itimerval limit{{}, {of_.most_seconds, 0}};
      setitimer(ITIMER_PROF, &limit, nullptr);
      fmt::print(out, "{}\n", seed);
      std::fflush(out);
      fmt::print(out, "{}\n", of_.line_of(seed).dump());
      std::fflush(out);
    }
    std::_Exit(0);
  }

  // The first seed that has not run.
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
      run_seeds(seeds, fdopen(ends[1], "w"));
    }
    close(ends[1]);
    std::FILE* in = fdopen(ends[0], "r");
    int begun_seed = -1;
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
    if (begun_seed < 0) return last;
    const bool late = WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF;
    add(begun_seed, {{"status", late ? "too long" : "crashed"},
                     {"crashed", late ? "took too long" : "crashed"}});
    return begun_seed + 1;
  }

  void add(int seed, json line) {
    const std::lock_guard lock(mutex_);
    line["seed"] = seed;
    if (log_) {
      fmt::print(log_, "{}\n", line.dump());
      std::fflush(log_);
    }
    of_.print_findings(line);
    lines_[seed] = std::move(line);
    if (lines_.size() % 100 == 0) fmt::print(stderr, "{} done\n", lines_.size());
  }

  const Campaign& of_;
  std::atomic<int> next_;
  int end_;
  SeedLines lines_;
  std::mutex mutex_;
  std::FILE* log_ = nullptr;
};

}  // namespace

SeedLines read_logs(const std::vector<std::string>& files) {
  SeedLines lines;
  for (const std::string& name : files) {
    std::ifstream in(name);
    for (std::string text; std::getline(in, text);) {
      json line = json::parse(text, nullptr, false);
      if (line.is_discarded()) continue;
      const int seed = line["seed"];
      lines[seed] = std::move(line);
    }
  }
  return lines;
}

SeedLines run(const Campaign& campaign) { return Run(campaign).lines(); }

}  // namespace flexopt
