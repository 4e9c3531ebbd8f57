// Stress of elastic bodies in what a mechanism answers: against beams, differences and itself.
#include <catch2/catch.hpp>
#include <numeric>

#include "core/response/stress_safety.hpp"
#include "support/gradient_checks.hpp"
#include "support/solid_box.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

constexpr int along = 12;

Material strong() {
  Material m = models::aluminium();
  m.yield_strength = 300e6;
  m.ultimate_strength = 400e6;
  m.endurance_limit = 100e6;
  return m;
}

// A square bar along x from the ground to O.
Mechanism bar(double length = 0.1, double side = 0.01, double modulus = 70e9,
              ElasticDegree degree = ElasticDegree::linear) {
  Mechanism m;
  m.bodies = {models::body({length, 0, 0}, 0.1, 1e-5)};
  ElasticBody box = models::box({length, side, side}, {along, 2, 2}, strong());
  box.name = "bar";
  box.material.youngs_modulus = modulus;
  box.place = {0.5 * length, 0, 0};
  box.degree = degree;
  models::hold_end(box, "base", ground, -1);
  models::hold_end(box, "tip", 0, 1);
  m.elastic_bodies = {box};
  m.drives = {make_drive(Direction::uy, 0)};
  return m;
}

}  // namespace

TEST_CASE("the largest stress of a bent bar is that of a beam, in the second row of cells") {
  const double s = 1e-3, length = 0.1, side = 0.01;
  StrokeRequest request{.points = {0, s, -s}};
  request.stress.yield = true;
  const StrokeResponse r = evaluated(bar(), {}, request);
  CHECK(r.path[0].max_stress->value < 1e-3);
  const PathPoint& p = r.path[1];
  REQUIRE(p.max_stress);
  REQUIRE(p.max_stress->elastic_body == 0);
  // nodes of cells beside the patch do not count: the first that do are in the middle of the next
  const double arm = length * (1 - 1.5 / along), I = std::pow(side, 4) / 12;
  CHECK(p.max_stress->value == Approx(p.drive_load * arm * 0.5 * side / I).epsilon(0.03));
  CHECK(p.max_stress->position[0] == Approx(1.5 * length / along).margin(1e-4));
  CHECK(std::abs(p.max_stress->position[1]) == Approx(0.5 * side).margin(1e-4));
  CHECK(r.path[2].max_stress->value == Approx(p.max_stress->value).epsilon(1e-6));
  REQUIRE(p.elastic_bodies[0].stress);
  CHECK(p.elastic_bodies[0].stress->value == p.max_stress->value);
  CHECK(p.elastic_bodies[0].stress_jump > 0);
  CHECK(p.elastic_bodies[0].stress_jump < 0.2 * p.max_stress->value);
  CHECK(p.yield_safety->value == Approx(300e6 / p.max_stress->value).epsilon(1e-12));
  request.outputs.remove(Output::stress);
  const PathPoint without = evaluated(bar(), {}, request).path[1];
  CHECK_FALSE(without.max_stress);
  CHECK_FALSE(without.elastic_bodies[0].stress);
}

TEST_CASE("cycles of an elastic body between the ends of a stroke are those of a stress ratio") {
  StrokeRequest request{.points = {-1e-3, 1e-3}};
  request.stress.fatigue = true;
  const PathPoint history = evaluated(bar(), {}, request).path[1];
  request.stress.fatigue_rule.stress_ratio = -1;
  const PathPoint ratio = evaluated(bar(), {}, request).path[1];
  REQUIRE(history.fatigue_safety);
  REQUIRE(ratio.fatigue_safety);
  CHECK(history.fatigue_safety->stress.elastic_body == 0);
  CHECK(history.fatigue_safety->amplitude == Approx(ratio.max_stress->value).epsilon(1e-3));
  CHECK(history.fatigue_safety->value == Approx(ratio.fatigue_safety->value).epsilon(1e-3));
  CHECK(ratio.fatigue_safety->value == Approx(100e6 / ratio.max_stress->value).epsilon(1e-9));
  CHECK(history.sections.empty());
}

TEST_CASE("strokes and loads are limited by the stress of an elastic body") {
  const double limit = 150e6;
  StrokeRequest request{.points = {1e-3}};
  request.stroke_capacity = {{.up_to = 0.01, .stress = limit}};
  request.capacity.directions[0] = true;
  request.capacity.stress = limit;
  const PathPoint p = evaluated(bar(), {}, request).path[0];
  REQUIRE(p.stroke_capacity[0]);
  CHECK(p.stroke_capacity[0]->limit == StrokeLimit::stress);
  CHECK(p.stroke_capacity[0]->reason.find("bar") != std::string::npos);
  CHECK(p.stroke_capacity[0]->value == Approx(1e-3 * limit / p.max_stress->value).epsilon(1e-2));
  REQUIRE(p.load_capacity[0]);
  CHECK(p.load_capacity[0]->limit == CapacityLimit::stress);
  request.loads.constant = {{.force = {p.load_capacity[0]->value, 0, 0}}};
  const PathPoint loaded = evaluated(bar(), {}, {.points = {1e-3}, .loads = request.loads}).path[0];
  CHECK(loaded.max_stress->value == Approx(limit).epsilon(1e-4));
}

