// Derivatives of the natural frequencies along the stroke: against differences of the path, under
// symmetry, and where the parabolas hold.
#include <algorithm>
#include <utility>

#include "core/mechanism/profile.hpp"
#include "core/response/path/frequency_derivatives.hpp"
#include "support/gradient_checks.hpp"

using namespace flexopt;

namespace {

// No symmetry at all: the payload's centre of mass lies off every plane.
Mechanism lopsided(Mechanism m, double size) {
  m.bodies[0].mass = 0.3;
  m.bodies[0].inertia = Vector3d(1e-4, 2e-4, 3e-4).asDiagonal();
  m.bodies[0].center_of_mass += size * Vector3d(0.1, 0.04, -0.03);
  return m;
}

struct Case {
  const char* name;
  Mechanism mechanism;
  Flexure flexure = Flexure::plate;
  double step = 3e-3;  ///< of the differences, over a leaf length or 1 rad
};

/// The tip is free, O the middle of it.
Mechanism free_tip() { return models::free_tip(models::single_leaf(0.1, 0.03, 5e-4), 0.02); }

/// Both edges clamped to the ground, O a material point away from every symmetry.
Mechanism clamped_plate() {
  return models::clamped_at_both(models::single_leaf(0.1, 0.06, 5e-4), 0.4, 0.75, 0.02);
}

/// The tip edge of the last leaf on a body of its own.
Mechanism jointed(Mechanism m, JointType type) {
  LeafSpring& leaf = m.leaves.back();
  m.bodies.push_back(models::intermediate(leaf.tip_middle(), 0, 0));
  m.joints = {{"joint", type, 0, 1, leaf.tip_middle(), Vector3d::UnitZ()}};
  leaf.tip = 1;
  return m;
}

std::vector<Case> families() {
  return {
      {"leaf spring", lopsided(models::single_leaf(0.1, 0.03, 5e-4), 0.1)},
      {"guide", lopsided(models::guide(0.1, 0.03, 5e-4), 0.1)},
      {"cross hinge",
       lopsided(models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.02}}), 0.1)},
      {"three-flexure cross hinge", lopsided(models::three_leaf_hinge(0.06, 0.04, 4e-4), 0.1)},
      {"beam guide", lopsided(models::guide(0.1, 0.03, 5e-4), 0.1), Flexure::beam},
      {"free tip", free_tip()},
      {"hinged guide", jointed(lopsided(models::guide(0.1, 0.03, 5e-4), 0.1), JointType::revolute)},
      {"hinge on a ball",
       jointed(lopsided(models::three_leaf_hinge(0.06, 0.04, 4e-4), 0.1), JointType::spherical)},
      // its stroke is measured by its thickness
      {"clamped plate", clamped_plate(), Flexure::plate, 2e-4},
  };
}

double omega2(double hertz) { return std::pow(2 * M_PI * hertz, 2); }

/// First and second derivative of fourth order from values at −2h, −h, 0, h, 2h.
std::pair<double, double> slopes(const std::array<double, 5>& f, double h) {
  return {(8 * (f[3] - f[1]) - (f[4] - f[0])) / (12 * h),
          (16 * (f[3] + f[1]) - (f[4] + f[0]) - 30 * f[2]) / (12 * h * h)};
}

double unit_of(const Mechanism& m) {
  return is_rotation(drive_direction(m)) ? 1 : m.leaves[0].length;
}

/// In the x–y plane only; heavy beside its leaves.
Mechanism planar(Mechanism m, double mass, double inertia, double density) {
  m.bodies[0].mass = mass;
  m.bodies[0].inertia = inertia * Matrix3d::Identity();
  m.bodies[0].held = {false, false, true, true, true, false};
  for (LeafSpring& leaf : m.leaves) {
    leaf.material.youngs_modulus = 210e9;
    leaf.material.density = density;
  }
  return m;
}

}  // namespace

