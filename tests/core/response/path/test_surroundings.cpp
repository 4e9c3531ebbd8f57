// What acts on a mechanism besides loads on its bodies: edges that sit in their bodies other than
// designed, warm leaves, and weight. Laws, closed forms, and the reduced model against the full
// one.
#include "support/strokes.hpp"
#include "support/tangent_law.hpp"

using namespace flexopt;
using test::evaluated;

namespace {

ModelOptions full(Flexure flexure = Flexure::plate) {
  return models::full(flexure, flexure == Flexure::plate ? default_mesh : std::array{20, 1});
}

StrokeRequest request_with(LoadCase loads, std::vector<double> points = {0}) {
  return {.points = std::move(points),
          .loads = std::move(loads),
          .outputs = Outputs::numbers().remove(Output::frequency_derivatives),
          .frequencies = 3,
          .newton = {.tolerance = 1e-12}};
}

/// Pushed by nothing, so that no drive holds it.
LoadCase undriven(LoadCase loads) {
  loads.growing = {{.force = {0, 1, 0}}};
  return loads;
}

Mechanism warm_steel(Mechanism m, double expansion = 1e-5) {
  for (LeafSpring& leaf : m.leaves) leaf.material.thermal_expansion = expansion;
  return m;
}

/// Clamped at its base, O the middle of its free tip.
Mechanism cantilever(double length, double width, double thickness) {
  return models::free_tip(models::single_leaf(length, width, thickness));
}

double drive_stiffness(const Mechanism& m, const LoadCase& loads) {
  return evaluated(m, full(), request_with(loads)).path[0].drive_stiffness;
}

}  // namespace

TEST_CASE("clamps of the ground that move as one body take the mechanism along unstressed") {
  const Vector3d spin(0.01, -0.02, 0.015), shift(1e-3, -2e-3, 5e-4), centre(0.01, 0.02, -0.01);
  const Matrix3d R = rotation_exp(spin);
  const auto check = [&](Mechanism m, const ModelOptions& model, double room) {
    LoadCase loads;
    for (int i = 0; i < 2; ++i) {
      const Vector3d from = m.leaves[static_cast<std::size_t>(i)].origin - centre;
      loads.assembly.push_back({i, 0, R * from - from + shift, spin});
    }
    const PathPoint p = evaluated(m, model, request_with(undriven(loads))).path[0];
    const Vector3d from = m.bodies[0].reference - centre;
    CHECK((p.displacement - (R * from - from + shift)).norm() < room * 0.1);
    CHECK((p.rotation - spin).norm() < room);
    CHECK(p.max_stress->value < 2e11 * room);
    const PathPoint rest = evaluated(m, model, request_with(undriven({}))).path[0];
    CHECK(test::frequency_error(p.frequencies_free, rest.frequencies_free) < 1e-6);
  };
  Mechanism guide = models::guide(0.1, 0.03, 5e-4);
  check(guide, full(), 1e-9);
  check(guide, full(Flexure::beam), 1e-9);
  check(guide, {}, 1e-8);
  ModelOptions linear{.method = Reduction::linear_craig_bampton, .superelements = {4, 0}};
  check(guide, linear, 1e-9);
  ModelOptions modal{.method = Reduction::modal_derivatives};
  check(guide, modal, 1e-8);
}

TEST_CASE("edges of a body that sit in it moved as one are that body moved") {
  // O of the body follows the other way, and nothing else changes
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const Vector3d spin(0.004, 0.003, -0.002), shift(2e-4, 1e-4, -3e-4);
  const Matrix3d R = rotation_exp(spin);
  LoadCase loads;
  for (int i = 0; i < 2; ++i) {
    const Vector3d from =
        m.leaves[static_cast<std::size_t>(i)].tip_middle() - m.bodies[0].reference;
    loads.assembly.push_back({i, 1, R * from - from + shift, spin});
  }
  const PathPoint p = evaluated(m, full(), request_with(undriven(loads))).path[0];
  CHECK((p.displacement + R.transpose() * shift).norm() < 1e-10);
  CHECK((p.rotation + spin).norm() < 1e-9);
  CHECK(p.max_stress->value < 10);
}

