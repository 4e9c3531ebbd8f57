#include "core/response/path/frequency_derivatives.hpp"

#include <algorithm>
#include <cmath>

namespace flexopt {

std::vector<VectorXd> stroke_ways(const StrokeRequest& request) {
  std::vector<VectorXd> ways;
  if (request.strokes.empty() || request.strokes.front().size() < 2) return ways;
  for (const VectorXd& strokes : request.strokes) {
    if (strokes.isZero(0)) continue;
    bool on_one = false;
    for (VectorXd& way : ways) {
      const auto part = part_of_way(way, {strokes.begin(), strokes.end()});
      if (!part) continue;
      on_one = true;
      if (std::abs(*part) > 1) way = strokes;
      break;
    }
    if (!on_one) ways.push_back(strokes);
  }
  if (ways.empty()) ways.push_back(VectorXd::Unit(request.strokes.front().size(), 0));
  return ways;
}

std::optional<double> part_of_way(const VectorXd& way, const std::vector<double>& strokes) {
  constexpr double beside = 1e-9;  // of the stroke
  Eigen::Index longest = 0;
  way.cwiseAbs().maxCoeff(&longest);
  const Eigen::Map<const VectorXd> at(strokes.data(), strokes.size());
  if (at.isZero(0)) return 0;
  // strokes have units of their own: each is compared with its own size
  const double part = at[longest] / way[longest];
  for (Eigen::Index k = 0; k < way.size(); ++k)
    if (std::abs(at[k] - part * way[k]) > beside * (std::abs(at[k]) + std::abs(part * way[k])))
      return std::nullopt;
  return part == 0 ? std::nullopt : std::optional(part);
}

std::optional<ModesToPoint> modes_to_point(const StrokeResponse& response,
                                           const StrokeGradients* gradients,
                                           const PathPoint& point) {
  if (response.frequency_derivatives.empty()) return std::nullopt;
  if (point.strokes.size() < 2) {
    const auto& modes = response.frequency_derivatives;
    if (modes.back().drive != 0) return std::nullopt;
    const bool whole = gradients && gradients->frequency_derivatives.size() == modes.size();
    return ModesToPoint{&modes, whole ? &gradients->frequency_derivatives : nullptr, point.stroke};
  }
  for (std::size_t k = 0; k < response.frequency_ways.size(); ++k) {
    const FrequencyWay& way = response.frequency_ways[k];
    const auto part = part_of_way(way.strokes, point.strokes);
    if (!part) continue;
    const bool whole = gradients && gradients->frequency_ways.size() > k &&
                       gradients->frequency_ways[k].size() == way.modes.size();
    return ModesToPoint{&way.modes, whole ? &gradients->frequency_ways[k] : nullptr, *part};
  }
  return std::nullopt;
}

}  // namespace flexopt
