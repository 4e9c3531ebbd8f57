#include "core/response/modes/mechanism_pencil.hpp"

#include <algorithm>
#include <utility>

#include "core/mechanism/joint.hpp"

namespace flexopt {

MatrixXd MechanismPencil::mass_times(const MatrixXd& X) const {
  MatrixXd Y = MatrixXd::Zero(size, X.cols());
  Y.topRows(bodies) = M_bodies * X.topRows(bodies);
  for (const Leaf& leaf : leaves) {
    const MatrixXd F = leaf.mass * X(leaf.coordinates, Eigen::all);
    for (std::size_t k = 0; k < leaf.coordinates.size(); ++k)
      Y.row(leaf.coordinates[k]) += F.row(static_cast<Eigen::Index>(k));
  }
  return Y;
}

MatrixXd MechanismPencil::motions(const System& system, const MatrixXd& phi) const {
  std::vector<MatrixXd> parts{body_motions(system, phi.topRows(bodies))};
  for (const Leaf& leaf : leaves)
    if (leaf.stations.rows() > 0)
      parts.push_back(leaf.stations * phi(leaf.coordinates, Eigen::all));
  Eigen::Index rows = 0;
  for (const MatrixXd& part : parts) rows += part.rows();
  MatrixXd all(rows, phi.cols());
  rows = 0;
  for (const MatrixXd& part : parts) {
    all.middleRows(rows, part.rows()) = part;
    rows += part.rows();
  }
  return all;
}

void MechanismPencil::add_shape(const VectorXd& phi, Mode& mode) const {
  mode.body_motion = phi.head(bodies);
  for (const Leaf& leaf : leaves)
    mode.leaf_motion.push_back(leaf.shape.rows() > 0 ? leaf.shape * phi(leaf.coordinates)
                                                     : VectorXd());
}

MechanismPencil mechanism_pencil(System& system, const std::vector<int>& leaf_modes,
                                 const FrequencyOptions& options) {
  const Mechanism& m = system.mechanism();
  int n = system.size();
  MechanismPencil pencil;
  pencil.bodies = n;
  pencil.group = rigid_groups(m);
  pencil.highest.resize(system.leaves());
  pencil.K_bodies = system.tangent();
  pencil.M_bodies = system.body_mass();
  for (int i = 0; i < system.leaves(); ++i) {
    const DynamicsRequest request(leaf_modes[i], options.shapes, options.motions);
    LeafDynamics leaf = options.constant_mass ? options.constant_mass->dynamics(system, i, request)
                                              : system.leaf(i).dynamics(request);
    const int k = static_cast<int>(leaf.mode_frequencies.size());
    pencil.highest[i] = leaf.highest_mode;
    pencil.check = std::max(pencil.check, leaf.check);
    // rows (edge and point coordinates, k modes) of the leaf from those of the pencil
    const LeafSpring& l = m.leaves[i];
    const int boundary = l.point ? 15 : 12;
    MechanismPencil::Leaf part;
    part.modes = k;
    MatrixXd T = MatrixXd::Zero(boundary + k, boundary + k);
    std::vector<int> sides;  // first rows of its edges that move
    int columns = 0;
    const auto put = [&](int row, int size, int coordinate, const MatrixXd& map) {
      T.block(row, columns, size, size) = map;
      for (int d = 0; d < size; ++d) part.coordinates.push_back(coordinate + d);
      columns += size;
    };
    for (int end = 0; end < 2; ++end)
      if (const int b = end == 0 ? l.base : l.tip; b >= 0) {
        put(6 * end, 6, 6 * b, system.edge_map(i, end));
        sides.push_back(end);
      }
    if (l.point) put(12, 3, 6 * l.point->body, Matrix3d::Identity());
    put(boundary, k, n, MatrixXd::Identity(k, k));
    T.conservativeResize(Eigen::NoChange, columns);
    part.mass = T.transpose() * leaf.mass * T;
    part.stiffness = leaf.stiffness.bottomRightCorner(k, k);
    if (options.motions && leaf.stations.rows() > 0) part.stations = leaf.stations * T;
    if (leaf.shape_motion.rows() > 0) part.shape = leaf.shape_motion * T;
    // a condensed full leaf is nearer the truth than the reduced one it stands in for
    const Matrix12d better =
        leaf.stiffness.topLeftCorner<12, 12>() - system.leaf(i).evaluation().tangent;
    for (const int a : sides)
      for (const int b : sides) {
        const Matrix6d Qa = system.edge_map(i, a), Qb = system.edge_map(i, b);
        pencil.K_bodies.block(a == 0 ? l.base : l.tip, b == 0 ? l.base : l.tip) +=
            Qa.transpose() * better.block<6, 6>(6 * a, 6 * b) * Qb;
      }
    pencil.leaves.push_back(std::move(part));
    n += k;
  }
  pencil.size = n;
  return pencil;
}

LeafModes::LeafModes(const MechanismPencil& of) {
  const int bodies = of.bodies, inside = of.size - bodies;
  pencil = {of.K_bodies.dense(), of.M_bodies.dense(), VectorXd(inside),
            MatrixXd::Zero(bodies, inside)};
  for (const MechanismPencil::Leaf& leaf : of.leaves) {
    const Eigen::Index edges = leaf.boundary(), k = leaf.modes;
    for (Eigen::Index j = 0; j < edges; ++j)
      for (Eigen::Index i = 0; i < edges; ++i)  // both edges may be of one body
        pencil.M(leaf.coordinates[static_cast<std::size_t>(i)],
                 leaf.coordinates[static_cast<std::size_t>(j)]) += leaf.mass(i, j);
    shapes.emplace_back();
    if (k == 0) continue;
    EigenPairs own =
        lowest_dense_pairs(leaf.stiffness, leaf.mass.bottomRightCorner(k, k), leaf.modes);
    const int first = leaf.first() - bodies;
    pencil.modes.segment(first, k) = own.values;
    const MatrixXd coupling = leaf.mass.topRightCorner(edges, k) * own.vectors;
    for (Eigen::Index i = 0; i < edges; ++i)
      pencil.C.row(leaf.coordinates[static_cast<std::size_t>(i)]).segment(first, k) +=
          coupling.row(i);
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

}  // namespace flexopt
