#include <map>
#include <tuple>

#include "core/math/rotation.hpp"
#include "core/mechanism/profile.hpp"
#include "core/response/quantities.hpp"
#include "results/export/ccx_model.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

void write_nodes(const CcxModel& model, CcxLines& deck) {
  deck.line("*NODE, NSET=NALL");
  int number = 0;
  for (const Vector3d& p : model.nodes)
    deck.line("{}, {:.12g}, {:.12g}, {:.12g}", ++number, p[0], p[1], p[2]);
}

/// Sets of solid elements and their materials: leaves, then elastic bodies.
struct SolidSet {
  std::string name;
  const Material* material;
};
std::vector<SolidSet> solid_sets(const Mechanism& mechanism) {
  std::vector<SolidSet> sets;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    sets.push_back({fmt::format("LEAF{}", i + 1), &mechanism.leaves[i].material});
  for (std::size_t k = 0; k < mechanism.elastic_bodies.size(); ++k)
    sets.push_back({fmt::format("ELASTIC{}", k + 1), &mechanism.elastic_bodies[k].material});
  return sets;
}

/// Writes leaves and elastic bodies; returns the number of elements so far.
int write_solids(const CcxModel& model, CcxLines& deck) {
  const std::vector<LeafSpring>& leaves = model.mechanism.leaves;
  int number = 0;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    deck.line("** leaf {}: {}", i + 1, one_line(leaves[i].name));
    deck.line("*ELEMENT, TYPE=C3D20R, ELSET=LEAF{}", i + 1);
    for (const auto& element : model.elements[i]) {
      deck.line("{}, {},", ++number, fmt::join(element.begin(), element.begin() + 15, ", "));
      deck.line("{}", fmt::join(element.begin() + 15, element.end(), ", "));
    }
  }
  number = write_cells(model, number, deck);
  std::map<std::tuple<double, double, double, double>, int> materials;
  for (const auto& [name, material] : solid_sets(model.mechanism)) {
    const Material& m = *material;
    const double expansion = m.thermal_expansion.value_or(0);
    const auto [at, is_new] =
        materials.insert({{m.youngs_modulus, m.poissons_ratio, m.density, expansion},
                          static_cast<int>(materials.size()) + 1});
    if (is_new) {
      deck.line("*MATERIAL, NAME=MATERIAL{}", at->second);
      deck.line("*ELASTIC\n{:.12g}, {:.12g}", m.youngs_modulus, m.poissons_ratio);
      if (m.density > 0) deck.line("*DENSITY\n{:.12g}", m.density);
      if (expansion != 0) deck.line("*EXPANSION, ZERO=0.\n{:.12g}", expansion);
    }
    deck.line("*SOLID SECTION, ELSET={}, MATERIAL=MATERIAL{}", name, at->second);
  }
  return number;
}

constexpr int quarters = 4;  ///< parts of a stroke that are followed, each in one step or more

/// The node and the degree of freedom that each stroke prescribes.
struct Handle {
  int node = 0, dof = 0;
};

class Writer {
 public:
  /// `path`: points evenly on the way to the strokes, these last.
  Writer(const CcxModel& model, const SolidMeshSize& size, const VectorXd& strokes,
         const std::vector<PathPoint>& path)
      : model_(&model),
        mechanism_(&model.mechanism),
        size_(size),
        strokes_(strokes),
        point_(&path.back()),
        sub_steps_(std::ranges::max(path, {}, &PathPoint::sub_steps).sub_steps) {}

  std::string text() && {
    write_head();
    write_nodes(*model_, deck_);
    write_ties(*model_, write_solids(*model_, deck_), deck_);
    write_rigids();
    write_holds();
    write_handles();
    write_watched();
    if (loads().acts_before_stroke()) write_load_step();
    write_stroke_step();
    write_support_steps();
    write_frequency_step();
    return std::move(deck_).text();
  }

 private:
  const LoadCase& loads() const { return model_->exported.request.loads; }

  void write_head() {
    const Exported& exported = model_->exported;
    deck_.line("** {}: flexopt {} wrote this deck. Units: m, kg, s, N, Pa, K.",
               one_line(exported.name), version());
    deck_.line(
        "** Leaves and elastic bodies of isotropic quadratic solids, else rigid. Run: ccx DECK");
    deck_.line(
        "** {} x {} x {} solids along, across and through a leaf, of a fold each leg: leaves are",
        size_.along, size_.across, size_.through);
    deck_.line("** up to {:.2g} % stiffer than in a finer mesh along them.",
               100 * solid_excess(*mechanism_, size_));
    deck_.line("** Lines that begin with **FLEXOPT are for compare_ccx.py DECK.inp.");
    deck_.line("**FLEXOPT stroke {}", exported.stroke_text(strokes_));
  }

