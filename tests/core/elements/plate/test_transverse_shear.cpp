// Transverse shear of leaves against Timoshenko's closed forms: core/elements/README.md (E10),
// (E11).
#include "core/elements/plate/beam_section.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

using models::without_poisson;

StrokeResponse guided(const LeafSpring& leaf, ModelOptions model, double stroke) {
  Mechanism mechanism;
  mechanism.drives = {make_drive(Direction::uy)};
  mechanism.bodies = {models::body({leaf.length, 0, 0}, 1, 1e-4)};
  mechanism.bodies[0].held = {false, false, true, true, true, true};
  mechanism.leaves = {leaf};
  return test::evaluated(mechanism, model, {.points = {stroke}});
}

double drive_stiffness(const LeafSpring& leaf, const ModelOptions& model) {
  const double stroke = 1e-6 * leaf.length;
  return guided(leaf, model, stroke).path[0].drive_load / stroke;
}

ModelOptions full(std::array<int, 2> mesh, bool shear = true) {
  return {.accuracy = Accuracy::full, .mesh = mesh, .transverse_shear = shear};
}

LeafSpring leaf_of(double length, double width, double thickness, const Material& m) {
  return models::leaf({0, 0, 0}, {1, 0, 0}, length, width, thickness, m);
}

/// Compliance that shear adds to a guided leaf, relative.
double softening(const LeafSpring& leaf, std::array<int, 2> mesh) {
  return drive_stiffness(leaf, full(mesh, false)) / drive_stiffness(leaf, full(mesh)) - 1;
}

}  // namespace

TEST_CASE("a guided leaf without Poisson effect gives way by Timoshenko's 1 + 12 EI/κGAL²") {
  const double L = 0.02;
  for (const double ratio : {10.0, 30.0, 100.0}) {
    const double t = L / ratio;
    const LeafSpring leaf = leaf_of(L, 4 * L, t, without_poisson());
    const double E = leaf.material.youngs_modulus, I = 4 * L * t * t * t / 12,
                 phi = 12 * E * I / (5.0 / 6 * 0.5 * E * 4 * L * t * L * L);
    CAPTURE(ratio);
    const double thin = 12 * E * I / (L * L * L);
    CHECK(drive_stiffness(leaf, full({10, 2}, false)) == Approx(thin).epsilon(1e-5));
    for (const std::array<int, 2>& mesh : {std::array{4, 2}, {10, 2}, {24, 2}})
      CHECK(thin / drive_stiffness(leaf, full(mesh)) - 1 == Approx(phi).epsilon(0.02));
    // elements of a third of t at the clamps of the thickest leaf
    CHECK(thin / drive_stiffness(leaf, {}) - 1 == Approx(phi).epsilon(0.05));
  }
}

TEST_CASE("a guided wire is Timoshenko's beam, on any mesh") {
  const double L = 0.02, d = 1e-3;
  LeafSpring wire = leaf_of(L, d, d, models::steel());
  wire.section = Section::circular;
  const double E = wire.material.youngs_modulus, G = wire.material.shear_modulus();
  const BeamSection s = beam_section(Section::circular, d, d, wire.material.poissons_ratio);
  const double phi = 12 * E * s.I_weak / (s.shear * G * s.area * L * L);
  CHECK(phi > 0.005);
  for (const int elements : {2, 7, 20})
    CHECK(drive_stiffness(wire, full({elements, 1})) ==
          Approx(12 * E * s.I_weak / (L * L * L * (1 + phi))).epsilon(1e-7));
}

TEST_CASE("the stress of a clamp is that of its moment, shear or not") {
  // Statically determinate by symmetry: M = F L / 2, whatever bends besides. Elements of different
  // widths give way a little differently where the leaf is very short.
  const double L = 0.02;
  for (const double ratio : {8.0, 40.0}) {
    const double t = L / ratio, w = 4 * L, stroke = 1e-6 * L;
    const LeafSpring leaf = leaf_of(L, w, t, without_poisson());
    for (const bool shear : {true, false})
      for (const std::array<int, 2>& mesh : {std::array{6, 2}, {24, 4}}) {
        CAPTURE(ratio, shear, mesh[0]);
        const StrokeResponse response = guided(leaf, full(mesh, shear), stroke);
        const PathPoint& p = response.path[0];
        REQUIRE(p.max_stress);
        CHECK(p.max_stress->value ==
              Approx(3 * p.drive_load * L / (w * t * t)).epsilon(ratio < 10 ? 2e-3 : 2e-5));
      }
  }
}

TEST_CASE("elements smaller than the thickness stay stable and agree with larger ones") {
  const LeafSpring leaf = leaf_of(0.02, 3e-3, 1e-3, models::steel());
  const double coarse = drive_stiffness(leaf, full({16, 4})),
               fine = drive_stiffness(leaf, full({48, 16}));
  CHECK(fine == Approx(coarse).epsilon(0.01));
  CHECK(guided(leaf, full({48, 16}), 1e-5).path[0].stable);
}

TEST_CASE("what shear gives back does not fall with the width of the elements") {
  const LeafSpring leaf = leaf_of(0.02, 6e-3, 1e-3, models::steel());
  const double wide = softening(leaf, {12, 6});
  CHECK(wide > 0.005);
  CHECK(softening(leaf, {12, 24}) == Approx(wide).epsilon(0.1));
}

TEST_CASE("a curved leaf gives way by shear as a flat one does") {
  // In the limit of a small angle; and its undeflected shape stays without force.
  const LeafSpring flat = leaf_of(0.02, 0.04, 1e-3, models::steel());
  LeafSpring curved = flat;
  curved.curve = 1e-3;
  CHECK(softening(flat, {10, 4}) > 0.005);
  CHECK(softening(curved, {10, 4}) == Approx(softening(flat, {10, 4})).epsilon(1e-3));
  curved.curve = 1.2;
  CHECK(softening(curved, {10, 4}) > 0.5 * softening(flat, {10, 4}));
  CHECK(softening(curved, {10, 4}) < 2 * softening(flat, {10, 4}));
}
