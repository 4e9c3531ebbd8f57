#include "core/response/modes/full_modes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "core/equilibrium/stroke_path.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/lanczos.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/modes/mechanism_pencil.hpp"

namespace flexopt {
namespace {

// Modes beyond those asked for: whole clusters of equal ones, and separation from what is left out.
constexpr int guards = 4;
// Relative residual of the Ritz pairs that is sought, and that is accepted where rounding prevents
// the former.
constexpr double tolerance = 1e-9, tolerance_of_rounding = 1e-6;

// The drives' static shapes C of unit strokes: K⁻¹ = K_l⁻¹ + C D Cᵀ, l with the drives held.
struct DriveShapes {
  MatrixXd shapes, mass;  ///< C, M C
  MatrixXd compliance;    ///< D
};

// Ritz pairs X = V of_V + C of_C of one list in the Krylov space, values θ = 1/λ.
struct RitzPairs {
  VectorXd values;
  MatrixXd of_V;
  MatrixXd of_C;        ///< empty where the drives are held
  int wanted = 0;       ///< so many are asked for
  double residual = 0;  ///< largest of these, relative
};

std::vector<int> counted(Eigen::Index size) {
  std::vector<int> indices(static_cast<std::size_t>(size));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

// Indices of θ = 1/λ by falling magnitude.
std::vector<int> by_magnitude(const VectorXd& theta) {
  std::vector<int> order = counted(theta.size());
  std::ranges::stable_sort(order, std::greater(), [&](int k) { return std::abs(theta[k]); });
  return order;
}

// Takes the residual of the first `count` pairs, whose λ ascend, and leaves all by falling |θ|.
void complete(const BlockKrylov& krylov, int count, RitzPairs& pairs) {
  pairs.wanted = count;
  const MatrixXd& B = krylov.rest();
  const VectorXd size = (B * pairs.of_V.bottomRows(B.cols())).colwise().norm();
  for (int k = 0; k < std::min<int>(count, size.size()); ++k)
    pairs.residual = std::max(pairs.residual, size[k] / std::abs(pairs.values[k]));
  const std::vector<int> order = by_magnitude(pairs.values);
  pairs.values = pairs.values(order).eval();
  pairs.of_V = pairs.of_V(Eigen::all, order).eval();
  if (pairs.of_C.size() > 0) pairs.of_C = pairs.of_C(Eigen::all, order).eval();
}

// Convergence of a list by the residuals of one decomposition after the other.
struct Convergence {
  double previous = 1;
  bool reached(double residual, bool held_up) {
    held_up = held_up || residual > 0.3 * previous;
    previous = residual;
    return residual <= tolerance || (held_up && residual <= tolerance_of_rounding);
  }
};

// The pairs of the lowest λ = 1/θ, ascending: negative θ come first, the smallest ones at the head.
// Ritz values have no more of them than K has negative eigenvalues.
LargestPairs lowest_of(const MatrixXd& T, int count) {
  constexpr double rounding = 1e-13;  // of the largest θ
  LargestPairs all = largest_pairs(T, static_cast<int>(T.rows()));
  const double least = all.values.size() > 0 ? rounding * std::abs(all.values[0]) : 0;
  std::vector<int> order = counted(all.values.size());
  const auto others =
      std::ranges::stable_partition(order, [&](int k) { return all.values[k] < -least; });
  std::reverse(order.begin(), others.begin());
  order.resize(std::min<std::size_t>(order.size(), static_cast<std::size_t>(count)));
  return {all.values(order), all.vectors(Eigen::all, order)};
}

RitzPairs locked_pairs(const BlockKrylov& krylov, int count) {
  LargestPairs largest = lowest_of(krylov.T(), count + guards);
  RitzPairs pairs{std::move(largest.values), std::move(largest.vectors), {}};
  complete(krylov, count, pairs);
  return pairs;
}

// Ritz pairs with the drives free, in the basis [V, Ĉ], Ĉ = (C − V W) P, W = VᵀM C, PᵀS P = 1 with
// S = CᵀM C − WᵀW; K_l⁻¹M C, given, is in V. What of C has no mass beside V, as of a drive that
// moves a body without mass, is left out: there S is rounding.
RitzPairs free_pairs(const BlockKrylov& krylov, const DriveShapes& drive, const MatrixXd& inertial,
                     int count) {
  constexpr double in_V = 1e-12;  // of a drive's mass
  const int k = krylov.columns();
  const MatrixXd T = krylov.T();
  if (drive.shapes.cols() == 0) return locked_pairs(krylov, count);
  const MatrixXd W = krylov.V().transpose() * drive.mass, G = krylov.MV().transpose() * inertial,
                 TW = T * W, whole = drive.shapes.transpose() * drive.mass;
  const VectorXd unit = whole.diagonal().cwiseMax(0).cwiseSqrt(),
                 by = unit.unaryExpr([](double u) { return u > 0 ? 1 / u : 0.0; });
  const SymmetricEigen beside(by.asDiagonal() * (whole - W.transpose() * W) * by.asDiagonal());
  const auto d = (beside.eigenvalues().array() > in_V).count();  // the last of the ascending ones
  const VectorXd size = beside.eigenvalues().tail(d).cwiseSqrt();
  const MatrixXd Q = beside.eigenvectors().rightCols(d),
                 P = by.asDiagonal() * Q * size.cwiseInverse().asDiagonal(),
                 SP = unit.asDiagonal() * Q * size.asDiagonal(), WD = W * drive.compliance;
  MatrixXd F(k + d, k + d);
  F.topLeftCorner(k, k) = T + WD * W.transpose();
  F.topRightCorner(k, d) = (G - TW) * P + WD * SP;
  F.bottomLeftCorner(d, k) = F.topRightCorner(k, d).transpose();
  const MatrixXd inner = drive.mass.transpose() * inertial - W.transpose() * G - G.transpose() * W +
                         W.transpose() * TW;
  F.bottomRightCorner(d, d) = P.transpose() * inner * P + SP.transpose() * drive.compliance * SP;
  LargestPairs largest = lowest_of(F, count + guards);
  RitzPairs pairs{std::move(largest.values), {}, P * largest.vectors.bottomRows(d)};
  pairs.of_V = largest.vectors.topRows(k) - W * pairs.of_C;
  complete(krylov, count, pairs);
  return pairs;
}

// Rayleigh–Ritz step on the columns of Y, whose |λ| ascend: the lower triangle of YᵀK Y then is the
// accurate one.
FullModes rayleigh_ritz(const MechanismFactor& factor, bool drive_locked, int count,
                        const Eigen::Ref<const MatrixXd>& Y, const Eigen::Ref<const MatrixXd>& MY,
                        const Eigen::Ref<const MatrixXd>& KY, ModeMotions motions) {
  if (Y.cols() == 0) return {0, {}, Y, {}, false};  // nothing moves
  const MatrixXd G = Y.transpose() * MY, A = Y.transpose() * KY;
  const SymmetricEigen ritz(A, G);
  const MatrixXd& Z = ritz.eigenvectors();
  count = std::min(count, static_cast<int>(Y.cols()));  // a coarse mesh has no more
  // the solver knows the values to the rounding of the largest; quotients know each to its own
  const VectorXd lambda = Z.cwiseProduct(A.selfadjointView<Eigen::Lower>() * Z)
                              .colwise()
                              .sum()
                              .cwiseQuotient(Z.cwiseProduct(G * Z).colwise().sum())
                              .transpose();
  std::vector<int> order = counted(lambda.size());
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return lambda[a] < lambda[b]; });
  const MatrixXd S = Z(Eigen::all, order);
  FullModes found{count, lambda(order), Y * S, {}, false};
  found.modes = classified_modes(factor, drive_locked, found.lambda.head(count),
                                 found.phi.leftCols(count), MY * S.leftCols(count), motions);
  return found;
}

// Lists of modes by list(drive_locked, count).
template <class List>
FullModeLists both_lists(const List& list, int free, int locked) {
  FullModeLists found;
  if (free > 0) found.free = list(false, free);
  if (locked > 0) found.locked = list(true, locked);
  return found;
}

// Number of motions with mass from which the lowest modes alone are computed.
constexpr int few_motions = 48;

// R of M = R Rᵀ, a column for each motion that has mass. Nothing where there are many of these, or
// where they are not independent.
std::optional<MatrixXd> root_of_mass(const MechanismFactor& factor) {
  if (factor.size() > 2 * few_motions) return std::nullopt;
  const MatrixXd M = factor.mass(MatrixXd::Identity(factor.size(), factor.size()));
  std::vector<int> moving;
  for (int i = 0; i < factor.size(); ++i)
    if (M(i, i) > 0) moving.push_back(i);
  if (moving.size() >= few_motions) return std::nullopt;
  const MatrixXd of_moving = M(moving, moving);
  const VectorXd unit = of_moving.diagonal().cwiseSqrt();
  const Cholesky root(unit.cwiseInverse().asDiagonal() * of_moving *
                      unit.cwiseInverse().asDiagonal());
  if (!root.positive_definite()) return std::nullopt;
  MatrixXd R = MatrixXd::Zero(factor.size(), moving.size());
  R(moving, Eigen::all) = unit.asDiagonal() * root.lower();
  return R;
}

// Modes by a root of the mass: Rᵀ K⁻¹ R z = z/λ, and one step of inverse iteration.
FullModeLists modes_of_root(const MechanismFactor& factor, const MatrixXd& R, int free, int locked,
                            ModeMotions motions) {
  constexpr double nothing = 1e-13;  // of the largest: motions that are held
  const auto [shapes, compliance] = factor.free_drives();
  const MatrixXd X = factor.solve_locked(R), along = R.transpose() * shapes,
                 held = R.transpose() * X;
  const auto list = [&](bool drive_locked, int count) {
    MatrixXd C = held;
    if (!drive_locked) C += along * compliance * along.transpose();
    LargestPairs pairs = lowest_of(0.5 * (C + C.transpose()), count + guards);
    const std::vector<int> order = by_magnitude(pairs.values);
    pairs = {pairs.values(order).eval(), pairs.vectors(Eigen::all, order).eval()};
    Eigen::Index found = 0;
    while (found < pairs.values.size() &&
           std::abs(pairs.values[found]) > nothing * std::abs(pairs.values[0]))
      ++found;
    const MatrixXd Z =
        pairs.vectors.leftCols(found) * pairs.values.head(found).cwiseInverse().asDiagonal();
    MatrixXd Y = X * Z;
    if (!drive_locked) {
      Y += shapes * (compliance * (along.transpose() * Z));
      for (const int row : factor.drive_rows()) Y.row(row).setZero();
    }
    return rayleigh_ritz(factor, drive_locked, count, Y, factor.mass(Y), R * Z, motions);
  };
  return both_lists(list, free, locked);
}

bool has_negative(const RitzPairs& pairs, int count) {
  return (pairs.values.array() < 0).count() >= std::min<Eigen::Index>(count, pairs.values.size());
}

// One step of inverse iteration from the Ritz pairs of both lists. Its columns are of equal size,
// for small modes are rounded beside large ones.
FullModeLists iterated_modes(const MechanismFactor& factor, const BlockKrylov& krylov,
                             const DriveShapes& drive, const RitzPairs& of_free,
                             const RitzPairs& of_locked, ModeMotions motions) {
  const auto f = of_free.values.size(), l = of_locked.values.size();
  MatrixXd KY(factor.size(), f + l);
  const auto times_lambda = [](const MatrixXd& coefficients, const RitzPairs& pairs) {
    return MatrixXd(coefficients * pairs.values.cwiseInverse().asDiagonal());
  };
  if (f > 0) {
    KY.leftCols(f).noalias() = krylov.MV() * times_lambda(of_free.of_V, of_free);
    if (of_free.of_C.size() > 0)
      KY.leftCols(f).noalias() += drive.mass * times_lambda(of_free.of_C, of_free);
  }
  if (l > 0) KY.rightCols(l).noalias() = krylov.MV() * times_lambda(of_locked.of_V, of_locked);
  MatrixXd Y = factor.solve_locked(KY);
  if (drive.shapes.cols() > 0) {
    const MatrixXd along = drive.compliance * (drive.shapes.transpose() * KY.leftCols(f));
    Y.leftCols(f).noalias() += drive.shapes * along;
    for (const int row : factor.drive_rows()) Y.row(row).head(f).setZero();
  }
  const MatrixXd MY = factor.mass(Y);
  FullModeLists found;
  if (of_free.wanted > 0)
    found.free = rayleigh_ritz(factor, false, of_free.wanted, Y.leftCols(f), MY.leftCols(f),
                               KY.leftCols(f), motions);
  if (of_locked.wanted > 0)
    found.locked = rayleigh_ritz(factor, true, of_locked.wanted, Y.rightCols(l), MY.rightCols(l),
                                 KY.rightCols(l), motions);
  return found;
}

// The lowest modes of both lists, from one Krylov space.
std::optional<FullModeLists> modes_of_krylov(const MechanismFactor& factor, int free, int locked,
                                             ModeMotions motions) {
  const LinearMap solve = factor.solver(true), mass = factor.masses();
  auto [shapes, compliance] = factor.free_drives();
  DriveShapes drive{std::move(shapes), {}, std::move(compliance)};
  drive.mass = factor.mass(drive.shapes);

  // equal leaves have equal modes: of those no more than are asked for
  const int width = std::min(std::max(4, static_cast<int>(factor.leaves().size())),
                             std::max(free, locked) + 2 * guards),
            most = std::min(factor.size(), 6 * (std::max(free, locked) + guards) + 20 * width + 40);
  MatrixXd start(factor.size(), width + drive.mass.cols());
  start.leftCols(width) = mass(start_columns(factor.size(), width));
  start.rightCols(drive.mass.cols()) = drive.mass;
  start = solve(start);
  const MatrixXd inertial = start.rightCols(drive.mass.cols());
  BlockKrylov krylov(start, most, solve, mass);
  const int negative_free = free > 0 ? negative_pivots(factor.system(), false) : 0,
            negative_locked = locked > 0 ? negative_pivots(factor.system(), true) : 0;
  RitzPairs of_free, of_locked;
  Convergence free_convergence, locked_convergence;
  for (int step = 1;; ++step) {
    const bool more = krylov.extend();
    // a decomposition costs about a solve: not at every step, nor of both lists before one is found
    if (more && (krylov.columns() < 2 * (std::max(free, locked) + guards) || step % 2 != 0))
      continue;
    bool found_all = true;
    if (locked > 0) {
      of_locked = locked_pairs(krylov, locked);
      found_all = locked_convergence.reached(of_locked.residual, !more) &&
                  has_negative(of_locked, negative_locked);
    }
    if (free > 0 && (found_all || !more)) {
      of_free = free_pairs(krylov, drive, inertial, free);
      const bool held_up = !more || of_locked.residual > tolerance;  // rounding is that of both
      found_all = free_convergence.reached(of_free.residual, held_up) &&
                  has_negative(of_free, negative_free) && found_all;
    }
    if (found_all || krylov.invariant()) break;
    if (!more) return std::nullopt;
  }
  return iterated_modes(factor, krylov, drive, of_free, of_locked, motions);
}

// The conditions bear what λ M φ − K φ leaves on the bodies, Ψᵀ μ; those of drives that are free
// bear nothing.
MatrixXd multipliers_of(const MechanismFactor& factor, const MechanismPencil& pencil,
                        bool drive_locked, const EigenPairs& pairs) {
  const Constraints& c = factor.system().constraints();
  MatrixXd multipliers = MatrixXd::Zero(c.count(), pairs.vectors.cols());
  const std::vector<int> bearing = factor.system().holding_conditions(drive_locked);
  if (bearing.empty()) return multipliers;
  const VectorXd& unit = factor.system().units();
  const MatrixXd left =
      pencil.mass_times(pairs.vectors).topRows(pencil.bodies) * pairs.values.asDiagonal() -
      pencil.K_bodies * MatrixXd(pairs.vectors.topRows(pencil.bodies));
  multipliers(bearing, Eigen::all) = least_squares(
      unit.asDiagonal() * c.gradient()(bearing, Eigen::all).transpose(), unit.asDiagonal() * left);
  return multipliers;
}

// Modes of a mechanism whose leaves know their internal motions; nothing for other leaves and for
// large mechanisms.
std::optional<FullModeLists> modes_of_border(const MechanismFactor& factor, int free, int locked,
                                             ModeMotions motions) {
  const System& system = factor.system();
  if (system.analyses()) return std::nullopt;
  const std::optional<InternalPencil> internal = internal_pencil(factor);
  if (!internal || internal->pencil.size >= krylov_from) return std::nullopt;
  const MechanismPencil& pencil = internal->pencil;
  const auto found_pairs = free_and_held_pairs(system, pencil, LeafModes(pencil), {free, locked});
  if (!found_pairs) return std::nullopt;
  const auto list = [&](bool drive_locked, int count) {
    const EigenPairs& pairs = (*found_pairs)[drive_locked ? 1 : 0];
    FullModes found;
    found.converged = std::min(count, static_cast<int>(pairs.values.size()));
    found.lambda = pairs.values;
    found.phi = factor.static_motion(pairs.vectors.topRows(pencil.bodies));
    for (std::size_t i = 0; i < pencil.leaves.size(); ++i) {
      const MatrixXd& unknowns = internal->unknowns[i];
      found.phi.middleRows(internal->offsets[i], unknowns.rows()).noalias() +=
          unknowns * pairs.vectors.middleRows(pencil.leaves[i].first(), unknowns.cols());
    }
    found.phi.bottomRows(factor.conditions()) = multipliers_of(factor, pencil, drive_locked, pairs);
    const MatrixXd listed = found.phi.leftCols(found.converged);
    found.modes = classified_modes(factor, drive_locked, found.lambda.head(found.converged), listed,
                                   factor.mass(listed), motions);
    return found;
  };
  return both_lists(list, free, locked);
}

}  // namespace

