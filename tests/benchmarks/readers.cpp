// Changed texts against every reader of texts from outside.
//
// Arguments: how many for each instead of 20 000, the seed.
// What is no answer and no refusal in words ends the program, with the text on stderr.
#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>

#include "tests/benchmarks/page.hpp"
#include "tests/fuzz/mutations.hpp"
#include "tests/fuzz/targets.hpp"

using namespace flexopt;
using namespace flexopt::fuzz;

namespace {

std::string present;  // what a reader is at

void tell(int signal) {
  fmt::print(stderr, "signal {} at:\n{}\n", signal, present);
  std::_Exit(1);
}

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

int main(int arguments, char** values) {
  const int count = arguments > 1 ? std::atoi(values[1]) : 20000;
  const auto seed = arguments > 2 ? std::strtoull(values[2], nullptr, 10) : 1;
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS}) std::signal(signal, tell);
  const std::filesystem::path root = FLEXOPT_SOURCE_DIR;
  const PageTable page("readers mutations");
  fmt::print("| reader | texts | longest time of one |\n|---|---|---|\n");
  for (const Target& target : targets()) {
    const std::vector<std::string> texts = corpus_of(target.name, root);
    RandomNumbers random(seed);
    double longest = 0;
    for (int k = 0; k < count; ++k) {
      present = mutated(texts, random);
      const double begin = now();
      try {
        target.run(present);
      } catch (const std::exception& error) {
        fmt::print(stderr, "{}: {} at:\n{}\n", target.name, error.what(), present);
        return 1;
      }
      longest = std::max(longest, now() - begin);
    }
    fmt::print("| {} | {} | {:.0f} ms |\n", target.name, count, 1e3 * longest);
    std::fflush(stdout);
  }
  return 0;
}
