#pragma once
// Requests that many tests make of a mechanism, and responses that they go on with.
#include <catch2/catch.hpp>

#include "core/response/response.hpp"

namespace flexopt::test {

/// The response, which has to be there.
inline StrokeResponse evaluated(const Mechanism& mechanism, const ModelOptions& model,
                                const StrokeRequest& request) {
  StrokeResponse response = evaluate_stroke(mechanism, model, request);
  INFO(response.message);
  REQUIRE(response.status == Status::ok);
  return response;
}

inline ModelOptions full(ModelOptions model = {}) {
  model.accuracy = Accuracy::full;
  return model;
}

/// Strokes from zero to the end at equal distances.
inline std::vector<double> evenly(double end, int points) {
  std::vector<double> all;
  for (int k = 0; k < points; ++k) all.push_back(end * k / (points - 1));
  return all;
}

/// All numbers but the stress.
inline Outputs without_stress() { return Outputs::numbers().remove(Output::stress); }

/// The largest relative difference of the support stiffness at a point.
inline double support_error(const PathPoint& found, const PathPoint& truth) {
  double worst = 0;
  for (std::size_t d = 0; d < 6; ++d)
    if (truth.support_stiffness[d])
      worst =
          std::max(worst, std::abs(*found.support_stiffness[d] / *truth.support_stiffness[d] - 1));
  return worst;
}

/// The largest relative difference of natural frequencies.
inline double frequency_error(const std::vector<double>& found, const std::vector<double>& truth) {
  REQUIRE(found.size() == truth.size());
  double worst = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    worst = std::max(worst, std::abs(found[i] / truth[i] - 1));
  return worst;
}

/// The same of all points of a path, their drive free and locked.
inline double frequency_error(const StrokeResponse& found, const StrokeResponse& truth) {
  double worst = 0;
  for (std::size_t k = 0; k < truth.path.size(); ++k)
    for (const auto list : {&PathPoint::frequencies_free, &PathPoint::frequencies_locked})
      worst = std::max(worst, frequency_error(found.path[k].*list, truth.path[k].*list));
  return worst;
}

}  // namespace flexopt::test
