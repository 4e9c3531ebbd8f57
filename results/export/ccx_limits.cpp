#include <limits>

#include "core/math/rotation.hpp"
#include "core/mechanism/joint.hpp"
#include "core/spec/spec_error.hpp"
#include "results/export/ccx_model.hpp"

namespace flexopt {

namespace {

class Refusals {
 public:
  void add(const std::string& item, const std::string& reason) {
    faults_.push_back({"--format", "ccx", item + " is not carried by a deck: " + reason});
  }
  void raise() {
    if (!faults_.empty()) throw SpecError(std::move(faults_));
  }

 private:
  std::vector<Fault> faults_;
};

std::string body_name(const Mechanism& mechanism, int body) {
  return body < 0 ? "the ground" : mechanism.bodies[body].name;
}

std::string drive_name(const Drive& drive) {
  return drive.name.empty() ? "the drive" : "drive " + drive.name;
}

int group_of(const std::vector<int>& groups, int body) { return body < 0 ? ground : groups[body]; }

/// A slide is written as equations of the degrees of freedom that it holds.
bool holds_besides(const Mechanism& mechanism, const Joint& slide, int group) {
  const std::vector<int> groups = rigid_groups(mechanism);
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b)
    if (groups[b] == group &&
        std::ranges::find(mechanism.bodies[b].held, true) != mechanism.bodies[b].held.end())
      return true;
  for (const Joint& joint : mechanism.joints)
    if (&joint != &slide && group_of(groups, joint.body) == group &&
        (is_held(joint.type) || joint.type == JointType::prismatic))
      return true;
  for (const Drive& drive : mechanism.drives) {
    const Vector3d axis = drive.axes.col(index(drive.direction) % 3);
    const bool along = !is_rotation(drive.direction) && axis.cwiseAbs().maxCoeff() > 1 - 1e-12 &&
                       axis.cross(slide.axis).norm() < 1e-12;
    if (group_of(groups, drive.body) == group && !along) return true;
  }
  return false;
}

void check_joints(const Mechanism& mechanism, Refusals& refusals) {
  const std::vector<int> groups = rigid_groups(mechanism);
  for (const Joint& joint : mechanism.joints) {
    if (joint.type != JointType::prismatic) continue;
    const int a = group_of(groups, joint.body), b = group_of(groups, joint.other);
    if (a != ground && b != ground)
      refusals.add("joint " + joint.name, "its axis turns with a body that moves");
    else if (a != b && holds_besides(mechanism, joint, a == ground ? b : a))
      refusals.add("joint " + joint.name,
                   "its body is held or driven otherwise, too, than along an axis of the job");
  }
}

void check_drives(const Mechanism& mechanism, Refusals& refusals) {
  const std::vector<int> group = rigid_groups(mechanism);
  std::vector<int> shown(mechanism.bodies.size(), -1);  // body whose place is the node of its group
  for (const Drive& drive : mechanism.drives) {
    const std::string name = drive_name(drive);
    const int of = group[drive.body];
    if (of == ground) refusals.add(name, "its body is tied to the ground");
    if (is_rotation(drive.direction) || of == ground) continue;
    int& body = shown[of];
    if (body >= 0 && body != drive.body)
      refusals.add(name, "bodies " + body_name(mechanism, body) + " and " +
                             body_name(mechanism, drive.body) +
                             ", one by a rigid joint, are driven at two places");
    body = drive.body;
  }
}

void check_loads(const Exported& of, Refusals& refusals) {
  const LoadCase& loads = of.request.loads;
  if (!loads.mounting.empty())
    refusals.add("assembly in steps", "the deck puts all loads on at once, its drives held");
  for (const double strain : loads.body_expansion)
    if (strain != 0) {
      refusals.add("the temperature of bodies", "rigid bodies of CalculiX do not expand");
      break;
    }
  for (std::size_t k = 0; k < loads.elastic_expansion.size(); ++k)
    if (loads.elastic_expansion[k] != 0)
      refusals.add("the temperature of elastic body " + of.mechanism.elastic_bodies[k].name,
                   "the frames that hold its faces are rigid bodies, which do not expand");
  for (const AssemblyError& error : loads.assembly) {
    const LeafSpring& leaf = of.mechanism.leaves[error.leaf];
    if ((error.end == 0 ? leaf.base : leaf.tip) != ground)
      refusals.add(fmt::format("the assembly error of leaf {}", leaf.name),
                   "a body that moves holds this edge");
  }
}

constexpr double far_turned = 0.01;  ///< [rad], or so much of a stiffness: a hundredth
constexpr double far_tilted = 0.05;  ///< [rad]: moments within a hundredth

class Near {
 public:
  Near(const Exported& exported, const PathPoint& point)
      : mechanism_(&exported.mechanism), point_(&point), loads_(&exported.request.loads) {}

  void check(Refusals& refusals) const {
    for (std::size_t k = 0; k < mechanism_->drives.size(); ++k)
      if (const Drive& drive = mechanism_->drives[k]; drive.other == ground)
        check_tilt(drive, refusals);
      else if (!is_near(drive, k))
        refusals.add(drive_name(drive), why_far(drive, k));
    for (const Spring& spring : mechanism_->springs)
      if (spring.matrix && !is_near(spring))
        refusals.add("bushing " + spring.name, "body " + body_name(*mechanism_, spring.body) +
                                                   turned(spring.body) +
                                                   ", and its axes with that");
    for (const auto* list : {&loads_->constant, &loads_->growing})
      for (const DeadLoad& load : *list) check(load, refusals);
  }

