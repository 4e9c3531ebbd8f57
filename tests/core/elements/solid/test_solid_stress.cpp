// Stress of condensed bodies: surfaces, beam theory, the peak of a notch, derivatives.
#include "core/elements/solid/solid_stress.hpp"

#include <catch2/catch.hpp>
#include <map>
#include <utility>

#include "notch_body.hpp"
#include "support/slopes.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

constexpr SolidCell all_cells[] = {SolidCell::hexahedron, SolidCell::wedge, SolidCell::tetrahedron};

// Both interfaces move against each other: displacement [m], turn [rad].
VectorXd apart(const Vector6d& motion) {
  VectorXd d(12);
  d << -0.5 * motion, 0.5 * motion;
  return d;
}

SolidStress stress_of(const ElasticBody& body, const VectorXd& d) {
  return solid_stress(body, solid_surface(body), solid_displacements(*condensed(body), d));
}

}  // namespace

TEST_CASE("triangles of a surface close it and look outwards") {
  for (const SolidCell cell : all_cells) {
    const ElasticBody body = box_body(cell, {3, 2, 2}, material(1, 0.3, 1), {0.6, 0.4, 0.2});
    std::map<std::pair<int, int>, int> sides;
    double volume = 0, area = 0;
    for (const auto& [a, b, c] : surface_triangles(*body.cells)) {
      for (const auto& side : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) ++sides[side];
      const auto at = [&](int k) { return body.nodes[static_cast<std::size_t>(k)]; };
      volume += at(a).dot(at(b).cross(at(c))) / 6;
      area += (at(b) - at(a)).cross(at(c) - at(a)).norm() / 2;
    }
    CHECK(volume == Approx(0.6 * 0.4 * 0.2));
    CHECK(area == Approx(2 * (0.6 * 0.4 + 0.4 * 0.2 + 0.2 * 0.6)));
    for (const auto& [side, count] : sides) {
      CHECK(count == 1);
      CHECK(sides.contains({side.second, side.first}));
    }
  }
}

TEST_CASE("a bent box has the stress and the energy of a beam") {
  const double E = 200e9, length = 0.1, height = 0.01, width = 0.008, turn = 1e-3;
  Vector6d motion = Vector6d::Zero();
  motion[5] = turn;
  for (const SolidCell cell : all_cells) {
    const ElasticBody body =
        box_body(cell, {8, 2, 2}, material(E, 0, 7800), {length, height, width});
    const SolidSurface surface = solid_surface(body);
    const SolidStress stress =
        solid_stress(body, surface, solid_displacements(*condensed(body), apart(motion)));
    for (std::size_t k = 0; k < surface.nodes.size(); ++k) {
      SolidTensor beam = SolidTensor::Zero();
      beam[0] = -E * body.nodes[static_cast<std::size_t>(surface.nodes[k])].y() * turn / length;
      CHECK((stress.at_nodes[k] - beam).norm() < 1e-6 * E * height * turn / length);
      CHECK(stress.von_mises[k] == Approx(std::abs(beam[0])).margin(1e3));
    }
    CHECK(stress.energy ==
          Approx(0.5 * E * width * std::pow(height, 3) / 12 * turn * turn / length));
    REQUIRE(stress.largest);
    CHECK(stress.largest->von_mises == Approx(0.5 * E * height * turn / length));
    CHECK(stress.largest->jump < 1e-6 * stress.largest->von_mises);
  }
}

TEST_CASE("a strip of degree 4 has the stress of its curvature and of its kept chord alone") {
  const double E = 200e9, length = 0.1, height = 0.002, turn = 0.1, bending = 200e6;
  ElasticBody body =
      box_body(SolidCell::hexahedron, {8, 2, 2}, material(E, 0, 7800), {length, height, 0.008});
  Vector6d motion = Vector6d::Zero();
  motion[5] = turn;
  body.degree = ElasticDegree::quartic;
  // an arc is longer than its chord by θ²/24
  const auto finite = stress_of(body, apart(motion)).largest;
  REQUIRE(finite);
  CHECK(finite->von_mises == Approx(bending + E * turn * turn / 24).epsilon(0.003));
  body.degree = ElasticDegree::linear;
  const auto linear = stress_of(body, apart(motion)).largest;
  REQUIRE(linear);
  CHECK(linear->von_mises == Approx(bending));
}

