#pragma once
// The elastic bodies of a mechanism as part of its energy: README.md (Q13).
#include <memory>
#include <vector>

#include "core/elements/solid/elastic_model.hpp"
#include "core/elements/solid/held_body.hpp"
#include "core/math/block_matrix.hpp"
#include "core/mechanism/load_case.hpp"

namespace flexopt {

class ElasticBodies {
 public:
  /// Condenses the bodies, each of which has passed check_solid(); nothing acts at first. The
  /// mechanism must outlive this.
  explicit ElasticBodies(const Mechanism& mechanism);

  int count() const { return static_cast<int>(bodies_.size()); }
  const ElasticBody& body(int k) const { return mechanism_->elastic_bodies[k]; }
  const CondensedSolid& solid(int k) const { return *bodies_[k].solid; }
  const ElasticModel& model(int k) const { return bodies_[k].solid->model; }
  /// Fixed-interface modes of a body for so many frequencies of the mechanism. This has no more
  /// modes below its highest frequency than that; the others make it accurate.
  std::shared_ptr<const FixedInterfaceModes> modes(int k, int frequencies) const {
    return fixed_interface_modes(body(k), modes_for(frequencies));
  }
  static int modes_for(int frequencies) { return frequencies + 12; }
  /// The state of the last evaluation.
  const HeldBody& held(int k) const { return bodies_[k].held; }
  const ElasticAction& action() const { return action_; }
  void act(const ElasticAction& action) { action_ = action; }

  /// Adds energy [J] (that of the weight from the undeflected places on), forces on the rigid
  /// bodies and tangent at these poses; false where the floating frame of a body is not found.
  bool add(const std::vector<JointBody>& poses, double& energy, VectorXd& force,
           BlockMatrix& tangent);
  /// Adds the mass at the state of the last evaluation.
  void add_mass(BlockMatrix& mass) const;

 private:
  struct Body {
    std::shared_ptr<const CondensedSolid> solid;
    std::vector<JointBody> holders;
    HeldBody held;
  };
  const Mechanism* mechanism_;
  std::vector<Body> bodies_;
  ElasticAction action_;
};

/// What so much of the loads does to elastic bodies.
ElasticAction action_of(const LoadCase& loads, LoadFactors factors);

/// Forces of the elastic bodies in the undeflected state, by their weight and warmth.
VectorXd elastic_forces(const Mechanism& mechanism, const ElasticAction& action);

/// The rigid bodies, or the ground, that hold the interfaces of an elastic body.
template <class S>
std::vector<JointBodyOf<S>> holders_of(const ElasticBody& body,
                                       const std::vector<JointBodyOf<S>>& bodies) {
  std::vector<JointBodyOf<S>> holders;
  for (const ElasticInterface& interface : body.interfaces)
    holders.push_back(body_or_ground(bodies, interface.body));
  return holders;
}

/// Rows of the holders' motions from rows of all bodies and the motion of the ground (6 rows; none:
/// it stays).
template <class S>
Eigen::MatrixX<S> holder_rows(const ElasticBody& body, const Eigen::MatrixX<S>& bodies,
                              const MatrixXd& of_ground = {}) {
  const auto count = static_cast<Eigen::Index>(body.interfaces.size());
  Eigen::MatrixX<S> rows = Eigen::MatrixX<S>::Zero(6 * count, bodies.cols());
  for (Eigen::Index a = 0; a < count; ++a)
    if (const int b = body.interfaces[static_cast<std::size_t>(a)].body; b >= 0)
      rows.middleRows(6 * a, 6) = bodies.middleRows(6 * b, 6);
    else if (of_ground.size() > 0)
      rows.middleRows(6 * a, 6) = of_ground.template cast<S>();
  return rows;
}

/// Adds forces on the holders to the rows of all bodies.
template <class Forces, class Rows>
void add_holder_forces(const ElasticBody& body, const Forces& forces, Rows&& bodies) {
  for (std::size_t a = 0; a < body.interfaces.size(); ++a)
    if (const int b = body.interfaces[a].body; b >= 0)
      bodies.middleRows(6 * b, 6) += forces.middleRows(6 * static_cast<Eigen::Index>(a), 6);
}

/// Adds a matrix over the holders of an elastic body to one over all bodies.
void add_between(const MatrixXd& H, const ElasticBody& body, BlockMatrix& K);

}  // namespace flexopt
