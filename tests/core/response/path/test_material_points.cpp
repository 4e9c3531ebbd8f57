// Leaves with a free tip, guided tips, plates loaded at a material point, load paths and probes.
#include <Eigen/Dense>

#include "core/math/rotation.hpp"
#include "core/response/quantities.hpp"
#include "support/slopes.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {
Mechanism free_tip(double length, double width, double thickness, const Material& m) {
  return models::free_tip(models::single_leaf(length, width, thickness, Direction::uy, m));
}

/// Clamped along x = 0 and x = a; O at (x, z) from the corner.
Mechanism clamped_plate(double a, double width, double thickness, double x, double z,
                        const Material& m) {
  return models::clamped_at_both(models::single_leaf(a, width, thickness, Direction::uy, m), x / a,
                                 z / width);
}

const Material plastic{"plastic", 21.5e9, 0.3, 1200, {}};

}  // namespace

TEST_CASE("a cantilever with a free tip follows the elastica") {
  // nu = 0, narrow and thin: P L²/EI = 1, 4, 10 (elliptic integrals)
  const Material m{"m", 12e9, 0, 1000, {}};
  const double L = 10, w = 0.5, t = 0.05, EI = m.youngs_modulus * w * t * t * t / 12;
  StrokeRequest request{.points = {0, 0.1, 0.25, 0.4, 0.7, 1},
                        .loads = {.growing = {load_at_O(10 * EI / (L * L) * Vector6d::Unit(1))}}};
  request.outputs.remove(Output::stress);
  const StrokeResponse r =
      test::evaluated(free_tip(L, w, t, m), {.accuracy = Accuracy::full, .mesh = {24, 2}}, request);
  const double expected[][3] = {{1, 0.3017207738, 0.0564332363},
                                {3, 0.669964181278, 0.328941242247},
                                {5, 0.81060902488, 0.554995597754}};
  for (const auto& [index, deflection, shortening] : expected) {
    const PathPoint& p = r.path[static_cast<std::size_t>(index)];
    CHECK(p.displacement[1] / L == Approx(deflection).margin(1e-4));
    CHECK(-p.displacement[0] / L == Approx(shortening).margin(1e-4));
    CHECK(p.drive_load == 0);
    CHECK(p.stable);
  }
}

TEST_CASE("superelements follow the cantilever and the clamped plate of their paper", "[slow]") {
  StrokeRequest request{.outputs = Outputs::numbers().remove(Output::stress)};
  ModelOptions model{.accuracy = Accuracy::full, .mesh = {20, 6}};
  SECTION("cantilever 10 x 1 x 0.1 m") {  // thin-shell spline, converged to 5e-6
    const Material m{"m", 12e9, 0.3, 1000, {}};
    request.points = {0, 0.1, 0.2, 0.5, 1};
    request.loads.growing = {load_at_O(1e5 * Vector6d::Unit(1))};
    model.free_edge_torsion = false;
    const StrokeResponse r = test::evaluated(free_tip(10, 1, 0.1, m), model, request);
    const double expected[][3] = {
        {1, 2.986831, 0.5543638}, {3, 7.089432, 3.824957}, {4, 8.063094, 5.491375}};
    for (const auto& [index, deflection, shortening] : expected) {
      const PathPoint& p = r.path[static_cast<std::size_t>(index)];
      CHECK(p.displacement[1] == Approx(deflection).epsilon(5e-4));
      CHECK(-p.displacement[0] == Approx(shortening).epsilon(1e-3));
    }
  }
  SECTION("square plate 400 x 400 x 1.98 mm, clamped on two sides") {
    const double mm = 1e-3;
    const Mechanism plate =
        clamped_plate(400 * mm, 400 * mm, 1.98 * mm, 200 * mm, 80 * mm, plastic);
    request.points = {0, 0.1, 0.5, 1};
    request.loads.growing = {load_at_O(250 * Vector6d::Unit(1))};
    for (const double z : {0.0, 200.0, 320.0})
      request.named_points.push_back(
          *point_on_leaf(plate, std::to_string(z), Vector3d(200 * mm, 0, (z - 200) * mm)));
    model.mesh = {20, 20};
    model.free_edge_torsion = false;
    const StrokeResponse r = test::evaluated(plate, model, request);
    // spline shell, converged to 4e-4: O (z = 80 mm), then the probes
    const double expected[][5] = {{1, 1.89226, 2.02588, 0.822692, 0.212521},
                                  {2, 4.52764, 4.11284, 1.85564, 0.477276},
                                  {3, 6.17851, 5.2229, 2.42743, 0.649486}};
    for (const auto& [index, o, p0, p1, p2] : expected) {
      const PathPoint& p = r.path[static_cast<std::size_t>(index)];
      CHECK(p.displacement[1] == Approx(o * mm).epsilon(5e-3));
      CHECK(p.named_points[0][1] == Approx(p0 * mm).epsilon(5e-3));
      CHECK(p.named_points[1][1] == Approx(p1 * mm).epsilon(5e-3));
      CHECK(p.named_points[2][1] == Approx(p2 * mm).epsilon(1e-2));
    }
  }
}