TEST_CASE("an error of one leaf stresses an overconstrained guide and not a released one") {
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4);
  // a hinge about y between the tip of the second leaf and the end-effector
  Mechanism released = guide;
  const Vector3d place = released.leaves[1].tip_middle();
  released.bodies.push_back(models::intermediate(place, 0.01, 1e-6));
  released.leaves[1].tip = 1;
  released.joints = {{"hinge", JointType::revolute, 1, 0, place, Vector3d::UnitY()}};
  const auto turned = [](double angle) {
    return LoadCase{.assembly = {{0, 0, Vector3d::Zero(), {0, angle, 0}}}};
  };
  const double loss = 1 - drive_stiffness(guide, turned(1e-3)) / drive_stiffness(guide, {}),
               released_loss =
                   1 - drive_stiffness(released, turned(1e-3)) / drive_stiffness(released, {});
  CHECK(loss > 0.01);
  CHECK(loss < 0.04);
  CHECK(std::abs(released_loss) < 1e-4);
  const PathPoint p = evaluated(guide, full(), request_with(turned(1e-3))).path[0],
                  q = evaluated(released, full(), request_with(turned(1e-3))).path[0];
  // each leaf takes half of the turn: its edge strain is a quarter of w θ / L
  CHECK(p.max_stress->value > 0.9 * 2e11 * 0.25 * 0.03 * 1e-3 / 0.1);
  CHECK(q.max_stress->value < 0.12 * p.max_stress->value);
  // O turns with them about y
  CHECK(p.rotation[1] == Approx(0.5e-3).epsilon(0.01));
  CHECK(q.rotation[1] == Approx(1e-3).epsilon(0.01));
}

TEST_CASE("a guide that is bolted down crooked buckles as its leaves do sideways") {
  // Each leaf is bent in its plane by half of the turn, M = E I_w θ / 2L. A moment M lets it twist
  // where it bends, GJ φ′ = M (v′ − s/L), as a thrust P = M²/GJ would but for P s²/2L. Clamped and
  // guided, with x = M L / (2 √(EI GJ)), two leaves have the drive stiffness
  //     8 EI/L³ x² tan x / (tan x − x),
  // which is 24 EI/L³ at x = 0 and vanishes at x = π, where leaves buckle sideways.
  // Narrow, so that warping does not count, and far apart, so that the body twists neither much.
  const double L = 0.1, w = 5e-3, t = 1e-4, E = 200e9, G = E / 2.6;
  const double EI = E * w * t * t * t / 12, EI_w = E * t * w * w * w / 12,
               GJ = G * w * t * t * t / 3 * (1 - 0.63 * t / w);
  const auto x_of = [&](double turn) {
    return 0.5 * EI_w * turn / L * L / (2 * std::sqrt(EI * GJ));
  };
  const Mechanism m = models::guide(L, w, t, 1.0);
  ModelOptions beams = full(Flexure::beam);
  beams.warping = Warping::free;
  const auto turned = [&](double turn) {
    const LoadCase loads{.assembly = {{0, 0, Vector3d::Zero(), {0, turn, 0}}}};
    return evaluated(m, beams, request_with(loads)).path[0];
  };
  for (const double turn : {1e-3, 2e-3, 3e-3, 4e-3, 5e-3}) {
    const double x = x_of(turn);
    CAPTURE(turn, x);
    CHECK(turned(turn).drive_stiffness ==
          Approx(8 * EI / (L * L * L) * x * x * std::tan(x) / (std::tan(x) - x)).epsilon(0.01));
  }
  const double critical = M_PI / x_of(1);
  CHECK(turned(0.99 * critical).drive_stiffness > 0);
  CHECK(turned(1.01 * critical).drive_stiffness < 0);
}

