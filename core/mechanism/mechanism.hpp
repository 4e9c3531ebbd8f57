#pragma once
// What a mechanism is: plain data, never changed after it was built. SI units, global axes.
// Templated on the scalar so that a family can be differentiated with respect to its parameters.
#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/answer.hpp"
#include "core/math/types.hpp"
#include "core/mechanism/arc.hpp"
#include "core/mechanism/elastic_body.hpp"
#include "core/mechanism/s_n_curve.hpp"

namespace flexopt {

/// Direction of a rigid body's motion; also its row in every 6×6 matrix.
enum class Direction { ux, uy, uz, rx, ry, rz };
inline constexpr std::array<std::string_view, 6> direction_names{"ux", "uy", "uz",
                                                                 "rx", "ry", "rz"};
inline constexpr int index(Direction d) { return static_cast<int>(d); }
inline constexpr bool is_rotation(Direction d) { return index(d) >= 3; }

/// Linear elastic, isotropic.
template <class Scalar>
struct MaterialT {
  std::string name;
  Scalar youngs_modulus{};                 ///< [Pa]
  Scalar poissons_ratio{};                 ///< [-]
  Scalar density{};                        ///< [kg/m³]
  std::optional<double> allowable_stress;  ///< [Pa]
  std::optional<double>
      thermal_expansion;  ///< linear coefficient, the same at all temperatures [1/K]
  /// Rp0.2, Rm, and the amplitude that is endured at mean zero, of the surface as made [Pa].
  std::optional<double> yield_strength, ultimate_strength, endurance_limit;
  std::optional<SnCurve> s_n_curve;  ///< S-N curve of the surface as made

  Scalar shear_modulus() const { return youngs_modulus / (2.0 * (1.0 + poissons_ratio)); }
};

/// Body index of the fixed world.
inline constexpr int ground = -1;
/// Value of LeafSpring::tip where nothing holds the tip edge.
inline constexpr int free_edge = -2;

/// A material point of a leaf's mid-surface that is a body of its own: the two share their
/// displacement, and a force on the body acts on the leaf there.
template <class Scalar>
struct LeafPointT {
  int body = 0;
  Scalar along{}, across{};  ///< place on the leaf, each in [0, 1]
  /// The body follows the mean of the tip edge instead, and spreads its force evenly over it.
  bool spread_over_tip = false;
};

/// Cross-section of a leaf. Circular: a wire flexure, width = thickness = diameter.
enum class Section { rectangular, circular };

/// Largest angle of a fold, so that both legs have room [rad].
inline constexpr double largest_fold = 175 * std::numbers::pi / 180;

/// A line across a leaf at which it turns when undeformed: two flat legs at a fixed angle.
template <class Scalar>
struct LeafFoldT {
  Scalar place{};  ///< of the line: the first leg's part of the length, between 0 and 1
  Scalar angle{};  ///< of the second leg against the first, towards the normal [rad]
  /// Inner radius of the bend over the length; 0: a mitred corner. fold_corner.hpp.
  Scalar radius{};
  auto operator<=>(const LeafFoldT&) const = default;
};

/// A leaf spring, flat, folded or a circular arc when undeformed; both short edges are clamped
/// along their whole width to a body or to the ground; the tip edge may be free. Width and
/// thickness may vary along a leaf that is not folded.
template <class Scalar>
struct LeafSpringT {
  std::string name;
  int base = ground;       ///< body that holds the base edge
  int tip = 0;             ///< body that holds the tip edge, or free_edge
  Vector3<Scalar> origin;  ///< middle of the base edge [m]
  /// Columns: along the leaf (its chord, its first leg), along its width, normal to it.
  Matrix3<Scalar> axes;
  /// [m]; of profiles: what their factors refer to. The length is that of the arc, or of both legs.
  Scalar length{}, width{}, thickness{};
  /// For a curved leaf, the angle that its arc subtends, bulging towards the normal [rad].
  std::optional<Scalar> curve;
  std::optional<LeafFoldT<Scalar>> fold;
  /// Factors on width and thickness along the leaf: profile.hpp. Empty: uniform.
  std::vector<Scalar> width_profile, thickness_profile;
  MaterialT<Scalar> material;
  Section section = Section::rectangular;
  bool may_cross = false;  ///< other leaves, as in planar models: no clearance between them
  std::optional<LeafPointT<Scalar>> point;
  /// Stress-free length, width and thickness over the nominal ones, for a leaf that is warmer than
  /// the bodies. Bodies hold its edges at the nominal places and widths, or at those of grown
  /// bodies.
  double growth = 1;
  /// Stress-free sizes over nominal sizes of the bodies that hold the base and the tip, which may
  /// be warm too.
  std::array<double, 2> clamp_growth{1, 1};
  /// Displacement [m] and rotation vector [rad] by which the base and the tip sit in their bodies
  /// other than designed, where they depend on parameters of the design; loads say when they come
  /// (AssemblyError::of_design). In a derivative also the change along any other error of assembly.
  std::array<Vector3d, 2> assembly_move{Vector3d::Zero(), Vector3d::Zero()},
      assembly_turn{Vector3d::Zero(), Vector3d::Zero()};

