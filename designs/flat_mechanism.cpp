#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

#include "core/math/dual.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/mechanism/fold_corner.hpp"
#include "core/spec/names.hpp"
#include "designs/flat_design.hpp"

namespace flexopt {
namespace {

/// The reference is the smallest value, so that a profile's factors are 1 and more.
template <class S>
void set_size(const FlatSize<S>& from, S& reference, std::vector<S>& profile) {
  reference = *std::ranges::min_element(
      from.values, [](const S& a, const S& b) { return value_of(a) < value_of(b); });
  if (from.values.size() > 1)
    for (const S& value : from.values) profile.push_back(value / reference);
}

/// The second leg of a leaf whose first one stands: both lie across the width, along the fold.
template <class S>
void add_fold(LeafSpringT<S>& leaf, const FlatLeaf<S>& from) {
  using std::atan2;
  const std::string at = from.source.pointer + "/fold/at";
  const Vector3<S> line = from.tip_at - *from.fold;
  const S first = leaf.length, second = line.norm();
  if (!(value_of(second) > 0)) throw SpecError(at, "0 m", "fold and tip stand in one place");
  const S along = leaf.axes.col(0).dot(line), across = leaf.axes.col(1).dot(line),
          above = leaf.axes.col(2).dot(line);
  const double angle = std::atan2(value_of(above), value_of(along));
  if (std::abs(value_of(across)) > 1e-6 * value_of(second))
    throw SpecError(from.source.pointer + "/across", "a vector that is not along the fold",
                    "both legs stand at right angles to the fold line: across is normal to base -> "
                    "fold and to fold -> tip");
  constexpr double degrees = 180 / std::numbers::pi;
  if (std::abs(angle) > largest_fold)
    throw SpecError(
        at, fmt::format("{:.1f} deg", 180 - std::abs(angle) * degrees),
        fmt::format("the legs open by at least {:g} deg", 180 - largest_fold * degrees));
  leaf.length = first + second;
  leaf.fold =
      LeafFoldT<S>{first / leaf.length, S(atan2(above, along)), from.fold_radius / leaf.length};
  // ends of a width and a thickness have one value
  const double reach = corner_reach(angle, value_of(from.fold_radius),
                                    value_of(from.thickness.values.front())),
               shorter = std::min(value_of(first), value_of(second));
  if (!(2 * reach < shorter))
    throw SpecError(
        from.source.pointer + (from.fold_radius == 0.0 ? "/fold" : "/fold/radius"),
        fmt::format("a corner that takes {:.4g} m of a leg of {:.4g} m", reach, shorter),
        "(radius + thickness/2) tan(turn/2) is less than half of each leg");
}

template <class S>
LeafSpringT<S> leaf_spring_of(const FlatLeaf<S>& from, const MaterialT<S>& material) {
  LeafSpringT<S> leaf;
  leaf.name = from.name;
  leaf.base = from.base;
  leaf.tip = from.tip;
  leaf.origin = from.base_at;
  const Vector3<S> line = from.fold.value_or(from.tip_at) - from.base_at;
  leaf.length = line.norm();
  if (!(value_of(leaf.length) > 0))
    throw SpecError(
        from.source.pointer + (from.fold ? "/fold/at" : "/tip/at"), "0 m",
        from.fold ? "base and fold stand in one place" : "base and tip stand in one place");
  leaf.axes.col(0) = line / leaf.length;
  if (from.curve) {
    leaf.curve = -*from.curve;  // the normal of the core's axes is (base → tip) × across
    leaf.length = leaf.length / sine_ratio<S>(0.5 * *leaf.curve);
  }
  Vector3<S> across = from.across;
  const S along = leaf.axes.col(0).dot(across);
  // a share that is zero here may not be so elsewhere; of plain numbers not even a zero's sign
  // changes
  if (!std::is_same_v<S, double> || value_of(along) != 0) across -= leaf.axes.col(0) * along;
  const S length = across.norm();
  if (!(value_of(length) > 1e-9 * value_of(from.across.norm()) && value_of(length) > 0))
    throw SpecError(from.source.pointer + "/across", "a vector along the leaf",
                    "the width lies across the line from base to tip");
  leaf.axes.col(1) = across / length;
  leaf.axes.col(2) = Vector3<S>(leaf.axes.col(0)).cross(Vector3<S>(leaf.axes.col(1)));
  if (from.fold) add_fold(leaf, from);
  set_size(from.width, leaf.width, leaf.width_profile);
  set_size(from.thickness, leaf.thickness, leaf.thickness_profile);
  leaf.material =
      from.material ? with_numbers<S>(*from.material, [](double x) { return S(x); }) : material;
  if (from.wire) leaf.section = Section::circular;
  leaf.may_cross = from.may_cross;
  return leaf;
}

/// Ties a material point to its leaf.
template <class S>
void put_on_leaf(MechanismT<S>& mechanism, const FlatBody<S>& body, int index) {
  const auto leaf = std::ranges::find(mechanism.leaves, body.leaf, &LeafSpringT<S>::name);
  if (leaf == mechanism.leaves.end())
    throw SpecError(body.source.pointer + "/on/leaf", "\"" + body.leaf + "\"",
                    "there is no such leaf; " + known_names(body.leaf, names_in(mechanism.leaves)));
  if (leaf->point)
    throw SpecError(body.source.pointer + "/on/leaf", "\"" + body.leaf + "\"",
                    "a leaf has one material point at most");
  if (leaf->fold)
    throw SpecError(body.source.pointer + "/on/leaf", "\"" + body.leaf + "\"",
                    "a folded leaf has no material point that is a body");
  const Vector3<S> place = leaf->coordinates(body.at);
  const S along = place[0] / leaf->length, across = place[1] / leaf->width + 0.5, off = place[2];
  if (std::abs(value_of(off)) > 1e-6 * value_of(leaf->length))
    throw SpecError(body.source.pointer + "/on/at", fmt::format("{:g} m off", value_of(off)),
                    "a material point lies in the middle surface of its leaf");
  LeafPointT<S> point;
  point.body = index;
  point.along = along;
  point.across = across;
  if (leaf->tip == free_edge && std::abs(value_of(along) - 1) < 1e-9 &&
      std::abs(value_of(across) - 0.5) < 1e-9) {
    point.spread_over_tip = true;
    point.along = S(1);
    point.across = S(0.5);
  }
  leaf->point = point;
}

/// What the file says of the end-effector, with what the job mounts on it.
template <class S>
void add_payload(RigidBodyT<S>& body, bool has_mass, const EndEffectorT<S>& payload) {
  const Vector3<S> at = body.reference + payload.center_of_mass;
  if (!has_mass) {
    body.mass = payload.mass;
    body.center_of_mass = at;
    body.inertia = payload.inertia;
    return;
  }
  const S mass = body.mass + payload.mass;
  const Vector3<S> own = body.center_of_mass;
  const Vector3<S> middle =
      value_of(mass) > 0 ? Vector3<S>((own * body.mass + at * payload.mass) / mass) : own;
  Matrix3<S> inertia = body.inertia + payload.inertia;
  for (const auto& [m, place] : {std::pair<S, Vector3<S>>(body.mass, own), {payload.mass, at}}) {
    const Vector3<S> arm = place - middle;
    const S square = arm.squaredNorm();
    for (int i = 0; i < 3; ++i) {
      inertia(i, i) += m * square;
      for (int j = 0; j < 3; ++j) inertia(i, j) -= m * arm[i] * arm[j];
    }
  }
  body.mass = mass;
  body.center_of_mass = middle;
  body.inertia = inertia;
}

/// Held directions that are no coordinates. Of one rotation alone the component of the rotation
/// vector is held; the spins about an axis do not add up to a rotation about it.
template <class S>
void add_held(MechanismT<S>& mechanism, const FlatBody<S>& from, int index) {
  RigidBodyT<S>& body = mechanism.bodies[static_cast<std::size_t>(index)];
  std::vector<FlatHeld<S>> held = from.held_along;
  std::ptrdiff_t rotations = std::ranges::count(held, JointType::held_rotation, &FlatHeld<S>::type);
  for (std::size_t d = 3; d < 6; ++d) rotations += body.held[d];
  for (std::size_t d = 3; rotations == 1 && d < 6; ++d)
    if (std::exchange(body.held[d], false)) {
      const Vector3d axis = Vector3d::Unit(static_cast<Eigen::Index>(d) - 3);
      held.push_back({JointType::held_rotation, axis.cast<S>()});
    }
  for (const FlatHeld<S>& direction : held)
    mechanism.joints.push_back({.name = from.name + " (held)",
                                .type = direction.type,
                                .body = index,
                                .other = ground,
                                .place = from.at,
                                .axis = direction.axis});
}

/// Puts a piezo stack between the bodies of its drive: a body without mass slides along the axis on
/// `other`, as far as the drive says, and a spring along the axis ties the body to it.
template <class S>
void add_piezo(MechanismT<S>& mechanism, const FlatDrive<S>& from, DriveT<S>& drive) {
  const std::string name = drive.name.empty() ? "piezo" : "piezo " + drive.name;
  if (std::ranges::find(mechanism.bodies, name, &RigidBodyT<S>::name) != mechanism.bodies.end())
    throw SpecError(from.source.pointer + "/piezo", "\"" + name + "\"",
                    "the end of the stack is a body of this name, which another one has");
  if (drive.body == drive.other) return;  // against itself: refused as any such drive
  const int stack = static_cast<int>(mechanism.bodies.size());
  const Vector3<S> axis = drive.axes.col(index(drive.direction));
  RigidBodyT<S> end;
  end.name = name;
  end.role = BodyRole::intermediate;
  end.reference = end.center_of_mass = from.piezo_at;
  end.inertia = Matrix3<S>::Zero();
  mechanism.bodies.push_back(std::move(end));
  mechanism.joints.push_back({.name = name,
                              .type = JointType::prismatic,
                              .body = stack,
                              .other = drive.other,
                              .place = from.piezo_at,
                              .axis = axis});
  SpringT<S> spring{.name = name, .body = drive.body, .other = stack, .place = from.piezo_at};
  Matrix6<S>& matrix = spring.matrix.emplace(Matrix6<S>::Zero());
  const S stiffness = drive.piezo->stiffness();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) matrix(i, j) = stiffness * axis[i] * axis[j];
  spring.other_place = spring.place;
  mechanism.springs.push_back(std::move(spring));
  drive.body = stack;
}

}  // namespace