TEST_CASE("modes of a leaf far above those of a heavy body are found") {
  // a notch of 3 um under a body that is thousands of times as heavy as the leaf
  ModelOptions model{.accuracy = Accuracy::full, .mesh = {6, 2}};
  for (const double deep : {490.0, 5e3}) {
    Mechanism m = models::single_leaf(1.14e-3, 4e-3, 2.85e-6);
    for (const double s : profile_stations())
      m.leaves[0].thickness_profile.push_back(1 + deep * (s - 0.5) * (s - 0.5));
    m.bodies = {models::body({1.14e-3, 0, 0}, 6e-3, 8e-10)};
    const auto found = frequency_derivatives(m, model, {}, {}, 4, {}, nullptr);
    CAPTURE(deep, why_not(found));
    REQUIRE(found);
    CHECK(found->modes.size() == 4);
  }
}

TEST_CASE("frequency derivatives agree with differences of the path", "[slow]") {
  int compared = 0;
  for (const Case& c : families()) {
    // so many leaf modes that the path's own error does not show in its differences
    const ModelOptions model{.accuracy = Accuracy::full, .flexure = c.flexure, .leaf_modes = 16};
    const double unit = unit_of(c.mechanism);
    // Central differences of fourth order with two steps: what they differ by is their own error.
    const auto differences = [&](double h) {
      StrokeRequest request{
          .points = {-2 * h, -h, 0, h, 2 * h}, .frequencies = 5, .newton = {.tolerance = 1e-11}};
      request.outputs.remove(Output::stress);
      return evaluate_stroke(c.mechanism, model, request);
    };
    const double h = c.step * unit;
    const StrokeResponse near = differences(h), far = differences(2 * h);
    REQUIRE(near.frequency_derivatives.size() == 5);
    int compared_here = 0;
    for (const FrequencyDerivatives& d : near.frequency_derivatives) {
      const auto along = [&](const StrokeResponse& r, double s) {
        std::array<double, 5> w2;
        for (std::size_t k = 0; k < 5; ++k) w2[k] = omega2(r.path[k].frequencies_free[d.index]);
        return slopes(w2, s);
      };
      const auto [d1, d2] = along(near, h);
      const auto [far1, far2] = along(far, 2 * h);
      const double own1 = std::abs(d1 - far1), own2 = std::abs(d2 - far2);
      compared_here += own2 < 1e-2 * std::abs(d2);
      INFO(c.name << " mode " << d.index << " d1 " << d.d_omega2 << " " << d1 << " +- " << own1
                  << " d2 " << d.d2_omega2 << " " << d2 << " +- " << own2);
      CHECK(d.omega2 == Approx(omega2(near.path[2].frequencies_free[d.index])).epsilon(1e-6));
      CHECK(std::abs(d.d_omega2 - d1) < 1e-4 * std::abs(d1) + 1e-6 * d.omega2 / unit + own1);
      // of two frequencies that nearly meet the differences know nothing: their own error is large
      if (own2 < 1e-2 * std::abs(d2)) {
        CHECK(std::abs(d.d2_omega2 - d2) < 1e-4 * std::abs(d2) + own2);
      }
      CHECK(d.compliance * d.omega2 == Approx(1));
      const double w4 = d.omega2 * d.omega2;
      CHECK(d.d_compliance == Approx(-d.d_omega2 / w4).margin(1e-30));
      CHECK(d.d2_compliance ==
            Approx(-d.d2_omega2 / w4 + 2 * d.d_omega2 * d.d_omega2 / (w4 * d.omega2)));
    }
    INFO(c.name);
    CHECK(compared_here >= 1);
    compared += compared_here;
  }
  CHECK(compared >= 20);
}

TEST_CASE("derivatives through a rigid joint are those of direct assembly") {
  for (const Mechanism& m : {lopsided(models::guide(0.1, 0.03, 5e-4), 0.1),
                             lopsided(models::three_leaf_hinge(0.06, 0.04, 4e-4), 0.1)}) {
    const LoadCase load{.constant = {{.force = {20, 1, -3}, .moment = {0.02, 0.05, 0.01}}}};
    const auto direct = frequency_derivatives(m, ModelOptions{}, load, {.tolerance = 1e-12}, 5);
    const auto joint = frequency_derivatives(jointed(m, JointType::rigid), ModelOptions{}, load,
                                             {.tolerance = 1e-12}, 5);
    REQUIRE(direct);
    REQUIRE(joint);
    for (std::size_t i = 0; i < direct->modes.size(); ++i) {
      const FrequencyDerivatives &a = joint->modes[i], &b = direct->modes[i];
      INFO("mode " << i);
      CHECK(a.omega2 == Approx(b.omega2).epsilon(1e-9));
      CHECK(a.d_omega2 == Approx(b.d_omega2).epsilon(1e-5));
      CHECK(a.d2_omega2 == Approx(b.d2_omega2).epsilon(1e-5));
      CHECK(a.mode.kind == b.mode.kind);
      CHECK(b.d_omega2 != 0);
    }
  }
}