TEST_CASE("the stroke counts from the mechanism as designed") {
  // both leaves shifted along the drive: held at zero the drive pulls them back
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const double s = 1e-4;
  const LoadCase shifted{
      .assembly = {{0, 0, {0, s, 0}, Vector3d::Zero()}, {1, 0, {0, s, 0}, Vector3d::Zero()}}};
  const StrokeResponse r = evaluated(m, full(), request_with(shifted, {0, s}));
  CHECK(r.path[0].displacement[1] == Approx(0).margin(1e-13));
  CHECK(r.path[0].drive_load == Approx(-r.path[0].drive_stiffness * s).epsilon(1e-3));
  CHECK(std::abs(r.path[1].drive_load) < 1e-6 * std::abs(r.path[0].drive_load));
  CHECK(r.path[1].max_stress->value < 1e-4 * r.path[0].max_stress->value);
}

TEST_CASE("reduced leaves follow errors of assembly as full ones do") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const LoadCase loads{.assembly = {{0, 0, {2e-5, 5e-5, 1e-4}, {1e-3, 1e-3, -2e-3}},
                                    {1, 1, {0, 0, -5e-5}, {-5e-4, 5e-4, 1e-3}}}};
  const StrokeRequest request = request_with(loads, {0, 0.01, -0.01});
  const StrokeResponse a = evaluated(m, full(), request), b = evaluated(m, {}, request);
  for (std::size_t k = 0; k < 3; ++k) {
    CAPTURE(k, b.path[k].leaves[0].model, b.path[k].leaves[0].reason);
    CHECK(b.path[k].drive_load == Approx(a.path[k].drive_load).epsilon(1e-3));
    CHECK((b.path[k].displacement - a.path[k].displacement).norm() <
          2e-3 * a.path[k].displacement.norm());
    CHECK((b.path[k].rotation - a.path[k].rotation).norm() < 2e-3 * a.path[k].rotation.norm());
    for (const int d : {0, 2, 3, 4, 5})
      CHECK(*b.path[k].support_stiffness[d] ==
            Approx(*a.path[k].support_stiffness[d]).epsilon(5e-3));
    CHECK(b.path[k].max_stress->value == Approx(a.path[k].max_stress->value).epsilon(0.01));
  }
}

TEST_CASE("with errors, warmth and weight force and tangent are the derivatives of the energy") {
  const Flexure flexure = GENERATE(Flexure::plate, Flexure::beam);
  ModelOptions model = full(flexure);
  model.mesh = flexure == Flexure::plate ? std::array{6, 2} : std::array{8, 1};
  LoadCase loads{.assembly = {{0, 0, {2e-5, 5e-5, 1e-4}, {1e-3, 1e-3, -2e-3}},
                              {1, 1, {0, 0, -5e-5}, {-5e-4, 5e-4, 1e-3}}},
                 .temperature = {10, -5},
                 .body_expansion = {2e-4, -1e-4},
                 .gravity = {20, 30, -40}};
  Mechanism m = warm_steel(models::guide(0.06, 0.02, 4e-4));
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.02, -0.015);
  m = warmed(m, loads);
  System system(m, make_full_leaves(m, model), loads);
  REQUIRE(step_load(system, {.constant = 1}, {}).converged);
  REQUIRE(step_to(system, 0.004, {}).converged);
  test::check_tangent(system);
}

