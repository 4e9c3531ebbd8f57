#include "core/response/modes/frequencies.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
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
    const MatrixXd shapes = q.size() > 0 ? elastic.modes(k, frequencies)->shapes : MatrixXd();
    VectorXd& motion = mode.elastic_motion.emplace_back(3 * surface.corners.size());
    for (std::size_t c = 0; c < surface.corners.size(); ++c) {
      const int row = 3 * surface.nodes[surface.corners[c]];
      Vector3d u = solid.fields.middleRows<3>(row) * d;
      if (q.size() > 0) u += shapes.middleRows<3>(row) * q;
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
  const MatrixXd forces = system.drive_forces();
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
  // drive free, where that is wanted, and held
  const auto pairs =
      [&](const MechanismPencil& pencil) -> std::optional<std::array<EigenPairs, 2>> {
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
    result.check = pencil.check;
    return result;
  }
}

}  // namespace flexopt