TEST_CASE("first derivatives of symmetric designs vanish") {
  for (const Mechanism& m : {models::guide(0.1, 0.03, 5e-4),
                             models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.02}})}) {
    const auto r = frequency_derivatives(m, ModelOptions{}, LoadCase{}, {}, 8);
    REQUIRE(r);
    for (const FrequencyDerivatives& d : r->modes) {
      CHECK(d.d_omega2 == 0);
      CHECK(d.d2_omega2 != 0);
    }
    CHECK(r->modes[0].mode.kind == ModeKind::drive);
  }
  const auto lop = frequency_derivatives(lopsided(models::guide(0.1, 0.03, 5e-4), 0.1),
                                         ModelOptions{}, LoadCase{}, {}, 4);
  CHECK(std::any_of(lop->modes.begin(), lop->modes.end(),
                    [](const FrequencyDerivatives& d) { return d.d_omega2 != 0; }));
}

TEST_CASE("the parabola of the compliance outlives that of the squared frequency") {
  // guide and cross hinge whose end-effector modes lie far below the leaves' own
  for (const Mechanism& m :
       {models::guide(0.1, 0.03, 5e-4, 0.06, 20, 0.05),
        models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.02}}, 20, 0.05)}) {
    StrokeRequest request;
    const double largest = is_rotation(drive_direction(m)) ? M_PI / 9 : 0.2 * m.leaves[0].length;
    request.points.clear();
    for (int k = 0; k <= 20; ++k) request.points.push_back(largest * k / 20);
    request.frequencies = 6;
    request.outputs.remove(Output::stress);
    const StrokeResponse r = test::evaluated(m, ModelOptions{}, request);
    // a supporting motion: its law is 1/ω² = c0 + c2 s²
    const FrequencyDerivatives* steepest = &r.frequency_derivatives[1];
    CHECK(steepest->mode.kind == ModeKind::end_effector);
    INFO("omega2 to " << steepest->omega2_valid_to.value_or(-1) << ", compliance to "
                      << steepest->compliance_valid_to.value_or(-1));
    REQUIRE(steepest->omega2_valid_to);
    CHECK(*steepest->omega2_valid_to < 0.2 * largest);
    CHECK((!steepest->compliance_valid_to ||
           *steepest->compliance_valid_to > 1.5 * *steepest->omega2_valid_to));
    for (const PathPoint& p : r.path) CHECK(p.parasitic_frequency_screening.has_value());
    CHECK(*r.path[0].parasitic_frequency_screening <= *r.path[0].parasitic_frequency * 1.0001);
  }
}

