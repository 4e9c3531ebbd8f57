#include "core/response/modes/full_modes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "core/response/modes/frequencies.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

System system_of(const Mechanism& m, int elements) {
  ModelOptions model{.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {elements, 1}};
  return System(m, make_full_leaves(m, model));
}

/// All squared frequencies below `highest`, from dense matrices of the whole mechanism.
std::vector<double> assembled(const MechanismFactor& factor, bool locked, double highest) {
  const MatrixXd unit = MatrixXd::Identity(factor.size(), factor.size());
  const MatrixXd A =
      locked ? factor.solve_locked(factor.mass(unit)) : factor.solve(factor.mass(unit));
  const Eigen::EigenSolver<MatrixXd> eigen(A, false);
  std::vector<double> lambda;
  for (Eigen::Index k = 0; k < A.rows(); ++k)
    if (const double theta = eigen.eigenvalues()[k].real(); theta > 1 / highest)
      lambda.push_back(1 / theta);
  std::sort(lambda.begin(), lambda.end());
  return lambda;
}

}  // namespace

TEST_CASE("both lists of modes are those of the dense matrices, bent far too") {
  for (const bool guide : {true, false}) {
    Mechanism m = guide ? models::guide(0.1, 0.03, 5e-4) : models::single_leaf(0.08, 0.02, 3e-4);
    m.bodies[0].mass = 0.05;
    m.bodies[0].inertia = Vector3d(1e-5, 2e-5, 3e-5).asDiagonal();
    System system = system_of(m, 6);
    for (const double stroke : {0.0, 0.02}) {
      REQUIRE(step_to(system, stroke, {}).converged);
      const auto linear = MechanismFactor::of(system);
      REQUIRE(linear);
      const MechanismFactor& factor = *linear;
      const auto found = full_modes(factor, 7, 5);
      REQUIRE(found);
      for (const bool locked : {true, false}) {
        const FullModes& list = locked ? found->locked : found->free;
        const int count = locked ? 5 : 7;
        REQUIRE(static_cast<int>(list.modes.size()) == count);
        const std::vector<double> expected = assembled(factor, locked, 2 * list.lambda[count - 1]);
        const MatrixXd M_phi = factor.mass(list.phi);
        for (int k = 0; k < count; ++k) {
          INFO("guide " << guide << ", stroke " << stroke << ", locked " << locked << ", mode "
                        << k);
          CHECK(list.lambda[k] == Approx(expected[static_cast<std::size_t>(k)]).epsilon(1e-8));
          CHECK(list.modes[static_cast<std::size_t>(k)].frequency ==
                Approx(std::sqrt(list.lambda[k]) / (2 * M_PI)));
          // vectors, not only values: K⁻¹ M φ λ is φ again
          const VectorXd b = list.lambda[k] * M_phi.col(k),
                         again = locked ? factor.solve_locked(b) : factor.solve(b),
                         off = again - list.phi.col(k);
          CHECK(std::sqrt(std::abs(off.dot(factor.mass(off).col(0)))) < 1e-9);
          if (locked) {
            const VectorXd of_bodies = list.phi.col(k).head(factor.bodies());
            CHECK(std::abs(factor.system().drive_forces().col(0).dot(of_bodies)) <
                  1e-12 * of_bodies.norm());
          }
        }
        const MatrixXd G = list.phi.transpose() * M_phi;
        CHECK((G - MatrixXd::Identity(G.rows(), G.cols())).norm() < 1e-9);
      }
    }
  }
}

TEST_CASE("a coarse mesh has no more modes than unknowns") {
  const Mechanism m = models::single_leaf(0.08, 0.02, 3e-4);
  System system = system_of(m, 2);
  system.assemble();
  const auto linear = MechanismFactor::of(system);
  REQUIRE(linear);
  const MechanismFactor& factor = *linear;
  const auto found = full_modes(factor, factor.size() + 20, factor.size() + 20);
  REQUIRE(found);
  CHECK(found->free.modes.size() > 6);
  CHECK(static_cast<int>(found->free.modes.size()) <= factor.size());
  CHECK(static_cast<int>(found->locked.modes.size()) < factor.size());
  for (const Mode& mode : found->free.modes) CHECK(std::isfinite(mode.frequency));
}

TEST_CASE("frequencies by condensed leaves are next to those of all unknowns, and no lower") {
  // hardly bent: what static shapes have beside the modes is 1e-5 of them
  Mechanism m = models::three_leaf_hinge(0.025, 0.005, 3.2e-5);
  m.bodies[0] = models::body({0, 0, 0}, 1.2e-3, 7e-8);
  for (LeafSpring& leaf : m.leaves)  // crossing a quarter of the way along
    leaf.origin += 0.25 * leaf.length * leaf.axes.col(0);
  const ModelOptions model{.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {2, 3}};
  for (const double force : {0.0, 1e-6, 1e-4, 3e-4}) {
    LoadCase loads{.constant = {{.force = force * Vector3d(0.2, -0.8, 1)}}};
    System system(m, make_full_leaves(m, model), loads);
    REQUIRE(step_load(system, {.constant = 1}, {}).converged);
    const auto linear = MechanismFactor::of(system);
    REQUIRE(linear);
    const auto full = full_modes(*linear, 0, 4);
    REQUIRE(full);
    for (const int leaf_modes : {1, 2, 3}) {
      const Frequencies condensed =
          natural_frequencies(system, {.count = 4, .free = false, .leaf_modes = leaf_modes})
              .value();
      for (std::size_t k = 0; k < 4; ++k) {
        const double all = full->locked.modes[k].frequency,
                     excess = condensed.locked[k].frequency / all - 1;
        CAPTURE(force, leaf_modes, k);
        CHECK(excess > -1e-9);
        CHECK(excess < 1e-5);
      }
    }
  }
}
