#include "core/response/modes/frequencies.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <utility>

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
  const TangentFactor factor(system, drive_locked);
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

// The lowest pairs of an unsymmetric tangent (Q14), of the real eigenvalues as of others. Those of
// a pair of complex ones are the real and the imaginary part of its motion, both with −(Re ω)²; it
// grows by `growth`. Nothing for a system that is solved sparse.
std::optional<EigenPairs> unsymmetric_pairs(const System& system, const MechanismPencil& pencil,
                                            bool drive_locked, int count, VectorXd& growth) {
  constexpr double real = 1e-7, massless = 1e-13;
  if (system.analyses()) return std::nullopt;
  const MatrixXd Z = FreeMotions(system, drive_locked).basis();
  const Eigen::Index free = Z.cols(), inside = pencil.size - pencil.bodies, n = free + inside;
  MatrixXd T = MatrixXd::Zero(pencil.size, n), K = MatrixXd::Zero(n, n);
  T.topLeftCorner(pencil.bodies, free) = Z;
  T.bottomRightCorner(inside, inside).setIdentity();
  K.topLeftCorner(free, free) = Z.transpose() * (pencil.K_bodies * Z);
  for (const MechanismPencil::Leaf& leaf : pencil.leaves) {
    if (leaf.modes == 0) continue;
    const Eigen::Index at = free + leaf.first() - pencil.bodies;
    K.block(at, at, leaf.modes, leaf.modes) = leaf.stiffness;
  }
  const VectorXd scale = K.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd S = T * scale.asDiagonal(), M = S.transpose() * pencil.mass_times(S);
  const GeneralEigen found =
      general_eigen(Lu(scale.asDiagonal() * K * scale.asDiagonal()).solve(M));
  struct Pair {
    double value, growth;
    VectorXd vector;
  };
  std::vector<Pair> all;
  const double largest = n > 0 ? found.values.cwiseAbs().maxCoeff() : 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const std::complex<double> inverse = found.values[k], omega = std::sqrt(1.0 / inverse);
    if (std::abs(inverse) <= massless * largest) continue;
    const auto add = [&](double value, double rate, const VectorXd& v) {
      const double mass = v.dot(M * v);
      all.push_back({value, rate, S * v / std::sqrt(mass)});
    };
    if (std::abs(inverse.imag()) <= real * std::abs(inverse)) {
      add(1 / inverse.real(), 0, found.vectors.col(k).real());
    } else {
      const VectorXd part = inverse.imag() > 0 ? VectorXd(found.vectors.col(k).real())
                                               : VectorXd(found.vectors.col(k).imag());
      add(-omega.real() * omega.real(), std::abs(omega.imag()), part);
    }
  }
  std::ranges::stable_sort(all, {}, &Pair::value);
  all.resize(std::min(all.size(), static_cast<std::size_t>(count)));
  EigenPairs pairs{VectorXd(all.size()), MatrixXd(pencil.size, all.size())};
  growth.resize(all.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    pairs.values[at] = all[k].value;
    pairs.vectors.col(at) = all[k].vector;
    growth[at] = all[k].growth;
  }
  return pairs;
}

// Motion of the corners at the surface of each elastic body, for drawing. Interfaces that have
// turned in the body's frame turn its fields with them to first order alone.
void add_elastic_motion(const System& system, const MechanismPencil& pencil, int frequencies,
                        const VectorXd& phi, Mode& mode) {
  const ElasticBodies& elastic = system.elastic_bodies();
  for (int k = 0; k < elastic.count(); ++k) {
    const CondensedSolid& solid = elastic.solid(k);
    const SolidSurface& surface = solid.surface;
    const VectorXd d = motions_in_frame<double>(
        elastic.held(k), holder_rows<double>(elastic.body(k), phi.head(pencil.bodies)));
    VectorXd q;
    if (pencil.leaves.size() > static_cast<std::size_t>(system.leaves())) {
      const MechanismPencil::Leaf& inside =
          pencil.leaves[static_cast<std::size_t>(system.leaves() + k)];
      q = phi.segment(inside.first(), inside.modes);
    }
    const auto modes = q.size() > 0 ? elastic.modes(k, frequencies) : nullptr;
    VectorXd& motion = mode.elastic_motion.emplace_back(3 * surface.corners.size());
    for (std::size_t c = 0; c < surface.corners.size(); ++c) {
      const int row = 3 * surface.nodes[surface.corners[c]];
      Vector3d u = solid.fields.middleRows<3>(row) * d;
      if (modes) u += modes->shapes.middleRows<3>(row) * q;
      motion.segment<3>(3 * static_cast<Eigen::Index>(c)) = elastic.held(k).floating.frame.axes * u;
    }
  }
}