// ω2/ω2(0) of a planar prototype: the path, then the parabola of 1/ω² from differences of a series
// without leaf inertia. The parabola of ω² is below zero from the second or third stroke on.
TEST_CASE("derivatives at rest foretell parasitic frequencies as the table of the page says") {
  struct Table {
    Mechanism (*make)(double density);
    double unit;
    std::vector<double> strokes, path, foretold;
    int negative;  ///< first row where the parabola of ω² says nothing
  };
  const double degree = M_PI / 180;
  const Table tables[] = {
      {[](double density) { return planar(models::guide(0.1, 0.03, 5e-4), 30, 0.032, density); },
       0.1,
       {0.02, 0.05, 0.1, 0.2, 0.3},
       {0.880, 0.601, 0.352, 0.181, 0.117},
       {0.886, 0.607, 0.356, 0.187, 0.126},
       1},
      {[](double density) {
         return planar(models::hinge(0.1, 5e-4, {{1, 0.0155, 0.03}, {-1, -0.0155, 0.03}}), 20,
                       1.0 / 30, density);
       },
       degree,
       {1, 2, 5, 10, 20, 30},
       {0.862, 0.689, 0.391, 0.213, 0.109, 0.072},
       {0.912, 0.743, 0.406, 0.217, 0.110, 0.074},
       2}};
  const ModelOptions model{.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {20, 1}};
  for (const Table& t : tables) {
    StrokeRequest request;
    for (const double s : t.strokes) request.points.push_back(s * t.unit);
    request.frequencies = 3;
    request.outputs.remove(Output::stress);
    const StrokeResponse heavy = evaluate_stroke(t.make(7800), model, request);
    const StrokeResponse light = evaluate_stroke(t.make(1), model, request);
    REQUIRE(heavy.status == Status::ok);
    const FrequencyDerivatives& d = light.frequency_derivatives[1];
    for (std::size_t k = 0; k < t.strokes.size(); ++k) {
      const double s = request.points[k + 1];
      INFO("stroke " << s);
      CHECK(heavy.path[k + 1].frequencies_free[1] / heavy.path[0].frequencies_free[1] ==
            Approx(t.path[k]).margin(1.2e-3));
      const double compliance = d.compliance + 0.5 * s * s * d.d2_compliance;
      CHECK(std::sqrt(d.compliance / compliance) == Approx(t.foretold[k]).margin(1.2e-3));
      CHECK(std::sqrt(d.compliance / compliance) ==
            Approx(light.path[k + 1].frequencies_free[1] / light.path[0].frequencies_free[1])
                .epsilon(0.08));
      const double parabola = d.omega2 + 0.5 * s * s * d.d2_omega2;
      CHECK((parabola > 0) == (static_cast<int>(k) < t.negative));
    }
  }
}

TEST_CASE("screening alone solves no equilibrium") {
  StrokeRequest request{.points = {0, 0.005, 0.01}, .frequencies = 4};
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeResponse all = evaluate_stroke(m, ModelOptions{}, request);
  request.outputs = {Output::frequency_derivatives};
  const StrokeResponse r = evaluate_stroke(m, ModelOptions{}, request);
  CHECK(r.status == Status::ok);
  for (int k = 0; k < 3; ++k) {
    CHECK(r.path[k].status == PointStatus::not_reached);
    CHECK(value_of(r.path[k], "parasitic_frequency_screening") ==
          value_of(all.path[k], "parasitic_frequency_screening"));
    CHECK(!value_of(r.path[k], "parasitic_frequency"));
  }
}

TEST_CASE("a dead load moves the state that frequencies are derived about") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const double h = 3e-4;
  const StrokeRequest request{
      .points = {-2 * h, -h, 0, h, 2 * h},
      .loads = {.constant = {{.force = {40, 0, -3}, .moment = {0.02, 0.1, 0}}}},
      .outputs = Outputs::numbers().remove(Output::stress),
      .frequencies = 2,
      .newton = {.tolerance = 1e-11}};
  const StrokeResponse r = test::evaluated(m, {.accuracy = Accuracy::full}, request);
  for (const FrequencyDerivatives& d : r.frequency_derivatives) {
    std::array<double, 5> w2;
    for (std::size_t k = 0; k < 5; ++k) w2[k] = omega2(r.path[k].frequencies_free[d.index]);
    const auto [first, second] = slopes(w2, h);
    INFO("mode " << d.index);
    CHECK(d.omega2 == Approx(w2[2]).epsilon(1e-7));
    CHECK(d.d_omega2 == Approx(first).epsilon(1e-4).margin(1e-6 * d.omega2 / 0.1));
    CHECK(d.d2_omega2 == Approx(second).epsilon(1e-4));
  }
}

