// What it costs to be told that a stroke ends beyond reach, in Newton iterations.
#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/math/work_count.hpp"
#include "optim/job/job.hpp"
#include "tests/benchmarks/page.hpp"

using namespace flexopt;
using nlohmann::json;

namespace {

struct Case {
  const char* job;
  double times_as_far;
  Accuracy accuracy;
};

struct Walk {
  long long iterations = 0;
  std::size_t found = 0;  // points up to the first that was not
};

// The first `points` of six, from rest.
Walk walk(const Case& of, double times_as_far, std::size_t points) {
  std::ifstream file(std::string(FLEXOPT_SOURCE_DIR "/designs/jobs/") + of.job + ".json");
  Job job = parse_job(json::parse(file));
  const double to = times_as_far * job.request.points.back();
  job.request.points.clear();
  for (std::size_t k = 0; k < points; ++k)
    job.request.points.push_back(to * static_cast<double>(k) / 5);
  job.request.frequencies = 0;
  job.model.accuracy = of.accuracy;
  const long long before = counted_iterations();
  const StrokeResponse response =
      evaluate_stroke(make_mechanism(job, job.design.parameters), job.model, job.request);
  Walk end{counted_iterations() - before, 0};
  while (end.found < points && response.path[end.found].status == PointStatus::converged)
    ++end.found;
  return end;
}

}  // namespace

int main() {
  const PageTable page("failures strokes");
  fmt::print(
      "| job | leaves | a stroke that is good | one that fails | of which up to the last point "
      "found | the failure, in good strokes |\n|---|---|---|---|---|---|\n");
  for (const Case& of :
       {Case{"parallel_guide", 10, Accuracy::full}, Case{"parallel_guide", 10, Accuracy::reduced},
        Case{"parallel_guide", 50, Accuracy::reduced}, Case{"leaf_spring", 50, Accuracy::full},
        Case{"folded_leaf_stage", 50, Accuracy::full},
        Case{"folded_leaf_stage", 50, Accuracy::reduced}}) {
    const Walk good = walk(of, 1, 6), far = walk(of, of.times_as_far, 6),
               found = walk(of, of.times_as_far, far.found);
    fmt::print("| `{}`, × {} | {} | {} | {} | {} | {:.1f} |\n", of.job, of.times_as_far,
               of.accuracy == Accuracy::full ? "full" : "reduced", good.iterations, far.iterations,
               found.iterations,
               static_cast<double>(far.iterations - found.iterations) /
                   static_cast<double>(good.iterations));
  }
  return 0;
}
