// What a call of C++ costs beside its computation, for python_calls, which takes the same job.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

#include "results/library/runs.hpp"

using namespace flexopt;

namespace {

/// Of a call, and of the end of the result before it.
double microseconds(const Job& job, std::shared_ptr<const RunRecord>& kept) {
  using Clock = std::chrono::steady_clock;
  Silent listener;
  const auto begin = Clock::now();
  kept = run(job, {.folder = {}, .threads = 2, .along = {}}, listener).record;
  const double taken = std::chrono::duration<double>(Clock::now() - begin).count();
  return 1e6 * (taken - kept->timings.at("total"));
}

}  // namespace

int main() {
  const Job job = read_job(FLEXOPT_SOURCE_DIR "/designs/jobs/parallel_guide.json",
                           {R"(/stroke={"at": [0]})", "/frequencies=1", "/expect=[]",
                            R"(/model={"accuracy": "full", "mesh": [4, 2]})"});
  std::shared_ptr<const RunRecord> kept;
  std::vector<double> times(300);
  for (double& time : times) time = microseconds(job, kept);
  std::ranges::nth_element(times, times.begin() + 150);
  std::printf("%.2f us\n", times[150]);
}
