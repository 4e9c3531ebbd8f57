#include "results/export/ccx_model.hpp"

#include <cmath>

#include "core/math/decompositions.hpp"
#include "core/mechanism/joint.hpp"
#include "core/mechanism/spring.hpp"

namespace flexopt {

namespace {

/// Real numbers under *SPRING have a point: what has none is taken for a degree of freedom.
class Ties {
 public:
  Ties(const CcxModel& model, int number, CcxLines& deck)
      : model_(&model), number_(number), deck_(&deck) {}

  void write() && {
    for (const CcxSpring& spring : model_->springs) write_spring(spring);
    for (const CcxPin& pin : model_->pins) write_pin(pin);
    for (const CcxBushing& bushing : model_->bushings) write_bushing(bushing);
    for (std::size_t k = 0; k < model_->masses.size(); ++k) {
      const CcxMass& mass = model_->masses[k];
      deck_->line("*ELEMENT, TYPE=MASS, ELSET=MASS{}\n{}, {}", k + 1, ++number_, mass.node);
      deck_->line("*MASS, ELSET=MASS{}\n{:.12g}", k + 1, mass.mass);
    }
  }

 private:
  struct Freedom {
    int node = 0, dof = 0;
  };

  void write_spring(const CcxSpring& tie) {
    const Spring& spring = *tie.spring;
    const int set = ++springs_;
    deck_->line("** spring {}", one_line(spring.name));
    deck_->line("*ELEMENT, TYPE=SPRINGA, ELSET=SPRING{}\n{}, {}, {}", set, ++number_, tie.node,
                tie.other);
    const double built = (spring.place - spring.other_place).norm();
    if (!spring.line.empty()) {  // the program joins points by straight lines
      constexpr int parts = 200;
      const double first = spring.line.front()[0], way = spring.line.back()[0] - first;
      deck_->line("*SPRING, NONLINEAR, ELSET=SPRING{}\n", set);
      const auto point = [&](double length) {
        deck_->line("{:#.12g}, {:#.12g}", pull_at(spring, length), length - built);
      };
      if (1e-3 * built < first) point(1e-3 * built);  // straight beyond both ends
      for (int i = 0; i <= parts; ++i) point(first + way * i / parts);
      point(first + way + 100 * built);
      return;
    }
    if (built == spring.free_length) {
      deck_->line("*SPRING, ELSET=SPRING{}\n\n{:#.12g}", set, spring.stiffness);
      return;
    }
    // force over the change of length since it was built
    deck_->line("*SPRING, NONLINEAR, ELSET=SPRING{}\n", set);
    for (const double change : {-0.999 * built, 0.0, 100 * built})
      deck_->line("{:#.12g}, {:#.12g}", spring.stiffness * (built + change - spring.free_length),
                  change);
  }

  /// ½ k (u_a − u_b)².
  void write_between(const Freedom& a, const Freedom& b, double stiffness) {
    const int set = ++ties_;
    deck_->line("*ELEMENT, TYPE=SPRING2, ELSET=TIE{}\n{}, {}, {}", set, ++number_, a.node, b.node);
    deck_->line("*SPRING, ELSET=TIE{}\n{}, {}\n{:#.12g}", set, a.dof, b.dof, stiffness);
  }
  /// ½ k u_a².
  void write_single(const Freedom& a, double stiffness) {
    const int set = ++ties_;
    deck_->line("*ELEMENT, TYPE=SPRING1, ELSET=TIE{}\n{}, {}", set, ++number_, a.node);
    deck_->line("*SPRING, ELSET=TIE{}\n{}\n{:#.12g}", set, a.dof, stiffness);
  }

  void write_pin(const CcxPin& pin) {
    double stiffest = 0;
    for (const LeafSpring& leaf : model_->mechanism.leaves)
      stiffest = std::max(stiffest,
                          leaf.material.youngs_modulus * leaf.width * leaf.thickness / leaf.length);
    for (const ElasticBody& body : model_->mechanism.elastic_bodies)
      if (model_->mechanism.leaves.empty())
        stiffest = std::max(stiffest, body.material.youngs_modulus * extent(body) / pin_stiffness);
    deck_->line("** a pin of joint {}", one_line(pin.joint->name));
    for (int c = 1; c <= 3; ++c)
      write_between({pin.node, c}, {pin.other, c}, pin_stiffness * stiffest);
  }

