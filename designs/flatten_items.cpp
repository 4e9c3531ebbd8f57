// Bodies, joints, springs and drives of a design file, in global axes.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/math/dual.hpp"
#include "core/mechanism/body_inertia.hpp"
#include "designs/flattener.hpp"

namespace flexopt {

// A unit vector stays as it is to the last bit; its derivatives are those of its direction.
template <class S>
Vector3<S> Flattener<S>::unit(const Vector3<S>& v, const std::string& pointer) const {
  S length = v.norm();
  if (!(value_of(length) > 0)) throw SpecError(pointer, "0", "an axis has a direction");
  if (const double off = value_of(length) - 1; std::abs(off) < 1e-15) length -= S(off);
  return v / length;
}

template <class S>
void Flattener<S>::add_held(const HeldDirection& held, const std::string& pointer,
                            const Placement<S>& at, FlatBody<S>& body) const {
  if (!held.direction) {
    body.held_along.push_back(
        {held.rotation ? JointType::held_rotation : JointType::held_displacement,
         unit(at.direction(vector(held.along)),
              pointer + held.key + (held.rotation ? "/rotation" : "/displacement"))});
    return;
  }
  const bool rotation = is_rotation(*held.direction);
  const int axis = index(*held.direction) % 3;
  for (int i = 0; at.fixed && i < 3; ++i)
    if (std::abs(std::abs(value_of(at.axes(i, axis))) - 1) < 1e-12) {
      body.held[static_cast<std::size_t>(i + (rotation ? 3 : 0))] = true;
      return;
    }
  body.held_along.push_back({rotation ? JointType::held_rotation : JointType::held_displacement,
                             unit(at.axes.col(axis), pointer + held.key)});
}

template <class S>
void Flattener<S>::add_rigid(const BodyItem& item, const Placement<S>& at,
                             FlatBody<S>& body) const {
  for (const HeldDirection& held : item.held) add_held(held, item.pointer, at, body);
  body.has_mass = item.mass || item.density || !item.inertia.empty();
  body.center_of_mass = at.direction(vector(item.center_of_mass));
  if (item.mass) body.mass = number(*item.mass);
  Matrix3<S> inertia = inertia_of(item);
  if (item.box.size() == 9) {
    Matrix3<S>& half = body.box_half_edges.emplace();
    for (int i = 0; i < 3; ++i) {
      Vector3<S> edge;
      for (int k = 0; k < 3; ++k) edge[k] = number(item.box[static_cast<std::size_t>(3 * i + k)]);
      half.col(i) = at.direction(edge) * S(0.5);
    }
  }
  if (item.box.size() == 3) {
    std::array<S, 3> l;
    for (std::size_t i = 0; i < 3; ++i)
      l[i] = positive(item.box[i], item.pointer + "/box", "the lengths of a box");
    Matrix3<S>& half = body.box_half_edges.emplace();
    for (int i = 0; i < 3; ++i) {
      Vector3<S> edge = Vector3<S>::Zero();
      edge[i] = l[static_cast<std::size_t>(i)];
      half.col(i) = at.direction(edge) * S(0.5);
    }
    if (item.density) {
      body.mass = number(*item.density) * l[0] * l[1] * l[2];
      for (int i = 0; i < 3; ++i) {
        const S &a = l[static_cast<std::size_t>((i + 1) % 3)],
                &b = l[static_cast<std::size_t>((i + 2) % 3)];
        inertia(i, i) = body.mass * (a * a + b * b) / 12.0;
      }
    }
  }
  body.inertia = at.tensor(inertia);
}

template <class S>
void Flattener<S>::add_body(const BodyItem& item) {
  const std::string name = instance_name(item, item.name);
  if (bodies_.contains(name)) {
    if (scope_.joined.contains(name)) return check_joined(item, bodies_.at(name));
    throw SpecError(item.pointer + "/name", "\"" + name + "\"", "another body has this name");
  }
  const Placement<S> at = frame(item.frame, item);
  FlatBody<S> body;
  body.name = scope_.prefix + name;
  body.source = source_of(item);
  body.at = at.place(vector(item.at));
  if (!item.leaf.empty()) {
    body.leaf = scope_.prefix + instance_name(item, item.leaf);
    body.held = {false, false, false, true, true, true};
  } else {
    add_rigid(item, at, body);
  }
  NamedBody& entry = bodies_[name];
  entry.body = item.elastic && !item.elastic->has_frame() && !is_rigid(*item.elastic)
                   ? no_body
                   : static_cast<int>(out_.bodies.size());
  if (scope_.prefix.empty() && name == "end_effector") out_.end_effector = entry.body;
  if (entry.body != no_body) out_.bodies.push_back(std::move(body));
  check_mass(item);
  if (item.elastic) add_elastic(item, at, entry);
}

// The body of the file around it stands for it, and has nothing of it.
template <class S>
void Flattener<S>::check_joined(const BodyItem& item, const NamedBody& to) const {
  FaultList lost;
  const auto loses = [&](const std::string& key) {
    lost.add(item.pointer + key, "\"" + instance_name(item, item.name) + "\"",
             fmt::format("the body that it is joined to stands for it, without its {0}: give {0} "
                         "to that one, or join another body of the part",
                         key.substr(1)));
  };
  const auto has = [&](const std::optional<DesignNumber>& n) {
    return n && value_of(number(*n)) != 0;
  };
  if (item.elastic) loses("/elastic");
  if (!item.leaf.empty()) loses("/on");
  if (to.body != ground) {  // where a mass does nothing
    if (has(item.mass)) loses("/mass");
    if (has(item.density)) loses("/density");
    const Matrix3d inertia = inertia_of(item).unaryExpr([](const S& x) { return value_of(x); });
    if (!inertia.isZero(0)) loses("/inertia");
  }
  lost.raise();
}

template <class S>
Matrix3<S> Flattener<S>::inertia_of(const BodyItem& item) const {
  Matrix3<S> inertia = Matrix3<S>::Zero();
  const auto entry = [&](int i) { return number(item.inertia[static_cast<std::size_t>(i)]); };
  if (item.inertia.size() == 3)
    for (int i = 0; i < 3; ++i) inertia(i, i) = entry(i);
  if (item.inertia.size() == 9)
    for (int i = 0; i < 9; ++i) inertia(i / 3, i % 3) = entry(i);
  return inertia;
}

// Checks the mass of a body. The body exists already, so that items which refer to it are not
// reported as well.
template <class S>
void Flattener<S>::check_mass(const BodyItem& item) const {
  if (item.mass) not_negative(*item.mass, item.pointer + "/mass", "a mass");
  if (item.density) not_negative(*item.density, item.pointer + "/density", "a density");
  const Matrix3d inertia = inertia_of(item).unaryExpr([](const S& x) { return value_of(x); });
  if (const auto fault = inertia_fault(inertia); fault && !fault->of_sum)  // that is a note
    throw SpecError(item.pointer + "/inertia" + fault->place, fault->value, fault->rule);
}

template <class S>
void Flattener<S>::add_joint(const JointItem& item) {
  const Placement<S> at = frame(item.frame, item);
  FlatJoint<S> joint;
  joint.name = scope_.prefix + instance_name(item, item.name);
  if (std::ranges::find(out_.joints, joint.name, &FlatJoint<S>::name) != out_.joints.end())
    throw SpecError(item.pointer + "/name", "\"" + joint.name + "\"",
                    "another joint has this name");
  joint.source = source_of(item);
  joint.type = item.type;
  joint.body = body(item, item.body, "/body");
  joint.other = body(item, item.other, "/other");
  joint.place = at.place(vector(item.at));
  if (item.type == JointType::revolute || item.type == JointType::prismatic) {
    joint.axis = unit(at.direction(vector(item.axis)), item.pointer + "/axis");
  }
  out_.joints.push_back(std::move(joint));
}

template <class S>
void Flattener<S>::add_spring(const SpringItem& item) {
  const Placement<S> at = frame(item.frame, item);
  FlatSpring<S> spring;
  spring.source = source_of(item);
  spring.name = scope_.prefix + instance_name(item, item.name);
  spring.body = body(item, item.body, "/body");
  spring.other = body(item, item.other, "/other");
  spring.place = at.place(vector(item.at));
  spring.other_place = spring.place;
  if (item.matrix.empty()) {
    spring.other_place = at.place(vector(item.other_at));
    spring.stiffness = number(item.stiffness);
    if (!(value_of(spring.stiffness) >= 0))
      throw SpecError(item.pointer + "/stiffness", fmt::format("{:g}", value_of(spring.stiffness)),
                      "a stiffness is not negative");
    if (value_of(S(Vector3<S>(spring.other_place - spring.place).norm())) == 0)
      throw SpecError(item.pointer + "/other_at", "\"" + spring.name + "\"",
                      "the two ends of a spring do not coincide");
    for (const auto& [length, force] : item.line)
      spring.line.push_back({number(length), number(force)});
    spring.free_length = item.free_length ? number(*item.free_length)
                                          : S(Vector3<S>(spring.other_place - spring.place).norm());
  } else {
    Matrix6<S> matrix, turn = Matrix6<S>::Zero();
    for (int i = 0; i < 36; ++i)
      matrix(i / 6, i % 6) = number(item.matrix[static_cast<std::size_t>(i)]);
    turn.template topLeftCorner<3, 3>() = at.axes;
    turn.template bottomRightCorner<3, 3>() = at.mirrored ? Matrix3<S>(-at.axes) : at.axes;
    if (!at.plain) {
      const Matrix6<S> left = turn.lazyProduct(matrix);
      matrix = left.lazyProduct(turn.transpose());
    }
    spring.matrix = matrix;
  }
  out_.springs.push_back(std::move(spring));
}

template <class S>
void Flattener<S>::add_drive(const DriveItem& item) {
  const Placement<S> at = frame(item.frame, item);
  FlatDrive<S> drive;
  drive.name = item.name;
  drive.source = source_of(item);
  drive.body = body(item, item.body, "/body");
  drive.other = body(item, item.other, "/other");
  drive.direction = item.direction;
  drive.axes = at.axes;
  if (item.voice_coil)
    drive.voice_coil = {positive(item.voice_coil->motor_constant,
                                 item.pointer + "/voice_coil/motor_constant", "a motor constant"),
                        positive(item.voice_coil->resistance,
                                 item.pointer + "/voice_coil/resistance", "a resistance")};
  if (item.piezo) {
    if (drive.body == ground)
      throw SpecError(item.pointer + "/body", "\"ground\"", "a stack pushes a body that moves");
    drive.piezo = {
        positive(item.piezo->free_stroke, item.pointer + "/piezo/free_stroke", "a free stroke"),
        positive(item.piezo->blocking_force, item.pointer + "/piezo/blocking_force",
                 "a blocking force")};
    drive.piezo_at = item.piezo->at ? at.place(vector(*item.piezo->at))
                                    : out_.bodies[static_cast<std::size_t>(drive.body)].at;
  }
  out_.drives.push_back(std::move(drive));
}

template Vector3d Flattener<double>::unit(const Vector3d&, const std::string&) const;
template Vector3<Dual1> Flattener<Dual1>::unit(const Vector3<Dual1>&, const std::string&) const;
template void Flattener<double>::add_body(const BodyItem&);
template void Flattener<Dual1>::add_body(const BodyItem&);
template void Flattener<double>::add_joint(const JointItem&);
template void Flattener<Dual1>::add_joint(const JointItem&);
template void Flattener<double>::add_spring(const SpringItem&);
template void Flattener<Dual1>::add_spring(const SpringItem&);
template void Flattener<double>::add_drive(const DriveItem&);
template void Flattener<Dual1>::add_drive(const DriveItem&);

}  // namespace flexopt
