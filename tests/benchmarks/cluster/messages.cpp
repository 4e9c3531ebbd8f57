// What a message of a crew costs its leader: mpirun -n 3 bench_crew_messages EVALUATIONS.jsonl
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "optim/numerics/sharing.hpp"
#include "optim/problem/line_log.hpp"
#include "results/run/join_crew.hpp"

namespace {

using namespace flexopt;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double processor_seconds() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// Questions that the other ranks answer with lines of a log, by so many threads.
void ask(Crew& crew, int questions, int threads,
         const std::function<void(const std::string&)>& keep) {
  const Answerer nobody = [](const std::string&) { return std::string(); };
  parallel_for(threads, threads, [&](int t) {
    for (int k = t; k < questions; k += threads) keep(crew.ask(std::to_string(k), nobody));
  });
}

int lead(Crew& crew, const std::vector<std::string>& lines) {
  constexpr int questions = 4000;
  std::atomic<bool> over = false;
  std::mutex mutex;
  // this process is busy with a question of its own
  std::thread busy([&] {
    crew.ask("0", [&](const std::string&) {
      while (!over) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return std::string();
    });
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  std::vector<double> trips;
  for (int k = 0; k < 500; ++k) {
    const auto begin = Clock::now();
    ask(crew, 1, 1, [](const std::string&) {});
    trips.push_back(seconds_since(begin));
  }
  std::ranges::sort(trips);
  std::ofstream log(std::filesystem::temp_directory_path() / "bench_crew_messages.jsonl");
  const auto keep = [&](const std::string& line) {
    (void)nlohmann::json::parse(line);
    const std::lock_guard lock(mutex);
    log << line << std::flush;
  };
  const double before = processor_seconds();
  const auto begin = Clock::now();
  ask(crew, questions, crew.members() - 1, keep);
  const double wall = seconds_since(begin), cost = (processor_seconds() - before) / questions;
  over = true;
  busy.join();
  crew.end_stage();
  std::size_t bytes = 0;
  for (const std::string& line : lines) bytes += line.size() / lines.size();
  fmt::print(
      "{{\"ranks\": {}, \"bytes\": {}, \"round_trip\": {:.3g}, \"leader\": {:.3g}, \"rate\": "
      "{:.4g}}}\n",
      crew.members(), bytes, trips[trips.size() / 2], cost, questions / wall);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::unique_ptr<Crew> crew = join_crew();
  if (!crew || argc != 2) {
    fmt::print(stderr, "mpirun -n 3 bench_crew_messages EVALUATIONS.jsonl\n");
    return 2;
  }
  std::vector<std::string> lines = read_log_lines(argv[1]);
  if (crew->leads()) return lead(*crew, lines);
  crew->answer([&](const std::string& question) {
    return lines[static_cast<std::size_t>(std::stoi(question)) % lines.size()] + "\n";
  });
  return 0;
}