  void write_bushing(const CcxBushing& tie) {
    const Matrix6d& K = *tie.spring->matrix;
    std::vector<Freedom> q;
    for (const auto& [place, rotation] :
         {std::pair{tie.node, tie.rotation}, std::pair{tie.other, tie.other_rotation}})
      for (int k = 0; k < 6 && place > 0; ++k)
        q.push_back(k < 3 ? Freedom{place, k + 1} : Freedom{rotation, k - 2});
    deck_->line("** bushing {}", one_line(tie.spring->name));
    const std::size_t n = q.size();
    const double none = 1e-14 * K.cwiseAbs().maxCoeff();
    const auto S = [&](std::size_t i, std::size_t j) {
      return (i / 6 == j / 6 ? 1 : -1) *
             K(static_cast<Eigen::Index>(i % 6), static_cast<Eigen::Index>(j % 6));
    };
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0;
      for (std::size_t j = 0; j < n; ++j) {
        sum += S(i, j);
        if (j > i && std::abs(S(i, j)) > none) write_between(q[i], q[j], -S(i, j));
      }
      if (std::abs(sum) > none) write_single(q[i], sum);
    }
  }

  const CcxModel* model_;
  int number_;
  CcxLines* deck_;
  int springs_ = 0, ties_ = 0;
};

}  // namespace

CcxModel::CcxModel(const Exported& exported, const SolidMeshSize& size) : exported(exported) {
  check_carried_by_ccx(exported);
  add_bodies();
  add_leaves(size);
  add_elastic_bodies();
  add_ties();
  std::erase_if(masses, [](const CcxMass& m) { return m.mass == 0; });
}

int CcxModel::add(const Vector3d& place) {
  nodes.push_back(place);
  return static_cast<int>(nodes.size());
}

int CcxModel::add_on(int body, const Vector3d& place) {
  const int node = add(place);
  nodes_on(body).push_back(node);
  return node;
}

std::vector<int>& CcxModel::nodes_on(int body) {
  const int rigid = body < 0 ? -1 : rigid_of_[body];
  return rigid < 0 ? fixed : rigids[rigid].nodes;
}

void CcxModel::add_bodies() {
  const Mechanism& m = mechanism;
  const std::vector<int> group = rigid_groups(m);
  // a body that is driven along a line lends its reference point to those it is tied to
  std::vector<int> shown(m.bodies.size());
  for (std::size_t b = 0; b < shown.size(); ++b) shown[b] = static_cast<int>(b);
  for (const Drive& drive : m.drives)
    if (const int g = group[drive.body]; g >= 0 && !is_rotation(drive.direction))
      shown[g] = drive.body;
  std::vector<int> made(m.bodies.size(), -1);
  rigid_of_.assign(m.bodies.size(), -1);
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const int g = group[b];
    if (g == ground) continue;
    int& rigid = made[g];
    if (rigid < 0) {
      const int body = shown[g];
      const RigidBody& own = m.bodies[body];
      rigid = static_cast<int>(rigids.size());
      rigids.push_back({own.name, body, add(own.reference), add(own.reference), {}});
    }
    rigid_of_[b] = rigid;
  }
  at_O = add_on(m.end_effector, m.bodies[m.end_effector].reference);
  for (std::size_t b = 0; b < m.bodies.size(); ++b) add_masses(static_cast<int>(b));
}