template <class S>
MechanismT<S> mechanism_of(const FlatDesign<S>& design, const MaterialT<S>& material,
                           const EndEffectorT<S>& payload, const std::vector<ElasticPlan>& plans) {
  MechanismT<S> mechanism;
  mechanism.end_effector = design.end_effector;
  FaultList faults;
  const auto attempt = [&](const ItemSource& source, const auto& action) {
    faults.attempt([&] {
      try {
        action();
      } catch (const SpecError& error) {
        throw located(source, error);
      }
    });
  };
  for (std::size_t i = 0; i < design.bodies.size(); ++i) {
    const FlatBody<S>& from = design.bodies[i];
    RigidBodyT<S> body;
    body.name = from.name;
    body.reference = from.at;
    body.mass = from.mass;
    body.center_of_mass = from.at + from.center_of_mass;
    body.inertia = from.inertia;
    body.held = from.held;
    if (from.box_half_edges) body.box = BodyBoxT<S>{body.center_of_mass, *from.box_half_edges};
    const bool is_end_effector = static_cast<int>(i) == design.end_effector;
    body.role = is_end_effector ? BodyRole::end_effector : BodyRole::intermediate;
    if (is_end_effector && from.leaf.empty()) add_payload(body, from.has_mass, payload);
    mechanism.bodies.push_back(std::move(body));
  }
  add_elastic_bodies(design, material, plans, mechanism);
  for (const FlatLeaf<S>& from : design.leaves)
    attempt(from.source, [&] { mechanism.leaves.push_back(leaf_spring_of(from, material)); });
  faults.raise();
  for (std::size_t i = 0; i < design.bodies.size(); ++i)
    if (!design.bodies[i].leaf.empty())
      attempt(design.bodies[i].source,
              [&] { put_on_leaf(mechanism, design.bodies[i], static_cast<int>(i)); });
  mechanism.joints.assign(design.joints.begin(), design.joints.end());
  for (std::size_t i = 0; i < design.bodies.size(); ++i)
    add_held(mechanism, design.bodies[i], static_cast<int>(i));
  mechanism.springs.assign(design.springs.begin(), design.springs.end());
  mechanism.drives.assign(design.drives.begin(), design.drives.end());
  for (std::size_t k = 0; k < design.drives.size(); ++k)
    if (mechanism.drives[k].piezo)
      attempt(design.drives[k].source,
              [&] { add_piezo(mechanism, design.drives[k], mechanism.drives[k]); });
  faults.raise();
  return mechanism;
}

template MechanismT<double> mechanism_of(const FlatDesign<double>&, const Material&,
                                         const EndEffector&, const std::vector<ElasticPlan>&);
template MechanismT<Dual1> mechanism_of(const FlatDesign<Dual1>&, const MaterialT<Dual1>&,
                                        const EndEffectorT<Dual1>&,
                                        const std::vector<ElasticPlan>&);

}  // namespace flexopt
