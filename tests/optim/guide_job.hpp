#pragma once
// A job that many tests change: a guide whose thickness is optimised.
#include "tests/optim/optim_tests.hpp"

namespace flexopt::test {

/// The job with these members changed; one of null is taken away.
inline json guide_job(const char* patch) {
  json job = json::parse(R"({
    "job": "optimise",
    "design": {"family": "parallel_guide", "parameters": {"length": "100 mm", "width": "30 mm",
               "thickness": "0.5 mm", "spacing": "60 mm"}, "material": "stavax"},
    "end_effector": {"mass": "0.5 kg"}, "frequencies": 2,
    "optimise": {
      "variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "1 mm"}],
      "objective": {"maximise": "parasitic_frequency"}, "algorithm": {"library": "ipopt"}}})");
  job.merge_patch(json::parse(patch));
  return job;
}

}  // namespace flexopt::test
