// A global search of the gallery: how fast it screens, with leaves built and looked up.
//
// And what it finds. The second row needs an atlas (flexopt atlas).
#include <fmt/format.h>

#include <string>

#include "tests/benchmarks/page.hpp"
#include "tests/benchmarks/run_job.hpp"

using namespace flexopt;
using Json = nlohmann::json;

namespace {

constexpr const char* job = FLEXOPT_SOURCE_DIR "/designs/jobs/crossing_anywhere.json";

struct Run {
  Json optimum;
  double seconds = 0;
};

Run run(int designs, const std::string& atlas) {
  const double before = seconds_of_children();
  Run done;
  done.optimum =
      run_job(job, fmt::format("--threads 1 --set '/maps/0/points=[2, 2]' --set /optimise/starts=8 "
                               "--set /optimise/screened_designs={} "
                               "--set '/model={{\"atlas\": \"{}\"}}'",
                               designs, atlas))
          .at("optimum");
  done.seconds = seconds_of_children() - before;
  return done;
}

void row(const std::string& atlas) {
  constexpr int few = 512, many = 4608;
  const Run first = run(few, atlas), second = run(many, atlas);
  const Json& found = second.optimum.at("screening");
  const bool looked_up = found.at("atlas").get<bool>();
  if (looked_up != (atlas == "auto")) {
    fmt::print(stderr, "no atlas: its row is left out\n");
    return;
  }
  // the searches, and all else, are about the same in both
  fmt::print("| {} | {:.0f} | {} | {} of 8 | {} |\n", looked_up ? "looked up" : "built",
             (many - few) / (second.seconds - first.seconds), found.at("feasible").get<int>(),
             second.optimum.at("agreeing_starts").get<int>(), second.optimum.at("optima").size());
  std::fflush(stdout);
}

}  // namespace

int main() {
  const PageTable page("screening crossing_anywhere");
  fmt::print(
      "| leaves | designs screened in a second of one processor | feasible of 4608 | searches that "
      "end "
      "in the best optimum | different optima |\n|---|---|---|---|---|\n");
  row("off");
  row("auto");
}