TEST_CASE("the tangent at a material point is the derivative of its force") {
  const bool clamped = GENERATE(true, false);
  CAPTURE(clamped);
  const Mechanism m = clamped ? clamped_plate(0.1, 0.08, 1e-3, 0.012, 0.03, plastic)
                              : free_tip(0.1, 0.03, 5e-4, plastic);
  System system(m, make_full_leaves(m, {.mesh = {6, 4}}));
  const Vector6d start =
      clamped ? Vector6d(Vector6d::Unit(1) * 1e-3) : Vector6d(Vector6d::Unit(1) * 0.03);
  system.assemble();
  auto settle = [&](const VectorXd& dq) {
    system.move(dq);
    for (int k = 0; k < 12; ++k) {
      system.assemble();
      system.move(VectorXd::Zero(6));
    }
    system.assemble();
  };
  for (int k = 0; k < 4; ++k) settle(0.25 * start);
  const MatrixXd K = system.tangent().dense();
  CHECK((K - K.transpose()).norm() < 1e-9 * K.norm());
  const VectorXd force = system.internal_force();
  const auto state = system.save();
  using Answer = Eigen::Matrix<double, 7, 1>;  // energy and force
  for (int d = 0; d < 3; ++d) {
    const auto at = [&](double x) {
      system.restore(state);
      settle(x * VectorXd::Unit(6, d));
      return Answer((Answer() << system.energy(), system.internal_force()).finished());
    };
    const Answer slope = test::slope_at_zero(at, clamped ? 2e-6 : 1e-5);
    CHECK((slope.tail<6>() - K.col(d)).head<3>().norm() < 1e-3 * K.col(d).head<3>().norm());
    CHECK(slope[0] == Approx(force[d]).epsilon(1e-4).margin(1e-5 * force.norm()));
  }
}

TEST_CASE("a cantilever vibrates as the beam does, its tip free or held") {
  const Material m{"m", 200e9, 0, 7800, {}};
  const double L = 0.1, w = 0.004, t = 2e-4;
  const StrokeResponse r = test::evaluated(
      free_tip(L, w, t, m), {.accuracy = Accuracy::full, .mesh = {16, 2}}, {.frequencies = 3});
  const double unit = t / (L * L) * std::sqrt(m.youngs_modulus / (12 * m.density)) / (2 * M_PI);
  const PathPoint& p = r.path[0];
  CHECK(p.frequencies_free[0] == Approx(3.516015 * unit).epsilon(1e-3));
  CHECK(p.frequencies_free[1] == Approx(22.03449 * unit).epsilon(1e-3));
  CHECK(p.frequencies_locked[0] == Approx(15.41821 * unit).epsilon(1e-3));  // pinned
  CHECK_FALSE(p.support_stiffness[3].has_value());  // a point has no rotation
  CHECK(p.support_stiffness[2].has_value());
}

TEST_CASE("a guided tip moves along x and the drive only") {
  Mechanism guided = models::single_leaf(0.1, 0.02, 5e-4);
  guided.bodies[0].held = {false, false, true, true, true, true};
  // a guide with leaves far apart does not rotate
  Mechanism guide = models::guide(0.1, 0.02, 5e-4, 20.0, 0, 0);
  for (const Accuracy accuracy : {Accuracy::full, Accuracy::reduced}) {
    StrokeRequest request{.points = {0, 0.01, 0.02}, .frequencies = 2};
    guided.bodies[0].mass = 0.1;
    const StrokeResponse one = evaluate_stroke(guided, {.accuracy = accuracy}, request);
    request.frequencies = 0;
    const StrokeResponse two = evaluate_stroke(guide, {.accuracy = accuracy}, request);
    REQUIRE(one.status == Status::ok);
    for (std::size_t k = 0; k < 3; ++k) {
      const PathPoint &p = one.path[k], &q = two.path[k];
      CHECK(p.drive_load == Approx(0.5 * q.drive_load).epsilon(1e-4).margin(1e-9));
      CHECK(p.displacement[0] == Approx(q.displacement[0]).epsilon(1e-4).margin(1e-9));
      CHECK(p.displacement[2] == 0);
      CHECK(p.rotation.norm() == 0);
      CHECK(*p.support_stiffness[0] == Approx(0.5 * *q.support_stiffness[0]).epsilon(1e-3));
      for (int d = 2; d < 6; ++d) CHECK_FALSE(p.support_stiffness[d].has_value());
      CHECK(p.frequencies_free.size() == 2);
    }
  }
}

