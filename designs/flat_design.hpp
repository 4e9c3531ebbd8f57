#pragma once
// A design at given numbers: no frames, parts, repeats or options, global axes, full names. What
// `flexopt expand` prints, and what the mechanism is made of.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/mechanism.hpp"
#include "core/spec/fault_list.hpp"
#include "designs/design_plan.hpp"
#include "designs/end_effector.hpp"
#include "designs/solids/solid_shape.hpp"

namespace flexopt {

/// What an item of the flat design comes from.
struct ItemSource {
  const DesignSource* source = nullptr;
  std::string pointer;   ///< into the file
  std::string instance;  ///< " (copy i = 3 of part arm)", for messages
  /// The item "parts" has of the design that the file is a part of; null where it is of none.
  std::shared_ptr<const ItemSource> part = nullptr;
};

/// The error with its place, and the copy that it comes from. In a part that is one of the
/// program's families the place is that of the part, in the file that uses it.
SpecError located(const ItemSource& item, const SpecError& error);

/// An item with what it comes from.
template <class Item>
struct Sourced : Item {
  ItemSource source;
};
template <class S>
using FlatJoint = Sourced<JointT<S>>;
template <class S>
using FlatSpring = Sourced<SpringT<S>>;
/// `piezo_at`: where the stack pushes its body, which is that of the drive.
template <class S>
struct FlatDrive : Sourced<DriveT<S>> {
  Vector3<S> piezo_at = Vector3<S>::Zero();
};

/// A direction that a body holds, of the kind held_displacement or held_rotation.
template <class S>
struct FlatHeld {
  JointType type = JointType::held_displacement;
  Vector3<S> axis;  ///< unit
};

template <class S>
struct FlatBody {
  std::string name;
  ItemSource source;
  Vector3<S> at;
  bool has_mass = false;  ///< says itself what it weighs
  S mass{};
  Vector3<S> center_of_mass = Vector3<S>::Zero();  ///< relative to `at`
  Matrix3<S> inertia = Matrix3<S>::Zero();
  std::optional<Matrix3<S>> box_half_edges;  ///< columns; around the centre of mass
  std::array<bool, 6> held{};                ///< along global axes, whatever the parameters are
  std::vector<FlatHeld<S>> held_along;       ///< the others
  std::string leaf;           ///< leaf of which it is a material point, by its full name
  bool of_interface = false;  ///< no item of its own: a frame of an elastic body
};

/// No body: that of an elastic body whose interfaces are all parts of other bodies.
inline constexpr int no_body = -3;

struct ElasticItem;

/// A rigid frame that holds a patch of an elastic body.
template <class S>
struct FlatInterface {
  std::string name;  ///< behind that of the elastic body
  ItemSource source;
  int body = ground;
  std::string carrier;   ///< body that the file names; empty: none
  bool implied = false;  ///< by a leaf or by another elastic body
  /// The patch, global axes: its middle, unit vectors out of the face and along the first side.
  Vector3<S> at, normal, along;
  std::array<S, 2> sides;
  PatchT<S> patch;         ///< the same in own axes of the elastic body
  std::vector<int> nodes;  ///< instead, of a mesh of a file
};

template <class S>
struct FlatElastic {
  std::string name;
  ItemSource source;
  Vector3<S> place;  ///< of its own origin
  Matrix3<S> axes;   ///< own axes, right-handed
  SolidShapeT<S> shape;
  std::shared_ptr<const ElasticItem> file;  ///< instead of the shape, where it is of a file
  bool mirrored = false;                    ///< the file's z is against own z
  std::optional<Material> material;         ///< where it has its own
  std::vector<FlatInterface<S>> interfaces;
  std::optional<ElasticDegree> given_degree;  ///< nothing: by the number of interfaces
  MeshDensity density;
  int frame = no_body;  ///< the body of its name
  bool rigid = false;   ///< all interfaces are parts of that body, so that it weighs alone

  /// Degree 4 costs little up to three interfaces, and what they join may be flexures of one piece.
  ElasticDegree degree() const {
    return given_degree.value_or(interfaces.size() <= 3 ? ElasticDegree::quartic
                                                        : ElasticDegree::linear);
  }
};

/// A size along a leaf: one value; or at base and tip; or at profile_stations().
template <class S>
struct FlatSize {
  std::vector<S> values;
  std::string formula;  ///< formula of a profile, with numbers for all names but s
};

/// A part of a leaf that lies on a face of an elastic body.
template <class S>
struct FlatClamp {
  S length;
  Vector3<S> normal;  ///< out of the face
};

template <class S>
struct FlatLeaf {
  std::string name;
  std::string whole;  ///< name of the leaf in the design file, of which this may be a piece
  ItemSource source;
  int base = ground, tip = ground;  ///< bodies; free_edge
  Vector3<S> base_at, tip_at, across;
  bool wire = false;
  bool may_cross = false;              ///< other leaves
  std::array<std::string, 2> held_by;  ///< elastic bodies whose faces base and tip are put on
  std::array<std::optional<FlatClamp<S>>, 2> clamps;
  FlatSize<S> width, thickness;    ///< width and thickness; both the diameter of a wire
  std::optional<S> curve;          ///< angle of its arc, bulging to across × (base → tip) [rad]
  std::optional<Vector3<S>> fold;  ///< middle of its fold line
  S fold_radius = S(0);            ///< inner radius of its bend [m]
  std::optional<Material> material;  ///< where the leaf has its own
};

template <class S>
struct FlatDesign {
  std::vector<FlatBody<S>> bodies;
  std::vector<FlatElastic<S>> elastic_bodies;
  std::vector<FlatLeaf<S>> leaves;
  std::vector<FlatJoint<S>> joints;
  std::vector<FlatSpring<S>> springs;
  std::vector<FlatDrive<S>> drives;
  bool named_drives = false;
  int end_effector = -1;
};

/// What a design is evaluated with.
template <class S>
struct DesignInput {
  std::vector<S> parameters;  ///< in the design's order
  const FamilyChoices* choices = nullptr;
  MaterialT<S> material;  ///< material of the leaves that have none of their own
};

/// Throws SpecError with all that is wrong, each with its place.
template <class S>
FlatDesign<S> flatten(const DesignPlan& plan, const DesignInput<S>& input);
/// The items that are sound; what is wrong is added to `faults`.
template <class S>
FlatDesign<S> flatten(const DesignPlan& plan, const DesignInput<S>& input, FaultList& faults);

/// Meshes of an elastic body, which stay along a design whose nominal numbers stay.
struct ElasticPlan {
  SolidPlan mesh;
  std::optional<SolidPlan> coarse;             ///< for the error of the mesh
  std::shared_ptr<const ElasticBody> nominal;  ///< the body that the mesh is made for
};
/// Plans of the elastic bodies of the nominal design; those of the last designs are kept. Throws
/// SpecError.
std::vector<ElasticPlan> plans_of(const FlatDesign<double>& nominal, const Material& material);

/// The mechanism of a flat design with these meshes. Throws SpecError.
template <class S>
MechanismT<S> mechanism_of(const FlatDesign<S>& design, const MaterialT<S>& material,
                           const EndEffectorT<S>& payload, const std::vector<ElasticPlan>& plans);

/// Adds the elastic bodies to a mechanism whose bodies stand.
template <class S>
void add_elastic_bodies(const FlatDesign<S>& design, const MaterialT<S>& material,
                        const std::vector<ElasticPlan>& plans, MechanismT<S>& mechanism);

}  // namespace flexopt
