#pragma once
// What path following, stiffness and frequencies know of a leaf: a body between two end edges that
// answers energy, internal force, tangent stiffness and mass. Full and reduced leaves alike.
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/elements/leaf/edge_pose.hpp"
#include "core/elements/leaf/leaf_stress.hpp"
#include "core/math/answer.hpp"
#include "core/math/types.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"

namespace flexopt {

/// The leaf seen from its edges; 12-vectors are (position, spin) of base then tip, global axes.
struct LeafEvaluation {
  double energy = 0;                      ///< [J]
  double rounding = 0;                    ///< what rounding may be of the energy [J]
  Vector12d force = Vector12d::Zero();    ///< ∂energy/∂q [N, N m]
  Matrix12d tangent = Matrix12d::Zero();  ///< ∂force/∂q, rotation varied as exp(hat δ) R
  /// Force and derivatives with respect to the displacement u of the leaf's material point. Only
  /// for leaves that have such a point (LeafSpring::point).
  struct Point {
    Vector3d force = Vector3d::Zero();      ///< ∂energy/∂u [N]
    Matrix3d tangent = Matrix3d::Zero();    ///< ∂force/∂u
    Eigen::Matrix<double, 3, 12> coupling;  ///< ∂force/∂q
  };
  std::optional<Point> point;
  double correction = 0;  ///< size of the step that the internal unknowns still want (lengths / L)
  double strain = 0;      ///< largest stretch of the mid-surface
  int negative_pivots = 0;  ///< of the internal stiffness, edges held
};

/// The unknowns inside a leaf, as lengths over its own, and their linearised change with the edges.
struct LeafInterior {
  VectorXd unknowns, change;
};

/// Kept copy of a leaf's internal unknowns.
struct LeafState {
  virtual ~LeafState() = default;
};

/// Mass over (12 edge coordinates, 3 of the material point if there is one, internal shapes), and
/// the stiffness of the internal shapes. That of the edges and the point is LeafEvaluation's; edges
/// and internal shapes have none together.
struct LeafDynamics {
  MatrixXd mass;
  MatrixXd internal_stiffness;
  VectorXd mode_frequencies;  ///< [Hz] of the internal shapes, edges held
  double highest_mode = 0;    ///< [Hz]; below it every mode between held edges is there
  double check = 0;           ///< relative internal correction met on the way
  /// Motion of stations of the leaf per unit coordinate, times the root of their mass: what tells
  /// two motions of the leaf apart. Any number of rows, the same at every state.
  MatrixXd stations;
  /// Motion of the points of shape() per unit coordinate, x, y, z of one after the other, global
  /// axes [m]: for drawing modes. Empty where it was not asked for, or a model does not tell.
  MatrixXd shape_motion;
};

/// Sets stiffness, frequencies and highest mode of internal shapes of unit mass. `omega2`: their
/// ω², ascending. The highest mode is half of the last: without shapes of the boundary's own
/// inertia more modes are needed.
void set_modes(LeafDynamics& dynamics, const VectorXd& omega2);

/// What dynamics() is asked for.
struct DynamicsRequest {
  int modes = 0;        ///< fixed-interface modes
  bool shapes = false;  ///< LeafDynamics::shape_motion too
  /// Whether LeafDynamics::stations are wanted; leaves may tell them all the same.
  bool stations = true;

  DynamicsRequest(int mode_count, bool with_shapes = false, bool with_stations = true)
      : modes(mode_count), shapes(with_shapes), stations(with_stations) {}
};

/// What acts inside a leaf.
struct LeafLoad {
  /// How much of the difference between the stress-free sizes of a warm leaf and those that its
  /// clamps hold acts, 0 … 1.
  double warmth = 0;
  Vector3d gravity = Vector3d::Zero();  ///< [m/s²], global axes
};

class LeafLinear;
class LimitedRange;

/// What a linearised leaf is wanted for beside its stiffness.
struct InteriorUse {
  bool mass = false;      ///< natural frequencies
  bool stress = false;    ///< stresses
  bool sections = false;  ///< LeafStress::sections as well
  bool places = false;    ///< places inside
};

class LeafElement {
 public:
  virtual ~LeafElement() = default;

  /// Follows the edges to a new place. `dq` is the linearised increment that led there, through
  /// the lever arms of the old place: the internal unknowns follow *it*.
  virtual void move(const EdgePoses& edges, const Vector12d& dq) = 0;
  /// Displacement of the material point, and its increment, for the move() to come. Only for leaves
  /// that have one.
  virtual void displace_point(const Vector3d& /*displacement*/, const Vector3d& /*du*/) {}

  /// From now on this load acts inside the leaf; at first no load does. Only full leaves support
  /// it: is_reducible() of core/mechanism/load_case.hpp says which leaves have to.
  virtual void act(const LeafLoad& /*load*/) {}

  /// Energy, force and tangent at the present place, internal unknowns eliminated to first order.
  virtual const LeafEvaluation& evaluate() = 0;
  /// Result of the latest evaluate().
  const LeafEvaluation& evaluation() const { return evaluation_; }

  /// This leaf as one whose model is valid in part of its states; null where it is valid in all.
  virtual LimitedRange* limited_range() { return nullptr; }
  /// Whether this is the leaf at full accuracy.
  virtual bool is_full() const { return false; }
  /// The leaf at full accuracy between the same edges, near its present state: what takes over
  /// where a reduced model does not lead on. `reason`: for its report. Of a full leaf a copy, its
  /// report unchanged. After evaluate().
  virtual std::unique_ptr<LeafElement> full_model(const std::string& reason) = 0;
  /// Linearisation about the present state with all interior unknowns; after evaluate(). The leaf
  /// must outlive it and keep its state. None unless the model has such unknowns.
  virtual Answer<std::unique_ptr<LeafLinear>> linearise();
  /// Whether linearise() has an answer for this use, with exact derivatives, at the present state.
  virtual Check check_interior(InteriorUse use);
  /// Whether a reduced leaf is to be believed beside the full one that it rebuilt at its present
  /// state, for frequencies or stress, and that one is, if one was rebuilt.
  virtual Check check_rebuilt() const { return {}; }

  /// Tells where the interior is and how it follows the edges; after evaluate(). It is empty for a
  /// leaf without unknowns of its own, and for one with a material point.
  virtual LeafInterior interior(const Vector12d& /*dq*/) const { return {}; }

  virtual std::unique_ptr<LeafState> save() const = 0;
  virtual void restore(const LeafState& state) = 0;

  /// Tells that dynamics() will be asked for at `states` states more: a model may prepare for it.
  virtual void expect_dynamics(int /*states*/) {}
  /// Craig–Bampton dynamics of the present equilibrium: constraint modes of the edges, the lowest
  /// fixed-interface modes and, where the leaf has them, further internal shapes. Without modes no
  /// internal shapes at all.
  virtual LeafDynamics dynamics(DynamicsRequest request) = 0;

  /// Tells the stress at the present state.
  virtual LeafStress stress() = 0;
  virtual LeafShape shape() = 0;
  /// Present places of points (along, across) of the mid-surface, each in [0, 1]²; looked-up ones
  /// are within some 1e-4 of the leaf's length.
  virtual std::vector<Vector3d> material_points(
      const std::vector<std::array<double, 2>>& places) = 0;
  /// Present place of such a point as exact as the leaf's forces.
  virtual Vector3d material_point(double along, double across) {
    return material_points({{along, across}}).front();
  }
  virtual LeafReport report() const = 0;

 protected:
  LeafEvaluation evaluation_;
};

}  // namespace flexopt
