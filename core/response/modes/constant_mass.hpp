#pragma once
// The classical mass of a flexible body: that of the undeflected leaf, turned with its chord frame.
// For comparison; the mass of a leaf follows its deflection by default.
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "core/equilibrium/system.hpp"
#include "core/mechanism/model_options.hpp"

namespace flexopt {

class ConstantMass {
 public:
  /// Uses undeflected full leaves, whatever the accuracy of the model.
  ConstantMass(const Mechanism& mechanism, const ModelOptions& model);

  /// Craig–Bampton dynamics of a leaf of the assembled system: the undeflected leaf's mass,
  /// internal shapes and their frequencies, M = T M0 Tᵀ with T the turn of the chord frame (of the
  /// base edge, where the tip is free) for every vector of three.
  LeafDynamics dynamics(const System& system, int leaf, DynamicsRequest request);

 private:
  std::vector<std::unique_ptr<LeafElement>> undeflected_;
  std::map<std::tuple<int, int, bool>, LeafDynamics> known_;  ///< by (leaf, modes, shapes)
};

}  // namespace flexopt