/// Pairs of point masses on the principal axes, as far out as the inertia wants.
void CcxModel::add_masses(int body) {
  const RigidBody& own = mechanism.bodies[body];
  if (own.mass <= 0) return;
  const Vector3d center = own.center_of_mass;
  const SymmetricEigen principal(own.inertia);
  const double half_trace = 0.5 * principal.eigenvalues().sum();
  std::vector<int> axes;
  for (int k = 0; k < 3; ++k)
    if (half_trace - principal.eigenvalues()[k] > 1e-12 * half_trace) axes.push_back(k);
  if (axes.empty()) {
    masses.push_back({add_on(body, center), own.mass});
    return;
  }
  const double share = own.mass / static_cast<double>(axes.size());
  for (const int k : axes) {
    const double arm = std::sqrt((half_trace - principal.eigenvalues()[k]) / share);  // Σ m x²
    for (const double side : {1.0, -1.0})
      masses.push_back(
          {add_on(body, center + side * arm * principal.eigenvectors().col(k)), 0.5 * share});
  }
}

void CcxModel::add_leaves(const SolidMeshSize& size) {
  const Mechanism& m = mechanism;
  for (std::size_t i = 0; i < m.leaves.size(); ++i) {
    const SolidMesh mesh = solid_mesh(m.leaves[i], size);
    const int first = static_cast<int>(nodes.size()) + 1;
    for (const Vector3d& place : mesh.nodes) add(place);
    nodes_of.emplace_back(first, static_cast<int>(nodes.size()));
    elements.push_back(mesh.elements);
    for (auto& element : elements.back())
      for (int& node : element) node += first;
    for (int end = 0; end < 2; ++end) {
      std::vector<int> edge = mesh.edges[end];
      for (int& node : edge) node += first;
      clamp(i, end, edge);
    }
  }
}

void CcxModel::add_elastic_bodies() {
  for (const ElasticBody& body : mechanism.elastic_bodies) {
    const int before = static_cast<int>(nodes.size());
    nodes_before.push_back(before);
    for (const Vector3d& node : body.nodes) add(body.place + body.axes * node);
    for (const ElasticInterface& interface : body.interfaces)
      for (const int node : interface.patch) nodes_on(interface.body).push_back(before + node + 1);
  }
}

void CcxModel::clamp(std::size_t leaf, int end, const std::vector<int>& edge) {
  const LeafSpring& own = mechanism.leaves[leaf];
  const auto& errors = exported.request.loads.assembly;
  placed_edges.resize(errors.size(), -1);
  for (std::size_t k = 0; k < errors.size(); ++k)
    if (errors[k].leaf == static_cast<int>(leaf) && errors[k].end == end) {
      const Vector3d middle = end == 0 ? own.origin : own.tip_middle();
      placed_edges[k] = static_cast<int>(rigids.size());
      rigids.push_back({"edge of " + own.name, ground, add(middle), add(middle), edge});
      return;
    }
  const int body = end == 0 ? own.base : own.tip;
  if (body == free_edge) return;
  std::vector<int>& to = nodes_on(body);
  to.insert(to.end(), edge.begin(), edge.end());
}

int CcxModel::rotation_of(int body) const {
  const CcxRigid* rigid = body < 0 ? nullptr : rigid_of(body);
  return rigid ? rigid->rotation : 0;
}

/// A pin lets two bodies turn about it, two pins let them turn about their line.
void CcxModel::add_joint(const Joint& joint) {
  if (rotation_of(joint.body) == rotation_of(joint.other)) return;  // rigid to each other
  const auto pin_at = [&](const Vector3d& place) {
    pins.push_back({add_on(joint.body, place), add_on(joint.other, place), &joint});
  };
  if (joint.type == JointType::spherical) pin_at(joint.place);
  if (joint.type != JointType::revolute) return;
  const double apart = longest_leaf(mechanism);  // no matter how far
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
  bushings.push_back(made);
}

