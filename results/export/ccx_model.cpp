#include "results/export/ccx_model.hpp"

#include <cmath>

#include "core/math/decompositions.hpp"
#include "core/mechanism/joint.hpp"

namespace flexopt {

CcxModel::CcxModel(const Exported& exported, const SolidMeshSize& size) : exported_(&exported) {
  check_carried_by_ccx(exported);
  add_bodies();
  add_leaves(size);
  add_ties();
  std::erase_if(masses_, [](const CcxMass& m) { return m.mass == 0; });
}

int CcxModel::add(const Vector3d& place) {
  nodes_.push_back(place);
  return static_cast<int>(nodes_.size());
}

int CcxModel::add_on(int body, const Vector3d& place) {
  const int node = add(place);
  const int rigid = body < 0 ? -1 : rigid_of_[static_cast<std::size_t>(body)];
  (rigid < 0 ? fixed_ : rigids_[static_cast<std::size_t>(rigid)].nodes).push_back(node);
  return node;
}

void CcxModel::add_bodies() {
  const Mechanism& m = mechanism();
  const std::vector<int> group = rigid_groups(m);
  // a body that is driven along a line lends its reference point to those it is tied to
  std::vector<int> shown(m.bodies.size());
  for (std::size_t b = 0; b < shown.size(); ++b) shown[b] = static_cast<int>(b);
  for (const Drive& drive : m.drives)
    if (const int g = group[static_cast<std::size_t>(drive.body)];
        g >= 0 && !is_rotation(drive.direction))
      shown[static_cast<std::size_t>(g)] = drive.body;
  std::vector<int> made(m.bodies.size(), -1);
  rigid_of_.assign(m.bodies.size(), -1);
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const int g = group[b];
    if (g == ground) continue;
    int& rigid = made[static_cast<std::size_t>(g)];
    if (rigid < 0) {
      const int body = shown[static_cast<std::size_t>(g)];
      const RigidBody& own = m.bodies[static_cast<std::size_t>(body)];
      rigid = static_cast<int>(rigids_.size());
      rigids_.push_back({own.name, body, add(own.reference), add(own.reference), {}});
    }
    rigid_of_[b] = rigid;
  }
  at_O_ = add_on(m.end_effector, m.bodies[static_cast<std::size_t>(m.end_effector)].reference);
  for (std::size_t b = 0; b < m.bodies.size(); ++b) add_masses(static_cast<int>(b));
}

/// Pairs of point masses on the principal axes, as far out as the inertia wants.
void CcxModel::add_masses(int body) {
  const RigidBody& own = mechanism().bodies[static_cast<std::size_t>(body)];
  if (own.mass <= 0) return;
  const Vector3d center = own.center_of_mass;
  const SymmetricEigen principal(own.inertia);
  const double half_trace = 0.5 * principal.eigenvalues().sum();
  std::vector<int> axes;
  for (int k = 0; k < 3; ++k)
    if (half_trace - principal.eigenvalues()[k] > 1e-12 * half_trace) axes.push_back(k);
  if (axes.empty()) {
    masses_.push_back({add_on(body, center), own.mass});
    return;
  }
  const double share = own.mass / static_cast<double>(axes.size());
  for (const int k : axes) {
    const double arm = std::sqrt((half_trace - principal.eigenvalues()[k]) / share);  // Σ m x²
    for (const double side : {1.0, -1.0})
      masses_.push_back(
          {add_on(body, center + side * arm * principal.eigenvectors().col(k)), 0.5 * share});
  }
}

void CcxModel::add_leaves(const SolidMeshSize& size) {
  const Mechanism& m = mechanism();
  for (std::size_t i = 0; i < m.leaves.size(); ++i) {
    const SolidMesh mesh = solid_mesh(m.leaves[i], size);
    const int first = static_cast<int>(nodes_.size()) + 1;
    for (const Vector3d& place : mesh.nodes) add(place);
    ranges_.emplace_back(first, static_cast<int>(nodes_.size()));
    elements_.push_back(mesh.elements);
    for (auto& element : elements_.back())
      for (int& node : element) node += first;
    for (int end = 0; end < 2; ++end) {
      std::vector<int> edge = mesh.edges[static_cast<std::size_t>(end)];
      for (int& node : edge) node += first;
      clamp(i, end, edge);
    }
  }
}

