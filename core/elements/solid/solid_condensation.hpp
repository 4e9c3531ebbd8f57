#pragma once
// A solid mesh reduced to its interfaces, with what its rates need of the reduction.
#include <memory>
#include <vector>

#include "core/elements/solid/elastic_model.hpp"
#include "core/math/sparse_definite.hpp"

namespace flexopt {

/// Displacements [1, −x̂; 0, 1] of interfaces with these origins in a rigid motion about the
/// body's own origin: displacement, rotation; 6N × 6.
MatrixXd rigid_motions(const std::vector<Vector3d>& origins);
/// Its rate while the origins move.
MatrixXd rigid_motion_rates(const std::vector<Vector3d>& motion);
/// Displacements of all nodes for unit d of the interfaces that hold them, zero inside: u = u_a +
/// θ_a × (x − x_a), 3n × 6N.
MatrixXd patch_fields(const ElasticBody& body);
/// Its rate while nodes and origins move.
MatrixXd patch_field_rates(const ElasticBody& body, const ElasticBody& direction);
std::vector<Vector3d> origins_of(const ElasticBody& body);

struct Condensation {
  explicit Condensation(const ElasticBody& body);

  CondensedSolid solid;
  MatrixXd stiffness_fields, mass_fields;  ///< K Φ, M Φ

  /// Displacements under forces on all nodes while the patches are held; forces on these are not
  /// read. 3n × any, both.
  MatrixXd held_answer(const MatrixXd& forces) const;
  std::size_t bytes() const;

 private:
  void reduce(const ElasticBody& body);

  std::vector<int> free_nodes_;
  std::shared_ptr<const DefiniteFactor> factor_;
};

/// Kept as condensed() keeps it.
std::shared_ptr<const Condensation> condensation(const ElasticBody& body);

/// Φ_rig⁺, 6 × 6N: the rigid motion that is in a motion of the interfaces, by least squares in
/// which turns count as K tells; and 1 − Φ_rig Φ_rig⁺, the motion without it.
struct RigidSplit {
  MatrixXd inverse, elastic;
  RigidSplit(const MatrixXd& K, const MatrixXd& rigid);
};

/// First moments, total mass and moment of mass of a model, or of its rate, from `mass`: a body
/// whose interfaces move as one moves as one. `moving`: moments · dΦ_rig of a rate, else zero.
void add_rigid_moments(ElasticModel& model, const MatrixXd& rigid, const MatrixXd& moving);

inline MatrixXd symmetric_part(const MatrixXd& a) { return 0.5 * (a + a.transpose()); }

}  // namespace flexopt