  /// Distance from base to tip [m].
  Scalar chord() const {
    return curve ? Scalar(length * sine_ratio<Scalar>(0.5 * *curve)) : length;
  }
  /// Vector from the middle of the base edge to that of the tip edge [m].
  Vector3<Scalar> span() const {
    if (!fold) return axes.col(0) * chord();
    const ArcPoint<Scalar> tip = middle(Scalar(1));
    return axes.col(0) * (length * tip.x) + axes.col(2) * (length * tip.z);
  }
  Vector3<Scalar> tip_middle() const { return origin + span(); }
  /// Place of the middle line over the length, in the leaf's axes, and its direction, at the part s
  /// of the length.
  ArcPoint<Scalar> middle(const Scalar& s) const {
    if (curve) return arc_point<Scalar>(*curve, s);
    if (fold && value_of(s) > value_of(fold->place))
      return leg_point<Scalar>(fold->place, fold->angle, s);
    return {s, Scalar(0), Scalar(1), Scalar(0)};
  }
  /// Coordinates of a place in global axes: along the leaf, across it from the middle, and above it
  /// [m].
  Vector3<Scalar> coordinates(const Vector3<Scalar>& place) const {
    const Vector3<Scalar> way = place - origin;
    Vector3<Scalar> local(axes.col(0).dot(way), axes.col(1).dot(way), axes.col(2).dot(way));
    if (fold) {
      const ArcPoint<Scalar> leg = leg_point<Scalar>(fold->place, fold->angle, fold->place);
      const Scalar x = local[0] - length * leg.x, z = local[2];
      const Scalar along = leg.cosine * x + leg.sine * z, above = leg.cosine * z - leg.sine * x;
      using std::abs;
      const bool second = abs(value_of(above)) < abs(value_of(z)) && value_of(along) > 0;
      if (second) return {length * leg.x + along, local[1], above};
      return local;
    }
    if (!curve || value_of(*curve) == 0) return local;
    const ArcCoordinates<Scalar> at =
        arc_coordinates<Scalar>(*curve, local[0] / length, local[2] / length);
    local[0] = length * at.along;
    local[2] = length * at.height;
    return local;
  }
  /// Axes of the clamped edge (0 base, 1 tip): along the leaf there, along its width, normal to it.
  Matrix3<Scalar> edge_axes(int end) const {
    if (!curve && !fold) return axes;
    return axes * middle(Scalar(end)).axes();
  }
  bool has_profile() const { return !width_profile.empty() || !thickness_profile.empty(); }
};

enum class BodyRole { end_effector, intermediate };

/// The room that a body takes, undeflected: a cuboid. For envelope and clearance alone.
template <class Scalar>
struct BodyBoxT {
  Vector3<Scalar> center;      ///< [m]
  Matrix3<Scalar> half_edges;  ///< columns, from the centre to three faces, global axes [m]
};

/// A rigid body in its undeflected place.
template <class Scalar>
struct RigidBodyT {
  std::string name;
  BodyRole role = BodyRole::end_effector;
  Vector3<Scalar> reference;       ///< the point whose displacement is an unknown (O) [m]
  Scalar mass{};                   ///< [kg]
  Vector3<Scalar> center_of_mass;  ///< [m]
  Matrix3<Scalar> inertia;         ///< about the centre of mass, global axes [kg m²]
  /// Directions along global axes in which it cannot move; other ones are joints of the kinds
  /// held_displacement and held_rotation. A material point of a leaf has no rotations.
  std::array<bool, 6> held{};
  std::optional<BodyBoxT<Scalar>> box;
};

enum class JointType {
  rigid,      ///< no relative motion
  revolute,   ///< turns about the axis
  spherical,  ///< turns about the place
  prismatic,  ///< slides along the axis
  /// The body holds one direction against the ground: the displacement of its reference point along
  /// the axis, or the component of its rotation vector.
  held_displacement,
  held_rotation
};
inline bool is_held(JointType type) {
  return type == JointType::held_displacement || type == JointType::held_rotation;
}

/// Ties two bodies, or a body to the ground, by conditions with Lagrange multipliers: joint.hpp.
template <class Scalar>
struct JointT {
  std::string name;
  JointType type = JointType::rigid;
  int body = 0, other = ground;
  Vector3<Scalar> place;                            ///< in the undeflected state, global axes [m]
  Vector3<Scalar> axis = Vector3<Scalar>::UnitZ();  ///< unit; not of a rigid or spherical joint
};

/// A spring between two points of two bodies, or a bushing between them: spring.hpp.
template <class Scalar>
struct SpringT {
  std::string name;
  int body = 0, other = ground;
  Vector3<Scalar> place;        ///< end on `body`, or the bushing's; undeflected, global axes [m]
  Vector3<Scalar> other_place;  ///< end on `other` [m]; not of a bushing
  Scalar stiffness{};           ///< not negative [N/m]; not of a bushing
  Scalar free_length{};         ///< length without force [m]; not of a bushing
  /// Instead of stiffness and free length: at least two lengths [m], ascending, each with the force
  /// that pulls the ends together there [N]. spring.hpp.
  std::vector<std::array<Scalar, 2>> line;
  /// Stiffness of a bushing: loads at `place` over displacement and rotation of `body` relative to
  /// `other`, undeflected, global axes, symmetric and positive semidefinite [N/m, N, N m].
  std::optional<Matrix6<Scalar>> matrix;
};

/// A voice coil whose force is the drive load.
template <class Scalar>
struct VoiceCoilT {
  Scalar motor_constant{};  ///< load over current [N/A or N m/A]
  Scalar resistance{};      ///< of its winding [ohm]
};

/// A piezo stack. Its full voltage makes it longer by the free stroke where nothing loads it, and
/// makes it push with the blocking force where its ends cannot part.
template <class Scalar>
struct PiezoStackT {
  Scalar free_stroke{};     ///< [m]
  Scalar blocking_force{};  ///< [N]
  Scalar stiffness() const { return blocking_force / free_stroke; }
};

/// What a stroke prescribes: the motion of a body's reference point or its rotation, relative to
/// `other`, along `direction` in axes of its own.
template <class Scalar>
struct DriveT {
  std::string name;
  int body = 0, other = ground;
  Direction direction = Direction::uy;
  /// Columns: x, y, z of the drive in the undeflected state, global; they turn with `other`.
  Matrix3<Scalar> axes = Matrix3<Scalar>::Identity();
  bool axes_change = false;  ///< along a design: the stroke then is a condition in any case
  /// What makes the load. The stroke of a piezo is that of `body`, a body without mass at the end
  /// of the stack, which a spring of the stack's stiffness ties to the body that the stack pushes.
  std::optional<VoiceCoilT<Scalar>> voice_coil;
  std::optional<PiezoStackT<Scalar>> piezo;
};

template <class Scalar>
using ElasticBodyT = ElasticBodyOf<Scalar, MaterialT<Scalar>>;

template <class Scalar>
struct MechanismT {
  std::vector<RigidBodyT<Scalar>> bodies;  ///< the free ones
  std::vector<LeafSpringT<Scalar>> leaves;
  std::vector<ElasticBodyT<Scalar>> elastic_bodies;
  std::vector<JointT<Scalar>> joints;
  std::vector<SpringT<Scalar>> springs;
  int end_effector = 0;  ///< its reference point is O
  /// Drives, at most six; none where nothing is driven.
  std::vector<DriveT<Scalar>> drives;
};

/// Whether a leaf has an elastic fold; such leaves are always full ones.
template <class Scalar>
bool has_fold(const MechanismT<Scalar>& mechanism) {
  for (const auto& leaf : mechanism.leaves)
    if (leaf.fold) return true;
  return false;
}

using Material = MaterialT<double>;
using LeafPoint = LeafPointT<double>;
using LeafFold = LeafFoldT<double>;
using LeafSpring = LeafSpringT<double>;
using RigidBody = RigidBodyT<double>;
using Joint = JointT<double>;
using Spring = SpringT<double>;
using ElasticInterface = ElasticInterfaceT<double>;
using ElasticBody = ElasticBodyT<double>;
using Drive = DriveT<double>;
using Mechanism = MechanismT<double>;

/// Rules of a mechanism: indices, positive sizes, unit axes, leaves meeting their bodies, elastic
/// bodies between two or more, joints that repeat each other or stand against the drive, leaves
/// that intersect when undeflected, a direction of a body without stiffness.
Check check_rules(const Mechanism& mechanism);
/// Rules of a spring, and of an elastic body, of a mechanism with so many bodies.
Check check_rules(const Spring& spring, int bodies);
Check check_rules(const ElasticBody& body, int bodies);
/// Rules of the material of what has this name.
Check check_rules(const Material& material, const std::string& where);
/// Whether axes are orthonormal and right-handed, to 1e-9.
bool are_right_handed(const Matrix3d& axes);

/// The largest size along the own axes; of imported matrices the length at which turning meets as
/// much resistance as pushing, where that is more [m].
double extent(const ElasticBody& body);

/// Length of the longest leaf; without leaves, size of the largest elastic body [m].
double longest_leaf(const Mechanism& mechanism);

}  // namespace flexopt
