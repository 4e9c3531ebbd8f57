#include "optim/problem/stroke_sensitivity.hpp"

#include <algorithm>

#include "optim/job/job_numbers.hpp"

namespace flexopt {

std::vector<std::string> differentiable_parameters(const Job& job) {
  const auto design = resolve(job.design);
  std::vector<std::string> names = design->independent_names();
  const std::vector<std::string>& counts = design->family().counts;
  std::erase_if(names, [&](const std::string& name) {
    return std::ranges::find(counts, name) != counts.end();
  });
  return names;
}

StrokeSensitivity stroke_sensitivity(const Job& job, const ParameterValues& parameters,
                                     const std::vector<std::string>& names,
                                     const ModelOptions& model, const StrokeRequest& request) {
  const auto design = resolve(job.design);
  const auto [material, end_effector] = numbers_set(job, parameters);
  return evaluate_stroke_gradients(design->build(parameters, material, end_effector),
                                   design->directions(parameters, material, end_effector, names),
                                   model, request);
}

}  // namespace flexopt
