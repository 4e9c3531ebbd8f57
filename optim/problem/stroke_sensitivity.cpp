#include "optim/problem/stroke_sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/spec/spec_error.hpp"
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

ThroughFormulas through_formulas(const Job& job, const ParameterValues& parameters,
                                 const std::vector<std::string>& wanted) {
  const std::vector<std::string> known = differentiable_parameters(job);
  for (const std::string& name : wanted)
    if (std::ranges::find(known, name) == known.end())
      throw SpecError("gradients", name,
                      fmt::format("expected some of {}", fmt::join(known, ", ")));
  const auto design = resolve(job.design);
  const std::optional<MatrixXd> slopes = design->derivatives(design->slots(parameters));
  if (!slopes)
    throw SpecError("/design/parameters", "a formula", "its slope is not finite at these values");
  ThroughFormulas through{wanted, {}};
  for (const DependentParameter& d : design->dependents())
    if (std::ranges::any_of(wanted, [&](const std::string& name) {
          return std::ranges::find(d.formula.slots(), design->slot(name)) !=
                 d.formula.slots().end();
        }))
      through.names.push_back(design->family().parameters[d.slot].name);
  const auto columns = std::ssize(wanted);
  through.by.setZero(through.names.size(), columns);
  through.by.topRows(columns).setIdentity();
  for (Eigen::Index i = columns; i < through.by.rows(); ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      if (const int along = design->slot(wanted[j]); along >= 0)
        through.by(i, j) = (*slopes)(design->slot(through.names[i]), along);
  return through;
}

StrokeSensitivity stroke_sensitivity(const Job& job, const ParameterValues& parameters,
                                     const std::vector<std::string>& names,
                                     const ModelOptions& model, const StrokeRequest& request) {
  const auto design = resolve(job.design);
  const auto [material, end_effector] = numbers_set(job, parameters);
  std::vector<MechanismDirection> along =
      design->directions(parameters, material, end_effector, names);
  // load cases may leave out the edges whose sizes are formulas
  if (std::ranges::none_of(request.loads.assembly, &AssemblyError::of_design))
    for (const EdgeSize& size : design->edges())
      for (MechanismDirection& direction : along) {
        LeafSpring& rate = direction.rate.leaves[static_cast<std::size_t>(size.leaf)];
        rate.assembly_move.fill(Vector3d::Zero());
        rate.assembly_turn.fill(Vector3d::Zero());
      }
  return evaluate_stroke_gradients(design->build(parameters, material, end_effector), along, model,
                                   request);
}

}  // namespace flexopt