void CcxModel::clamp(std::size_t leaf, int end, const std::vector<int>& nodes) {
  const LeafSpring& own = mechanism().leaves[leaf];
  const auto& errors = exported_->request.loads.assembly;
  placed_edges_.resize(errors.size(), -1);
  for (std::size_t k = 0; k < errors.size(); ++k)
    if (errors[k].leaf == static_cast<int>(leaf) && errors[k].end == end) {
      const Vector3d middle = end == 0 ? own.origin : own.tip_middle();
      placed_edges_[k] = static_cast<int>(rigids_.size());
      rigids_.push_back({"edge of " + own.name, ground, add(middle), add(middle), nodes});
      return;
    }
  const int body = end == 0 ? own.base : own.tip;
  if (body == free_edge) return;
  const int rigid = body == ground ? -1 : rigid_of_[static_cast<std::size_t>(body)];
  auto& to = rigid < 0 ? fixed_ : rigids_[static_cast<std::size_t>(rigid)].nodes;
  to.insert(to.end(), nodes.begin(), nodes.end());
}

int CcxModel::rotation_of(int body) const {
  const CcxRigid* rigid = body < 0 ? nullptr : rigid_of(body);
  return rigid ? rigid->rotation : 0;
}

/// A pin lets two bodies turn about it, two pins let them turn about their line.
void CcxModel::add_joint(const Joint& joint) {
  if (rotation_of(joint.body) == rotation_of(joint.other)) return;  // rigid to each other
  const auto pin_at = [&](const Vector3d& place) {
    pins_.push_back({add_on(joint.body, place), add_on(joint.other, place), &joint});
  };
  if (joint.type == JointType::spherical) pin_at(joint.place);
  if (joint.type != JointType::revolute) return;
  double apart = 0;  // no matter how far
  for (const LeafSpring& leaf : mechanism().leaves) apart = std::max(apart, leaf.length);
  for (const double side : {-0.5, 0.5}) pin_at(joint.place + side * apart * joint.axis);
}

void CcxModel::add_bushing(const Spring& spring) {
  const int own = rotation_of(spring.body), other = rotation_of(spring.other);
  if (own == other) return;
  const auto node = [&](int body) {
    return rotation_of(body) == 0 ? 0 : add_on(body, spring.place);
  };
  CcxBushing made{node(spring.body), own, node(spring.other), other, &spring};
  if (own == 0) {  // the energy does not change when both change places
    std::swap(made.node, made.other);
    std::swap(made.rotation, made.other_rotation);
  }
  bushings_.push_back(made);
}

void CcxModel::add_ties() {
  const Mechanism& m = mechanism();
  for (const Spring& spring : m.springs)
    if (spring.matrix)
      add_bushing(spring);
    else
      springs_.push_back(
          {add_on(spring.body, spring.place), add_on(spring.other, spring.other_place), &spring});
  for (const Joint& joint : m.joints) add_joint(joint);
  for (const Drive& drive : m.drives) {
    const int turned = drive.other == ground ? 0 : rotation_of(drive.other);
    const Vector3d& place = m.bodies[static_cast<std::size_t>(drive.body)].reference;
    drive_nodes_.push_back(
        turned == 0 || is_rotation(drive.direction) ? turned : add_on(drive.other, place));
  }
  const LoadCase& loads = exported_->request.loads;
  for (const auto* list : {&loads.constant, &loads.growing})
    for (const DeadLoad& load : *list) {
      const int body = load.body.value_or(m.end_effector);
      const Vector3d reference = m.bodies[static_cast<std::size_t>(body)].reference;
      load_nodes_.push_back(add_on(body, load.place.value_or(reference + load.arm)));
    }
}

const CcxRigid* CcxModel::rigid_of(int body) const {
  const int rigid = rigid_of_[static_cast<std::size_t>(body)];
  return rigid < 0 ? nullptr : &rigids_[static_cast<std::size_t>(rigid)];
}

std::pair<int, int> CcxModel::freedom(int body, Direction direction) const {
  const CcxRigid& rigid = *rigid_of(body);
  return {is_rotation(direction) ? rigid.rotation : rigid.reference, index(direction) % 3 + 1};
}

}  // namespace flexopt
