#include "core/response/modes/mechanism_pencil.hpp"

#include <algorithm>
#include <utility>

#include "core/equilibrium/free_motions.hpp"
#include "core/math/decompositions.hpp"

namespace flexopt {

MatrixXd MechanismPencil::mass_times(const MatrixXd& X) const {
  MatrixXd Y = MatrixXd::Zero(size, X.cols());
  Y.topRows(bodies) = M_bodies * X.topRows(bodies);
  for (const Leaf& leaf : leaves) {
    const MatrixXd F = leaf.mass * X(leaf.coordinates, Eigen::all);
    for (std::size_t k = 0; k < leaf.coordinates.size(); ++k)
      Y.row(leaf.coordinates[k]) += F.row(k);
  }
  return Y;
}

MatrixXd MechanismPencil::motions(const System& system, const MatrixXd& phi) const {
  std::vector<MatrixXd> parts{body_motions(system, phi.topRows(bodies))};
  for (const Leaf& leaf : leaves)
    if (leaf.stations.rows() > 0)
      parts.push_back(leaf.stations * phi(leaf.coordinates, Eigen::all));
  return stacked(parts);
}

void MechanismPencil::add_shape(const System& system, const VectorXd& phi, Mode& mode) const {
  mode.body_motion = phi.head(bodies);
  for (int i = 0; i < system.leaves(); ++i) {
    const Leaf& leaf = leaves[static_cast<std::size_t>(i)];
    mode.leaf_motion.push_back(leaf.shape.rows() > 0 ? leaf.shape * phi(leaf.coordinates)
                                                     : VectorXd());
  }
}

namespace {

MechanismPencil without_leaves(const System& system) {
  MechanismPencil pencil;
  pencil.bodies = pencil.size = system.size();
  pencil.highest.resize(system.leaves());
  pencil.K_bodies = system.tangent();
  pencil.M_bodies = system.body_mass();
  return pencil;
}

// Adds the next leaf.
void add_leaf(const System& system, const LeafDynamics& leaf, bool motions,
              MechanismPencil& pencil) {
  const int i = static_cast<int>(pencil.leaves.size()),
            k = static_cast<int>(leaf.mode_frequencies.size());
  pencil.highest[i] = leaf.highest_mode;
  pencil.check = std::max(pencil.check, leaf.check);
  const LeafSpring& l = system.mechanism().leaves[i];
  const int boundary = l.point ? 15 : 12;
  MechanismPencil::Leaf part;
  part.modes = k;
  std::vector<int> kept, sides;  // coordinates of the leaf that move, edges among them
  const auto keep = [&](int row, int size, int coordinate) {
    for (int d = 0; d < size; ++d) {
      kept.push_back(row + d);
      part.coordinates.push_back(coordinate + d);
    }
  };
  for (int end = 0; end < 2; ++end)
    if (const int b = end == 0 ? l.base : l.tip; b >= 0) {
      keep(6 * end, 6, 6 * b);
      sides.push_back(end);
    }
  if (l.point) keep(12, 3, 6 * l.point->body);
  keep(boundary, k, pencil.size);
  // columns of the bodies in place of those of the edges
  const auto of_bodies = [&](MatrixXd columns) {
    for (const int a : sides)
      columns.middleCols<6>(6 * a) =
          columns.middleCols<6>(6 * a).lazyProduct(system.edge_map(i, a)).eval();
    return MatrixXd(columns(Eigen::all, kept));
  };
  part.mass = of_bodies(of_bodies(leaf.mass).transpose());
  part.stiffness = leaf.internal_stiffness;
  if (motions && leaf.stations.rows() > 0) part.stations = of_bodies(leaf.stations);
  if (leaf.shape_motion.rows() > 0) part.shape = of_bodies(leaf.shape_motion);
  pencil.leaves.push_back(std::move(part));
  pencil.size += k;
}

// Adds the modes of the elastic bodies. Without them no leaf has any either.
void add_elastic_modes(const System& system, int frequencies, MechanismPencil& pencil) {
  const ElasticBodies& elastic = system.elastic_bodies();
  for (int k = 0; k < elastic.count() && frequencies > 0; ++k) {
    const std::shared_ptr<const FixedInterfaceModes> modes = elastic.modes(k, frequencies);
    const MatrixXd coupling = held_coupling(*modes, elastic.held(k));
    MechanismPencil::Leaf part;
    part.modes = static_cast<int>(modes->count());
    std::vector<int> kept;  // rows of holders that move
    for (std::size_t a = 0; a < elastic.body(k).interfaces.size(); ++a)
      if (const int b = elastic.body(k).interfaces[a].body; b >= 0)
        for (int d = 0; d < 6; ++d) {
          kept.push_back(6 * static_cast<int>(a) + d);
          part.coordinates.push_back(6 * b + d);
        }
    for (int m = 0; m < part.modes; ++m) part.coordinates.push_back(pencil.size++);
    const auto edges = static_cast<Eigen::Index>(kept.size());
    part.mass = MatrixXd::Zero(edges + part.modes, edges + part.modes);
    part.mass.topRightCorner(edges, part.modes) = coupling(kept, Eigen::all);
    part.mass.bottomLeftCorner(part.modes, edges) = coupling(kept, Eigen::all).transpose();
    part.mass.bottomRightCorner(part.modes, part.modes) = modes->mass;
    part.stiffness = modes->stiffness;
    part.stations = MatrixXd::Zero(part.modes, edges + part.modes);
    part.stations.rightCols(part.modes) = modes->root_of_mass();
    pencil.leaves.push_back(std::move(part));
  }
}

}  // namespace

MechanismPencil mechanism_pencil(System& system, const std::vector<int>& leaf_modes,
                                 const FrequencyOptions& options) {
  MechanismPencil pencil = without_leaves(system);
  for (int i = 0; i < system.leaves(); ++i) {
    const DynamicsRequest request(leaf_modes[i], options.shapes, options.motions);
    add_leaf(system,
             options.constant_mass ? options.constant_mass->dynamics(system, i, request)
                                   : system.leaf(i).dynamics(request),
             options.motions, pencil);
  }
  add_elastic_modes(system, options.leaf_modes > 0 ? options.count : 0, pencil);
  return pencil;
}

std::optional<InternalPencil> internal_pencil(const MechanismFactor& factor) {
  InternalPencil found{without_leaves(factor.system()), {}, {}};
  for (const MechanismFactor::Leaf& leaf : factor.leaves()) {
    std::optional<InternalMotions> motions = leaf.linear->internal_motions();
    if (!motions) return std::nullopt;
    add_leaf(factor.system(), motions->dynamics, false, found.pencil);
    found.unknowns.push_back(std::move(motions->unknowns));
    found.offsets.push_back(leaf.offset);
  }
  add_elastic_modes(factor.system(), factor.frequencies(), found.pencil);
  for (const MechanismFactor::ElasticInside& inside : factor.elastic()) {
    found.unknowns.push_back(MatrixXd::Identity(inside.count(), inside.count()));
    found.offsets.push_back(inside.offset);
  }
  return found;
}

LeafModes::LeafModes(const MechanismPencil& of) {
  const int bodies = of.bodies, inside = of.size - bodies;
  pencil = {of.K_bodies.dense(), of.M_bodies.dense(), VectorXd(inside),
            MatrixXd::Zero(bodies, inside)};
  for (const MechanismPencil::Leaf& leaf : of.leaves) {
    const Eigen::Index edges = leaf.boundary(), k = leaf.modes;
    for (Eigen::Index j = 0; j < edges; ++j)
      for (Eigen::Index i = 0; i < edges; ++i)  // both edges may be of one body
        pencil.M(leaf.coordinates[i], leaf.coordinates[j]) += leaf.mass(i, j);
    shapes.emplace_back();
    if (k == 0) continue;
    EigenPairs own =
        lowest_dense_pairs(leaf.stiffness, leaf.mass.bottomRightCorner(k, k), leaf.modes);
    const int first = leaf.first() - bodies;
    pencil.modes.segment(first, k) = own.values;
    const MatrixXd coupling = leaf.mass.topRightCorner(edges, k) * own.vectors;
    for (Eigen::Index i = 0; i < edges; ++i)
      pencil.C.row(leaf.coordinates[i]).segment(first, k) += coupling.row(i);
    shapes.back() = std::move(own.vectors);
  }
}

MatrixXd LeafModes::expanded(const MechanismPencil& to, const MatrixXd& of_bodies,
                             const MatrixXd& vectors) const {
  MatrixXd phi(to.size, vectors.cols());
  phi.topRows(to.bodies) = of_bodies;
  phi.bottomRows(to.size - to.bodies) = vectors.bottomRows(to.size - to.bodies);
  for (std::size_t i = 0; i < shapes.size(); ++i)
    if (const MechanismPencil::Leaf& leaf = to.leaves[i]; leaf.modes > 0) {
      auto rows = phi.middleRows(leaf.first(), leaf.modes);
      rows = (shapes[i] * rows).eval();
    }
  return phi;
}

namespace {

// Motions of the bodies that joints and held directions leave free; `held`: the columns that are
// left out where the drives are held.
struct UnheldMotions {
  MatrixXd basis;
  std::vector<int> held;
};

UnheldMotions motions_of(const System& system) {
  UnheldMotions motions{FreeMotions(system, false).basis(), {}};
  const MatrixXd forces = system.drive_forces(DriveHold::named);
  if (forces.cols() == 0) return motions;
  const MatrixXd strokes = motions.basis.transpose() * forces,
                 still = null_space_of_transpose(strokes, 1e-9);
  MatrixXd turned(strokes.rows(), strokes.rows());
  turned.leftCols(still.cols()) = still;
  if (still.cols() > 0)
    turned.rightCols(turned.rows() - still.cols()) = null_space_of_transpose(still, 1e-9);
  else
    turned.setIdentity();
  motions.basis = (motions.basis * turned).eval();
  for (auto k = still.cols(); k < turned.rows(); ++k) motions.held.push_back(static_cast<int>(k));
  return motions;
}

}  // namespace

std::optional<std::array<EigenPairs, 2>> free_and_held_pairs(const System& system,
                                                             const MechanismPencil& pencil,
                                                             const LeafModes& modes,
                                                             PairCounts counts) {
  const UnheldMotions motions = motions_of(system);
  const auto found = lowest_pairs(modes.pencil.along(motions.basis), motions.held, counts);
  if (!found) return std::nullopt;
  const auto all = [&](const EigenPairs& pairs) -> EigenPairs {
    if (pairs.values.size() == 0) return pairs;
    const MatrixXd bodies = motions.basis * pairs.vectors.topRows(motions.basis.cols());
    return {pairs.values, modes.expanded(pencil, bodies, pairs.vectors)};
  };
  return std::array{all(found->free), all(found->held)};
}

}  // namespace flexopt