TEST_CASE("a load path and the stroke it leads to are one equilibrium") {
  const Mechanism leaf = models::single_leaf(0.1, 0.02, 5e-4);
  StrokeRequest driven{.points = {0.02}};
  for (const Accuracy accuracy : {Accuracy::full, Accuracy::reduced}) {
    const StrokeResponse a = test::evaluated(leaf, {.accuracy = accuracy}, driven);
    StrokeRequest loaded{
        .points = {0, 0.5, 1},
        .loads = {.growing = {load_at_O(a.path[0].drive_load * Vector6d::Unit(1))}}};
    const StrokeResponse b = test::evaluated(leaf, {.accuracy = accuracy}, loaded);
    CHECK((b.path[2].displacement - a.path[0].displacement).norm() < 1e-7);
    CHECK((b.path[2].compliance_free - a.path[0].compliance_free).norm() <
          1e-4 * a.path[0].compliance_free.norm());
    // and back at no load nothing is left
    loaded.points = {1, 0};
    const StrokeResponse c = evaluate_stroke(leaf, {.accuracy = accuracy}, loaded);
    CHECK(c.path[1].displacement.norm() < 1e-12);
  }
}

TEST_CASE("a point lies on the leaf it was put on, and nowhere else") {
  const Mechanism guide = models::guide(0.1, 0.02, 5e-4, 0.06);
  CHECK_FALSE(point_on_leaf(guide, "beside", {0.05, 0, 0}).has_value());
  CHECK_FALSE(point_on_leaf(guide, "beyond", {0.11, 0.03, 0}).has_value());
  const auto probe = point_on_leaf(guide, "tip", {0.1, -0.03, 0.01});
  REQUIRE(probe);
  CHECK(probe->leaf == 1);
  CHECK(probe->along == Approx(1));
  CHECK(probe->across == Approx(1));
  for (const Accuracy accuracy : {Accuracy::full, Accuracy::reduced}) {
    StrokeRequest request{
        .points = {0.01},
        .named_points = {*probe,
                         *point_on_leaf(guide, "base", {0, 0.03, 0}),
                         {.name = "sensor", .body = 0, .at = Vector3d(0.2, 0.01, 0)},
                         {.name = "O", .body = 0},
                         {.name = "tilt", .body = 0, .direction = Vector6d::Unit(5)},
                         {.name = "side",
                          .body = 0,
                          .at = Vector3d(0.2, 0.01, 0),
                          .direction = Vector6d::Unit(1)}}};
    const StrokeResponse r = evaluate_stroke(guide, {.accuracy = accuracy}, request);
    // the tip edge is part of the end-effector
    const PathPoint& p = r.path[0];
    const Vector3d arm(0, -0.03, 0.01);
    const Vector3d turned = Eigen::AngleAxisd(p.rotation.norm(), p.rotation.normalized()) * arm;
    CHECK((p.named_points[0] - (p.displacement + turned - arm)).norm() < 1e-9);
    CHECK(p.named_points[1].norm() < 1e-12);
    const Vector3d beyond(0.1, 0.01, 0);
    const Matrix3d turn = rotation_exp(p.rotation);
    CHECK((p.named_points[2] - (p.displacement + turn * beyond - beyond)).norm() < 1e-12);
    CHECK(p.named_points[3] == p.displacement);
    CHECK_FALSE(p.motions_along[2]);
    CHECK(value_of(p, "point.tilt") == p.rotation[2]);
    CHECK(value_of(p, "point.side") == p.named_points[2][1]);
    CHECK_THROWS_AS(value_of(p, "point.sensor"), std::invalid_argument);  // without a direction
  }
}