TEST_CASE("stress and safeties of elastic bodies have exact derivatives", "[slow]") {
  for (const ElasticDegree degree : {ElasticDegree::linear, ElasticDegree::quartic}) {
    const Family family{[&](const Values& v) { return bar(v[0], v[1], v[2], degree); },
                        {{"length", 0.1}, {"side", 0.01}, {"modulus", 70e9}},
                        {0, 1, 2},
                        10.0};
    StrokeRequest request{
        .points = {-4e-4, 1e-3},
        .loads = {.constant = {{.force = {20, 0, -12}, .moment = {0.3, 0.2, 0.1}}}}};
    request.stress.yield = request.stress.fatigue = true;
    request.stress_peaks = 3;
    request.stroke_capacity = {{.up_to = 0.01, .ways = {true, false}, .stress = 150e6}};
    // along the bar, up to such a stress, a body of degree 2 does not hold a load
    request.capacity.directions[0] = degree == ElasticDegree::quartic;
    request.capacity.stress = 150e6;
    request.values = PathValues::differentiable;
    request.newton.tolerance = 1e-11;
    const StrokeSensitivity exact = evaluate_stroke_gradients(
        family.make(values_of(family.numbers)), directions_of(family), {}, request);
    INFO(exact.message << exact.response.message);
    REQUIRE(exact.gradients);
    const auto numbers = [](const PathPoint& p) {
      return Values{p.max_stress->value, p.yield_safety->value, p.fatigue_safety->value,
                    p.load_capacity[0] ? p.load_capacity[0]->value : 0,
                    p.stroke_capacity[0]->value};
    };
    for (std::size_t k = 0; k < family.along.size(); ++k) {
      const Derivatives d = differences_along(family, k, 0.02, [&](const Mechanism& m) {
        Values all;
        for (const PathPoint& p : evaluated(m, {}, request).path)
          for (const double x : numbers(p)) all.push_back(x);
        return all;
      });
      for (std::size_t i = 0; i < 2; ++i) {
        const PointGradients& g = exact.gradients->path[i];
        const auto at = static_cast<Eigen::Index>(k);
        const Values found{(*g.max_stress)[at], (*g.yield_safety)[at], (*g.fatigue_safety)[at],
                           g.load_capacity[0] ? (*g.load_capacity[0])[at] : 0,
                           (*g.stroke_capacity[0])[at]};
        const Values here = numbers(exact.response.path[i]);
        for (std::size_t n = 0; n < found.size(); ++n) {
          const double size = std::max(std::abs(d.value[5 * i + n]),
                                       0.1 * std::abs(here[n] / family.numbers[k].value));
          INFO(family.numbers[k].name << ", number " << n << " at point " << i << ": " << found[n]
                                      << " not " << d.value[5 * i + n]);
          CHECK(std::abs(found[n] - d.value[5 * i + n]) <= 1e-6 * size);
        }
        const auto& peaks = exact.response.path[i].stress_peaks;
        REQUIRE_FALSE(peaks.empty());
        CHECK(peaks[0].value == exact.response.path[i].max_stress->value);
        CHECK(g.stress_peaks.rows() == static_cast<Eigen::Index>(peaks.size()));
      }
    }
  }
}

TEST_CASE("the surface of an elastic body is closed, and moves with what holds it") {
  const double length = 0.1, side = 0.01;
  StrokeRequest request{.points = {1e-3}, .frequencies = 2};
  request.outputs.add(Output::shapes);
  const Mechanism m = bar();
  const PathPoint p = evaluated(m, {}, request).path[0];
  REQUIRE(p.elastic_shapes.size() == 1);
  const ElasticShape& shape = p.elastic_shapes[0];
  double area = 0, volume = 0;
  for (const auto& [a, b, c] : shape.triangles) {
    const Vector3d &x = shape.undeflected[a], &y = shape.undeflected[b], &z = shape.undeflected[c];
    area += 0.5 * (y - x).cross(z - x).norm();
    volume += x.dot(y.cross(z)) / 6;
  }
  CHECK(area == Approx(2 * side * side + 4 * side * length).epsilon(1e-12));
  CHECK(volume == Approx(side * side * length).epsilon(1e-12));
  REQUIRE(p.modes_free[0].elastic_motion.size() == 1);
  const VectorXd& motion = p.modes_free[0].elastic_motion[0];
  REQUIRE(motion.size() == 3 * std::ssize(shape.undeflected));
  const Vector3d O = m.bodies[0].reference + p.displacement;
  const VectorXd& body = p.modes_free[0].body_motion;
  for (std::size_t k = 0; k < shape.undeflected.size(); ++k) {
    const auto at = 3 * static_cast<Eigen::Index>(k);
    if (shape.undeflected[k][0] < 1e-9) {
      CHECK((shape.deflected[k] - shape.undeflected[k]).norm() < 1e-6);
      CHECK(motion.segment<3>(at).norm() < 0.03 * motion.cwiseAbs().maxCoeff());
    }
    if (shape.undeflected[k][0] < length - 1e-9) continue;
    const Vector3d arm = shape.deflected[k] - O;
    CHECK(std::abs(arm.norm() - (shape.undeflected[k] - m.bodies[0].reference).norm()) < 2e-5);
    const Vector3d rigid = body.head<3>() + Vector3d(body.segment<3>(3)).cross(arm);
    CHECK((motion.segment<3>(at) - rigid).norm() < 0.03 * motion.cwiseAbs().maxCoeff());
  }
}
