// Gain and cross-coupling: closed forms, the path that they are derivatives of, their gradients.
#include "core/response/gain.hpp"

#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

ModelOptions beams() {
  return {.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {8, 1}};
}

StrokeRequest at(std::vector<double> strokes) {
  return {.points = std::move(strokes),
          .outputs = {Output::equilibrium, Output::gain},
          .values = PathValues::differentiable,
          .newton = {.tolerance = 1e-12}};
}

// The end-effector at the end of a lever of the length p[0], which turns on the ground.
Mechanism lever(const Values& p) {
  Mechanism m{
      .bodies = {models::body({p[0], 0, 0}, 0.1, 1e-4), models::intermediate({0, 0, 0}, 0.1, 1e-4)},
      .drives = {make_drive(Direction::rz, 1)}};
  m.leaves = {models::between(ground, 1, models::leaf({-0.1, 0, 0}, {1, 0, 0}, 0.1, 0.01, 2e-4))};
  m.joints = {{"pivot", JointType::revolute, 1, ground, {0, 0, 0}, {0, 0, 1}},
              {"rigid", JointType::rigid, 0, 1, {0, 0, 0}}};
  return m;
}

// Two leaves in parallel, inclined by p[0] to the normal of the drive.
Mechanism inclined(const Values& p) {
  const Vector3d along(std::cos(p[0]), std::sin(p[0]), 0);
  Mechanism m{.bodies = {models::body(0.1 * along, 0.1, 1e-4)},
              .drives = {make_drive(Direction::uy)}};
  for (const double y : {0.03, -0.03})
    m.leaves.push_back(models::leaf({0, y, 0}, along, 0.1, 0.02, 2e-4));
  return m;
}

// Two guides in series, nothing symmetric.
Mechanism stages() {
  Mechanism m{.bodies = {models::body({0.001, 0.006, 0.003}, 0.4, 3e-4),
                         models::intermediate({0.1, -0.006, 0.002}, 0.2, 2e-4)},
              .drives = {{"coarse", 1, ground, Direction::uy}, {"fine", 0, 1, Direction::uy}}};
  for (const double y : {0.05, -0.045})
    m.leaves.push_back(models::between(
        ground, 1,
        models::leaf({0, y, 0}, {std::cos(y), std::sin(y), 0}, 0.1, 0.03, (1 + 2 * y) * 5e-4)));
  for (const double y : {0.03, -0.025})
    m.leaves.push_back(
        models::between(1, 0, models::leaf({0.1, y, 0.001}, {-1, 0.1 * y, 0}, 0.095, 0.03, 5e-4)));
  return m;
}

Vector3d turn_between(const PathPoint& a, const PathPoint& b) {
  return rotation_log(Matrix3d(rotation_exp(b.rotation) * rotation_exp(Vector3d(-a.rotation))));
}

}  // namespace

TEST_CASE("the gain of a lever is its arm, and so is the derivative along its length") {
  const double length = 0.07, angle = 0.3;
  const Family family{lever, {{"length", length}}, {0}, 1};
  const StrokeSensitivity s =
      evaluate_stroke_gradients(lever({length}), directions_of(family), beams(), at({0, angle}));
  INFO(s.message << s.response.message);
  REQUIRE(s.gradients);
  for (std::size_t k = 0; k < 2; ++k) {
    const PathPoint& p = s.response.path[k];
    const double turned = p.stroke;
    const std::vector<std::pair<const char*, double>> arms{{"ux", -std::sin(turned)},
                                                           {"uy", std::cos(turned)}};
    for (const auto& [direction, arm] : arms)
      for (const std::string name : {"gain.", "cross_coupling."}) {
        CAPTURE(name, direction, turned);
        CHECK(*value_of(p, name + direction) == Approx(length * arm).margin(1e-12));
        CHECK((*gradient_of(p, s.gradients->path[k], name + direction))[0] ==
              Approx(arm).margin(1e-9));
      }
    CHECK(*value_of(p, "gain.rz") == Approx(1).epsilon(1e-12));
    CHECK(*value_of(p, "gain.uz") == Approx(0).margin(1e-12));
  }
}

TEST_CASE("a guide of inclined leaves moves across its drive by the tangent of their angle") {
  const double angle = 0.4;
  const Family family{inclined, {{"angle", angle}}, {0}, 1};
  const StrokeSensitivity s =
      evaluate_stroke_gradients(inclined({angle}), directions_of(family), beams(), at({0}));
  INFO(s.message << s.response.message);
  REQUIRE(s.gradients);
  const PathPoint& p = s.response.path[0];
  const double stretch = 1e-5;  // leaves stretch by (thickness/length)^2 of what they bend
  CHECK(*value_of(p, "cross_coupling.ux") == Approx(-std::tan(angle)).epsilon(stretch));
  CHECK((*gradient_of(p, s.gradients->path[0], "cross_coupling.ux"))[0] ==
        Approx(-1 / std::pow(std::cos(angle), 2)).epsilon(stretch));
  CHECK_FALSE(value_of(p, "cross_coupling.uy"));  // the drive's own
  CHECK_FALSE(value_of(p, "gain.ux"));            // the drive is one of the end-effector
}

TEST_CASE("gains are the slopes of the end-effector's path along each stroke") {
  const Mechanism mechanism = stages();
  const Eigen::Vector2d strokes(0.01, -0.006);
  const double h = 2e-5;
  StrokeRequest request = at({});
  for (int drive = -1; drive < 2; ++drive)
    for (const double side : {-h, h}) {
      VectorXd there = strokes;
      if (drive >= 0) there[drive] += side;
      request.strokes.push_back(there);
      request.points.push_back(there[0]);
    }
  request.loads.constant = {{.force = {1, 0.3, -2}}};
  const StrokeResponse r = evaluated(mechanism, beams(), request);
  const PathPoint& here = r.path[0];
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string drive = "." + mechanism.drives[k].name + ".";
    const PathPoint &before = r.path[2 * k + 2], &after = r.path[2 * k + 3];
    Vector6d slope;
    slope << after.displacement - before.displacement, turn_between(before, after);
    slope /= 2 * h;
    CHECK(std::abs(slope[0]) > 0.01);  // a shift along the leaves
    for (int d = 0; d < 6; ++d) {
      const std::string name = drive + std::string(direction_names[static_cast<std::size_t>(d)]);
      CAPTURE(name);
      CHECK(*value_of(here, "gain" + name) == Approx(slope[d]).epsilon(1e-6).margin(1e-7));
      CHECK(*value_of(here, "cross_coupling" + name) ==
            Approx(slope[d] / slope[1]).epsilon(1e-6).margin(1e-7));
    }
  }
}

TEST_CASE("the output of a drive is the axis along which it moves the end-effector most") {
  const Drive slides = make_drive(Direction::ux), turns = make_drive(Direction::rx);
  const Vector6d motion = (Vector6d() << 0.1, -3, 2, 40, 50, -60).finished();
  CHECK(output_of(slides, motion) == 1);
  CHECK(output_of(turns, motion) == 5);
  const Vector6d rounding = (Vector6d() << 1e-12, 0, 0, 1, 0, 0).finished();
  CHECK_FALSE(output_of(slides, rounding));
}
