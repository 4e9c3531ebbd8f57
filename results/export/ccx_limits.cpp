#include "results/export/ccx_limits.hpp"

#include <fmt/format.h>

#include "core/mechanism/joint.hpp"
#include "core/spec/spec_error.hpp"

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
  return body < 0 ? "the ground" : mechanism.bodies[static_cast<std::size_t>(body)].name;
}

void check_joints(const Mechanism& mechanism, Refusals& refusals) {
  for (const Joint& joint : mechanism.joints)
    if (!is_held(joint.type) && joint.type != JointType::rigid)
      refusals.add("joint " + joint.name,
                   "its two places would both be places of rigid bodies, which depend on others");
}

void check_drives(const Mechanism& mechanism, Refusals& refusals) {
  const std::vector<int> group = rigid_groups(mechanism);
  std::vector<int> shown(mechanism.bodies.size(), -1);  // of a group: whose place is its node
  for (const Drive& drive : mechanism.drives) {
    const std::string name = drive.name.empty() ? "the drive" : "drive " + drive.name;
    if (drive.other != ground)
      refusals.add(name, "it stands on body " + body_name(mechanism, drive.other) +
                             " and its axis turns with that");
    const int of = group[static_cast<std::size_t>(drive.body)];
    if (is_rotation(drive.direction) || of == ground) continue;
    int& body = shown[static_cast<std::size_t>(of)];
    if (body >= 0 && body != drive.body)
      refusals.add(name, "bodies " + body_name(mechanism, body) + " and " +
                             body_name(mechanism, drive.body) +
                             ", one by a rigid joint, are driven at two places");
    body = drive.body;
  }
}

void check_loads(const Exported& of, Refusals& refusals) {
  const LoadCase& loads = of.request.loads;
  for (const auto* list : {&loads.constant, &loads.growing})
    for (const DeadLoad& load : *list)
      if (!load.moment.isZero(0))
        refusals.add("the moment of load " + (load.name.empty() ? "at O" : load.name),
                     "moments of CalculiX do not keep their axis while the body turns");
  for (const double strain : loads.body_expansion)
    if (strain != 0) {
      refusals.add("the temperature of bodies", "rigid bodies of CalculiX do not expand");
      break;
    }
  for (const AssemblyError& error : loads.assembly) {
    const LeafSpring& leaf = of.mechanism.leaves[static_cast<std::size_t>(error.leaf)];
    if ((error.end == 0 ? leaf.base : leaf.tip) != ground)
      refusals.add(fmt::format("the assembly error of leaf {}", leaf.name),
                   "a body that moves holds this edge");
  }
}

}  // namespace

void check_carried_by_ccx(const Exported& exported) {
  const Mechanism& mechanism = exported.mechanism;
  Refusals refusals;
  for (const LeafSpring& leaf : mechanism.leaves)
    if (leaf.point)
      refusals.add("body " + body_name(mechanism, leaf.point->body),
                   "it is a material point of leaf " + leaf.name);
  check_joints(mechanism, refusals);
  for (const Spring& spring : mechanism.springs)
    if (spring.matrix) refusals.add("bushing " + spring.name, "CalculiX has no such element");
  check_drives(mechanism, refusals);
  check_loads(exported, refusals);
  refusals.raise();
}

}  // namespace flexopt