TEST_CASE("a clamped leaf buckles at the temperature of the closed form") {
  // pi² t² / (3 L² alpha) of a beam; the strain is compared, so that its own square counts too
  const double L = 0.1, t = 5e-4, alpha = 1e-5,
               expected = M_PI * M_PI * t * t / (3 * L * L * alpha);
  const Flexure flexure = GENERATE(Flexure::beam, Flexure::plate);
  Mechanism m =
      warm_steel(models::single_leaf(L, flexure == Flexure::beam ? 0.02 : 2.5e-3, t), alpha);
  if (flexure == Flexure::plate) m.leaves[0].material.poissons_ratio = 0;
  m = models::clamped_at_both(m, 0.5, 0.5);
  const auto stable = [&](double change) {
    const StrokeResponse r =
        evaluated(m, full(flexure), request_with(undriven({.temperature = {change}})));
    return r.path[0].stable;
  };
  CHECK(stable(0.995 * expected));
  CHECK_FALSE(stable(1.005 * expected));
  CHECK(stable(-2 * expected));
}

TEST_CASE("warm leaves carry the end-effector along, and one alone is pressed") {
  const double L = 0.1, E = 2e11, alpha = 1e-5;
  const Mechanism m = warm_steel(models::guide(L, 0.01, 5e-4), alpha);
  const PathPoint both = evaluated(m, full(), request_with({.temperature = {20, 20}})).path[0];
  // a clamp that holds the width lets a leaf expand along by a little more
  CHECK(both.displacement[0] == Approx(alpha * 20 * L).epsilon(0.02));
  CHECK(both.displacement[0] > alpha * 20 * L);
  CHECK(both.displacement.tail<2>().norm() < 1e-12);
  // a guide held against turning: half of the expansion of one leaf, pressed and pulled by it
  Mechanism held = m;
  held.bodies[0].held[5] = true;
  held.leaves[0].material.poissons_ratio = held.leaves[1].material.poissons_ratio = 0;
  const PathPoint one = evaluated(held, full(), request_with({.temperature = {4, 0}})).path[0];
  CHECK(one.displacement[0] == Approx(0.5 * alpha * 4 * L).epsilon(1e-3));
  // beside that it is held across at its clamps
  CHECK(one.max_stress->value > 0.5 * E * alpha * 4);
  CHECK(one.max_stress->value < 3 * E * alpha * 4);
  // the leaf that is as warm as its clamps stays reduced
  const PathPoint reduced = evaluated(held, {}, request_with({.temperature = {4, 0}})).path[0];
  CHECK(reduced.leaves[0].model == "full");
  CHECK(reduced.leaves[0].reason == "it is warmer than its clamps");
  CHECK(reduced.leaves[1].reason == "");
  CHECK(reduced.leaves[1].model == "tube");
  CHECK(reduced.displacement[0] == Approx(one.displacement[0]).epsilon(1e-4));
}

TEST_CASE("a mechanism that is warm all over scales") {
  // lengths over 1 + alpha dT, moduli equal: forces with the square, masses as they were
  const double alpha = 1e-5, change = 300, g = 1 + alpha * change;
  const Flexure flexure = GENERATE(Flexure::plate, Flexure::beam);
  const Mechanism cold = warm_steel(models::guide(0.1, 0.02, 5e-4), alpha);
  Mechanism grown = cold;
  for (LeafSpring& leaf : grown.leaves) {
    leaf.origin *= g;
    leaf.length *= g;
    leaf.width *= g;
    leaf.thickness *= g;
    leaf.material.density /= g * g * g;
  }
  grown.bodies[0].reference *= g;
  grown.bodies[0].center_of_mass *= g;
  const LoadCase hot{.temperature = {change, change}, .body_expansion = {g - 1, g - 1}};
  const StrokeResponse a = evaluated(cold, full(flexure), request_with(hot, {0, 0.01})),
                       b = evaluated(grown, full(flexure), request_with({}, {0, 0.01}));
  CHECK(a.path[0].max_stress->value < 1);
  CHECK((a.path[0].displacement - (g - 1) * cold.bodies[0].reference).norm() < 1e-12);
  CHECK(a.path[1].drive_load == Approx(b.path[1].drive_load).epsilon(1e-8));
  CHECK(a.path[1].max_stress->value == Approx(b.path[1].max_stress->value).epsilon(1e-8));
  for (const int d : {0, 2, 3, 4, 5})
    CHECK(*a.path[1].support_stiffness[d] == Approx(*b.path[1].support_stiffness[d]).epsilon(1e-7));
}

