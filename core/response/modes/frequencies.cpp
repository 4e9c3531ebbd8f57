#include "core/response/modes/frequencies.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/equilibrium/free_motions.hpp"
#include "core/equilibrium/stroke_path.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/lanczos.hpp"
#include "core/math/rotation.hpp"
#include "core/response/modes/mechanism_pencil.hpp"

namespace flexopt {
namespace {

// The lowest eigenpairs by a Krylov method; the modes of each leaf form a diagonal block. Nothing
// where the pairs are not found, and where some are negative: these may be of any magnitude.
std::optional<EigenPairs> solve_by_krylov(const System& system, const MechanismPencil& pencil,
                                          bool drive_locked, int count) {
  if (negative_pivots(system, drive_locked) > 0) return std::nullopt;
  const TangentFactor factor(system, pencil.K_bodies, drive_locked);
  std::vector<Lu> modes(pencil.leaves.size());
  for (std::size_t i = 0; i < modes.size(); ++i)
    if (pencil.leaves[i].modes > 0) modes[i].compute(pencil.leaves[i].stiffness);
  const auto solve = [&](const MatrixXd& B) {
    MatrixXd X = B;
    X.topRows(pencil.bodies) = factor.answer(B.topRows(pencil.bodies));
    for (std::size_t i = 0; i < modes.size(); ++i) {
      const MechanismPencil::Leaf& leaf = pencil.leaves[i];
      if (leaf.modes == 0) continue;
      X.middleRows(leaf.first(), leaf.modes) =
          modes[i].solve(B.middleRows(leaf.first(), leaf.modes));
    }
    return X;
  };
  const auto mass = [&](const MatrixXd& B) { return pencil.mass_times(B); };
  const LowestPairs found =
      lowest_pairs(pencil.size, count, std::min(system.leaves() + 4, count + 4), solve, mass);
  if (!found.converged) return std::nullopt;
  return EigenPairs{found.values, found.vectors};
}

double hertz(double omega2) {
  return std::copysign(std::sqrt(std::abs(omega2)), omega2) / (2 * std::numbers::pi);
}

// Shares of the modal kinetic energy. The drives' is that of the static motions under drive loads,
// which are M-orthogonal; the rest is split between the coordinates, mixed terms half each.
std::vector<Mode> classify(const MechanismPencil& pencil, const System& system,
                           const VectorXd& omega2, const MatrixXd& phi,
                           const MatrixXd& drive_shapes, bool with_motions) {
  if (phi.cols() == 0) return {};
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
MatrixXd drive_shapes_of(const MechanismPencil& pencil, const System& system) {
  const MatrixXd forces = system.drive_forces();
  MatrixXd shapes = MatrixXd::Zero(pencil.size, forces.cols());
  if (forces.cols() == 0) return shapes;
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

constexpr int most_leaf_modes = 192;  // for 100 frequencies, the most of a job, of one leaf

// More modes where the kept ones do not reach far enough beyond `highest`, or are too few to yield
// `missing` further frequencies; false if all are enough.
bool grow(std::vector<int>& leaf_modes, const VectorXd& top, double highest, int missing,
          const FrequencyOptions& options) {
  bool grown = false;
  const int leaves = static_cast<int>(leaf_modes.size());
  for (int i = 0; i < leaves; ++i) {
    int& modes = leaf_modes[i];
    int wanted = modes;
    const double cutoff = options.cutoff_ratio * highest;
    // the number of plate modes below a frequency grows in proportion to it
    if (top[i] < cutoff)
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

std::optional<Frequencies> natural_frequencies(System& system, const FrequencyOptions& options) {
  Frequencies result;
  // Not the modes of the previous state: the answer would depend on the path.
  std::vector<int> leaf_modes(static_cast<std::size_t>(system.leaves()), options.leaf_modes);
  const std::vector<int> driven = system.driven_coordinates();
  const bool conditions = system.constraints().count() > 0;
  const auto unknowns = [&](const MechanismPencil& pencil) {  // drives held
    return conditions ? pencil.size - pencil.bodies + FreeMotions(system, true).count()
                      : pencil.size - static_cast<int>(driven.size() + system.held().size());
  };
  const auto by_krylov = [&](const MechanismPencil& pencil) {
    return system.analyses() || pencil.size >= krylov_from;
  };
  // drive free, where that is wanted, and held
  const auto pairs =
      [&](const MechanismPencil& pencil) -> std::optional<std::array<EigenPairs, 2>> {
    if (by_krylov(pencil)) {
      const int count = std::min(options.count, unknowns(pencil));
      const std::optional<EigenPairs> held = solve_by_krylov(system, pencil, true, count),
                                      free = options.free
                                                 ? solve_by_krylov(system, pencil, false, count)
                                                 : EigenPairs();
      if (held && free) return std::array{*free, *held};  // else all at once, however many
    }
    auto found = free_and_held_pairs(system, pencil, LeafModes(pencil),
                                     {options.free ? options.count : 0, options.count});
    if (!found) return std::nullopt;
    for (EigenPairs& list : *found) {
      const auto count = std::min<Eigen::Index>(options.count, list.values.size());
      list = {list.values.head(count).eval(), list.vectors.leftCols(count).eval()};
    }
    return found;
  };
  for (;;) {
    const MechanismPencil pencil = mechanism_pencil(system, leaf_modes, options);
    const auto found = pairs(pencil);
    if (!found) return std::nullopt;
    const auto& [free, locked] = *found;
    const Eigen::Index held = locked.values.size();  // none: nothing moves with the drives held
    const double highest = held > 0 ? hertz(std::max(0.0, locked.values[held - 1])) : 0;
    if (options.leaf_modes > 0 &&
        grow(leaf_modes, pencil.highest, highest, options.count - unknowns(pencil), options))
      continue;
    if (options.free)
      result.free = classify(pencil, system, free.values, free.vectors,
                             drive_shapes_of(pencil, system), options.motions);
    result.locked = classify(pencil, system, locked.values, locked.vectors,
                             MatrixXd(pencil.size, 0), options.motions);
    if (options.shapes) {
      for (int k = 0; k < static_cast<int>(result.free.size()); ++k)
        pencil.add_shape(free.vectors.col(k), result.free[k]);
      for (int k = 0; k < locked.values.size(); ++k)
        pencil.add_shape(locked.vectors.col(k), result.locked[k]);
    }
    result.check = pencil.check;
    return result;
  }
}

}  // namespace flexopt
