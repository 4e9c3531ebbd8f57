// The beam leaf: section constants and closed forms, laws, derivatives, frequencies.
#include <Eigen/Eigenvalues>

#include "core/elements/plate/beam_section.hpp"
#include "core/reduction/expansion/tube_expansion.hpp"
#include "elastica.hpp"
#include "support/plate_laws.hpp"
#include "support/strokes.hpp"

using namespace flexopt;
using namespace flexopt::plate_laws;

namespace {

std::shared_ptr<const PlateMesh> make_mesh(double w = 0.5, double t = 0.006,
                                           Section section = Section::rectangular,
                                           Warping warping = Warping::clamped, int along = 6,
                                           bool shear = true) {
  PlateShape shape{w, t, 0.3, {along, 1}, true};
  shape.flexure = Flexure::beam;
  shape.section = section;
  shape.warping = warping;
  shape.transverse_shear = shear;
  return std::make_shared<PlateMesh>(shape);
}

const std::vector<std::shared_ptr<const PlateMesh>>& kinds() {
  static const std::vector<std::shared_ptr<const PlateMesh>> all{
      make_mesh(), make_mesh(0.2, 0.01, Section::rectangular, Warping::free),
      make_mesh(0.02, 0.02, Section::circular)};
  return all;
}

ModelOptions beam_model(int along = 10, Warping warping = Warping::clamped) {
  return {
      .accuracy = Accuracy::full, .flexure = Flexure::beam, .warping = warping, .mesh = {along, 1}};
}

System beam_system(const Mechanism& m, int along = 10, Warping warping = Warping::clamped,
                   LoadCase loads = {}) {
  return System(m, make_full_leaves(m, beam_model(along, warping)), std::move(loads));
}

// 6×6 compliance of the tip of one undeflected beam along x.
Matrix6d tip_compliance(const Mechanism& m, int along = 10, Warping warping = Warping::clamped) {
  System system = beam_system(m, along, warping);
  system.assemble();
  const Matrix6d K = system.tangent().dense();
  return K.inverse();
}

Mechanism wire(double length, double diameter, Direction drive = Direction::uy) {
  Mechanism m = models::single_leaf(length, diameter, diameter, drive);
  m.leaves[0].section = Section::circular;
  return m;
}

}  // namespace

TEST_CASE("section constants meet Saint-Venant's series, its limits and the circle") {
  // Timoshenko and Goodier, table of J / (w t³): square 0.1406, 2:1 0.229, 10:1 0.312
  for (const auto& [ratio, expected] : {std::pair{1.0, 0.1406}, {2.0, 0.229}, {10.0, 0.312}})
    CHECK(beam_section(Section::rectangular, ratio, 1, 0.3).J / ratio ==
          Approx(expected).margin(6e-4));
  // thin: w t³/3 − 0.21 t⁴
  CHECK(beam_section(Section::rectangular, 100, 1, 0.3).J ==
        Approx(100.0 / 3 - 0.21).epsilon(1e-5));
  const BeamSection c = beam_section(Section::circular, 2, 2, 0.3);
  CHECK(c.area == Approx(M_PI));
  CHECK(c.I_weak == Approx(M_PI / 4));
  CHECK(c.I_strong == Approx(M_PI / 4));
  CHECK(c.J == Approx(M_PI / 2));
  CHECK(c.C_w == 0);
  // largest shear stress of a twisted square 1.351 G θ′ a/2 · 2: T = 0.208 τ a³ with T = 0.1406 G
  // θ′ a⁴
  CHECK(torsion_stress_factor<double>(1, 1, 0) == Approx(0.1406 / 0.208).epsilon(2e-3));
  CHECK(torsion_stress_factor<double>(50, 1, 0) == Approx(1).epsilon(1e-6));
  CHECK(torsion_stress_factor<double>(50, 1, 1) == Approx(0).margin(6e-3));
}

