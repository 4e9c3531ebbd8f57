#include "optim/problem/stroke_sensitivity.hpp"

#include <algorithm>

#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"

namespace flexopt {
namespace {

std::vector<MechanismDirection> all_directions(const Job& job, const ParameterValues& parameters,
                                               const Mechanism& mechanism) {
  const Family& family = find_family(job.design.family, "/design/family");
  const auto [material, end_effector] = numbers_set(job, parameters);
  std::vector<MechanismDirection> all =
      family.directions(parameters, job.design.choices, material, end_effector);
  const auto append = [&](std::vector<MechanismDirection> more) {
    all.insert(all.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
  };
  append(material_directions(mechanism));
  if (family.has_end_effector(job.design.choices)) append(payload_directions(mechanism));
  return all;
}

}  // namespace

std::vector<std::string> differentiable_parameters(const Job& job) {
  const Mechanism mechanism = make_mechanism(job, job.design.parameters);
  std::vector<std::string> names;
  for (const MechanismDirection& d : all_directions(job, job.design.parameters, mechanism))
    if (!job.design.expressions.contains(d.parameter)) names.push_back(d.parameter);
  return names;
}

StrokeSensitivity stroke_sensitivity(const Job& job, const ParameterValues& parameters,
                                     const std::vector<std::string>& names,
                                     const ModelOptions& model, const StrokeRequest& request) {
  const Mechanism mechanism = make_mechanism(job, parameters);
  std::vector<MechanismDirection> all = all_directions(job, parameters, mechanism), wanted;
  for (const std::string& name : names) {
    const auto found = std::find_if(
        all.begin(), all.end(), [&](const MechanismDirection& d) { return d.parameter == name; });
    if (found == all.end())
      throw SpecError("/design/parameters", name, "expected a parameter that designs depend on");
    wanted.push_back(std::move(*found));
  }
  return evaluate_stroke_gradients(mechanism, wanted, model, request);
}

}  // namespace flexopt
