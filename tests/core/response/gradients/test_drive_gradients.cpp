// Exact derivatives of mechanisms whose drives are conditions or several: (S11), (S17).
#include <map>

#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::vector<Number> numbers{{"length", 0.1},   {"width", 0.03},  {"thickness", 0.5e-3},
                                  {"modulus", 2e11}, {"poisson", 0.3}, {"density", 7800},
                                  {"mass", 0.4},     {"place", 0.006}, {"tilt", 0.3}};

enum class Kind { stage, relative, tilted, turning, several };

// Two guides in series, nothing symmetric.
Mechanism series(Kind kind, const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m{.bodies = {models::body({0.001, p[7], 0.5 * p[7]}, p[6], 3e-4),
                         models::intermediate({p[0], -p[7], 0.002}, 0.5 * p[6], 2e-4)}};
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.005, 0.003);
  for (const double y : {0.05, -0.045}) {
    m.leaves.push_back(models::between(ground, 1,
                                       models::leaf({0, y, 0}, {std::cos(y), std::sin(y), 0}, p[0],
                                                    p[1], (1 + 2 * y) * p[2], material)));
  }
  for (const double y : {0.03, -0.025}) {
    m.leaves.push_back(models::between(
        1, 0, models::leaf({p[0], y, 0.001}, {-1, 0.1 * y, 0}, 0.95 * p[0], p[1], p[2], material)));
  }
  const Matrix3d axes = Eigen::AngleAxisd(p[8], Vector3d(0.36, 0.48, 0.8)).toRotationMatrix();
  const std::map<Kind, std::vector<Drive>> drives{
      {Kind::stage, {{"", 1, ground, Direction::uy}}},
      {Kind::relative, {{"", 0, 1, Direction::uy, axes}}},
      {Kind::tilted, {{"", 0, ground, Direction::uy, axes}}},
      {Kind::turning, {{"", 0, 1, Direction::rz, axes}}},
      {Kind::several,
       {{"y", 0, ground, Direction::uy},
        {"stage", 1, ground, Direction::uy, axes},
        {"turn", 0, 1, Direction::rz}}}};
  m.drives = drives.at(kind);
  return m;
}

// A hinge driven about an axis of its own.
Mechanism hinge(const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m = models::hinge(p[0], p[2], {{1, 0.8 * p[1], 0.5 * p[1]}, {-1, -0.1 * p[1], p[1]}});
  for (LeafSpring& leaf : m.leaves) leaf.material = material;
  m.bodies[0].mass = p[6];
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.005, 0);
  m.drives = {make_drive(Direction::rz)};
  m.drives[0].axes = Eigen::AngleAxisd(p[8], Vector3d(0.8, 0.6, 0)).toRotationMatrix();
  return m;
}

// One narrow leaf after the other: loads tilt both bodies however they are driven.
Mechanism chain(const Values& p) {
  const Material material{"steel", p[3], p[4], p[5], {}};
  Mechanism m{.bodies = {models::body({0.6 * p[0], 0.5 * p[0], p[7]}, p[6], 3e-4),
                         models::intermediate({0.6 * p[0], -p[7], 0.002}, 0.5 * p[6], 2e-4)}};
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.005, 0.003);
  m.leaves = {
      models::between(ground, 1,
                      models::leaf({0, 0, 0}, {1, 0, 0}, 0.6 * p[0], 0.15 * p[1], p[2], material)),
      models::between(
          1, 0,
          models::leaf({0.6 * p[0], 0, 0}, {0, 1, 0}, 0.5 * p[0], 0.2 * p[1], p[2], material))};
  return m;
}
Mechanism twisted(const Values& p) {
  Mechanism m = chain(p);
  m.drives = {make_drive(Direction::rx)};
  return m;
}
Mechanism turned_twice(const Values& p) {
  Mechanism m = chain(p);
  const Matrix3d axes = Eigen::AngleAxisd(p[8], Vector3d(0.36, 0.48, 0.8)).toRotationMatrix();
  m.drives = {{"roll", 0, ground, Direction::rx, axes}, {"turn", 0, 1, Direction::rz}};
  return m;
}