std::optional<FullModeLists> full_modes(const MechanismFactor& factor, int free, int locked,
                                        ModeMotions motions) {
  if (free == 0 && locked == 0) return FullModeLists();
  if (std::optional<FullModeLists> lists = modes_of_border(factor, free, locked, motions))
    return lists;
  if (const std::optional<MatrixXd> R = root_of_mass(factor))
    return modes_of_root(factor, *R, free, locked, motions);
  return modes_of_krylov(factor, free, locked, motions);
}

// Uses M̂ = R Rᵀ, the mass carried by the bodies: Rᵀ K⁻¹ R z = z/λ and q = K⁻¹ R z.
FullModeLists static_modes(const MechanismFactor& factor, int free, int locked) {
  if (free == 0 && locked == 0) return {};
  constexpr double nothing = 1e-14;  // of the largest: motions that have no mass, or are held
  const int bodies = factor.bodies();
  const MatrixXd follow = factor.static_motion(MatrixXd::Identity(bodies, bodies));
  MatrixXd M = factor.condensed(factor.mass(follow)).topRows(bodies);
  const VectorXd unit =
      M.diagonal().cwiseMax(nothing * M.diagonal().maxCoeff()).cwiseSqrt().cwiseInverse();
  M = (unit.asDiagonal() * (0.5 * (M + M.transpose())) * unit.asDiagonal()).eval();
  const SymmetricEigen mass(M);
  MatrixXd R = MatrixXd::Zero(factor.size(), bodies);
  R.topRows(bodies) = unit.cwiseInverse().asDiagonal() * mass.eigenvectors() *
                      mass.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  FullModeLists lists = modes_of_root(factor, R, free, locked, ModeMotions::yes);
  lists.free.static_shapes = lists.locked.static_shapes = true;
  return lists;
}

}  // namespace flexopt
