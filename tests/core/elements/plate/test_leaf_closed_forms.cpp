// Full leaves against closed forms: elastica, strips, plates, torsion.
#include "elastica.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

System full_system(const Mechanism& m, std::array<int, 2> mesh, bool edge_term = true,
                   LoadCase loads = {}) {
  const ModelOptions options{
      .accuracy = Accuracy::full, .mesh = mesh, .free_edge_torsion = edge_term};
  return System(m, make_full_leaves(m, options), std::move(loads));
}

using models::without_poisson;

/// A guide without Poisson's effect.
Mechanism strips(double length, double width, double thickness, double mass, double inertia) {
  Mechanism m = models::guide(length, width, thickness, 0.06, mass, inertia);
  for (LeafSpring& leaf : m.leaves) leaf.material = without_poisson();
  return m;
}

}  // namespace

TEST_CASE("a narrow leaf without Poisson effect follows the elastica to PL²/EI = 10") {
  const Material m = without_poisson();
  const double L = 0.1, w = 1e-3, t = 1e-4;
  const Mechanism mechanism = models::single_leaf(L, w, t, Direction::rx, m);
  const double EI = m.youngs_modulus * w * t * t * t / 12;
  System system =
      full_system(mechanism, {32, 1}, false, {.constant = {{.force = {0, EI / (L * L), 0}}}});
  check_elastica(system, L, 1e-4);
}

TEST_CASE("an end moment bends a narrow leaf to a circle") {
  const Material m = without_poisson();
  const double L = 0.1, w = 1e-3, t = 1e-4;
  const Mechanism mechanism = models::single_leaf(L, w, t, Direction::rz, m);
  System system = full_system(mechanism, {24, 1}, false);
  const double EI = m.youngs_modulus * w * t * t * t / 12;
  for (const double angle : {0.3, 0.8, 1.4}) {
    const Equilibrium e = step_to(system, angle, {});
    REQUIRE(e.converged);
    CHECK(e.drive_load == Approx(EI * angle / L).epsilon(2e-4));
    const Vector3d p = system.pose(0).position;
    CHECK(std::abs(p[0] / L - std::sin(angle) / angle) < 1e-4);
    CHECK(std::abs(p[1] / L - (1 - std::cos(angle)) / angle) < 1e-4);
  }
}

TEST_CASE("a free strip in torsion has the solid's constant: G (b t³/3 − 0.21 t⁴)") {
  // A long narrow strip; warping is restrained at its ends only, which the difference of two
  // lengths takes out.
  const double w = 0.01, t = 5e-4;
  const Material m = models::steel();
  const double G = m.shear_modulus();
  for (const bool edge_term : {true, false}) {
    double flexibility[2];
    const double lengths[2] = {0.15, 0.3};
    for (int k = 0; k < 2; ++k) {
      const Mechanism mechanism = models::single_leaf(lengths[k], w, t, Direction::rx);
      System system = full_system(mechanism, {k == 0 ? 20 : 40, 4}, edge_term);
      const Equilibrium e = step_to(system, 1e-6, {});
      REQUIRE(e.converged);
      flexibility[k] = 1e-6 / e.drive_load;
    }
    const double GJ = (lengths[1] - lengths[0]) / (flexibility[1] - flexibility[0]);
    const double J = w * t * t * t / 3 - (edge_term ? 0.21 * t * t * t * t : 0);
    CHECK(GJ == Approx(G * J).epsilon(1e-3));
  }
}

TEST_CASE("a guide has the closed-form stiffness, shortening and axial compliance") {
  const Material m = without_poisson();
  const double L = 0.1, w = 4e-3, t = 5e-4, x = 5e-3;
  const StrokeResponse r =
      test::evaluated(strips(L, w, t, 0.5, 4e-4), {.accuracy = Accuracy::full, .mesh = {16, 2}},
                      {.points = {0, x}});
  const double EI = m.youngs_modulus * w * t * t * t / 12, EA = m.youngs_modulus * w * t;
  const double shear = 12 * EI / (5.0 / 6 * m.shear_modulus() * w * t * L * L);
  CHECK(r.path[0].drive_stiffness == Approx(24 * EI / (L * L * L) / (1 + shear)).epsilon(1e-4));
  CHECK(*r.path[0].support_stiffness[0] == Approx(2 * EA / L).epsilon(1e-4));
  // Awtar's beam constraint model: shortening 0.6 x²/L, drive-locked collapse x² L/700 …
  CHECK(-r.path[1].displacement[0] == Approx(0.6 * x * x / L).epsilon(2e-3));
  const double d = x / L;
  CHECK(*r.path[1].support_stiffness[0] ==
        Approx(2 / (L / EA + d * d * L * L * L / 700 / EI)).epsilon(5e-3));
  // clamped–guided leaf: σ = 3 E t x / L²
  CHECK(r.path[1].max_stress->value ==
        Approx(3 * m.youngs_modulus * t * x / (L * L)).epsilon(0.02));
}

TEST_CASE("a leaf between two clamps vibrates like the clamped strip") {
  // Local leaf mode (22.373/2π L²) √(E t²/12ρ), seen as the lowest locked mode of a heavy guide.
  const Material m = without_poisson();
  const StrokeResponse r =
      test::evaluated(strips(0.1, 5e-3, 5e-4, 1e6, 1e6),
                      {.accuracy = Accuracy::full, .mesh = {16, 2}}, {.frequencies = 10});
  const double expected =
      22.3733 / (2 * M_PI * 0.01) * std::sqrt(m.youngs_modulus * 25e-8 / 12 / m.density);
  int found = 0;
  for (const Mode& mode : r.path[0].modes_locked)
    if (mode.kind == ModeKind::leaf && std::abs(mode.frequency / expected - 1) < 2e-3) ++found;
  CHECK(found == 2);  // one for each leaf
}