TEST_CASE("cells beside patches do not count for the largest stress") {
  const ElasticBody body =
      box_body(SolidCell::hexahedron, {6, 4, 4}, material(200e9, 0.3, 7800), {0.03, 0.01, 0.01});
  const SolidSurface surface = solid_surface(body);
  Vector6d motion = Vector6d::Zero();
  motion[0] = 1e-6;
  const SolidStress stress =
      solid_stress(body, surface, solid_displacements(*condensed(body), apart(motion)));
  double beside = 0, elsewhere = 0;
  for (std::size_t k = 0; k < surface.nodes.size(); ++k) {
    const double x = body.nodes[static_cast<std::size_t>(surface.nodes[k])].x();
    CHECK(surface.beside_patch[k] == (std::abs(x) > 0.01 - 1e-9));
    double& largest = surface.beside_patch[k] ? beside : elsewhere;
    largest = std::max(largest, stress.von_mises[k]);
  }
  REQUIRE(stress.largest);
  CHECK(stress.largest->von_mises == Approx(elsewhere));
  CHECK(elsewhere < beside);
}

TEST_CASE("the peak of a notch is that of a finer mesh within its estimated error") {
  Vector6d motion = Vector6d::Zero();
  motion[5] = 0.01;
  for (const double thickness : {0.5e-3, 1e-3}) {
    ElasticBody body = notch_body({.thickness = thickness}, {20, 3, 4}),
                fine = notch_body({.thickness = thickness}, {32, 4, 6});
    for (ElasticBody* b : {&body, &fine}) b->degree = ElasticDegree::linear;
    const auto found = stress_of(body, apart(motion)).largest,
               exact = stress_of(fine, apart(motion)).largest;
    REQUIRE((found && exact));
    CHECK(found->von_mises == Approx(exact->von_mises).epsilon(0.02));
    CHECK(std::abs(found->von_mises - exact->von_mises) < found->jump);
    CHECK(std::abs(found->place.x()) < 1e-9);
    CHECK(std::abs(found->place.y()) == Approx(thickness / 2));
    // bending of the thinnest section, 6 M/(w t²), times the factor of a shallow notch
    const double moment = condensed(fine)->model.stiffness(11, 11) * 0.01,
                 nominal = 6 * moment / (10e-3 * thickness * thickness);
    CHECK(exact->von_mises / nominal ==
          Approx(std::pow(1 + thickness / 10e-3, 0.45)).epsilon(0.08));
  }
}

TEST_CASE("derivatives of the stress at a node are exact") {
  for (const ElasticDegree degree : {ElasticDegree::linear, ElasticDegree::quartic}) {
    ElasticBody body = notch_body({}, {6, 2, 2});
    body.degree = degree;
    const ElasticBody direction = any_direction(body);
    Vector6d motion, rate;
    motion << 2e-6, 1e-6, 3e-6, 0.01, 0.02, 0.05;
    rate << 1e-6, -3e-6, 2e-6, 0.03, -0.01, 0.02;
    const VectorXd d = apart(motion), d_rate = apart(rate);
    const auto solid = condensed(body);
    const VectorXd u = solid_displacements(*solid, d),
                   u_rate =
                       solid_displacement_rates(*solid, *field_rates(body, direction), d, d_rate);
    const SolidSurface surface = solid_surface(body);
    for (const int node : {surface.nodes[3], solid_stress(body, surface, u).largest->node}) {
      const auto at = [&](double h) {
        const ElasticBody moved = moved_body(body, direction, h);
        const VectorXd displaced = solid_displacements(*condensed(moved), d + h * d_rate);
        const SolidStress stress = solid_stress(moved, surface, displaced);
        const auto place = std::ranges::find(surface.nodes, node) - surface.nodes.begin();
        return stress.von_mises[static_cast<std::size_t>(place)];
      };
      const RatedTensor found = node_stresses(body, direction, u, u_rate, {node}).front();
      CHECK(von_mises_stress(found.value) == Approx(at(0)));
      CHECK(von_mises_rate(found.value, found.rate) ==
            Approx(slope_at_zero(at, 1e-3)).epsilon(1e-7));
    }
  }
}