ModelOptions beams(Accuracy accuracy = Accuracy::full) {
  return {.accuracy = accuracy, .flexure = Flexure::beam, .mesh = {6, 1}};
}

StrokeRequest loaded(double stroke) {
  return {.points = {0, stroke},
          .loads = {.constant = {{.force = {1, 0.3, -2}, .moment = {0.01, 0.02, -0.01}}}},
          .frequencies = 4};
}

auto of(Kind kind) {
  return [kind](const Values& p) { return series(kind, p); };
}

}  // namespace

TEST_CASE("exact derivatives of a drive on any body agree with differences", "[slow]") {
  struct Case {
    Kind kind;
    double stroke;
    std::vector<std::size_t> along;
  };
  const Case c =
      GENERATE(Case{Kind::stage, 0.01, {0, 2, 6, 7}}, Case{Kind::relative, 0.012, {0, 2, 3, 7, 8}},
               Case{Kind::tilted, 0.01, {0, 2, 7, 8}}, Case{Kind::turning, 1e-3, {0, 2, 7, 8}});
  INFO("kind " << static_cast<int>(c.kind));
  const int compared =
      check_gradients({of(c.kind), numbers, c.along, 10.0}, beams(), loaded(c.stroke));
  CHECK(compared > 60 * static_cast<int>(c.along.size()));
}

TEST_CASE("exact derivatives of a turn of one body agree with differences") {
  check_gradients({hinge, numbers, {0, 2, 6, 8}, 0.1}, beams(), loaded(0.3));  // its own axis
  check_gradients({twisted, numbers, {2, 7}, 0.1}, beams(), loaded(0.3));      // loads tilt it
}

TEST_CASE("exact derivatives of several drives agree with differences", "[slow]") {
  const auto check = [](const Family& family, const VectorXd& strokes) {
    StrokeRequest request = loaded(strokes[0]);
    request.strokes = {VectorXd::Zero(strokes.size()), strokes};
    check_gradients(family, beams(), request);
  };
  check({turned_twice, numbers, {0, 2, 7, 8}, 0.1}, Eigen::Vector2d(0.2, 0.15));
  check({of(Kind::several), numbers, {0, 2, 7, 8}, 10.0}, Vector3d(0.008, 0.005, 3e-3));
}

TEST_CASE("exact derivatives of a relative drive agree with differences on reduced leaves") {
  check_gradients({of(Kind::relative), numbers, {2, 8}, 10.0}, beams(Accuracy::reduced),
                  loaded(0.012));
}

TEST_CASE("exact derivatives with some drives held agree with differences", "[slow]") {
  StrokeRequest request = loaded(0.008);
  request.strokes = {VectorXd::Zero(3), Vector3d(0.008, 0.005, 3e-3)};
  request.outputs.remove({Output::frequency_derivatives, Output::frequencies_locked});
  for (const unsigned held : {0b001u, 0b010u, 0b101u}) {  // a coordinate, a condition, both
    INFO("held " << held);
    request.loads.held = held;
    CHECK(check_gradients({of(Kind::several), numbers, {2, 7, 8}, 10.0}, beams(), request) > 60);
  }
}

