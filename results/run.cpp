#include "results/run.hpp"

#include <fmt/format.h>

namespace flexopt {

namespace {

/// Evaluates a design with shapes, for drawing.
StrokeResponse drawn_response(const Job& job, const Mechanism& mechanism) {
  StrokeRequest request = job.request;
  request.shapes = true;
  return evaluate_stroke(mechanism, job.model, request);
}

}  // namespace

RunRecord run_evaluation(const Job& job, Progress& progress) {
  RunRecord record;
  record.job = job;
  record.mechanism = make_mechanism(job, job.design.parameters);
  progress.say(
      fmt::format("evaluating {} at {} stroke points", job.name, job.request.points.size()));
  record.response = drawn_response(job, record.mechanism);
  record.timings["coefficients"] = record.response.seconds_coefficients;
  record.timings["path"] = record.response.seconds_path;
  conclude(record);
  return record;
}

}  // namespace flexopt