TEST_CASE("a straight beam has the stiffness of Timoshenko's theory in every direction") {
  struct Shape {
    double length, width, thickness;
  };
  for (const Shape& s : {Shape{0.1, 0.01, 1e-3}, {0.1, 0.03, 5e-4}, {0.06, 0.06, 5e-4}}) {
    const Mechanism m = models::single_leaf(s.length, s.width, s.thickness);
    const Material& steel = m.leaves[0].material;
    const double E = steel.youngs_modulus, G = steel.shear_modulus(), L = s.length;
    const double A = s.width * s.thickness, I_weak = A * s.thickness * s.thickness / 12,
                 I_strong = A * s.width * s.width / 12;
    const double nu = 0.3, k = 10 * (1 + nu) / (12 + 11 * nu);
    const Matrix6d C = tip_compliance(m);
    CHECK(C(0, 0) == Approx(L / (E * A)).epsilon(1e-6));
    CHECK(C(1, 1) == Approx(L * L * L / (3 * E * I_weak) + L / (k * G * A)).epsilon(1e-6));
    CHECK(C(5, 5) == Approx(L / (E * I_weak)).epsilon(1e-6));
    CHECK(C(1, 5) == Approx(L * L / (2 * E * I_weak)).epsilon(1e-6));
    // what remains of the thickness' share in the clamps' shear layer is of the order (t/w)² t/L
    CHECK(C(2, 2) == Approx(L * L * L / (3 * E * I_strong) + L / (k * G * A)).epsilon(2e-3));
    CHECK(C(4, 4) == Approx(L / (E * I_strong)).epsilon(2e-3));
    CHECK(C(2, 4) == Approx(-L * L / (2 * E * I_strong)).epsilon(2e-3));
  }
}

TEST_CASE("restrained warping stiffens torsion as GJ / (L − 2 λ tanh(L/2λ))") {
  const double w = 0.03, t = 5e-4;
  for (const double ratio : {4.0, 2.0, 1.0, 0.5, 0.25}) {
    const double L = ratio * w;
    const Mechanism m = models::single_leaf(L, w, t, Direction::rx);
    const Material& steel = m.leaves[0].material;
    const double G = steel.shear_modulus();
    // thin rectangle with the first term of the series: within 1e-6 of it at w/t = 60
    const double J = w * t * t * t / 3 * (1 - 192 / std::pow(M_PI, 5) * t / w * 1.0045238),
                 C_w = std::pow(w * t, 3) / 144;
    const double lambda = std::sqrt(steel.youngs_modulus * C_w / (G * J));
    const double held = G * J / (L - 2 * lambda * std::tanh(L / (2 * lambda)));
    for (const int along : {10, 24}) {
      CHECK(1 / tip_compliance(m, along)(3, 3) == Approx(held).epsilon(along == 10 ? 1e-3 : 1e-4));
      CHECK(1 / tip_compliance(m, along, Warping::free)(3, 3) == Approx(G * J / L).epsilon(1e-4));
    }
  }
}

TEST_CASE("a wire is as stiff in y as in z, and has its closed forms") {
  const double L = 0.08, d = 1e-3;
  const Matrix6d C = tip_compliance(wire(L, d));
  const Material steel = models::steel();
  const double E = steel.youngs_modulus, I = M_PI * std::pow(d, 4) / 64,
               kGA = 6 * 1.3 / (7 + 6 * 0.3) * steel.shear_modulus() * M_PI * d * d / 4;
  CHECK(C(0, 0) == Approx(L / (E * M_PI * d * d / 4)).epsilon(1e-9));
  CHECK(C(1, 1) == Approx(L * L * L / (3 * E * I) + L / kGA).epsilon(1e-9));
  CHECK(std::abs(C(2, 2) / C(1, 1) - 1) < 2e-7);  // 1e-9 without shear
  CHECK(std::abs(C(4, 4) / C(5, 5) - 1) < 1e-9);
  CHECK(std::abs(C(2, 4) / C(1, 5) + 1) < 1e-9);
  CHECK(C(3, 3) == Approx(L / (steel.shear_modulus() * 2 * I)).epsilon(1e-9));

  // bent far to either side, support stiffness across included
  const StrokeRequest request{.points = {0.2 * L}};
  const StrokeResponse y = test::evaluated(wire(L, d, Direction::uy), beam_model(), request),
                       z = test::evaluated(wire(L, d, Direction::uz), beam_model(), request);
  CHECK(y.path[0].drive_load == Approx(z.path[0].drive_load).epsilon(1e-4));
  CHECK(*y.path[0].support_stiffness[0] == Approx(*z.path[0].support_stiffness[0]).epsilon(2e-3));
  CHECK(*y.path[0].support_stiffness[2] == Approx(*z.path[0].support_stiffness[1]).epsilon(2e-3));
  CHECK(y.path[0].max_stress->value == Approx(z.path[0].max_stress->value).epsilon(2e-3));
}

