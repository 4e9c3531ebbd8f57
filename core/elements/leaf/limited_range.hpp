#pragma once
// What path following asks of a leaf whose model holds in part of its states only.
#include <functional>
#include <memory>
#include <optional>

#include "core/elements/leaf/leaf_element.hpp"

namespace flexopt {

/// How a mechanism in equilibrium stands at the edges of one of its leaves, this leaf in it.
/// 12-vectors are (displacement, spin) of base then tip, global axes.
struct EdgeSurroundings {
  /// Motion of the edges by unit forces and moments upon them, drives held; symmetric.
  Matrix12d compliance = Matrix12d::Zero();
  /// Motion of the edges by a unit stroke of each drive, the others held, all that is free giving
  /// way.
  Eigen::Matrix<double, 12, Eigen::Dynamic> strokes;
  /// d load / d stroke of the drives; symmetric.
  MatrixXd drive_stiffness;
  /// For each drive, the sum over all leaves of the absolute values of what they add to its load
  /// and to its own stiffness.
  VectorXd parts_of_load, parts_of_stiffness;
  VectorXd drive_loads;
};

/// A leaf whose model holds in part of its states.
class LimitedRange {
 public:
  virtual ~LimitedRange() = default;

  /// The change that is needed before the equilibrium is believed.
  struct Refinement {
    bool changed = false;                      ///< solve again
    std::unique_ptr<LeafElement> replacement;  ///< another model of the leaf, at the same state
  };
  /// Computed when it is called. None where the equilibrium is not stable, drives held.
  using Surroundings = std::function<std::optional<EdgeSurroundings>()>;
  virtual Refinement refine(const Surroundings& surroundings) = 0;
};

}  // namespace flexopt
