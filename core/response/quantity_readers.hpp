#pragma once
// Readers of lists of a point and of its gradients, for rows of the table of quantities.
#include <optional>

#include "core/response/quantities.hpp"

namespace flexopt {

/// Entry k of a list, or row k of a matrix; nothing where it has none.
template <auto Member>
std::optional<double> entry(const PathPoint& p, int k) {
  if (k >= static_cast<int>((p.*Member).size())) return std::nullopt;
  return (p.*Member)[k];
}
template <auto Member>
std::optional<VectorXd> entry(const PathPoint&, const PointGradients& g, int k) {
  if (k >= static_cast<int>((g.*Member).size())) return std::nullopt;
  return (g.*Member)[k];
}
template <auto Member>
std::optional<VectorXd> rate_row(const PathPoint&, const PointGradients& g, int k) {
  if (k >= (g.*Member).rows()) return std::nullopt;
  return VectorXd((g.*Member).row(k));
}

}  // namespace flexopt
