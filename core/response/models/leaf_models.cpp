#include "core/response/models/leaf_models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>

#include "core/elements/plate/full_leaf.hpp"
#include "core/equilibrium/free_motions.hpp"
#include "core/equilibrium/system.hpp"
#include "core/math/decompositions.hpp"
#include "core/mechanism/joint.hpp"
#include "core/reduction/atlas/tube_atlas.hpp"
#include "core/reduction/superelement/leaf_chain.hpp"
#include "core/reduction/superelement/modal_leaf.hpp"
#include "core/reduction/superelement/superelement_leaf.hpp"
#include "core/reduction/superelement/superelement_rule.hpp"
#include "core/reduction/tube/tube_leaf.hpp"

namespace flexopt {

namespace {

// Shapes and meshes of leaves, shared by those that are equal.
class Meshes {
 public:
  // Shape of the first of all leaves that are alike.
  const PlateShape& shape(const LeafSpring& leaf, const ModelOptions& model) {
    return entry(leaf, model).shape;
  }
  const std::shared_ptr<const PlateMesh>& mesh(const LeafSpring& leaf, const ModelOptions& model) {
    Entry& of = entry(leaf, model);
    if (!of.mesh) of.mesh = std::make_shared<PlateMesh>(of.shape);
    return of.mesh;
  }

