#include "core/response/modes/frequencies.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/equilibrium/free_motions.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/joint.hpp"

namespace flexopt {
namespace {

// K and M over (bodies, internal modes of leaf 0, of leaf 1, …).
struct Pencil {
  MatrixXd K, M;
  int bodies = 0;          ///< coordinates of the bodies
  std::vector<int> group;  ///< of every body: what rigid joints make it part of
  VectorXd highest;        ///< highest kept mode of each leaf [Hz]
  MatrixXd motion;         ///< Mode::motion of the coordinates
  double check = 0;
};

Pencil assemble(System& system, const std::vector<int>& leaf_modes, ConstantMass* constant_mass) {
  const Mechanism& m = system.mechanism();
  std::vector<LeafDynamics> leaves;
  int n = system.size();
  Pencil pencil;
  pencil.bodies = n;
  pencil.group = rigid_groups(m);
  pencil.highest.resize(system.leaves());
  for (int i = 0; i < system.leaves(); ++i) {
    leaves.push_back(constant_mass ? constant_mass->dynamics(system, i, leaf_modes[i])
                                   : system.leaf(i).dynamics(leaf_modes[i]));
    const VectorXd& f = leaves.back().mode_frequencies;
    n += static_cast<int>(f.size());
    pencil.highest[i] = leaves.back().highest_mode;
    pencil.check = std::max(pencil.check, leaves.back().check);
  }
  pencil.K = MatrixXd::Zero(n, n);
  pencil.M = MatrixXd::Zero(n, n);
  pencil.K.topLeftCorner(pencil.bodies, pencil.bodies) = system.tangent_stiffness();
  pencil.M.topLeftCorner(pencil.bodies, pencil.bodies) = system.body_mass();
  Eigen::Index stations = 0;
  for (const LeafDynamics& leaf : leaves) stations += leaf.stations.rows();
  pencil.motion = MatrixXd::Zero(pencil.bodies + stations, n);
  pencil.motion.topLeftCorner(pencil.bodies, pencil.bodies) = body_motion_map(system);
  Eigen::Index station = pencil.bodies;
  int o = pencil.bodies;
  for (int i = 0; i < system.leaves(); ++i) {
    const LeafDynamics& leaf = leaves[i];
    const int k = static_cast<int>(leaf.mode_frequencies.size());
    // rows (edge and point coordinates, k modes) of the leaf from those of the pencil
    const LeafSpring& l = m.leaves[i];
    const int boundary = l.point ? 15 : 12;
    MatrixXd T = MatrixXd::Zero(boundary + k, n);
    for (int end = 0; end < 2; ++end) {
      const int b = end == 0 ? l.base : l.tip;
      if (b >= 0) T.block<6, 6>(6 * end, 6 * b) = system.edge_map(i, end);
    }
    if (l.point) T.block<3, 3>(12, 6 * l.point->body).setIdentity();
    T.block(boundary, o, k, k).setIdentity();
    pencil.M += T.transpose() * leaf.mass * T;
    if (leaf.stations.rows() > 0)
      pencil.motion.middleRows(station, leaf.stations.rows()).noalias() = leaf.stations * T;
    station += leaf.stations.rows();
    // a condensed full leaf is nearer the truth than the reduced one it stands in for
    const MatrixXd Q = T.topLeftCorner(12, pencil.bodies);
    const Matrix12d better =
        leaf.stiffness.topLeftCorner<12, 12>() - system.leaf(i).evaluation().tangent;
    pencil.K.topLeftCorner(pencil.bodies, pencil.bodies) += Q.transpose() * better * Q;
    pencil.K.block(o, o, k, k) = leaf.stiffness.bottomRightCorner(k, k);
    o += k;
  }
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

double hertz(double omega2) {
  return std::copysign(std::sqrt(std::abs(omega2)), omega2) / (2 * std::numbers::pi);
}

// Shares of the modal kinetic energy. The drives' is that of the static motions under drive loads,
// which are M-orthogonal; the rest is split between the coordinates, mixed terms half each.
Mode classify(const Pencil& pencil, const System& system, double omega2, const VectorXd& phi,
              const MatrixXd& drive_shapes) {
  double drive = 0, end_effector = 0, intermediate = 0;
  VectorXd rest = phi;
  for (const auto& shape : drive_shapes.colwise()) {
    const VectorXd Mx = pencil.M * shape;
    const double a = Mx.dot(phi), b = Mx.dot(shape);
    drive += a * a / b;
    rest -= a / b * shape;
  }
  drive = std::clamp(drive, 0.0, 1.0);
  const VectorXd share = rest.cwiseProduct(pencil.M * rest);
  for (int b = 0; b < pencil.bodies / 6; ++b) {
    const double e = std::max(0.0, share.segment<6>(6 * b).sum());
    if (pencil.group[b] == system.mechanism().end_effector)
      end_effector += e;
    else
      intermediate += e;
  }
  const double leaf = std::max(0.0, share.tail(share.size() - pencil.bodies).sum());
  Mode mode = mode_of_shares(omega2, drive, end_effector, intermediate, leaf);
  mode.motion = pencil.motion * phi;
  return mode;
}

// Static motions of the bodies under the drive loads, M-orthogonal.
MatrixXd drive_shapes_of(const Pencil& pencil, const System& system) {
  const MatrixXd forces = system.drive_forces();
  MatrixXd shapes = MatrixXd::Zero(pencil.K.rows(), forces.cols());
  if (forces.cols() == 0) return shapes;
  if (system.constraints().count() > 0)
    shapes.topRows(pencil.bodies) = FreeMotions(system, false).answer(forces);
  else
    shapes.topRows(pencil.bodies) =
        Lu(pencil.K.topLeftCorner(pencil.bodies, pencil.bodies)).solve(forces);
  for (Eigen::Index k = 0; k < shapes.cols(); ++k) {
    auto x = shapes.col(k);
    x /= x.cwiseAbs().maxCoeff();
    for (Eigen::Index j = 0; j < k; ++j) {
      const VectorXd Mx = pencil.M * shapes.col(j);
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

MatrixXd body_motion_map(const System& system) {
  MatrixXd map = MatrixXd::Zero(system.size(), system.size());
  for (int b = 0; b < system.size() / 6; ++b) {
    const RigidBody& body = system.mechanism().bodies[b];
    const Matrix3d RT = system.pose(b).rotation.transpose();
    const SymmetricEigen inertia(body.inertia);
    const Vector3d root = inertia.eigenvalues().cwiseMax(0).cwiseSqrt();
    const Vector3d arm = body.center_of_mass - body.reference;
    map.block<3, 3>(6 * b, 6 * b) = std::sqrt(body.mass) * RT;
    map.block<3, 3>(6 * b, 6 * b + 3) = -std::sqrt(body.mass) * hat(arm) * RT;
    map.block<3, 3>(6 * b + 3, 6 * b + 3) =
        inertia.eigenvectors() * root.asDiagonal() * inertia.eigenvectors().transpose() * RT;
  }
  return map;
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
    const Eigen::Index inner = pencil.K.rows() - Z.rows();
    MatrixXd T = MatrixXd::Zero(pencil.K.rows(), Z.cols() + inner);
    T.topLeftCorner(Z.rows(), Z.cols()) = Z;
    T.bottomRightCorner(inner, inner).setIdentity();
    EigenPairs found =
        solve(T.transpose() * pencil.K * T, T.transpose() * pencil.M * T, options.count);
    found.shape = (T * found.shape).eval();
    return found;
  };
  const auto pairs = [&](const Pencil& pencil, bool drive_locked) {
    if (conditions) return jointed_pairs(pencil, drive_locked);
    std::vector<int> kept;
    const int n = static_cast<int>(pencil.K.rows());
    for (int i = 0; i < n; ++i)
      if (!system.is_held(i) && !(drive_locked && std::ranges::find(driven, i) != driven.end()))
        kept.push_back(i);
    EigenPairs found = solve(pencil.K(kept, kept), pencil.M(kept, kept), options.count);
    MatrixXd shape = MatrixXd::Zero(n, found.shape.cols());
    shape(kept, Eigen::all) = found.shape;
    found.shape = std::move(shape);
    return found;
  };
  for (;;) {
    const Pencil pencil = assemble(system, leaf_modes, options.constant_mass);
    const int n = static_cast<int>(pencil.K.rows());
    const EigenPairs locked = pairs(pencil, true);
    const double highest = hertz(std::max(0.0, locked.omega2[locked.omega2.size() - 1]));
    const int unknowns = conditions ? n - pencil.bodies + FreeMotions(system, true).count()
                                    : n - static_cast<int>(driven.size() + system.held().size());
    if (options.leaf_modes > 0 &&
        grow(leaf_modes, pencil.highest, highest, options.count - unknowns, options))
      continue;
    const EigenPairs free = pairs(pencil, false);
    const MatrixXd drive_shapes = drive_shapes_of(pencil, system);
    for (int k = 0; k < free.omega2.size(); ++k)
      result.free.push_back(
          classify(pencil, system, free.omega2[k], free.shape.col(k), drive_shapes));
    for (int k = 0; k < locked.omega2.size(); ++k)
      result.locked.push_back(
          classify(pencil, system, locked.omega2[k], locked.shape.col(k), MatrixXd(n, 0)));
    result.check = pencil.check;
    return result;
  }
}

}  // namespace flexopt
