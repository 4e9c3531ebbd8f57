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
#include <sstream>
#include <thread>
#include <vector>

#include "optim/numerics/sharing.hpp"
#include "optim/problem/line_log.hpp"
#include "results/run/shard.hpp"

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

/// Questions that the other ranks answer with so many lines of a log each, by so many threads.
void ask(Crew& crew, int questions, int lines, int threads,
         const std::function<void(const std::string&)>& keep) {
  const Answerer nobody = [](const std::string&) { return std::string(); };
  parallel_for(threads, threads, [&](int t) {
    for (int k = t; k < questions; k += threads)
      keep(crew.ask(fmt::format("{} {}", k, lines), nobody));
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
    ask(crew, 1, 1, 1, [](const std::string&) {});
    trips.push_back(seconds_since(begin));
  }
  std::ranges::sort(trips);
  std::ofstream log(std::filesystem::temp_directory_path() / "bench_crew_messages.jsonl");
  const auto keep = [&](const std::string& answer) {
    for (std::size_t at = 0, end; at < answer.size(); at = end) {
      end = answer.find('\n', at) + 1;
      const std::string line = answer.substr(at, end - at);
      [[maybe_unused]] const auto read = nlohmann::json::parse(line);
      const std::lock_guard lock(mutex);
      log << line << std::flush;
    }
  };
  const auto cost_of = [&](int lines_each) {
    const double before = processor_seconds();
    ask(crew, questions, lines_each, crew.members() - 1, keep);
    return (processor_seconds() - before) / questions;
  };
  const double one = cost_of(1), nine = cost_of(9), unit = (nine - one) / 8;
  const double before = processor_seconds();
  for (int k = 0; k < questions; ++k)
    [[maybe_unused]] const auto read =
        nlohmann::json::parse(lines[static_cast<std::size_t>(k) % lines.size()]);
  const double parse = (processor_seconds() - before) / questions;
  over = true;
  busy.join();
  crew.end_stage();
  std::size_t bytes = 0;
  for (const std::string& line : lines) bytes += line.size() / lines.size();
  fmt::print(
      "{{\"bytes\": {}, \"round_trip\": {:.3g}, \"message\": {:.3g}, \"unit\": {:.3g}, "
      "\"parse\": {:.3g}}}\n",
      bytes, trips[trips.size() / 2], one - unit, unit, parse);
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
    std::istringstream stream(question);
    std::size_t first = 0, count = 0;
    stream >> first >> count;
    std::string answer;
    for (std::size_t k = 0; k < count; ++k) answer += lines[(first + k) % lines.size()] + "\n";
    return answer;
  });
  return 0;
}
