// Evaluates a job through the installed library; exit code 0 if the numbers are sound.
#include <cmath>
#include <cstdio>

#include "core/spec/spec_error.hpp"
#include "optim/job/job.hpp"

int main(int argc, char** argv) try {
  if (argc != 2) return 2;
  const flexopt::Job job = flexopt::read_job(argv[1], {"/stroke/points=2", "/frequencies=0"});
  const flexopt::Mechanism mechanism = flexopt::make_mechanism(job, job.design.parameters);
  const flexopt::StrokeResponse response =
      flexopt::evaluate_stroke(mechanism, job.model, job.request);
  const flexopt::PathPoint& last = response.path.back();
  std::printf("%zu leaves, drive load %g\n", mechanism.leaves.size(), last.drive_load);
  return response.status == flexopt::Status::ok && last.drive_load > 0 ? 0 : 1;
} catch (const flexopt::SpecError& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
