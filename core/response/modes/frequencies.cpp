#include "core/response/modes/frequencies.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/equilibrium/free_motions.hpp"
#include "core/math/bordered_pencil.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/lanczos.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/joint.hpp"

namespace flexopt {
namespace {

// K and M over (bodies, internal modes of leaf 0, of leaf 1, …).
struct Pencil {
  int size = 0;
  int bodies = 0;          ///< coordinates of the bodies
  BlockMatrix K_bodies;    ///< the modes add a diagonal block each: no coupling
  BlockMatrix M_bodies;    ///< of the rigid bodies alone
  std::vector<int> group;  ///< of every body: what rigid joints make it part of
  VectorXd highest;        ///< highest kept mode of each leaf [Hz]
  double check = 0;
  struct Leaf {
    std::vector<int> coordinates;  ///< of its bodies, its point and its modes in the pencil
    int modes;                     ///< the last of them
    MatrixXd mass, stiffness;      ///< over them; of the modes alone
    MatrixXd stations, shape;

    Eigen::Index boundary() const { return mass.rows() - modes; }
    /// The first of the modes in the pencil.
    int first() const { return coordinates[static_cast<std::size_t>(boundary())]; }
  };
  std::vector<Leaf> leaves;

  MatrixXd mass_times(const MatrixXd& X) const {
    MatrixXd Y = MatrixXd::Zero(size, X.cols());
    Y.topRows(bodies) = M_bodies * X.topRows(bodies);
    for (const Leaf& leaf : leaves) {
      const MatrixXd F = leaf.mass * X(leaf.coordinates, Eigen::all);
      for (std::size_t k = 0; k < leaf.coordinates.size(); ++k)
        Y.row(leaf.coordinates[k]) += F.row(static_cast<Eigen::Index>(k));
    }
    return Y;
  }
  // Mode::motion of every column.
  MatrixXd motions(const System& system, const MatrixXd& phi) const {
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
  void add_shape(const VectorXd& phi, Mode& mode) const {
    mode.body_motion = phi.head(bodies);
    for (const Leaf& leaf : leaves)
      mode.leaf_motion.push_back(leaf.shape.rows() > 0 ? leaf.shape * phi(leaf.coordinates)
                                                       : VectorXd());
  }
};

Pencil assemble(System& system, const std::vector<int>& leaf_modes,
                const FrequencyOptions& options) {
  const Mechanism& m = system.mechanism();
  int n = system.size();
  Pencil pencil;
  pencil.bodies = n;
  pencil.group = rigid_groups(m);
  pencil.highest.resize(system.leaves());
  pencil.K_bodies = system.tangent();
  pencil.M_bodies = system.body_mass();
  for (int i = 0; i < system.leaves(); ++i) {
    const DynamicsRequest request(leaf_modes[i], options.shapes, options.motions);
    LeafDynamics leaf = options.constant_mass
                            ? options.constant_mass->dynamics(system, i, request)
                            : system.leaf(i).dynamics(request);
    const int k = static_cast<int>(leaf.mode_frequencies.size());
    pencil.highest[i] = leaf.highest_mode;
    pencil.check = std::max(pencil.check, leaf.check);
    // rows (edge and point coordinates, k modes) of the leaf from those of the pencil
    const LeafSpring& l = m.leaves[i];
    const int boundary = l.point ? 15 : 12;
    Pencil::Leaf part;
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

// The same over (bodies, modes of every leaf between held edges): these shapes of each leaf.
struct LeafModes {
  BorderedPencil pencil;
  std::vector<MatrixXd> shapes;

  /// Back to the coordinates of the other pencil.
  void expand(const Pencil& other, MatrixXd& phi) const {
    for (std::size_t i = 0; i < shapes.size(); ++i)
      if (const Pencil::Leaf& leaf = other.leaves[i]; leaf.modes > 0) {
        auto rows = phi.middleRows(leaf.first(), leaf.modes);
        rows = (shapes[i] * rows).eval();
      }
  }
};

LeafModes leaf_modes_of(const Pencil& pencil) {
  const int bodies = pencil.bodies, inside = pencil.size - bodies;
  LeafModes all{{pencil.K_bodies.dense(), pencil.M_bodies.dense(), VectorXd(inside),
                 MatrixXd::Zero(bodies, inside)},
                {}};
  for (const Pencil::Leaf& leaf : pencil.leaves) {
    const Eigen::Index edges = leaf.boundary(), k = leaf.modes;
    for (Eigen::Index j = 0; j < edges; ++j)
      for (Eigen::Index i = 0; i < edges; ++i)  // both edges may be of one body
        all.pencil.M(leaf.coordinates[static_cast<std::size_t>(i)],
                     leaf.coordinates[static_cast<std::size_t>(j)]) += leaf.mass(i, j);
    all.shapes.emplace_back();
    if (k == 0) continue;
    EigenPairs own =
        lowest_dense_pairs(leaf.stiffness, leaf.mass.bottomRightCorner(k, k), leaf.modes);
    const int first = leaf.first() - bodies;
    all.pencil.modes.segment(first, k) = own.values;
    const MatrixXd coupling = leaf.mass.topRightCorner(edges, k) * own.vectors;
    for (Eigen::Index i = 0; i < edges; ++i)
      all.pencil.C.row(leaf.coordinates[static_cast<std::size_t>(i)]).segment(first, k) +=
          coupling.row(i);
    all.shapes.back() = std::move(own.vectors);
  }
  return all;
}

// From this many coordinates on the lowest pairs alone are sought.
constexpr int krylov_from = 150;

// The same, the lowest alone: the modes of leaves have a diagonal block each.
EigenPairs solve_by_krylov(const System& system, const Pencil& pencil, bool drive_locked,
                           int count) {
  const TangentFactor factor(system, pencil.K_bodies, drive_locked);
  std::vector<Lu> modes(pencil.leaves.size());
  for (std::size_t i = 0; i < modes.size(); ++i)
    if (pencil.leaves[i].modes > 0) modes[i].compute(pencil.leaves[i].stiffness);
  const auto solve = [&](const MatrixXd& B) {
    MatrixXd X = B;
    X.topRows(pencil.bodies) = factor.answer(B.topRows(pencil.bodies));
    for (std::size_t i = 0; i < modes.size(); ++i) {
      const Pencil::Leaf& leaf = pencil.leaves[i];
      if (leaf.modes == 0) continue;
      X.middleRows(leaf.first(), leaf.modes) =
          modes[i].solve(B.middleRows(leaf.first(), leaf.modes));
    }
    return X;
  };
  const auto mass = [&](const MatrixXd& B) { return pencil.mass_times(B); };
  const LowestPairs found =
      lowest_pairs(pencil.size, count, std::min(system.leaves() + 4, count + 4), solve, mass);
  return {found.values, found.vectors};
}

// From the bodies' coordinates that `rows` are of, all others at rest, and the modes of the leaves.
EigenPairs expanded(const Pencil& pencil, const LeafModes& modes, const EigenPairs& found,
                    const MatrixXd& of_bodies) {
  const Eigen::Index inside = pencil.size - pencil.bodies;
  EigenPairs all{found.values, MatrixXd(pencil.size, found.vectors.cols())};
  all.vectors.topRows(pencil.bodies) = of_bodies;
  all.vectors.bottomRows(inside) = found.vectors.bottomRows(inside);
  modes.expand(pencil, all.vectors);
  return all;
}

// Of a mechanism with joints or drives that are conditions.
EigenPairs jointed_pairs(const System& system, const Pencil& pencil, const LeafModes& modes,
                         bool drive_locked, int count) {
  const MatrixXd Z = FreeMotions(system, drive_locked).basis();
  const EigenPairs found = lowest_pairs(modes.pencil.along(Z), count);
  return expanded(pencil, modes, found, Z * found.vectors.topRows(Z.cols()));
}

// Of all others: drive free and held.
std::array<EigenPairs, 2> free_pairs(const System& system, const Pencil& pencil,
                                     const LeafModes& modes, int count) {
  const std::vector<int> driven = system.driven_coordinates();
  std::vector<int> kept, held;  // of the bodies' coordinates, and of those
  for (int i = 0; i < pencil.bodies; ++i) {
    if (system.is_held(i)) continue;
    if (std::ranges::find(driven, i) != driven.end()) held.push_back(static_cast<int>(kept.size()));
    kept.push_back(i);
  }
  const FreeAndHeldPairs found = lowest_pairs(modes.pencil.kept(kept), held, count);
  const auto all = [&](const EigenPairs& pairs) {
    MatrixXd bodies = MatrixXd::Zero(pencil.bodies, pairs.vectors.cols());
    bodies(kept, Eigen::all) = pairs.vectors.topRows(static_cast<Eigen::Index>(kept.size()));
    return expanded(pencil, modes, pairs, bodies);
  };
  return {all(found.free), all(found.held)};
}

double hertz(double omega2) {
  return std::copysign(std::sqrt(std::abs(omega2)), omega2) / (2 * std::numbers::pi);
}

// Shares of the modal kinetic energy. The drives' is that of the static motions under drive loads,
// which are M-orthogonal; the rest is split between the coordinates, mixed terms half each.
std::vector<Mode> classify(const Pencil& pencil, const System& system, const VectorXd& omega2,
                           const MatrixXd& phi, const MatrixXd& drive_shapes,
                           bool with_motions) {
  MatrixXd rest = phi, M_rest = pencil.mass_times(phi);
  VectorXd of_drive = VectorXd::Zero(phi.cols());
  const MatrixXd M_shapes = pencil.mass_times(drive_shapes);
  for (Eigen::Index s = 0; s < drive_shapes.cols(); ++s) {
    const double b = M_shapes.col(s).dot(drive_shapes.col(s));
    const Eigen::RowVectorXd a = M_shapes.col(s).transpose() * phi;
    of_drive += (a.cwiseAbs2() / b).transpose();
    rest -= drive_shapes.col(s) * (a / b);
    M_rest -= M_shapes.col(s) * (a / b);
  }
  const MatrixXd shares = rest.cwiseProduct(M_rest);
  MatrixXd motions;
  if (with_motions) motions = pencil.motions(system, phi);
  std::vector<Mode> modes;
  for (Eigen::Index k = 0; k < phi.cols(); ++k) {
    double end_effector = 0, intermediate = 0;
    const auto share = shares.col(k);
    for (int b = 0; b < pencil.bodies / 6; ++b) {
      const double e = std::max(0.0, share.segment<6>(6 * b).sum());
      (pencil.group[b] == system.mechanism().end_effector ? end_effector : intermediate) += e;
    }
    const double leaf = std::max(0.0, share.tail(share.size() - pencil.bodies).sum());
    modes.push_back(mode_of_shares(omega2[k], std::clamp(of_drive[k], 0.0, 1.0), end_effector,
                                   intermediate, leaf));
    if (with_motions) modes.back().motion = motions.col(k);
  }
  return modes;
}

// Static motions of the bodies under the drive loads, M-orthogonal.
MatrixXd drive_shapes_of(const Pencil& pencil, const System& system) {
  const MatrixXd forces = system.drive_forces();
  MatrixXd shapes = MatrixXd::Zero(pencil.size, forces.cols());
  if (forces.cols() == 0) return shapes;
  if (system.constraints().count() > 0)
    shapes.topRows(pencil.bodies) = FreeMotions(system, false).answer(forces);
  else
    shapes.topRows(pencil.bodies) = TangentFactor(system, pencil.K_bodies, false).answer(forces);
  for (Eigen::Index k = 0; k < shapes.cols(); ++k) {
    auto x = shapes.col(k);
    x /= x.cwiseAbs().maxCoeff();
    for (Eigen::Index j = 0; j < k; ++j) {
      const VectorXd Mx = pencil.mass_times(shapes.col(j));
      x -= Mx.dot(x) / Mx.dot(shapes.col(j)) * shapes.col(j);
    }
  }
  return shapes;
}

constexpr int most_leaf_modes = 48;
// Below this share of a leaf's lowest own frequency its static shapes and one mode are enough.
constexpr double far_below = 0.2;

// More modes where the kept ones do not reach far enough beyond `highest`, or are too few to yield
// `missing` further frequencies; false if all are enough.
bool grow(std::vector<int>& leaf_modes, const VectorXd& top, double highest, int missing,
          const FrequencyOptions& options) {
  bool grown = false;
  const int leaves = static_cast<int>(leaf_modes.size());
  for (int i = 0; i < leaves; ++i) {
    int& modes = leaf_modes[i];
    int wanted = modes;
    if (modes < options.leaf_modes && far_below * top[i] < highest) wanted = options.leaf_modes;
    const double cutoff = options.cutoff_ratio * highest;
    // the number of plate modes below a frequency grows in proportion to it
    if (wanted == modes && top[i] < cutoff)
      wanted = static_cast<int>(
          std::ceil(modes * std::min(3.0, 1.1 * cutoff / std::max(top[i], 1e-3 * cutoff))));
    if (missing > 0) wanted = std::max(wanted, modes + (missing + leaves - 1) / leaves);
    wanted = std::min(wanted, most_leaf_modes);
    grown |= wanted > modes;
    modes = std::max(modes, wanted);
  }
  return grown;
}

}  // namespace

MatrixXd body_motions(const System& system, const Eigen::Ref<const MatrixXd>& q) {
  MatrixXd motions(system.size(), q.cols());
  for (int b = 0; b < system.size() / 6; ++b) {
    const RigidBody& body = system.mechanism().bodies[b];
    const Matrix3d RT = system.pose(b).rotation.transpose();
    const SymmetricEigen inertia(body.inertia);
    const Vector3d root = inertia.eigenvalues().cwiseMax(0).cwiseSqrt();
    const Vector3d arm = body.center_of_mass - body.reference;
    const Matrix3d turning =
        inertia.eigenvectors() * root.asDiagonal() * inertia.eigenvectors().transpose() * RT;
    const MatrixXd u = RT * q.middleRows<3>(6 * b), w = RT * q.middleRows<3>(6 * b + 3);
    motions.middleRows<3>(6 * b) = std::sqrt(body.mass) * (u - hat(arm) * w);
    motions.middleRows<3>(6 * b + 3) = turning * q.middleRows<3>(6 * b + 3);
  }
  return motions;
}

Mode mode_of_shares(double omega2, double drive, double end_effector, double intermediate_body,
                    double leaf) {
  Mode mode;
  mode.frequency = hertz(omega2);
  const double sum = end_effector + intermediate_body + leaf;
  const double factor = sum > 0 ? (1 - drive) / sum : 0;
  mode.drive = drive;
  mode.end_effector = end_effector * factor;
  mode.intermediate_body = intermediate_body * factor;
  mode.leaf = leaf * factor;
  const double largest =
      std::max({mode.drive, mode.end_effector, mode.intermediate_body, mode.leaf});
  mode.kind = largest == mode.drive          ? ModeKind::drive
              : largest == mode.end_effector ? ModeKind::end_effector
              : largest == mode.leaf         ? ModeKind::leaf
                                             : ModeKind::intermediate_body;
  return mode;
}

Frequencies natural_frequencies(System& system, const FrequencyOptions& options,
                                std::vector<int>& leaf_modes) {
  Frequencies result;
  leaf_modes.resize(system.leaves(), std::min(1, options.leaf_modes));
  const std::vector<int> driven = system.driven_coordinates();
  const bool conditions = system.constraints().count() > 0;
  const auto unknowns = [&](const Pencil& pencil) {  // drives held
    return conditions ? pencil.size - pencil.bodies + FreeMotions(system, true).count()
                      : pencil.size - static_cast<int>(driven.size() + system.held().size());
  };
  const auto by_krylov = [&](const Pencil& pencil) {
    return system.analyses() || pencil.size >= krylov_from;
  };
  // drive free and held
  const auto pairs = [&](const Pencil& pencil) -> std::array<EigenPairs, 2> {
    if (by_krylov(pencil)) {
      const int count = std::min(options.count, unknowns(pencil));
      return {solve_by_krylov(system, pencil, false, count),
              solve_by_krylov(system, pencil, true, count)};
    }
    const LeafModes modes = leaf_modes_of(pencil);
    if (conditions)
      return {jointed_pairs(system, pencil, modes, false, options.count),
              jointed_pairs(system, pencil, modes, true, options.count)};
    return free_pairs(system, pencil, modes, options.count);
  };
  for (;;) {
    const Pencil pencil = assemble(system, leaf_modes, options);
    const auto [free, locked] = pairs(pencil);
    const double highest = hertz(std::max(0.0, locked.values[locked.values.size() - 1]));
    if (options.leaf_modes > 0 &&
        grow(leaf_modes, pencil.highest, highest, options.count - unknowns(pencil), options))
      continue;
    result.free =
        classify(pencil, system, free.values, free.vectors, drive_shapes_of(pencil, system), options.motions);
    result.locked = classify(pencil, system, locked.values, locked.vectors, MatrixXd(pencil.size, 0), options.motions);
    if (options.shapes) {
      for (int k = 0; k < free.values.size(); ++k)
        pencil.add_shape(free.vectors.col(k), result.free[static_cast<std::size_t>(k)]);
      for (int k = 0; k < locked.values.size(); ++k)
        pencil.add_shape(locked.vectors.col(k), result.locked[static_cast<std::size_t>(k)]);
    }
    result.check = pencil.check;
    return result;
  }
}

}  // namespace flexopt