TEST_CASE("along turns of tilted bodies frequencies change as differences of the path say") {
  Mechanism m{.bodies = {models::body({0.06, 0.05, 0.006}, 0.3, 1e-4),
                         models::intermediate({0.06, 0, 0}, 0.2, 2e-4)}};
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.004, -0.003);
  m.leaves = {models::between(ground, 1, models::leaf({0, 0, 0}, {1, 0, 0}, 0.06, 5e-3, 5e-4)),
              models::between(1, 0, models::leaf({0.06, 0, 0}, {0, 1, 0}, 0.05, 6e-3, 5e-4))};
  const bool several = GENERATE(false, true);
  m.drives = {{"roll", 0, ground, Direction::rx}};
  if (several) {
    m.drives[0].axes = Eigen::AngleAxisd(0.4, Vector3d(0.36, 0.48, 0.8)).toRotationMatrix();
    m.drives.push_back({"turn", 0, 1, Direction::rz});
  }
  const auto drives = static_cast<Eigen::Index>(m.drives.size());
  const double h = 0.01;
  StrokeRequest request{
      .points = {},
      .loads = {.constant = {{.force = {0.5, 0.4, -0.8}, .arm = {0.01, 0, 0.02}}}},
      .outputs = Outputs::numbers().remove(Output::stress),
      .values = PathValues::differentiable,
      .frequencies = 4,
      .newton = {.tolerance = 1e-12}};
  for (Eigen::Index k = 0; k < drives; ++k)
    for (const double s : {-4 * h, -2 * h, -h, 0.0, h, 2 * h, 4 * h}) {
      request.strokes.push_back(s * VectorXd::Unit(drives, k));
      request.points.push_back(request.strokes.back()[0]);
    }
  const StrokeResponse r = test::evaluated(m, models::beams(6), request);
  REQUIRE(r.path[3].rotation.norm() > 0.09);  // tilted before it is driven
  REQUIRE(r.frequency_derivatives.size() == 4 * m.drives.size());
  for (const FrequencyDerivatives& d : r.frequency_derivatives) {
    const auto w2 = [&](int k) {
      return omega2(r.path[7 * d.drive + 3 + k].frequencies_free[d.index]);
    };
    // from two steps, whose difference is their error
    const auto [d1, d2] = slopes({w2(-2), w2(-1), w2(0), w2(1), w2(2)}, h);
    const auto [far1, far2] = slopes({w2(-3), w2(-2), w2(0), w2(2), w2(3)}, 2 * h);
    const double own1 = std::abs(d1 - far1) / 15, own2 = std::abs(d2 - far2) / 15;
    INFO("drive " << d.drive << " mode " << d.index << " of " << d.omega2 << ": " << d.d_omega2
                  << ", " << d1 << " +- " << own1 << "; " << d.d2_omega2 << ", " << d2 << " +- "
                  << own2);
    CHECK(d.omega2 == Approx(w2(0)).epsilon(1e-8));
    CHECK(std::abs(d.d_omega2 - d1) < 1e-6 * (std::abs(d1) + d.omega2) + 2 * own1);
    const double rounding = 1e-9 * d.omega2 * 30 / (12 * h * h);
    CHECK(std::abs(d.d2_omega2 - d2) < 1e-5 * std::abs(d2) + rounding + 2 * own2);
    CHECK(own1 < 1e-4 * (std::abs(d1) + d.omega2));
    CHECK(own2 < 1e-3 * (std::abs(d2) + d.omega2));
  }
}