TEST_CASE("a beam or wire with a free tip bends like a cantilever in both planes") {
  for (const bool circular : {false, true}) {
    const double L = 0.1, w = circular ? 1e-3 : 0.01, t = 1e-3;
    const Mechanism m = models::free_tip(circular ? wire(L, t) : models::single_leaf(L, w, t));
    System system = beam_system(m);
    system.assemble();
    const Matrix3d C = system.tangent().dense().topLeftCorner<3, 3>().inverse();
    const BeamSection s = beam_section(m.leaves[0].section, w, t, 0.3);
    const Material& steel = m.leaves[0].material;
    const double shear = L / (s.shear * steel.shear_modulus() * s.area);
    CHECK(C(0, 0) == Approx(L / (steel.youngs_modulus * s.area)).epsilon(1e-6));
    CHECK(C(1, 1) ==
          Approx(L * L * L / (3 * steel.youngs_modulus * s.I_weak) + shear).epsilon(1e-6));
    CHECK(C(2, 2) ==
          Approx(L * L * L / (3 * steel.youngs_modulus * s.I_strong) + shear).epsilon(2e-3));
  }
}

TEST_CASE("a beam follows the elastica to PL²/EI = 10") {
  // thin enough for an axial strain (t/L)² P L²/12 EI of 8e-6
  const double L = 0.1, w = 1e-3, t = 3e-4;
  const Mechanism mechanism = models::single_leaf(L, w, t, Direction::rx);
  const double EI = mechanism.leaves[0].material.youngs_modulus * w * t * t * t / 12;
  System system =
      beam_system(mechanism, 32, Warping::clamped, {.constant = {{.force = {0, EI / (L * L), 0}}}});
  check_elastica(system, L, 1e-5);
}

TEST_CASE("a rigid motion of a bent beam stores no energy and turns force and tangent with it") {
  for (const auto& mesh : kinds()) {
    ChordLeaf chord(mesh);
    const double EI = mesh->bending_stiffness();
    REQUIRE(chord.solve({0.15, -0.1, 0.01}, {6 * EI, 0.4 * EI, 0.2 * EI}).converged);
    REQUIRE(chord.plate().energy() > 1e-3 * EI);
    check_turned(chord.plate(), 1e-10);
  }
}

TEST_CASE("a beam's force and tangent are the derivatives of its energy") {
  for (const auto& mesh : kinds()) check_energy_derivatives(mesh, 1e-3, false);
}

TEST_CASE("a beam's mass sums to density times volume, and its spin to the polar moment") {
  for (const auto& mesh : kinds()) {
    const Matrix6d M = rigid_mass(mesh);
    const double w = mesh->shape().width, t = mesh->shape().thickness;
    const bool circular = mesh->shape().section == Section::circular;
    const double area = circular ? M_PI * w / 4 : w,
                 polar = circular ? M_PI * w * w * w / 32 : (w * w * w + w * t * t) / 12;
    const double expected[] = {area, area, area, polar, area / 3};
    for (int c = 0; c < 5; ++c) CHECK(M(c, c) == Approx(expected[c]).epsilon(1e-9));
  }
}