TEST_CASE("a warm body spreads the edges that it holds") {
  // in the middle between two leaves: as if their tips had been put on so much apart
  const Mechanism m = warm_steel(models::guide(0.1, 0.005, 5e-4), 1e-5);
  const double strain = 2e-3;
  LoadCase apart;
  for (int i = 0; i < 2; ++i)
    apart.assembly.push_back(
        {i, 1,
         strain * (m.leaves[static_cast<std::size_t>(i)].tip_middle() - m.bodies[0].reference),
         Vector3d::Zero()});
  const LoadCase warm{.body_expansion = {strain, 0}};
  const PathPoint a = evaluated(m, full(), request_with(warm, {0, 0.005})).path[1],
                  b = evaluated(m, full(), request_with(apart, {0, 0.005})).path[1];
  // what is different is the strain across at the clamps alone
  CHECK(a.drive_load == Approx(b.drive_load).epsilon(1e-3));
  CHECK((a.displacement - b.displacement).norm() < 1e-6);
  CHECK(a.max_stress->value > 1e6);
  const PathPoint reduced = evaluated(m, {}, request_with(warm, {0, 0.005})).path[1];
  CHECK(reduced.leaves[0].reason == "its clamps are warm");
  CHECK(reduced.drive_load == Approx(a.drive_load).epsilon(1e-9));
}

TEST_CASE("a leaf without clamps across expands freely") {
  // its tip is free: beyond the clamp's reach there is no stress, and places scale
  const double L = 0.1, alpha = 1e-5, change = 100;
  const Mechanism m = warm_steel(cantilever(L, 0.01, 5e-4), alpha);
  StrokeRequest request = request_with(undriven({.temperature = {change}}));
  request.named_points = {{"middle", 0, 0.5, 0.5}, {"corner", 0, 1.0, 1.0}};
  const PathPoint p = evaluated(m, full(), request).path[0];
  CHECK(p.displacement[0] == Approx(alpha * change * L).epsilon(0.01));
  const Vector3d further = p.named_points[1] - p.named_points[0];
  CHECK(further[0] == Approx(alpha * change * 0.5 * L).epsilon(1e-4));
  CHECK(further[2] == Approx(alpha * change * 0.005).epsilon(1e-3));
}

TEST_CASE("a leaf droops under its weight as a beam does") {
  const double L = 0.1, w = 0.01, t = 2e-4, E = 2e11, rho = 7800;
  const Mechanism m = cantilever(L, w, t);
  const double EI = E * w * t * t * t / 12, weight = rho * w * t;
  const auto droop = [&](double g) {
    return evaluated(m, full(Flexure::beam), request_with(undriven({.gravity = {0, g, 0}})))
        .path[0]
        .displacement;
  };
  // little: q L⁴ / 8 EI
  const double small = 0.01;
  CHECK(droop(small)[1] == Approx(weight * small * L * L * L * L / (8 * EI)).epsilon(1e-4));
  // far: EI θ″ = −q (L − s) cos θ, the heavy elastica, by shooting with Runge and Kutta's method
  const double g = 400, q = weight * g;
  const auto shoot = [&](double curvature) {
    Eigen::Vector4d y(0, curvature, 0, 0);  // θ, θ′, x, y
    const int n = 4000;
    const double h = L / n;
    const auto rate = [&](double s, const Eigen::Vector4d& v) {
      return Eigen::Vector4d(v[1], -q * (L - s) * std::cos(v[0]) / EI, std::cos(v[0]),
                             std::sin(v[0]));
    };
    for (int i = 0; i < n; ++i) {
      const double s = i * h;
      const Eigen::Vector4d a = rate(s, y), b = rate(s + h / 2, y + h / 2 * a),
                            c = rate(s + h / 2, y + h / 2 * b), d = rate(s + h, y + h * c);
      y += h / 6 * (a + 2 * b + 2 * c + d);
    }
    return y;
  };
  double low = 0, high = q * L * L / EI;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (shoot(middle)[1] > 0 ? high : low) = middle;
  }
  const Eigen::Vector4d end = shoot(low);
  REQUIRE(end[3] > 0.3 * L);
  const Vector3d far = droop(g);
  CHECK(far[1] == Approx(end[3]).epsilon(1e-3));
  CHECK(far[0] == Approx(end[2] - L).epsilon(2e-3));
}

