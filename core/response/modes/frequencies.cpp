#include "core/response/modes/frequencies.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/equilibrium/free_motions.hpp"
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
  MatrixXd dense_stiffness() const {
    MatrixXd K = MatrixXd::Zero(size, size);
    K.topLeftCorner(bodies, bodies) = K_bodies.dense();
    for (const Leaf& leaf : leaves)
      if (leaf.modes > 0) {
        const int o =
            leaf.coordinates[leaf.coordinates.size() - static_cast<std::size_t>(leaf.modes)];
        K.block(o, o, leaf.modes, leaf.modes) = leaf.stiffness;
      }
    return K;
  }
  MatrixXd dense_mass() const {
    MatrixXd M = MatrixXd::Zero(size, size);
    M.topLeftCorner(bodies, bodies) = M_bodies.dense();
    for (const Leaf& leaf : leaves)
      for (std::size_t j = 0; j < leaf.coordinates.size(); ++j)
        for (std::size_t i = 0; i < leaf.coordinates.size(); ++i)  // both edges may be of one body
          M(leaf.coordinates[i], leaf.coordinates[j]) +=
              leaf.mass(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    return M;
  }
};

Pencil assemble(System& system, const std::vector<int>& leaf_modes, ConstantMass* constant_mass,
                bool shapes) {
  const Mechanism& m = system.mechanism();
  int n = system.size();
  Pencil pencil;
  pencil.bodies = n;
  pencil.group = rigid_groups(m);
  pencil.highest.resize(system.leaves());
  pencil.K_bodies = system.tangent();
  pencil.M_bodies = system.body_mass();
  for (int i = 0; i < system.leaves(); ++i) {
    const DynamicsRequest request(leaf_modes[i], shapes);
    LeafDynamics leaf = constant_mass ? constant_mass->dynamics(system, i, request)
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
    if (leaf.stations.rows() > 0) part.stations = leaf.stations * T;
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

struct EigenPairs {
  VectorXd omega2;  ///< ascending
  MatrixXd shape;   ///< M-orthonormal columns
};

// Through the Cholesky factor of K, whose spectrum is inverted: the lowest frequencies come out
// with full accuracy. Through that of M where K is not positive definite.
EigenPairs solve(const MatrixXd& K, const MatrixXd& M, int count) {
  const int n = static_cast<int>(K.rows());
  count = std::min(count, n);
  EigenPairs pairs{VectorXd(count), MatrixXd(n, count)};
  const VectorXd s = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd Ks = s.asDiagonal() * K * s.asDiagonal(), Ms = s.asDiagonal() * M * s.asDiagonal();
  const Cholesky factor(Ks);
  if (factor.positive_definite()) {
    MatrixXd A = factor.solve_lower(Ms);
    A = factor.solve_lower(A.transpose());
    const SymmetricEigen eigen(0.5 * (A + A.transpose()));
    for (int k = 0; k < count; ++k) {
      const double mu = std::max(eigen.eigenvalues()[n - 1 - k], 1e-300);
      pairs.omega2[k] = 1 / mu;
      pairs.shape.col(k) =
          s.asDiagonal() * factor.solve_upper(eigen.eigenvectors().col(n - 1 - k)) / std::sqrt(mu);
    }
  } else {
    const SymmetricEigen eigen(Ks, Ms);
    pairs.omega2 = eigen.eigenvalues().head(count);
    pairs.shape = s.asDiagonal() * eigen.eigenvectors().leftCols(count);
  }
  return pairs;
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
      const int o =
          leaf.coordinates[leaf.coordinates.size() - static_cast<std::size_t>(leaf.modes)];
      X.middleRows(o, leaf.modes) = modes[i].solve(B.middleRows(o, leaf.modes));
    }
    return X;
  };
  const auto mass = [&](const MatrixXd& B) { return pencil.mass_times(B); };
  const LowestPairs found =
      lowest_pairs(pencil.size, count, std::min(system.leaves() + 4, count + 4), solve, mass);
  return {found.values, found.vectors};
}

double hertz(double omega2) {
  return std::copysign(std::sqrt(std::abs(omega2)), omega2) / (2 * std::numbers::pi);
}

// Shares of the modal kinetic energy. The drives' is that of the static motions under drive loads,
// which are M-orthogonal; the rest is split between the coordinates, mixed terms half each.
std::vector<Mode> classify(const Pencil& pencil, const System& system, const VectorXd& omega2,
                           const MatrixXd& phi, const MatrixXd& drive_shapes) {
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
  const MatrixXd shares = rest.cwiseProduct(M_rest), motions = pencil.motions(system, phi);
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
    modes.back().motion = motions.col(k);
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
  const auto jointed_pairs = [&](const Pencil& pencil, bool drive_locked) {
    const MatrixXd Z = FreeMotions(system, drive_locked).basis();
    const Eigen::Index inner = pencil.size - Z.rows();
    MatrixXd T = MatrixXd::Zero(pencil.size, Z.cols() + inner);
    T.topLeftCorner(Z.rows(), Z.cols()) = Z;
    T.bottomRightCorner(inner, inner).setIdentity();
    EigenPairs found = solve(T.transpose() * pencil.dense_stiffness() * T,
                             T.transpose() * pencil.dense_mass() * T, options.count);
    found.shape = (T * found.shape).eval();
    return found;
  };
  const auto unknowns = [&](const Pencil& pencil) {  // drives held
    return conditions ? pencil.size - pencil.bodies + FreeMotions(system, true).count()
                      : pencil.size - static_cast<int>(driven.size() + system.held().size());
  };
  const auto pairs = [&](const Pencil& pencil, bool drive_locked) {
    if (system.analyses() || pencil.size >= krylov_from)
      return solve_by_krylov(system, pencil, drive_locked,
                             std::min(options.count, unknowns(pencil)));
    if (conditions) return jointed_pairs(pencil, drive_locked);
    std::vector<int> kept;
    const int n = pencil.size;
    for (int i = 0; i < n; ++i)
      if (!(i < pencil.bodies && system.is_held(i)) &&
          !(drive_locked && std::ranges::find(driven, i) != driven.end()))
        kept.push_back(i);
    EigenPairs found =
        solve(pencil.dense_stiffness()(kept, kept), pencil.dense_mass()(kept, kept), options.count);
    MatrixXd shape = MatrixXd::Zero(n, found.shape.cols());
    shape(kept, Eigen::all) = found.shape;
    found.shape = std::move(shape);
    return found;
  };
  for (;;) {
    const Pencil pencil = assemble(system, leaf_modes, options.constant_mass, options.shapes);
    const EigenPairs locked = pairs(pencil, true);
    const double highest = hertz(std::max(0.0, locked.omega2[locked.omega2.size() - 1]));
    if (options.leaf_modes > 0 &&
        grow(leaf_modes, pencil.highest, highest, options.count - unknowns(pencil), options))
      continue;
    const EigenPairs free = pairs(pencil, false);
    result.free =
        classify(pencil, system, free.omega2, free.shape, drive_shapes_of(pencil, system));
    result.locked = classify(pencil, system, locked.omega2, locked.shape, MatrixXd(pencil.size, 0));
    if (options.shapes) {
      for (int k = 0; k < free.omega2.size(); ++k)
        pencil.add_shape(free.shape.col(k), result.free[static_cast<std::size_t>(k)]);
      for (int k = 0; k < locked.omega2.size(); ++k)
        pencil.add_shape(locked.shape.col(k), result.locked[static_cast<std::size_t>(k)]);
    }
    result.check = pencil.check;
    return result;
  }
}

}  // namespace flexopt