 private:
  struct Entry {
    PlateShape shape;
    std::shared_ptr<const PlateMesh> mesh;
  };
  Entry& entry(const LeafSpring& leaf, const ModelOptions& model) {
    PlateShape shape = leaf_shape(leaf, model);
    for (Entry& known : entries_)
      if (alike(known.shape, shape)) return known;
    return entries_.emplace_back(Entry{std::move(shape), nullptr});
  }
  std::deque<Entry> entries_;  // they stay where they are
};

// The leaves as their elements see them: edges on bodies that rigid joints tie to the ground are
// grounded.
std::vector<LeafSpring> leaves_of(const Mechanism& mechanism) {
  std::vector<LeafSpring> leaves = mechanism.leaves;
  if (mechanism.joints.empty()) return leaves;
  const std::vector<int> group = rigid_groups(mechanism);
  for (LeafSpring& leaf : leaves)
    for (int* body : {&leaf.base, &leaf.tip})
      if (*body >= 0 && group[*body] == ground) *body = ground;
  return leaves;
}

std::vector<std::unique_ptr<LeafElement>> full_leaves(const std::vector<LeafSpring>& springs,
                                                      const ModelOptions& model, Meshes& meshes,
                                                      const std::string& reason = {}) {
  std::vector<std::unique_ptr<LeafElement>> leaves;
  std::vector<FullLeaf*> first;  // of each kind
  for (int i = 0; i < static_cast<int>(springs.size()); ++i) {
    auto leaf = std::make_unique<FullLeaf>(springs[i], meshes.mesh(springs[i], model), i, reason);
    if (std::none_of(first.begin(), first.end(), [&](FullLeaf* f) { return leaf->start_as(*f); }))
      first.push_back(leaf.get());
    leaves.push_back(std::move(leaf));
  }
  return leaves;
}

constexpr double margin = 1.12;  ///< of the range of a tube over what its leaf is expected to do

// Model from the look-up table, if there is a table that covers such leaves; else null.
std::shared_ptr<TubeModel> known_tube(const PlateShape& shape, TubeRange range,
                                      const ModelOptions& model, int nodes = 0,
                                      ShapeSlopes slopes = ShapeSlopes::all) {
  if (!model.atlas) return nullptr;
  // an atlas that ends within the margin will do: a tube grows where it has to
  if (const double last = model.atlas->settings().sigmas.back(); range.sigma_max <= margin * last)
    range.sigma_max = std::min(range.sigma_max, last);
  if (!model.atlas->covers(shape, range)) return nullptr;
  if (nodes == 0) nodes = model.atlas->nodes_to(range.sigma_max);
  const TubeAtlas::Tube tube = model.atlas->look_up(shape, range.ray, nodes);
  KnownTube known{tube.directions, tube.nodes, {}, TubeAtlas::view(range.ray), {}};
  if (model.atlas->settings().dynamics) {
    known.dynamics = [atlas = model.atlas, shape, ray = range.ray](double sigma,
                                                                   StationsWanted stations) {
      return atlas->dynamics(shape, ray, sigma, stations);
    };
    known.dynamics_rates = [atlas = model.atlas, shape, ray = range.ray, slopes](double sigma) {
      return atlas->dynamics_rates(shape, ray, sigma, slopes);
    };
  }
  if (const auto stress = model.atlas->stress()) {
    known.stress_patterns = stress->patterns();
    known.stress = [atlas = model.atlas, shape, ray = range.ray](double sigma) {
      return atlas->look_up_stress(shape, ray, atlas->nodes_to(sigma));
    };
    known.stress_rates = [atlas = model.atlas, shape, ray = range.ray, slopes] {
      return atlas->stress_rates(shape, ray, slopes);
    };
  }
  known.rates = [atlas = model.atlas, shape, ray = range.ray, nodes, slopes] {
    return atlas->look_up_rates(shape, ray, nodes, slopes);
  };
  return std::make_shared<TubeModel>(shape, range, std::move(known));
}

// Leaves for linear statics at rest: full leaves, or tubes where the look-up table has them.
std::vector<std::unique_ptr<LeafElement>> leaves_at_rest(const std::vector<LeafSpring>& springs,
                                                         const ModelOptions& model,
                                                         Meshes& meshes) {
  if (!model.atlas) return full_leaves(springs, model, meshes);
  std::vector<std::unique_ptr<LeafElement>> leaves;
  std::map<PlateShape, std::shared_ptr<TubeModel>> tubes;
  for (int i = 0; i < static_cast<int>(springs.size()); ++i) {
    const LeafSpring& leaf = springs[i];
    const PlateShape& shape = meshes.shape(leaf, model);
    auto [tube, unknown] = tubes.try_emplace(shape);
    if (unknown) tube->second = known_tube(shape, {.sigma_max = 0}, model, 2);
    if (tube->second && !leaf.point && leaf.tip != free_edge && leaf.growth == 1 &&
        leaf.clamp_growth == std::array<double, 2>{1, 1})
      leaves.push_back(std::make_unique<TubeLeaf>(leaf, tube->second, i));
    else
      leaves.push_back(std::make_unique<FullLeaf>(leaf, meshes.mesh(leaf, model), i));
  }
  return leaves;
}

bool is_uniform_plate(const PlateShape& shape) {
  return !shape.is_beam() && !shape.curve && !shape.fold && !shape.has_profile();
}

struct LinearMotion {
  Eigen::Vector2d bending = Eigen::Vector2d::Zero();  ///< (θ1y, θ2y) for a unit stroke
  double axial = 0;  ///< N under the dead load, drive held; over D/L
};

// How the edges of each leaf are moved and turned in their bodies by so much of the loads.
std::vector<Vector12d> forced_increments(const Mechanism& mechanism, const LoadCase& loads,
                                         double share) {
  std::vector<Vector12d> increments(mechanism.leaves.size(), Vector12d::Zero());
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i) {
    const LeafSpring& leaf = mechanism.leaves[i];
    increments[i].segment<3>(6) = share * (1 - leaf.growth) * leaf.span();
    for (int e = 0; e < 2; ++e)
      increments[i].segment<3>(6 * e) += share * growth_move(mechanism, static_cast<int>(i), e);
  }
  for (const AssemblyError& error : loads.assembly)
    increments[error.leaf].segment<6>(6 * error.end) +=
        share * (Vector6d() << error.move_in(mechanism), error.turn_in(mechanism)).finished();
  return increments;
}

// Linear statics of the undeflected mechanism, leaf by leaf: for the strokes beside the load or,
// where nothing is driven, for the load. Of several strokes those that bend the leaf most.
std::vector<LinearMotion> linear_motion(const Mechanism& mechanism, const ModelOptions& model,
                                        const LoadCase& loads, LoadFactors factors,
                                        const std::vector<VectorXd>& strokes, Meshes& meshes) {
  System system(mechanism, leaves_at_rest(leaves_of(mechanism), model, meshes));
  system.assemble();
  // at a dead point of the conditions nothing is known; the solver then says so
  const auto answer = [&](bool drives_held, const MatrixXd& forces) -> MatrixXd {
    const MatrixXd found = FreeMotions(system, drives_held).answer(forces);
    return found.allFinite() ? found : MatrixXd::Zero(found.rows(), found.cols());
  };
  const bool driven = loads.driven();
  VectorXd P = forces_at_rest(loads, factors, mechanism) - preload_forces(mechanism) -
               elastic_forces(mechanism, action_of(loads, factors));
  // edges that are brought to where their bodies hold them push these the other way
  const std::vector<Vector12d> forced = forced_increments(mechanism, loads, factors.constant);
  for (int i = 0; i < system.leaves(); ++i) {
    if (forced[i].isZero(0)) continue;
    const Vector12d force = system.leaf(i).evaluation().tangent * forced[i];
    const std::array<int, 2> body{mechanism.leaves[i].base, mechanism.leaves[i].tip};
    for (int e = 0; e < 2; ++e)
      if (body[e] >= 0)
        P.segment<6>(6 * body[e]) -= system.edge_map(i, e).transpose() * force.segment<6>(6 * e);
  }
  for (const int k : system.held()) P[k] = 0;
  const MatrixXd forces = driven ? system.drive_forces() : MatrixXd(P);
  MatrixXd drive = MatrixXd::Zero(system.size(), forces.cols());
  if (forces.cols() > 0) drive = answer(false, forces);
  if (driven && forces.cols() > 0)
    drive = (drive * Lu(MatrixXd(system.drive_forces().transpose() * drive)).inverse()).eval();
  const VectorXd loaded = answer(true, P);

  std::vector<LinearMotion> motion(system.leaves());
  for (int i = 0; i < system.leaves(); ++i) {
    const LeafSpring& l = mechanism.leaves[i];
    if (l.fold) continue;  // never reduced
    const LeafScale scale(l, flexure_of(l, model));
    EdgePoses edges{scale.scaled(system.edge_pose(i, 0)), scale.scaled(system.edge_pose(i, 1))};
    for (int e = 0; e < 2; ++e)  // as those of a flat leaf on the chord
      edges[e].axes = (edges[e].axes * l.middle(e).axes().transpose()).eval();
    const ChordFrame frame = chord_frame(edges, l.chord() / l.length);
    const auto bending = [&](const VectorXd& q) -> Eigen::Vector2d {
      const Vector6d e = frame.B * scale.scaled_increment(system.edge_increment(i, q));
      return {e[theta1y], e[theta2y]};
    };
    if (!driven) motion[i].bending = bending(drive.col(0));
    if (driven && drive.cols() > 0)
      for (const VectorXd& stroke : strokes)
        if (const Eigen::Vector2d b = bending(drive * stroke);
            b.cwiseAbs().maxCoeff() > motion[i].bending.cwiseAbs().maxCoeff())
          motion[i].bending = b;
    const Vector12d force =
        system.leaf(i).evaluation().tangent * (system.edge_increment(i, loaded) + forced[i]);
    motion[i].axial = l.axes.col(0).dot(force.segment<3>(6)) * scale.length / scale.energy;
  }
  return motion;
}

std::vector<std::unique_ptr<LeafElement>> linear_leaves(const std::vector<LeafSpring>& springs,
                                                        const ModelOptions& model,
                                                        const LoadCase& loads, Meshes& meshes) {
  std::vector<std::unique_ptr<LeafElement>> leaves;
  std::vector<std::shared_ptr<const SuperelementGrid>> grids;  // shared by equal leaves
  for (int i = 0; i < static_cast<int>(springs.size()); ++i) {
    const LeafSpring& leaf = springs[i];
    Check kept = check_rules(leaf, model);
    if (kept) kept = is_reducible(leaf, loads);
    if (!kept) {
      leaves.push_back(std::make_unique<FullLeaf>(leaf, meshes.mesh(leaf, model), i, kept.error()));
      continue;
    }
    std::shared_ptr<const SuperelementGrid> grid;
    for (const auto& g : grids)
      if (g->fits(leaf, model)) grid = g;
    if (!grid) grids.push_back(grid = std::make_shared<SuperelementGrid>(leaf, model));
    leaves.push_back(std::make_unique<SuperelementLeaf>(leaf, grid, i));
  }
  return leaves;
}

std::vector<std::unique_ptr<LeafElement>> modal_leaves(const std::vector<LeafSpring>& springs,
                                                       const ModelOptions& model,
                                                       const LoadCase& loads, Meshes& meshes) {
  std::vector<std::unique_ptr<LeafElement>> leaves;
  std::map<PlateShape, std::shared_ptr<const ModalModel>> models;  // shared by equal segments
  const int n = model.superelements[0];
  const ModelOptions own = segment_options(model);
  for (int i = 0; i < static_cast<int>(springs.size()); ++i) {
    const LeafSpring& leaf = springs[i];
    const bool held = !leaf.point && leaf.tip != free_edge;
    Check kept = check_rules(leaf, model);
    if (kept) kept = is_reducible(leaf, loads);
    if (kept && !held) kept = Because("it has no two rigid edges");
    if (!kept) {
      leaves.push_back(std::make_unique<FullLeaf>(leaf, meshes.mesh(leaf, model), i, kept.error()));
      continue;
    }
    const auto mesh = meshes.mesh(n == 1 ? leaf : leaf_segment(leaf, 0, n), own);
    auto& modal = models[mesh->shape()];
    if (!modal) modal = std::make_shared<ModalModel>(mesh, model.method, model.modal_derivatives);
    if (n == 1) {
      leaves.push_back(std::make_unique<ModalLeaf>(leaf, modal, i));
      continue;
    }
    std::vector<std::unique_ptr<LeafElement>> segments;
    for (int k = 0; k < n; ++k)
      segments.push_back(std::make_unique<ModalLeaf>(leaf_segment(leaf, k, n), modal, i));
    leaves.push_back(
        std::make_unique<LeafChain>(leaf, std::move(segments), leaf_shape(leaf, model), i));
  }
  return leaves;
}

// Shares of the buckling load, between held edges, that a dead load gives a leaf: from the first on
// its potential is expanded about the load; where it is looked up it is not, up to the second, and
// the tests of belief decide.
constexpr double slight_load = 0.01, largest_looked_up_load = 0.1;

// States that a leaf bends to by its linear motion, of which the strokes make so much more where it
// is driven.
TubeRange tube_range(const LeafSpring& leaf, const ModelOptions& model, const LinearMotion& motion,
                     bool driven, double growth, Meshes& meshes) {
  const PlateShape& shape = meshes.shape(leaf, model);
  TubeRange range;
  range.order = model.degree == 7 ? 3 : 2;
  Eigen::Vector2d b = motion.bending;
  const double size = b.cwiseAbs().maxCoeff();
  if (size > 1e-9) {
    if (b[0] < 0) b = -b;  // the tube is mirrored
    range.ray = b / size;
    for (int k = 0; k < 2; ++k)  // rounding must not tell equal leaves apart
      range.ray[k] = std::round(range.ray[k] * 1e9) * 1e-9;
  }
  // linear kinematics overrates a large load; the tube grows where it does not
  range.sigma_max = driven ? margin * size * growth : std::min(0.5, margin * size);
  if (driven && motion.axial != 0) {
    const double stiffness = model.atlas && is_uniform_plate(shape)
                                 ? shape.width
                                 : meshes.mesh(leaf, model)->bending_stiffness();
    const double buckling = 4 * std::numbers::pi * std::numbers::pi * stiffness,
                 share = std::abs(motion.axial) / buckling;
    range.loaded = share > slight_load;
    if (share > (model.atlas && is_uniform_plate(shape) ? largest_looked_up_load : slight_load))
      range.force_centre = motion.axial / tube_force_scale(shape)[0];
  }
  return range;
}

// The nearest of the rays in steps for which leaves are looked up: between two steps of its ray a
// design changes by its shape and place alone, whose derivatives are exact. A state is as well
// known next to a ray as on it.
TubeRange on_ray_in_steps(TubeRange range) {
  constexpr double step = 0.01;  // the rays of the atlas are multiples of it
  for (int k = 0; k < 2; ++k) range.ray[k] = std::round(range.ray[k] / step) * step;
  return range;
}

}  // namespace