  void write_rigids() {
    deck_.line("*NSET, NSET=GROUND");
    deck_.numbers(model_->fixed);
    int number = 0;
    for (const CcxRigid& rigid : model_->rigids) {
      ++number;
      deck_.line("** {}: node {} displaces, node {} has the rotation vector", one_line(rigid.name),
                 rigid.reference, rigid.rotation);
      if (rigid.nodes.empty()) continue;
      deck_.line("*NSET, NSET=BODY{}", number);
      deck_.numbers(rigid.nodes);
      deck_.line("*RIGID BODY, NSET=BODY{}, REF NODE={}, ROT NODE={}", number, rigid.reference,
                 rigid.rotation);
    }
  }

  void write_holds() {
    if (!model_->fixed.empty()) deck_.line("*BOUNDARY\nGROUND, 1, 3, 0.");
    for (std::size_t b = 0; b < mechanism_->bodies.size(); ++b)
      for (int d = 0; d < 6; ++d)
        if (mechanism_->bodies[b].held[d] && model_->rigid_of(static_cast<int>(b))) {
          const auto [node, dof] = model_->freedom(static_cast<int>(b), static_cast<Direction>(d));
          deck_.line("*BOUNDARY\n{}, {}, {}, 0.", node, dof, dof);
        }
    for (const Joint& joint : mechanism_->joints) {
      const CcxRigid* rigid = is_held(joint.type) ? model_->rigid_of(joint.body) : nullptr;
      if (!rigid) continue;
      const bool turn = joint.type == JointType::held_rotation;
      write_equation(terms_along(turn ? rigid->rotation : rigid->reference, joint.axis), deck_);
    }
    write_slides(*model_, deck_);
  }

  /// A stroke along no global axis, or one that a body sees which moves itself, is the first
  /// displacement of a node of its own.
  void write_handles() {
    int own = static_cast<int>(model_->nodes.size());
    if (!loads().driven()) return;
    for (std::size_t k = 0; k < mechanism_->drives.size(); ++k) {
      const Drive& drive = mechanism_->drives[k];
      const auto [node, dof] = model_->freedom(drive.body, drive.direction);
      const int seen_from = model_->drive_nodes[k];
      const Vector3d axis = drive.axes.col(index(drive.direction) % 3);
      int along = 0;
      axis.cwiseAbs().maxCoeff(&along);
      if (seen_from == 0 && axis[along] > 1 - 1e-12) {
        handles_.push_back({node, along + 1});
        continue;
      }
      ++own;
      deck_.line("*NODE, NSET=NALL\n{}, 0., 0., 0.", own);
      std::vector<CcxTerm> terms = terms_along(node, axis);
      if (seen_from > 0)
        for (const CcxTerm& term : terms_along(seen_from, -axis)) terms.push_back(term);
      terms.push_back({own, 1, -1});
      write_equation(terms, deck_);
      deck_.line("*BOUNDARY\n{}, 2, 3, 0.", own);
      handles_.push_back({own, 1});
    }
  }

  void write_watched() {
    std::vector<int> nodes{model_->at_O};
    for (const CcxRigid& rigid : model_->rigids) {
      nodes.push_back(rigid.reference);
      nodes.push_back(rigid.rotation);
    }
    for (const Handle& handle : handles_) nodes.push_back(handle.node);
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    deck_.line("*NSET, NSET=WATCHED");
    deck_.numbers(nodes);
    const CcxRigid* end_effector = model_->rigid_of(mechanism_->end_effector);
    if (end_effector)
      deck_.line("**FLEXOPT end_effector node {} rotation {}", model_->at_O,
                 end_effector->rotation);
    if (!loads().temperature.empty()) deck_.line("*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNALL, 0.");
    for (std::size_t i = 0; i < loads().temperature.size(); ++i) {
      const auto [first, last] = model_->nodes_of[i];
      deck_.line("*NSET, NSET=WARM{}, GENERATE\n{}, {}, 1", i + 1, first, last);
    }
  }

  /// Parts of a stroke, and how close Newton's method has to come.
  void begin_step(double first, const char* field) {
    ++steps_;
    deck_.line("*STEP, NLGEOM, INC=500\n*CONTROLS, PARAMETERS=FIELD\n{}", field);
    deck_.line("*STATIC\n{:.12g}, 1., 1e-6, {:.12g}", first, first);
  }
  void end_step() { deck_.line("*NODE PRINT, NSET=WATCHED, FREQUENCY=1000\nU, RF\n*END STEP"); }

  void write_prescribed(const VectorXd& strokes) {
    for (std::size_t k = 0; k < handles_.size(); ++k)
      deck_.line("*BOUNDARY\n{}, {}, {}, {:.12g}", handles_[k].node, handles_[k].dof,
                 handles_[k].dof, strokes[k]);
  }

