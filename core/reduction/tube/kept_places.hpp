#pragma once
// Results kept for the latest places of the leaves of a model. Leaves in the same state reuse them:
// equal leaves of a symmetric mechanism.
#include <memory>
#include <utility>
#include <vector>

#include "core/reduction/tube/tube_dynamics.hpp"

namespace flexopt {

/// Whether two leaves of one model stand alike, but for rounding.
inline bool stand_alike(const TubeDynamics::Place& a, const TubeDynamics::Place& b) {
  constexpr double rounding = 1e-12;
  const auto all = [](const TubeDynamics::Place& p) {
    return (Vector6d() << p.sigma, p.tau, p.twist, p.f).finished();
  };
  const Vector6d one = all(a);
  return (one - all(b)).cwiseAbs().maxCoeff() <= rounding * one.cwiseAbs().maxCoeff();
}

template <class T>
class KeptPlaces {
 public:
  /// What was made at this place; where nothing was, make() makes it.
  template <class Make>
  std::shared_ptr<const T> at(const TubeDynamics::Place& place, const Make& make) {
    for (const auto& [where, what] : kept_)
      if (stand_alike(where, place)) return what;
    if (kept_.size() == most) kept_.erase(kept_.begin());
    return kept_.emplace_back(place, std::make_shared<const T>(make())).second;
  }

 private:
  static constexpr std::size_t most = 4;
  std::vector<std::pair<TubeDynamics::Place, std::shared_ptr<const T>>> kept_;
};

}  // namespace flexopt
