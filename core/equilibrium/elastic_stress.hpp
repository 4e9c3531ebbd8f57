#pragma once
// Stress of the elastic bodies of a mechanism at an equilibrium.
#include "core/elements/leaf/leaf_results.hpp"
#include "core/elements/solid/solid_stress.hpp"
#include "core/equilibrium/elastic_bodies.hpp"

namespace flexopt {

/// What an elastic body with a mesh tells of its stress, as LeafStress does of a leaf's.
class ElasticStress {
 public:
  /// Body `k` in the state of the last evaluation, which must stay.
  ElasticStress(const ElasticBodies& bodies, int k);

  const SolidSurface& surface() const { return bodies_->solid(k_).surface; }
  const SolidStress& stress() const { return stress_; }
  /// The largest von Mises stress of the surface; nothing where all cells are beside patches.
  std::optional<StressPeak> largest() const;
  /// The nodes where it is larger than at all others of their cells that count. The largest of them
  /// is largest().
  std::vector<StressPeak> peaks() const;
  /// The nodes that count for largest(), and their stresses in columns.
  std::vector<StressPlace> places() const;
  MatrixXd sections(const std::vector<StressPlace>& places) const;
  /// Places of a node, global axes: present, and undeflected [m].
  Vector3d place(int node) const;
  Vector3d undeflected_place(int node) const;

 private:
  StressPeak peak(int node, double von_mises) const;

  const ElasticBodies* bodies_;
  int k_;
  VectorXd displacements_;
  SolidStress stress_;
};

}  // namespace flexopt