// The path's own factor and modes at rest are taken where it has them.
TEST_CASE("a path with a point at rest foretells as one without") {
  const test::Family family{
      [](const test::Values& p) { return lopsided(models::guide(p[0], p[1], p[2]), 0.1); },
      {{"length", 0.1}, {"width", 0.03}, {"thickness", 5e-4}},
      {0, 2},
      10.0};
  const Mechanism m = family.make(test::values_of(family.numbers));
  std::vector<MechanismDirection> directions;
  for (const std::size_t k : family.along) directions.push_back(test::direction(family, k));
  for (const Accuracy accuracy : {Accuracy::full, Accuracy::reduced}) {
    StrokeRequest request{.frequencies = 4};
    request.outputs.remove(Output::frequencies_free);  // foretold all the same
    request.loads.constant = {{.force = {4, 0, -3}, .moment = {0.02, 0.1, 0}}};
    request.newton.tolerance = 1e-11;
    const auto over = [&](std::vector<double> points) {
      request.points = std::move(points);
      StrokeSensitivity found =
          evaluate_stroke_gradients(m, directions, {.accuracy = accuracy}, request);
      REQUIRE(found.response.status == Status::ok);
      REQUIRE(found.gradients);
      REQUIRE(found.response.frequency_derivatives.size() == 4);
      REQUIRE(found.gradients->frequency_derivatives.size() == 4);
      return found;
    };
    const StrokeSensitivity with = over({0, 0.004}), without = over({0.004});
    for (const PathPoint& p : with.response.path) {
      CHECK(p.modes_free.empty());
      CHECK(p.modes_locked.size() == 4);
    }
    CHECK(with.gradients->path[0].frequencies_free.rows() == 0);
    for (std::size_t k = 0; k < 4; ++k) {
      const FrequencyDerivatives &a = with.response.frequency_derivatives[k],
                                 &b = without.response.frequency_derivatives[k];
      CHECK(a.omega2 == Approx(b.omega2).epsilon(1e-9));
      CHECK(a.d_omega2 == Approx(b.d_omega2).epsilon(1e-7).margin(1e-9 * b.omega2 / 0.1));
      CHECK(a.d2_omega2 == Approx(b.d2_omega2).epsilon(1e-7));
      CHECK(a.mode.frequency == Approx(b.mode.frequency).epsilon(1e-9));
      const FrequencyDerivativeGradients &da = with.gradients->frequency_derivatives[k],
                                         &db = without.gradients->frequency_derivatives[k];
      REQUIRE(db.d2_omega2.norm() > 0);
      CHECK((da.omega2 - db.omega2).norm() < 1e-8 * db.omega2.norm());
      CHECK((da.d_omega2 - db.d_omega2).norm() < 1e-6 * db.d_omega2.norm());
      CHECK((da.d2_omega2 - db.d2_omega2).norm() < 1e-6 * db.d2_omega2.norm());
    }
    const PathPoint &at = with.response.path[1], &alone = without.response.path[0];
    REQUIRE(alone.parasitic_frequency_screening);
    CHECK(*at.parasitic_frequency_screening ==
          Approx(*alone.parasitic_frequency_screening).epsilon(1e-8));
  }
}