void CcxModel::add_ties() {
  const Mechanism& m = mechanism;
  for (const Spring& spring : m.springs)
    if (spring.matrix)
      add_bushing(spring);
    else
      springs.push_back(
          {add_on(spring.body, spring.place), add_on(spring.other, spring.other_place), &spring});
  for (const Joint& joint : m.joints) add_joint(joint);
  for (const Drive& drive : m.drives) {
    const int turned = drive.other == ground ? 0 : rotation_of(drive.other);
    const Vector3d& place = m.bodies[drive.body].reference;
    drive_nodes.push_back(turned == 0 || is_rotation(drive.direction) ? turned
                                                                      : add_on(drive.other, place));
  }
  const LoadCase& loads = exported.request.loads;
  for (const auto* list : {&loads.constant, &loads.growing})
    for (const DeadLoad& load : *list) {
      const int body = load.body.value_or(m.end_effector);
      const Vector3d reference = m.bodies[body].reference;
      load_nodes.push_back(add_on(body, load.place.value_or(reference + load.arm)));
    }
}

const CcxRigid* CcxModel::rigid_of(int body) const {
  const int rigid = rigid_of_[body];
  return rigid < 0 ? nullptr : &rigids[rigid];
}

std::pair<int, int> CcxModel::freedom(int body, Direction direction) const {
  const CcxRigid& rigid = *rigid_of(body);
  return {is_rotation(direction) ? rigid.rotation : rigid.reference, index(direction) % 3 + 1};
}

void write_ties(const CcxModel& model, int number, CcxLines& deck) {
  Ties(model, number, deck).write();
}

int write_cells(const CcxModel& model, int number, CcxLines& deck) {
  for (std::size_t k = 0; k < model.mechanism.elastic_bodies.size(); ++k) {
    const ElasticBody& body = model.mechanism.elastic_bodies[k];
    deck.line("** elastic body {}: {}", k + 1, one_line(body.name));
    for (const SolidCells::Block& block : body.cells->blocks) {
      const char* reduced = block.cell == SolidCell::hexahedron ? "R" : "";
      const auto size = static_cast<std::size_t>(nodes_of(block.cell));
      deck.line("*ELEMENT, TYPE=C3D{}{}, ELSET=ELASTIC{}", size, reduced, k + 1);
      for (std::size_t first = 0; first < block.nodes.size(); first += size) {
        std::string line = std::to_string(++number);
        for (std::size_t n = 0; n < size; ++n)  // at most 16 numbers in a line
          line += (n == 15 ? ",\n" : ", ") +
                  std::to_string(model.nodes_before[k] + block.nodes[first + n] + 1);
        deck.line("{}", line);
      }
    }
  }
  return number;
}

void write_slides(const CcxModel& model, CcxLines& deck) {
  for (const Joint& joint : model.mechanism.joints) {
    if (joint.type != JointType::prismatic) continue;
    const CcxRigid& rigid = *model.rigid_of(model.rigid_of(joint.body) ? joint.body : joint.other);
    deck.line("** joint {}\n*BOUNDARY\n{}, 1, 3, 0.", one_line(joint.name), rigid.rotation);
    int along = 0;  // the others follow: u_c = a_c / a_along u_along
    joint.axis.cwiseAbs().maxCoeff(&along);
    for (int c = 0; c < 3; ++c) {
      if (c == along) continue;
      std::vector<CcxTerm> terms{{rigid.reference, c + 1, 1}};
      if (std::abs(joint.axis[c]) > 1e-12)
        terms.push_back({rigid.reference, along + 1, -joint.axis[c] / joint.axis[along]});
      write_equation(terms, deck);
    }
  }
}

void write_equation(const std::vector<CcxTerm>& terms, CcxLines& deck) {
  std::vector<std::string> lines;
  for (const CcxTerm& term : terms)
    lines.push_back(fmt::format("{}, {}, {:.12g}", term.node, term.dof, term.factor));
  deck.line("*EQUATION\n{}\n{}", lines.size(), fmt::join(lines, ",\n"));
}

std::vector<CcxTerm> terms_along(int node, const Vector3d& axis) {
  std::array<int, 3> order{0, 1, 2};
  std::ranges::sort(order, {}, [&](int c) { return -std::abs(axis[c]); });
  std::vector<CcxTerm> terms;
  for (const int c : order)
    if (std::abs(axis[c]) > 1e-12) terms.push_back({node, c + 1, axis[c]});
  return terms;
}

}  // namespace flexopt