// Modes of the lists: of those with the drive free `shapes` are the static motions of the bodies
// under the drive loads.
std::vector<Mode> classify(const MechanismPencil& pencil, const System& system,
                           const EigenPairs& pairs, MatrixXd shapes,
                           const FrequencyOptions& options) {
  if (pairs.values.size() == 0) return {};
  const LinearMap mass = [&](const MatrixXd& B) { return pencil.mass_times(B); };
  const MatrixXd& phi = pairs.vectors;
  std::vector<Mode> modes =
      classified_modes(system.mechanism(), pairs.values, phi, mass(phi), std::move(shapes), mass,
                       [](const MatrixXd& B) { return B; });
  const MatrixXd motions = options.motions ? pencil.motions(system, phi) : MatrixXd();
  for (Eigen::Index k = 0; k < phi.cols(); ++k) {
    if (options.motions) modes[k].motion = motions.col(k);
    if (!options.shapes) continue;
    pencil.add_shape(system, phi.col(k), modes[k]);
    add_elastic_motion(system, pencil, options.count, phi.col(k), modes[k]);
  }
  return modes;
}

MatrixXd drive_shapes_of(const MechanismPencil& pencil, const System& system) {
  const MatrixXd forces = system.drive_forces(DriveHold::named);
  MatrixXd shapes = MatrixXd::Zero(pencil.size, forces.cols());
  if (forces.cols() > 0)
    shapes.topRows(pencil.bodies) = TangentFactor(system, false).answer(forces);
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
  std::vector<MatrixXd> parts;
  const ElasticBodies& elastic = system.elastic_bodies();
  for (int k = 0; k < elastic.count(); ++k) {
    const SymmetricEigen mass(elastic.model(k).mass);
    const VectorXd root = mass.eigenvalues().cwiseMax(0).cwiseSqrt();
    parts.push_back(root.asDiagonal() * mass.eigenvectors().transpose() *
                    motions_in_frame(elastic.held(k), holder_rows<double>(elastic.body(k), q)));
  }
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
  parts.insert(parts.begin(), std::move(motions));
  return stacked(parts);
}

std::optional<Frequencies> natural_frequencies(System& system, const FrequencyOptions& options) {
  Frequencies result;
  // Not the modes of the previous state: the answer would depend on the path.
  std::vector<int> leaf_modes(static_cast<std::size_t>(system.leaves()), options.leaf_modes);
  const int of_bodies = FreeMotions(system, true).count();
  const auto unknowns = [&](const MechanismPencil& pencil) {  // drives held
    return pencil.size - pencil.bodies + of_bodies;
  };
  std::array<VectorXd, 2> growth;
  // drive free, where that is wanted, and held
  const auto pairs =
      [&](const MechanismPencil& pencil) -> std::optional<std::array<EigenPairs, 2>> {
    if (system.follows()) {
      const auto free = unsymmetric_pairs(system, pencil, false, options.count, growth[0]),
                 held = unsymmetric_pairs(system, pencil, true, options.count, growth[1]);
      if (!free || !held) return std::nullopt;
      return std::array{*free, *held};
    }
    if (system.analyses() || pencil.size >= krylov_from) {
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
      result.free = classify(pencil, system, free, drive_shapes_of(pencil, system), options);
    result.locked = classify(pencil, system, locked, MatrixXd(pencil.size, 0), options);
    for (const auto& [list, rates] :
         {std::pair{&result.free, &growth[0]}, {&result.locked, &growth[1]}})
      for (Eigen::Index k = 0; k < rates->size() && k < std::ssize(*list); ++k)
        (*list)[k].growth_rate = (*rates)[k];
    result.check = pencil.check;
    return result;
  }
}

}  // namespace flexopt