TEST_CASE("along several strokes at once frequencies change as along one drive that points there") {
  const double angle = 0.6, far = 2e-3;
  const auto driven = [&](const Matrix3d& axes) {
    Mechanism m = lopsided(models::single_leaf(0.1, 0.03, 5e-4), 0.1);
    m.drives = {make_drive(Direction::uy), make_drive(Direction::uz)};
    m.drives[0].name = "first";
    m.drives[1].name = "second";
    for (Drive& drive : m.drives) drive.axes = axes;
    return m;
  };
  const Matrix3d turn = Eigen::AngleAxisd(angle, Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Vector2d way = far * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const auto both = frequency_derivatives(driven(Matrix3d::Identity()), ModelOptions{}, LoadCase{},
                                          {}, 4, {way, Eigen::Vector2d(0, far)});
  const auto one = frequency_derivatives(driven(turn), ModelOptions{}, LoadCase{}, {}, 4,
                                         {Eigen::Vector2d(far, 0)});
  REQUIRE(both);
  REQUIRE(one);
  REQUIRE(both->ways.size() == 2);
  const auto close = [](double a, double b, double size) {
    return std::abs(a - b) <= 1e-6 * (std::abs(a) + std::abs(b)) + 1e-9 * size;
  };
  for (std::size_t k = 0; k < 4; ++k) {
    const FrequencyDerivatives &a = both->ways[0].modes[k], &b = one->ways[0].modes[k];
    CAPTURE(k, a.d_omega2, b.d_omega2, a.d2_omega2, b.d2_omega2);
    CHECK(a.omega2 == Approx(b.omega2).epsilon(1e-9));
    CHECK(close(a.d_omega2, b.d_omega2, a.omega2));
    CHECK(close(a.d2_omega2, b.d2_omega2, a.omega2));
    // by the number of the way: 1 at its end
    const FrequencyDerivatives &c = both->ways[1].modes[k], &d = both->modes[4 + k];
    REQUIRE(d.drive == 1);
    CHECK(c.d_omega2 == Approx(far * d.d_omega2));
    CHECK(c.d2_omega2 == Approx(far * far * d.d2_omega2));
  }
}

TEST_CASE("screening foretells the frequencies of points of several strokes") {
  Mechanism m = lopsided(models::single_leaf(0.1, 0.03, 5e-4), 0.1);
  m.drives = {make_drive(Direction::uy), make_drive(Direction::rx)};
  m.drives[0].name = "bend";
  m.drives[1].name = "twist";
  StrokeRequest request;
  for (const double by : {0.0, 0.5, 1.0, -1.0})
    for (const double side : {1.0, -1.0})
      request.strokes.push_back(by * Eigen::Vector2d(4e-3, side * 0.04));
  for (const VectorXd& s : request.strokes) request.points.push_back(s[0]);
  request.points.erase(request.points.begin());
  request.frequencies = 4;
  request.parasitic.drive = DriveState::free;
  const ModelOptions model{.accuracy = Accuracy::full, .leaf_modes = 8};
  const StrokeResponse response = test::evaluated(m, model, request);
  REQUIRE(response.frequency_ways.size() == 2);
  double change = 0, error = 0;
  const PathPoint& rest = response.path[0];
  for (const PathPoint& p : response.path) {
    REQUIRE(p.parasitic_frequency);
    REQUIRE(p.parasitic_frequency_screening);
    CHECK(*p.parasitic_frequency_screening == Approx(*p.parasitic_frequency).epsilon(2e-3));
    const double by = *p.parasitic_frequency / *rest.parasitic_frequency - 1;
    change = std::max(change, std::abs(by));
    error = std::max(
        error,
        std::abs(*p.parasitic_frequency_screening / *rest.parasitic_frequency_screening - 1 - by));
  }
  CAPTURE(change, error);
  CHECK(change > 1e-4);
  CHECK(error < 0.1 * change);
}

TEST_CASE("of frequencies below very many equal ones there are derivatives") {
  // leaves in one place, with as many times the payload: the motions of the body are those of one
  const auto stack = [](int leaves) {
    Mechanism m = lopsided(models::single_leaf(0.1, 0.03, 5e-4), 0.1);
    m.bodies[0].mass *= leaves;
    m.bodies[0].inertia *= leaves;
    m.leaves.resize(static_cast<std::size_t>(leaves), m.leaves[0]);
    return m;
  };
  const ModelOptions model{.accuracy = Accuracy::full, .mesh = {4, 2}};
  const auto one = frequency_derivatives(stack(1), model, LoadCase{}, {}, 6),
             many = frequency_derivatives(stack(70), model, LoadCase{}, {}, 6);
  REQUIRE(one);
  REQUIRE(many);
  REQUIRE(many->modes.size() >= 2);
  REQUIRE(many->modes.size() < 6);
  CHECK(many->note.find("too near each other") != std::string::npos);
  for (std::size_t k = 0; k < many->modes.size(); ++k) {
    CHECK(many->modes[k].omega2 == Approx(one->modes[k].omega2).epsilon(1e-7));
    CHECK(many->modes[k].d2_omega2 == Approx(one->modes[k].d2_omega2).epsilon(1e-5));
  }
}

TEST_CASE("a path says why it has no frequency derivatives") {
  StrokeRequest request{.loads = {.constant = {{.force = {20, 1, -3}}}}, .frequencies = 3};
  const ModelOptions model{.accuracy = Accuracy::full, .mesh = {4, 2}};
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeResponse whole = evaluate_stroke(m, model, request);
  CHECK(whole.no_frequency_derivatives.empty());
  CHECK_FALSE(whole.frequency_derivatives.empty());
  // the derivatives come last: among all limits there are those that end them alone
  int cut = 0;
  for (int most = 1; most < 30; ++most) {
    request.limits.iterations = most;
    const StrokeResponse response = evaluate_stroke(m, model, request);
    if (response.path[0].status != PointStatus::converged ||
        response.status != Status::limit_reached)
      continue;
    ++cut;
    CHECK(response.frequency_derivatives.empty());
    CHECK_FALSE(response.no_frequency_derivatives.empty());
    CHECK(response.message == "all 1 stroke points converged; no frequency derivatives: " +
                                  response.no_frequency_derivatives);
  }
  CHECK(cut > 0);
}
