// Reduced against full accuracy over sampled designs: those of tests/benchmarks/compare/jobs.json.
//
// Exit code 1 where a family misses the bar: 99th percentile of the support stiffness within 1 %,
// drive load within 0.3 %. Jobs of the part "beyond" leave the range that the bar is about.
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "tests/benchmarks/page.hpp"
#include "tests/benchmarks/run_job.hpp"

using namespace flexopt;
using Json = nlohmann::json;

namespace {

std::string percent(const Json& share) {
  if (share.is_null()) return "–";
  const double p = 100 * share.get<double>();
  return p < 1000 ? fmt::format("{:.2g}", p) : fmt::format("{:.0f}", p);
}

bool within(const Json& error, double bar) { return error.is_number() && error <= bar; }

/// A job of jobs.json: the parts that it is made of, one merged into the other, and what it varies.
Json made_of(const Json& all, const Json& one) {
  Json job = all.at("every");
  for (const Json& part : one.at("of"))
    job.merge_patch(all.at("parts").at(part.get<std::string>()));
  job["name"] = one.at("name");
  for (const Json& key : one.at("vary"))
    job["samples"]["vary"].push_back(all.at("vary").at(key.get<std::string>()));
  return job;
}

}  // namespace

int main() {
  const Json all =
      Json::parse(std::ifstream(FLEXOPT_SOURCE_DIR "/tests/benchmarks/compare/jobs.json"));
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     fmt::format("flexopt_bench_compare_{}.json", getpid());
  const char* quantities[] = {"drive_load",  "support_stiffness",   "displacement",
                              "frequencies", "parasitic_frequency", "max_stress"};
  bool met = true;
  {
    const PageTable page("compare");
    fmt::print(
        "| errors in % | designs (failed) | failures | full leaves | drive load | support "
        "stiffness "
        "| displacement | frequencies | parasitic frequency | max stress | speed-up |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const Json& job : all.at("jobs")) {
      std::ofstream(file) << made_of(all, job);
      const Json result = run_job(file);
      const Json& comparison = result.at("comparison");
      const Json& model = comparison.at("models").at(0);
      fmt::print("| {} | {} ({}) | {} | {} |", result.at("job").at("name").get<std::string>(),
                 comparison.at("designs").get<int>(), comparison.at("failed_designs").get<int>(),
                 model.at("failures").get<int>(), model.at("fallbacks").at("points").get<int>());
      for (const char* quantity : quantities) {
        const Json& e = model.at("errors").at(quantity);
        fmt::print(" {} / {} / {} |", percent(e.at("median")), percent(e.at("p99")),
                   percent(e.at("worst")));
      }
      fmt::print(" {:.2g}, {:.2g} |\n", model.at("speed_up").get<double>(),
                 model.at("speed_up_with_reduction").get<double>());
      std::fflush(stdout);
      const Json& errors = model.at("errors");
      const Json& parts = job.at("of");
      const bool beyond = std::ranges::find(parts, "beyond") != parts.end();
      met = met && (beyond || (within(errors.at("support_stiffness").at("p99"), 0.01) &&
                               within(errors.at("drive_load").at("worst"), 0.003)));
    }
  }
  std::filesystem::remove(file);
  if (!met) fmt::print(stderr, "a family misses the bar\n");
  return met ? 0 : 1;
}