TEST_CASE("a beam between two clamps vibrates as beams do: bending, torsion, length") {
  // scaled units: ω² in D/(ρ t L⁴)
  const double w = 0.05, t = 0.005, nu = 0.3;
  const auto modes_of = [](const std::shared_ptr<const PlateMesh>& mesh) {
    PlateLeaf leaf(mesh);
    leaf.assemble();
    return leaf.modes(8);
  };
  const auto has = [](const std::vector<PlateLeaf::Mode>& modes, double omega, double tolerance) {
    for (const PlateLeaf::Mode& m : modes)
      if (std::abs(std::sqrt(m.omega2) / omega - 1) < tolerance) return true;
    return false;
  };
  const auto leaf = modes_of(make_mesh(w, t, Section::rectangular, Warping::free, 16, false));
  REQUIRE(leaf.size() == 8);
  for (const double root : {4.73004074, 7.85320462, 10.9956079})
    CHECK(has(leaf, root * root, 1e-3));  // √(EI/ρA L⁴) is the unit
  // torsion: π √(GJ / ρ I_p) / L; I_p = (w³t + w t³)/12, lengths over L, ω over √(D/ρ t L⁴)
  const double J = beam_section(Section::rectangular, w, t, nu).J;
  const double Ip = (w * w * w * t + w * t * t * t) / 12;
  const double unit = std::sqrt(t * t / 12);  // √(D/ρ t) with E = ρ = L = 1
  CHECK(has(leaf, M_PI * std::sqrt(0.5 / (1 + nu) * J / Ip) / unit, 1e-3));

  const double d = 0.02;
  const auto wire_modes = modes_of(make_mesh(d, d, Section::circular, Warping::clamped, 16, false));
  REQUIRE(wire_modes.size() == 8);
  // E I / ρ A = d²/16; both planes vibrate alike (rotary inertia: 1e-3)
  CHECK(std::sqrt(wire_modes[0].omega2) ==
        Approx(4.73004074 * 4.73004074 * d / 4 / (d / std::sqrt(12.0))).epsilon(1e-3));
  CHECK(wire_modes[1].omega2 == Approx(wire_modes[0].omega2).epsilon(5e-3));
}

TEST_CASE("a wire's bending modes come in both planes, an equal pair whole") {
  PlateLeaf coarse(make_mesh(5e-4, 5e-4, Section::circular)),
      fine(make_mesh(5e-4, 5e-4, Section::circular, Warping::clamped, 40));
  coarse.assemble();
  fine.assemble();
  const auto two = coarse.modes(2), four = coarse.modes(4), equal = fine.modes(1);
  REQUIRE(two.size() == 2);
  REQUIRE(four.size() == 4);
  REQUIRE(equal.size() == 2);
  CHECK(two[1].omega2 == Approx(two[0].omega2).epsilon(1e-3));
  CHECK(four[3].omega2 == Approx(four[2].omega2).epsilon(1e-2));
  CHECK(four[2].omega2 > 5 * four[1].omega2);
  CHECK(equal[1].omega2 == Approx(equal[0].omega2).epsilon(1e-6));
}

TEST_CASE("all unstable modes of a wire are found, and the stable ones that were asked for") {
  PlateLeaf leaf(make_mesh(0.02, 0.02, Section::circular));
  leaf.assemble();
  // pushed together to many times its buckling load, still straight
  Vector12d push = Vector12d::Zero();
  push[6] = -0.02;
  PlateLeaf::State state = leaf.state();
  state.edges[1].position.x() += push[6];
  state.x += leaf.internal_step(push);
  leaf.set_state(state);
  leaf.assemble();
  REQUIRE(leaf.correction() < 1e-8);
  const int unstable = leaf.negative_pivots();
  REQUIRE(unstable >= 6);
  const auto all = leaf.modes(leaf.unknowns()), lowest = leaf.modes(2);
  REQUIRE(static_cast<int>(lowest.size()) >= unstable + 2);
  CHECK(lowest[unstable - 1].omega2 < 0);
  CHECK(lowest[unstable].omega2 > 0);
  for (std::size_t k = 0; k < lowest.size(); ++k)
    CHECK(lowest[k].omega2 == Approx(all[k].omega2).epsilon(1e-9));
}