ModelOptions segment_options(const ModelOptions& model) {
  ModelOptions own = model;
  const int n = model.superelements[0];
  if (n == 1) return own;
  own.mesh[0] = own_elements(model.mesh[0], n);
  own.warping = Warping::free;
  return own;
}

std::vector<std::unique_ptr<LeafElement>> make_full_leaves(const Mechanism& mechanism,
                                                           const ModelOptions& model,
                                                           const std::string& reason) {
  Meshes meshes;
  return full_leaves(leaves_of(mechanism), model, meshes, reason);
}

std::vector<std::unique_ptr<LeafElement>> make_reduced_leaves(const Mechanism& mechanism,
                                                              const ModelOptions& model,
                                                              double largest, const LoadCase& loads,
                                                              const std::vector<VectorXd>& several,
                                                              bool poissons_ratio_moves) {
  Meshes meshes;
  const std::vector<LeafSpring> springs = leaves_of(mechanism);
  if (model.method == Reduction::linear_craig_bampton)
    return linear_leaves(springs, model, loads, meshes);
  if (model.method == Reduction::modal_derivatives || model.method == Reduction::quadratic_manifold)
    return modal_leaves(springs, model, loads, meshes);
  const bool driven = loads.driven();
  const std::vector<VectorXd> one{VectorXd::Ones(mechanism.drives.size())};
  const std::vector<LinearMotion> motion =
      linear_motion(mechanism, model, loads, loads.mounted(driven ? 0 : largest),
                    several.empty() ? one : several, meshes);
  std::vector<std::unique_ptr<LeafElement>> leaves;
  std::vector<std::shared_ptr<TubeModel>> models;
  std::map<const PlateMesh*, std::shared_ptr<PlatePool>> pools;
  for (int i = 0; i < static_cast<int>(springs.size()); ++i) {
    const LeafSpring& leaf = springs[i];
    const auto full = [&](const std::string& reason) {
      leaves.push_back(std::make_unique<FullLeaf>(leaf, meshes.mesh(leaf, model), i, reason));
    };
    if (leaf.point || leaf.fold) {
      full(leaf.fold ? "it is folded" : "it has no two rigid edges");
      continue;
    }
    if (const Check reducible = is_reducible(leaf, loads); !reducible) {
      full(reducible.error());
      continue;
    }
    const PlateShape& shape = meshes.shape(leaf, model);
    const TubeRange range =
        tube_range(leaf, model, motion[i], driven, several.empty() ? largest : 1, meshes);
    const auto made = [&](const TubeRange& wanted) -> std::shared_ptr<TubeModel> {
      for (const auto& m : models)
        if (m->shape() == shape && m->range().loaded == wanted.loaded &&
            (m->range().ray - wanted.ray).norm() < 1e-6 &&
            std::abs(m->range().sigma_max - wanted.sigma_max) < 1e-6 &&
            std::abs(m->range().force_centre - wanted.force_centre) < 1e-6)
          return m;
      return nullptr;
    };
    const TubeRange in_steps = model.atlas ? on_ray_in_steps(range) : range;
    std::shared_ptr<TubeModel> tube = made(in_steps);
    if (!tube) tube = made(range);
    if (!tube) {
      tube = known_tube(shape, in_steps, model, 0,
                        poissons_ratio_moves ? ShapeSlopes::all : ShapeSlopes::sizes);
      if (!tube) {
        const auto mesh = meshes.mesh(leaf, model);
        auto& pool = pools[mesh.get()];
        if (!pool) pool = std::make_shared<PlatePool>(mesh);
        tube = std::make_shared<TubeModel>(mesh, range, pool);
      }
      models.push_back(tube);
    }
    if (tube->built())
      leaves.push_back(std::make_unique<TubeLeaf>(leaf, tube, i));
    else
      full("no bent states were found");
  }
  return leaves;
}

}  // namespace flexopt