 private:
  Vector3d rotation(int body) const {
    return body < 0 ? Vector3d(Vector3d::Zero()) : point_->bodies[body].rotation;
  }
  std::string turned(int body) const {
    return fmt::format(", which turns by {:.3g} rad", rotation(body).norm());
  }

  /// A force along an axis that turns with a body has another moment than one whose axis stays: of
  /// the distance of both places times that turn.
  double load_times_distance(const Drive& drive, std::size_t number) const {
    const auto place = [&](int body) {
      return Vector3d(mechanism_->bodies[body].reference + point_->bodies[body].displacement);
    };
    return std::abs(point_->drive_loads[number]) * (place(drive.body) - place(drive.other)).norm();
  }
  double least_turning_stiffness() const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t d = 3; d < 6; ++d)
      least = std::min(least, point_->support_stiffness[d].value_or(least));
    return least;
  }
  bool is_near(const Drive& drive, std::size_t number) const {
    if (!is_rotation(drive.direction))
      return rotation(drive.other).norm() < far_turned &&
             load_times_distance(drive, number) < 0.1 * far_turned * least_turning_stiffness();
    const Vector3d axis = drive.axes.col(index(drive.direction) % 3);  // all turn about it
    return rotation(drive.other).cross(axis).norm() < 0.1 * far_turned &&
           rotation(drive.body).cross(axis).norm() < 0.1 * far_turned;
  }
  /// The stroke of a body that turns about the axis alone is a component of its rotation vector.
  void check_tilt(const Drive& drive, Refusals& refusals) const {
    const Vector3d axis = drive.axes.col(index(drive.direction) % 3);
    const double tilt = rotation(drive.body).cross(axis).norm();
    if (is_rotation(drive.direction) && tilt > far_tilted)
      refusals.add(drive_name(drive),
                   fmt::format("it turns body {}, which is tilted by {:.2g} rad besides",
                               body_name(*mechanism_, drive.body), tilt));
  }
  std::string why_far(const Drive& drive, std::size_t number) const {
    std::string reason = "its axis turns with body " + body_name(*mechanism_, drive.other) +
                         fmt::format(" (here {:.2g} rad)", rotation(drive.other).norm());
    if (!is_rotation(drive.direction))
      reason += fmt::format(
          ", and its load with that: load times distance is {:.2g} N m, the least stiffness "
          "against turning {:.2g} N m/rad",
          load_times_distance(drive, number), least_turning_stiffness());
    return reason;
  }

  /// Whether the matrix is the same in axes that have turned half-way with both bodies, and their
  /// rotation vectors may be subtracted.
  bool is_near(const Spring& bushing) const {
    const Vector3d a = rotation(bushing.body), b = rotation(bushing.other);
    const double length = longest_leaf(*mechanism_);
    Matrix6d K = *bushing.matrix;  // [N/m] throughout
    K.bottomRows<3>() /= length;
    K.rightCols<3>() /= length;
    Matrix6d Q = Matrix6d::Zero();
    Q.topLeftCorner<3, 3>() = Q.bottomRightCorner<3, 3>() = rotation_exp(0.5 * (a + b));
    return (Q * K * Q.transpose() - K).norm() < far_turned * K.norm() &&
           a.cross(b).norm() <= far_turned * (a - b).norm();
  }

  /// For the end-effector, the rotation under small loads is known.
  void check(const DeadLoad& load, Refusals& refusals) const {
    if (load.follows) refusals.add("load " + load.name, "it turns with its body");
    const int body = load.body.value_or(mechanism_->end_effector);
    const std::vector<int> groups = rigid_groups(*mechanism_);
    const int group = group_of(groups, body);
    if (group == ground || group == group_of(groups, mechanism_->end_effector)) return;
    if (rotation(body).cross(load.moment).norm() > 0.1 * far_turned * load.moment.norm())
      refusals.add("the moment of load " + load.name,
                   "body " + body_name(*mechanism_, body) + turned(body) + ", not about its axis");
  }

  const Mechanism* mechanism_;
  const PathPoint* point_;
  const LoadCase* loads_;
};

}  // namespace

void check_carried_by_ccx(const Exported& exported) {
  const Mechanism& mechanism = exported.mechanism;
  Refusals refusals;
  for (const LeafSpring& leaf : mechanism.leaves)
    if (leaf.point)
      refusals.add("body " + body_name(mechanism, leaf.point->body),
                   "it is a material point of leaf " + leaf.name);
  for (const ElasticBody& body : mechanism.elastic_bodies)
    if (!body.cells)
      refusals.add("elastic body " + body.name,
                   "it is matrices of another program, which have no mesh");
  check_joints(mechanism, refusals);
  check_drives(mechanism, refusals);
  check_loads(exported, refusals);
  refusals.raise();
}

void check_near_in_ccx(const Exported& exported, const PathPoint& point) {
  Refusals refusals;
  Near(exported, point).check(refusals);
  refusals.raise();
}

}  // namespace flexopt