TEST_CASE("the largest stress of a beam is that of the section formulas") {
  const double L = 0.1, w = 0.01, t = 1e-3;
  const Material steel = models::steel();
  const auto peak = [&](const Mechanism& m, Warping warping = Warping::clamped) {
    return *test::evaluated(m, beam_model(16, warping), {.points = {1e-5}}).path[0].max_stress;
  };
  // cantilever, the rotation of its tip free: σ = 3 E t u / 2 L²
  CHECK(peak(models::single_leaf(L, w, t, Direction::uy)).value ==
        Approx(1.5 * steel.youngs_modulus * t * 1e-5 / (L * L)).epsilon(1e-3));
  CHECK(peak(models::single_leaf(L, w, t, Direction::uy)).along == Approx(0).margin(1e-12));
  // twist with free warping: τ = G θ′ t (w ≫ t: less 8/π² of cosh⁻¹), von Mises √3 τ
  CHECK(peak(models::single_leaf(L, w, t, Direction::rx), Warping::free).value ==
        Approx(std::sqrt(3.0) * steel.shear_modulus() * 1e-5 / L * t).epsilon(1e-3));
  // wire in torsion and bending
  CHECK(peak(wire(L, t, Direction::rx)).value ==
        Approx(std::sqrt(3.0) * steel.shear_modulus() * 1e-5 / L * t / 2).epsilon(1e-3));
  CHECK(peak(wire(L, t, Direction::uz)).value ==
        Approx(1.5 * steel.youngs_modulus * t * 1e-5 / (L * L)).epsilon(1e-3));
}

TEST_CASE("beams of any width bear moment, force and twist with the stress of their section") {
  // (B3): statics, whatever the sheared layer at the clamps and the mesh make of the curvature
  const double L = 0.05, t = 5e-4;
  const Material steel = models::steel();
  for (const double ratio : {1.1, 1.5, 2.0, 3.0, 10.0}) {
    const double w = ratio * t, small = 1e-6;
    for (const int along : {6, 12, 40}) {
      CAPTURE(ratio, along);
      const auto point = [&](Direction drive, Warping warping = Warping::clamped) {
        return test::evaluated(models::single_leaf(L, w, t, drive), beam_model(along, warping),
                               {.points = {small}})
            .path[0];
      };
      const PathPoint in_plane = point(Direction::ry), across = point(Direction::uz),
                      normal = point(Direction::rz), along_it = point(Direction::ux),
                      twisted = point(Direction::rx, Warping::free);
      CHECK(in_plane.max_stress->value ==
            Approx(std::abs(in_plane.drive_load) * 6 / (t * w * w)).epsilon(5e-4));
      CHECK(across.max_stress->value ==
            Approx(across.drive_load * L * 6 / (t * w * w)).epsilon(5e-4));
      CHECK(normal.max_stress->value ==
            Approx(steel.youngs_modulus * t / 2 * small / L).epsilon(5e-4));
      CHECK(along_it.max_stress->value == Approx(steel.youngs_modulus * small / L).epsilon(5e-4));
      CHECK(twisted.max_stress->value == Approx(std::sqrt(3.0) * steel.shear_modulus() * small / L *
                                                t * torsion_stress_factor(w, t, 0.0))
                                             .epsilon(1e-3));
    }
  }
}

TEST_CASE("ten elements along are as good as forty: guided to 0.3 L, turned to 45°") {
  for (const double w : {0.01, 0.03, 0.06})
    for (const Direction drive : {Direction::uy, Direction::rz}) {
      const bool guided = drive == Direction::uy;
      const Mechanism m =
          guided ? models::guide(0.1, w, 5e-4) : models::single_leaf(0.1, w, 5e-4, Direction::rz);
      const double end = guided ? 0.03 : M_PI / 4;
      const StrokeRequest request{.points = {0.5 * end, end}, .outputs = test::without_stress()};
      const StrokeResponse ten = test::evaluated(m, beam_model(), request),
                           forty = test::evaluated(m, beam_model(40), request);
      for (int k = 0; k < 2; ++k) {
        const PathPoint &a = ten.path[k], &b = forty.path[k];
        CAPTURE(w, guided, k);
        CHECK(a.drive_load == Approx(b.drive_load).epsilon(3e-3));
        CHECK(test::support_error(a, b) < 1e-2);
      }
    }
}