  void write_force(int node, const Vector3d& force) {
    for (int c = 0; c < 3; ++c)
      if (force[c] != 0) deck_.line("*CLOAD\n{}, {}, {:.12g}", node, c + 1, force[c]);
  }

  /// Moments of the case on a rigid body: those before the stroke, and growing ones where it ends.
  Vector3d moment_on(const CcxRigid& rigid, bool ended) const {
    Vector3d sum = Vector3d::Zero();
    const auto add = [&](const std::vector<DeadLoad>& list, double factor) {
      for (const DeadLoad& load : list)
        if (model_->rigid_of(load.body.value_or(mechanism_->end_effector)) == &rigid)
          sum += factor * load.moment;
    };
    add(loads().constant, 1);
    if (ended) add(loads().growing, strokes_[0]);
    return sum;
  }
  /// A moment m about an axis that stays does the work of Jᵀ m on the rotation vector v: exact
  /// where the body has turned by v, which it has at the end of the stroke.
  void write_moment(const CcxRigid& rigid, const Vector3d& v, const Vector3d& moment) {
    const Vector3d work = rotation_left_tangent(v).transpose() * moment;
    for (int c = 0; c < 3; ++c)
      deck_.line("*CLOAD\n{}, {}, {:.12g}", rigid.rotation, c + 1, work[c]);
  }
  void write_moments(bool ended) {
    for (const CcxRigid& rigid : model_->rigids)
      if (const Vector3d m = moment_on(rigid, ended); rigid.body != ground && !m.isZero(0))
        write_moment(rigid, point_->bodies[rigid.body].rotation, m);
  }

  void write_load_step() {
    deck_.line("** what acts before the stroke");
    begin_step(0.25, "1e-5, 1e-4");
    write_prescribed(VectorXd::Zero(strokes_.size()));
    const LoadCase& all = loads();
    for (std::size_t k = 0; k < all.constant.size(); ++k)
      write_force(model_->load_nodes[k], all.constant[k].force);
    write_moments(false);
    if (const double g = all.gravity.norm(); g > 0) {
      for (const SolidSet& set : solid_sets(*mechanism_))
        if (set.material->density > 0)
          deck_.line("*DLOAD\n{}, GRAV, {:.12g}, {:.12g}, {:.12g}, {:.12g}", set.name, g,
                     all.gravity[0] / g, all.gravity[1] / g, all.gravity[2] / g);
      for (const CcxMass& mass : model_->masses) write_force(mass.node, mass.mass * all.gravity);
    }
    for (std::size_t i = 0; i < all.temperature.size(); ++i)
      deck_.line("*TEMPERATURE\nWARM{}, {:.12g}", i + 1, all.temperature[i]);
    for (std::size_t k = 0; k < all.assembly.size(); ++k) {
      const CcxRigid& edge = model_->rigids[model_->placed_edges[k]];
      const Vector3d move = all.assembly[k].move_in(model_->mechanism),
                     turn = all.assembly[k].turn_in(model_->mechanism);
      for (int c = 0; c < 3; ++c)
        deck_.line("*BOUNDARY\n{}, {}, {}, {:.12g}\n{}, {}, {}, {:.12g}", edge.reference, c + 1,
                   c + 1, move[c], edge.rotation, c + 1, c + 1, turn[c]);
    }
    end_step();
  }

  void write_stroke_step() {
    deck_.line(
        "** the stroke, in steps as short as flexopt takes where it turns sharply: longer ones "
        "may end on another branch");
    constexpr double shortest = 0.004;  // half of the increments that begin_step allows
    begin_step(std::max(1.0 / (quarters * sub_steps_), shortest), "1e-5, 1e-4");
    write_prescribed(strokes_);
    const LoadCase& all = loads();
    for (std::size_t k = 0; k < all.growing.size(); ++k)
      write_force(model_->load_nodes[all.constant.size() + k], strokes_[0] * all.growing[k].force);
    if (!all.growing.empty()) write_moments(true);
    end_step();
    for (int c = 0; c < 3; ++c)
      deck_.line("**FLEXOPT displacement {} step {} value {:.9g}", direction_names[c], steps_,
                 point_->displacement[c]);
    for (int c = 0; c < 3; ++c)
      deck_.line("**FLEXOPT rotation {} step {} value {:.9g}", direction_names[3 + c], steps_,
                 point_->rotation[c]);
    for (std::size_t k = 0; k < handles_.size(); ++k) {
      const Drive& drive = mechanism_->drives[k];
      const std::string_view direction = direction_names[index(drive.direction)];
      const CcxRigid* body = model_->rigid_of(drive.body);
      const Vector3d m = body ? moment_on(*body, true) : Vector3d(Vector3d::Zero());
      deck_.line(
          "**FLEXOPT drive_load {} step {} node {} dof {} less {:.9g} {:.9g} {:.9g} value {:.9g} "
          "{}",
          drive.name.empty() ? std::string(direction) : one_line(drive.name), steps_,
          handles_[k].node, handles_[k].dof, m[0], m[1], m[2], point_->drive_loads[k],
          load_unit(drive.direction));
    }
  }

