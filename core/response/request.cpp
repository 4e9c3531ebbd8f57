#include "core/response/request.hpp"

#include <algorithm>

namespace flexopt {

bool ParasiticRule::admits(ModeKind kind) const {
  return kind != ModeKind::drive && std::ranges::find(skipped, kind) == skipped.end();
}

VectorXd StrokeRequest::strokes_at(std::size_t point, std::size_t drives) const {
  if (!strokes.empty()) return strokes[point];
  VectorXd first = VectorXd::Zero(drives);
  if (drives > 0) first[0] = points[point];
  return first;
}

int StrokeRequest::frequencies_of(DriveState drive) const {
  const Output list =
      drive == DriveState::free ? Output::frequencies_free : Output::frequencies_locked;
  const bool wanted =
      outputs.has(list) || (outputs.has(Output::parasitic_frequency) && parasitic.drive == drive);
  return wanted ? frequencies : 0;
}

bool StrokeRequest::wants_frequency_derivatives() const {
  return frequencies > 0 && outputs.has(Output::frequency_derivatives) && loads.driven() &&
         loads.held.none() && !loads.follow();
}

bool StrokeRequest::wants_state_space(std::size_t point) const {
  return state_space && outputs.has(Output::state_space) &&
         (state_space->points.empty() ||
          std::ranges::find(state_space->points, static_cast<int>(point)) !=
              state_space->points.end());
}

bool StrokeRequest::wants_leaf_points(std::size_t point, bool differentiable) const {
  const bool wanted = (wants_state_space(point) && state_space->sensors) || wants_transfers() ||
                      (wants_dynamics() && dynamics->transmissibility) ||
                      (differentiable && outputs.has(Output::leaf_points));
  return wanted && std::ranges::any_of(named_points, [](const NamedPoint& p) { return !p.body; });
}

std::optional<std::size_t> StrokeRequest::growing_load() const {
  if (!outputs.has(Output::buckling) || buckling_load.empty()) return std::nullopt;
  const auto named = std::ranges::find(loads.constant, buckling_load, &DeadLoad::name);
  if (named == loads.constant.end()) return std::nullopt;
  return static_cast<std::size_t>(named - loads.constant.begin());
}

}  // namespace flexopt
