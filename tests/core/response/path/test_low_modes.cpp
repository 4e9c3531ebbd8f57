// Modes that series along the stroke begin with: all that are unstable, and no vectors that are
// none.
#include <algorithm>

#include "core/mechanism/profile.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/path/frequency_derivatives.hpp"

using namespace flexopt;

namespace {

/// A step of inverse iteration from every mode, over the mode, in the norm of M.
VectorXd changes(const MechanismFactor& factor, const LowModes& modes) {
  const MatrixXd change =
      factor.solve(factor.mass(modes.phi)) * modes.lambda.asDiagonal() - modes.phi;
  return change.cwiseProduct(factor.mass(change)).colwise().sum().cwiseSqrt();
}

}  // namespace

TEST_CASE("unstable modes that are larger than the lowest ones are among those found") {
  // a heavy body sways far below the leaf that it presses, which buckles in many ways
  const double L = 0.1, w = 0.01, t = 2e-4;
  Mechanism m = models::single_leaf(L, w, t);
  m.bodies = {models::body({L, 0, 0}, 10, 1e-2)};
  const double euler = std::pow(M_PI / L, 2) * 210e9 * w * std::pow(t, 3) / 12;
  for (const double times : {0.0, 10.0, 50.0, 200.0}) {
    const LoadCase loads{.constant = {{.force = {-times * euler, 0, 0}}}};
    System system(m, make_full_leaves(m, models::free_beams(20)), loads);
    REQUIRE(step_load(system, {.constant = 1}, {}).converged);
    const auto factor = MechanismFactor::of(system);
    REQUIRE(factor);
    const int unstable = negative_pivots(system, false);
    CHECK((unstable > 0) == (times > 0));
    const auto modes = low_modes(*factor, 2, false, nullptr);
    REQUIRE(modes);
    CAPTURE(times, unstable, modes->lambda.transpose());
    CHECK((modes->lambda.array() < 0).count() == unstable);
    CHECK(std::is_sorted(modes->lambda.begin(), modes->lambda.end()));
    CHECK(changes(*factor, *modes).maxCoeff() < 1e-6);
  }
}

TEST_CASE("of notches of a micrometre under heavy bodies every vector is a mode") {
  for (const double size : {1.0, 2.0, 4.0, 8.0}) {
    for (const double deep : {300.0, 3e3, 3e4}) {
      Mechanism m = models::single_leaf(2.9e-4 * size, 1.9e-3 * size, 1.2e-6 * size);
      for (const double s : profile_stations())
        m.leaves[0].thickness_profile.push_back(1 + deep * (s - 0.5) * (s - 0.5));
      m.bodies = {models::body({2.9e-4 * size, 0, 0}, 1.2e-4 * std::pow(size, 3),
                               1e-12 * std::pow(size, 5))};
      System system(m, make_full_leaves(m, {.flexure = Flexure::beam, .mesh = {3, 2}}), {});
      system.assemble();
      const auto factor = MechanismFactor::of(system);
      REQUIRE(factor);
      const auto modes = low_modes(*factor, 4, false, nullptr);
      REQUIRE(modes);
      CAPTURE(size, deep, modes->lambda.transpose());
      CHECK(modes->kept == 4);
      CHECK(changes(*factor, *modes).maxCoeff() < 1e-6);
    }
  }
}