TEST_CASE("with one of two drives held all is as with that drive alone") {
  // the other drive is then the force that it bears, which acts on as a dead load
  const Values p = values_of(numbers);
  const bool exactly = GENERATE(false, true);
  const bool first = GENERATE(false, true);  // whether the held drive stands first
  const int on = GENERATE(0, 1);             // body of the held drive
  INFO("exactly " << exactly << ", first " << first << ", held on body " << on);
  const Drive held{"x", on, ground, Direction::uy}, other{"y", 1 - on, ground, Direction::uy};
  Mechanism both = series(Kind::stage, p), alone = both;
  both.drives = first ? std::vector{held, other} : std::vector{other, held};
  alone.drives = {held};
  StrokeRequest request = loaded(0);
  request.newton.tolerance = 1e-12;
  request.outputs.remove(Output::frequency_derivatives);
  if (exactly) request.values = PathValues::differentiable;
  request.loads.held.set(first ? 0 : 1);
  const double x = on == 0 ? 0.009 : 0.004, y = on == 0 ? 0.004 : 0.009;
  request.points = {first ? x : y};
  request.strokes = {first ? Eigen::Vector2d(x, y) : Eigen::Vector2d(y, x)};
  const PathPoint a = evaluated(both, beams(), request).path[0];
  StrokeRequest single = request;
  single.loads.held = {};
  single.strokes.clear();
  single.points = {x};
  single.loads.constant.push_back(
      {.force = {0, a.drive_loads[first ? 1 : 0], 0}, .body = other.body});
  const PathPoint b = evaluated(alone, beams(), single).path[0];
  CHECK(a.drive_loads[first ? 0 : 1] == Approx(b.drive_load).epsilon(1e-7));
  // as they are modelled leaves have more modes of their own where what is held is stiffer
  CHECK(frequency_error(a.frequencies_free, b.frequencies_locked) < (exactly ? 1e-7 : 1e-3));
  CHECK(a.frequencies_locked[0] > 1.05 * a.frequencies_free[0]);
  CHECK((a.compliance_free - b.compliance_locked).norm() < 1e-7 * b.compliance_locked.norm());
  CHECK(a.stable);
  // what does not know of free drives is as before
  request.loads.held = {};
  const PathPoint c = evaluated(both, beams(), request).path[0];
  CHECK(frequency_error(a.frequencies_locked, c.frequencies_locked) < 1e-9);
  for (const std::size_t k : {0, 1})
    CHECK(a.drive_stiffnesses[k] == Approx(c.drive_stiffnesses[k]).epsilon(1e-9));
}

TEST_CASE("a held drive is the limit of a stiff spring in its place") {
  const Values p = values_of(numbers);
  Mechanism held = series(Kind::stage, p), sprung = held;
  held.drives = {{"x", 1, ground, Direction::uy}, {"y", 0, ground, Direction::uy}};
  sprung.drives = {held.drives[1]};
  Matrix6d k = Matrix6d::Zero();
  k(1, 1) = 1e12;
  sprung.springs = {{.body = 1, .other = ground, .place = held.bodies[1].reference, .matrix = k}};
  StrokeRequest request{.points = {0}, .frequencies = 4};
  const PathPoint limit = evaluated(sprung, beams(), request).path[0];
  request.strokes = {VectorXd::Zero(2)};
  request.loads.held.set(0);
  const PathPoint found = evaluated(held, beams(), request).path[0];
  CHECK(frequency_error(found.frequencies_free, limit.frequencies_free) < 1e-5);
  CHECK((found.compliance_free - limit.compliance_free).norm() <
        1e-5 * limit.compliance_free.norm());
}

TEST_CASE("stability is that with the held drives alone held") {
  // pressed until it gives way along y: stable where y is held, whatever else is free
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.drives = {{"y", 0, ground, Direction::uy}, {"z", 0, ground, Direction::uz}};
  StrokeRequest request{.points = {0},
                        .strokes = {VectorXd::Zero(2)},
                        .loads = {.constant = {{.force = {-200, 0, 0}}}},
                        .frequencies = 2};
  for (const bool swapped : {false, true}) {
    if (swapped) std::swap(m.drives[0], m.drives[1]);
    for (const unsigned held : {0u, 1u, 2u, 3u}) {
      INFO("swapped " << swapped << ", held " << held);
      request.loads.held = held;
      const PathPoint point = evaluated(m, beams(), request).path[0];
      const bool holds_y = held == 0 || (held & (swapped ? 2u : 1u)) != 0;  // 0: all drives
      CHECK(point.stable == holds_y);
      CHECK_FALSE(point.bifurcation_passed);
      if (held != 0) CHECK((point.frequencies_free[0] > 0) == holds_y);
    }
  }
}