  /// A load one way and the other in each direction that the mechanism supports, small beside all
  /// else: what O moves between both over the load is the compliance.
  void write_support_steps() {
    const double length = longest_leaf(*mechanism_);
    double thin = mechanism_->leaves.empty() ? 0.01 * length : 1e300;
    for (const LeafSpring& leaf : mechanism_->leaves)
      thin = std::min(thin, leaf.thickness * profile_range(leaf.thickness_profile).smallest);
    const double way = 0.005 * thin;  // so little that the stiffness stays
    const CcxRigid* body = model_->rigid_of(mechanism_->end_effector);
    if (!body) return;
    // A moment m about O does the work of Jᵀ m on the rotation vector.
    const Matrix3d J = rotation_left_tangent(point_->rotation);
    for (int d = 0; d < 6; ++d) {
      const auto stiffness = point_->support_stiffness[d];
      if (!stiffness) continue;
      const double size = *stiffness * (d < 3 ? way : way / length);
      const Vector3d unit = Vector3d::Unit(d % 3);
      for (const double sign : {1.0, -1.0}) {
        begin_step(1, "1e-6, 1e-5");
        const Vector3d force = d < 3 ? Vector3d(sign * size * unit) : Vector3d(Vector3d::Zero()),
                       moment = d < 3 ? Vector3d(Vector3d::Zero())
                                      : Vector3d(sign * size * (J.transpose() * unit));
        // Rotation that the moments which act already add.
        const Vector3d spin = sign * size * point_->compliance_locked.block<3, 1>(3, d);
        const Vector3d turned =
            point_->rotation + rotation_left_tangent_inverse(point_->rotation) * spin;
        const Vector3d acting =
            rotation_left_tangent(turned).transpose() * moment_on(*body, true) + moment;
        deck_.line("*CLOAD");
        for (int c = 0; c < 3; ++c) deck_.line("{}, {}, {:.12g}", model_->at_O, c + 1, force[c]);
        for (int c = 0; c < 3; ++c) deck_.line("{}, {}, {:.12g}", body->rotation, c + 1, acting[c]);
        end_step();
      }
      deck_.line("**FLEXOPT support_stiffness {} steps {} {} load {:.12g} value {:.9g} {}",
                 direction_names[d], steps_ - 1, steps_, size, *stiffness,
                 d < 3 ? "N/m" : "N m/rad");
    }
  }

  /// Frequencies about the state at the stroke, with the drive held.
  void write_frequency_step() {
    const std::vector<double>& found = point_->frequencies_locked;
    if (found.empty()) return;
    if (const CcxRigid* body = model_->rigid_of(mechanism_->end_effector)) {
      begin_step(1, "1e-6, 1e-5");  // without the small loads
      for (int c = 1; c <= 3; ++c) deck_.line("*CLOAD\n{}, {}, 0.", model_->at_O, c);
      write_moment(*body, point_->rotation, moment_on(*body, true));
      end_step();
    }
    deck_.line("*STEP, PERTURBATION\n*FREQUENCY\n{}\n*END STEP", found.size());
    for (std::size_t k = 0; k < found.size(); ++k)
      deck_.line("**FLEXOPT frequency {} value {:.9g} Hz", k + 1, found[k]);
  }

  const CcxModel* model_;
  const Mechanism* mechanism_;
  SolidMeshSize size_;
  VectorXd strokes_;
  const PathPoint* point_;
  int sub_steps_;  ///< most that a quarter of the stroke took
  std::vector<Handle> handles_;
  CcxLines deck_;
  int steps_ = 0;
};

}  // namespace

std::string ccx_deck(const Exported& exported, const VectorXd& strokes, const SolidMeshSize& size) {
  const CcxModel model(exported, size);
  ModelOptions full = exported.model;
  full.accuracy = Accuracy::full;
  Outputs outputs{Output::stiffness};
  if (exported.request.frequencies > 0) outputs.add(Output::frequencies_locked);
  std::vector<VectorXd> way;  // in quarters, which is as coarse as CalculiX should go
  for (int k = 1; k <= quarters; ++k) way.push_back(strokes * k / quarters);
  if (strokes.isZero(0)) way = {strokes};
  const std::vector<PathPoint> path = exported.equilibria(way, full, outputs);
  check_near_in_ccx(exported, path.back());
  return Writer(model, size, strokes, path).text();
}

}  // namespace flexopt
