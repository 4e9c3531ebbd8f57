// Laws of 10 000 random mechanisms: how far each is kept. Arguments: how many instead, the first.
//
// Progress is told every 100. A run that SIGTERM, SIGINT or SIGHUP ends prints the table of what is
// done, and says so.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "support/mechanism_laws.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;

namespace {

struct Law {
  const char* name;
  double limit;
  std::function<laws::Deviation(const RandomDesign&, unsigned long long)> check;
  std::vector<double> sizes = {};
  int failed = 0;
};

double quantile(std::vector<double>& sizes, double share) {
  std::sort(sizes.begin(), sizes.end());
  return sizes[static_cast<std::size_t>(share * static_cast<double>(sizes.size() - 1))];
}

volatile std::sig_atomic_t ended_by = 0;

void end_by(int signal) { ended_by = signal; }

}  // namespace

int main(int arguments, char** values) {
  const int count = arguments > 1 ? std::atoi(values[1]) : 10000;
  const int begin = arguments > 2 ? std::atoi(values[2]) : 0;
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) std::signal(signal, end_by);
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("flexopt_random_{}", getpid());
  std::filesystem::create_directories(folder);
  const auto model = [](unsigned long long seed) { return laws::coarse(seed, seed % 10 == 0); };
  std::vector<Law> all{
      {"moved and turned as a whole", 1e-10,
       [&](const RandomDesign& d, unsigned long long seed) {
         return laws::motion_of_the_whole(d, seed, "", model(seed));
       }},
      {"mirrored, moved and turned", 1e-10,
       [&](const RandomDesign& d, unsigned long long seed) {
         return laws::motion_of_the_whole(d, seed, std::string(1, "xyz"[seed % 3]), model(seed));
       }},
      {"force and tangent from the energy", 2e-7,
       [&](const RandomDesign& d, unsigned long long seed) {
         return laws::energy(d, seed, laws::coarse(seed, false));
       }},
      {"written flat, and without repeats", 0,
       [](const RandomDesign& d, unsigned long long) { return laws::ways_of_writing(d); }},
      {"derivatives of all numbers", 1e-8,
       [](const RandomDesign& d, unsigned long long) { return laws::derivatives(d); }}};
  int refused = 0, faulty = 0, done = 0;
  for (int seed = begin; seed < begin + count && ended_by == 0; ++seed, ++done) {
    if (done > 0 && done % 100 == 0) fmt::print(stderr, "{} done\n", done);
    RandomDesign design;
    try {
      design = random_design(static_cast<unsigned long long>(seed), folder);
    } catch (const std::exception& error) {
      ++faulty;
      fmt::print(stderr, "seed {}, no design: {}\n", seed, error.what());
      continue;
    }
    refused += design.refused;
    for (Law& law : all) {
      laws::Deviation d;
      try {
        d = law.check(design, static_cast<unsigned long long>(seed));
      } catch (const std::exception& error) {
        d = {1e300, error.what()};
      }
      law.sizes.push_back(d.size);
      if (!(d.size <= std::max(law.limit, laws::known(d, seed % 10 == 0)))) {
        ++law.failed;
        fmt::print(stderr, "seed {}, {}: {:.1e}, {}\n", seed, law.name, d.size, d.what);
      }
    }
  }
  std::filesystem::remove_all(folder);
  if (done == 0 || faulty > 0) {
    fmt::print(stderr, "{} of {} seeds drew nothing: a fault of the generator\n", faulty, done);
    return 1;
  }
  const PageTable page("random_mechanisms laws");
  fmt::print("{} random mechanisms; {} others had leaves that cross or are too thick.\n\n", done,
             refused);
  fmt::print("| law | limit, or rounding | half are within | 99 % | largest | beyond |\n");
  fmt::print("|---|---|---|---|---|---|\n");
  for (Law& law : all)
    fmt::print("| {} | {:.0e} | {:.0e} | {:.0e} | {:.0e} | {} |\n", law.name, law.limit,
               quantile(law.sizes, 0.5), quantile(law.sizes, 0.99), quantile(law.sizes, 1),
               law.failed);
  if (ended_by == 0) return 0;
  fmt::print(stderr, "ended by signal {} after {} of {}\n", int{ended_by}, done, count);
  return 1;
}