TEST_CASE("the drive carries the bodies and half of the leaves") {
  const double g = 9.81, w = 0.03, t = 5e-4, L = 0.1;
  const Mechanism m = models::guide(L, w, t);
  const double leaf = 7800 * L * w * t;
  for (const ModelOptions& model : {full(), full(Flexure::beam), ModelOptions{}}) {
    const StrokeResponse r = evaluated(m, model, request_with({.gravity = {0, -g, 0}}));
    CHECK(r.path[0].drive_load == Approx(g * (0.5 + leaf)).epsilon(1e-6));
    CHECK(r.path[0].leaves[0].model == "full");
  }
}

TEST_CASE("gravity on a body is a dead force at its centre of mass") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].center_of_mass += Vector3d(0.02, -0.01, 0.015);
  for (LeafSpring& leaf : m.leaves) leaf.material.density = 0;
  const Vector3d g(3, 5, -9);
  LoadCase dead{.constant = {{.force = m.bodies[0].mass * g, .place = m.bodies[0].center_of_mass}}};
  for (const ModelOptions& model : {full(), ModelOptions{}}) {
    StrokeRequest by_gravity = request_with({.gravity = g}, {0, 0.005}),
                  by_force = request_with(dead, {0, 0.005});
    by_gravity.frequencies = by_force.frequencies = 0;  // leaves without mass
    const StrokeResponse a = evaluated(m, model, by_gravity), b = evaluated(m, model, by_force);
    for (std::size_t k = 0; k < 2; ++k) {
      CHECK(a.path[k].drive_load == Approx(b.path[k].drive_load).epsilon(1e-9));
      CHECK((a.path[k].rotation - b.path[k].rotation).norm() < 1e-12);
      CHECK(a.path[k].drive_stiffness == Approx(b.path[k].drive_stiffness).epsilon(1e-9));
      CHECK(a.path[k].leaves[0].model == b.path[k].leaves[0].model);
    }
  }
}

TEST_CASE("what acts on no edge and no leaf that there is is refused in words") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const auto says = [](const Mechanism& mechanism, LoadCase loads) {
    const StrokeResponse r = evaluate_stroke(mechanism, full(), request_with(std::move(loads)));
    CHECK(r.status == Status::no_equilibrium);
    return r.message;
  };
  CHECK(says(m, {.assembly = {{2, 0, Vector3d::Zero(), {}}}}) ==
        "an assembly error is of leaf 2, but there are 2 leaves");
  CHECK(says(m, {.assembly = {{.leaf = 0}, {.leaf = 0}}}) ==
        "two assembly errors are of one edge of leaf 0");
  CHECK(says(cantilever(0.1, 0.02, 5e-4), {.assembly = {{.leaf = 0, .end = 1}}}) ==
        "an assembly error of leaf 0 is not of a clamped edge");
  CHECK(says(m, {.temperature = {1}}) == "there are 1 temperatures, but 2 leaves");
  CHECK(says(m, {.temperature = {0, 1}}) ==
        "leaf 1 is warmed, but its material has no thermal expansion");
  CHECK(says(warm_steel(m), {.temperature = {0, 1e4}}) ==
        "leaf 1 expands by 0.1; expected at most 0.05");
}
