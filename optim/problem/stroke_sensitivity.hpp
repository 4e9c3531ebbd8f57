#pragma once
// A job's stroke with exact derivatives with respect to the parameters of its design.
#include <string>
#include <vector>

#include "core/response/stroke_gradients.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// Every name that the design of a job can be differentiated by: the parameters of the family
/// (formulas and counts apart), `material.…` and, where there is one, `end_effector.…`.
std::vector<std::string> differentiable_parameters(const Job& job);

/// The stroke of the design with these parameters (complete_parameters), differentiated by the
/// named ones, each at constant others: formulas among the parameters count as parameters of their
/// own, with the values given, and numbers of material and end-effector may stand among them.
/// Throws SpecError where the parameters make no sensible geometry.
StrokeSensitivity stroke_sensitivity(const Job& job, const ParameterValues& parameters,
                                     const std::vector<std::string>& names,
                                     const ModelOptions& model, const StrokeRequest& request);

}  // namespace flexopt
