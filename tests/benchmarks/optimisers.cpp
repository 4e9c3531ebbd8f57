// What each optimiser makes of the optimisation jobs of the gallery, from eight starts.
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "tests/benchmarks/page.hpp"
#include "tests/benchmarks/run_job.hpp"

using namespace flexopt;
using Json = nlohmann::json;

namespace {

void row(const std::string& job, const std::string& algorithm) {
  const bool ipopt = algorithm == "ipopt";
  const std::string choice =
      ipopt ? R"({"library":"ipopt"})" : R"({"library":"nlopt","name":")" + algorithm + R"("})";
  const double before = seconds_of_children();
  const Json optimum =
      run_job(FLEXOPT_SOURCE_DIR "/designs/jobs/" + job + ".json",
              "--threads 1 --set /optimise/starts=8 --set /optimise/max_evaluations=300 "
              "--set '/optimise/algorithm=" +
                  choice + "'")
          .at("optimum");
  const double seconds = seconds_of_children() - before;
  int fewest = 1 << 30, most = 0;
  double residual = 0, violation = 0;
  for (const Json& start : optimum.at("starts")) {
    const int evaluations = start.at("evaluations").get<int>();
    fewest = std::min(fewest, evaluations);
    most = std::max(most, evaluations);
    if (start.value("kkt_residual", Json()).is_number())
      residual = std::max(residual, start["kkt_residual"].get<double>());
  }
  const Json& best = optimum.at("starts").at(optimum.at("best_start").get<std::size_t>());
  if (best.at("violation").is_number()) violation = best["violation"].get<double>();
  fmt::print("| `{}` | {:.3f} Hz | {} | {} | {:.0f} s | {} | {} |\n", algorithm,
             optimum.at("objective").get<double>(), optimum.at("agreeing_starts").get<int>(),
             fewest == most ? fmt::format("{}", most) : fmt::format("{} to {}", fewest, most),
             seconds, violation < 1e-9 ? "< 1e-9" : fmt::format("{:.0e}", violation),
             residual > 0 ? fmt::format("{:.0e}", residual) : "");
  std::fflush(stdout);
}

}  // namespace

int main() {
  for (const char* job : {"three_flexure_cross_hinge", "fast_guide", "screened_guide"}) {
    const PageTable page(fmt::format("optimisers {}", job));
    fmt::print(
        "| `{}.json` | best | starts within 0.1 % of it | evaluations a start | processor time | "
        "violation | KKT |\n|---|---|---|---|---|---|---|\n",
        job);
    for (const char* algorithm : {"ipopt", "LD_SLSQP", "LD_MMA"}) row(job, algorithm);
    if (std::string(job) == "screened_guide") continue;
    for (const char* algorithm : {"LN_COBYLA", "LN_NELDERMEAD"}) row(job, algorithm);
  }
}
