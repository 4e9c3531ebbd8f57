// The strokes of drives: derivatives, what they measure, and which of them are coordinates.
#include <catch2/catch.hpp>

#include "core/math/ridders.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/drive.hpp"
#include "support/models.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

JointBody moved(const JointBody& b, const Vector6d& dq) {
  return {b.position + dq.head<3>(), rotation_exp(dq.tail<3>()) * b.rotation, b.reference};
}

Vector12d direction(double seed) {
  Vector12d d;
  for (int i = 0; i < 12; ++i) d[i] = std::sin(1 + seed + 2.3 * i);
  return d;
}

/// Two bodies in general places.
const JointBody a{{0.3, -0.2, 0.5}, rotation_exp({0.4, -0.9, 0.3}), {0.1, 0.2, -0.1}};
const JointBody b{{-0.4, 0.1, 0.2}, rotation_exp({-0.3, 0.5, 0.8}), {0.2, -0.3, 0.4}};

Drive turned_drive(Direction direction) {
  Drive d;
  d.direction = direction;
  d.axes = rotation_exp({0.3, -0.7, 0.5});
  return d;
}

DriveStroke<double> stroke(const Drive& d, const JointBody& body, const JointBody& other) {
  return drive_stroke<double>(d, body, other);
}

}  // namespace

TEST_CASE("the stroke of a drive follows its first and second derivatives") {
  const Direction of = GENERATE(Direction::ux, Direction::uy, Direction::rx, Direction::rz);
  const Drive drive = turned_drive(of);
  const DriveStroke<double> s = stroke(drive, a, b);
  REQUIRE(s.gradient.norm() > 0.1);
  const Matrix12d& second = s.curvature;
  REQUIRE(second.norm() > 0.1);
  CHECK((second - second.transpose()).norm() < 1e-14);
  const Vector12d d = direction(0.5);
  const auto rest = [&](double h) {
    const double value = stroke(drive, moved(a, h * d.head<6>()), moved(b, h * d.tail<6>())).value;
    const double first = value - s.value - h * s.gradient.dot(d);
    return std::array<double, 2>{std::abs(first),
                                 std::abs(first - 0.5 * h * h * d.dot(second * d))};
  };
  const auto coarse = rest(1e-2), fine = rest(5e-3);
  CHECK(std::log2(coarse[0] / fine[0]) == Approx(2).margin(0.1));
  CHECK(std::log2(coarse[1] / fine[1]) == Approx(3).margin(0.1));
}

TEST_CASE("the stroke of a drive follows what it depends on") {
  const Direction of = GENERATE(Direction::uy, Direction::ry);
  const Vector12d d = direction(1.5), r = direction(2.5);
  const auto at = [&](double h) {
    StrokeState<double> s{turned_drive(of), moved(a, h * d.head<6>()), moved(b, h * d.tail<6>())};
    s.body.reference += h * r.head<3>();
    s.other.reference += h * r.segment<3>(3);
    s.drive.axes = rotation_exp(h * r.segment<3>(6)) * s.drive.axes;
    return s;
  };
  StrokeState<double> rate = at(0);
  rate.drive.axes = hat(r.segment<3>(6)) * rate.drive.axes;
  rate.body = {d.head<3>(), hat(d.segment<3>(3)) * a.rotation, r.head<3>()};
  rate.other = {d.segment<3>(6), hat(d.tail<3>()) * b.rotation, r.segment<3>(3)};
  const DriveStroke<double> exact = drive_stroke_rate(at(0), rate);
  const Derivatives differences = ridders(
      [&](double h) {
        const StrokeState<double> s = at(h);
        const DriveStroke<double> x = drive_stroke<double>(s.drive, s.body, s.other);
        std::vector<double> all{x.value};
        all.insert(all.end(), x.gradient.data(), x.gradient.data() + 12);
        all.insert(all.end(), x.curvature.data(), x.curvature.data() + 144);
        return all;
      },
      0, 0.05);
  CHECK(exact.value == Approx(differences.value[0]).margin(1e-9));
  for (int i = 0; i < 12; ++i)
    CHECK(exact.gradient[i] == Approx(differences.value[1 + i]).margin(1e-9));
  for (int i = 0; i < 144; ++i)
    CHECK(exact.curvature.data()[i] == Approx(differences.value[13 + i]).margin(1e-9));
  CHECK(exact.curvature.norm() > 0.1);
}

TEST_CASE("along a path the stroke is a series") {
  const Direction of = GENERATE(Direction::uz, Direction::rx);
  const Drive drive = turned_drive(of);
  const Vector12d d = direction(0.2), e = direction(0.9);
  const auto path = [&](const JointBody& from, int k) {  // by the rotation vector
    const Vector3d theta = rotation_log(from.rotation), t1 = d.segment<3>(k + 3),
                   t2 = e.segment<3>(k + 3);
    const Vector3<Jet> jet_theta = jets(Series<Vector3d>{theta, t1, t2});
    return JointBodyOf<Jet>{jets(Series<Vector3d>{from.position, d.segment<3>(k), e.segment<3>(k)}),
                            jet_rotation_exp(jet_theta), from.reference};
  };
  const auto at = [&](const JointBody& from, int k, double s) {
    return JointBody{from.position + s * d.segment<3>(k) + s * s * e.segment<3>(k),
                     rotation_exp(rotation_log(from.rotation) + s * d.segment<3>(k + 3) +
                                  s * s * e.segment<3>(k + 3)),
                     from.reference};
  };
  const DriveStroke<Jet> series = drive_stroke(drive, path(a, 0), path(b, 6));
  const double h = 1e-3;
  const auto sample = [&](double s) { return stroke(drive, at(a, 0, s), at(b, 6, s)); };
  const DriveStroke<double> here = sample(0), up = sample(h), down = sample(-h);
  const auto compare = [&](const Jet& jet, double f0, double f1, double f2) {
    CHECK(jet.c[0] == Approx(f0).margin(1e-13));
    CHECK(jet.c[1] == Approx((f1 - f2) / (2 * h)).margin(2e-5));
    CHECK(jet.c[2] == Approx((f1 - 2 * f0 + f2) / (2 * h * h)).margin(2e-5));
  };
  compare(series.value, here.value, up.value, down.value);
  for (int i = 0; i < 12; ++i) {
    compare(series.gradient[i], here.gradient[i], up.gradient[i], down.gradient[i]);
    for (int j = 0; j < 12; ++j)
      compare(series.curvature(i, j), here.curvature(i, j), up.curvature(i, j),
              down.curvature(i, j));
  }
  // rates along a direction of the same path, order by order
  StrokeState<Jet> state{drive, path(a, 0), path(b, 6)}, rate = state;
  rate.drive.axes.setZero();
  for (JointBodyOf<Jet>* body : {&rate.body, &rate.other}) {
    const Vector3d spin(0.3, -0.2, 0.6);
    body->rotation = hat(Vector3<Jet>(spin.cast<Jet>())).lazyProduct(body->rotation).eval();
    body->position = spin.cast<Jet>();
    body->reference.setZero();
  }
  const DriveStroke<Jet> along = drive_stroke_rate(state, rate);
  Eigen::Matrix<Jet, 12, 1> q;
  for (int side = 0; side < 2; ++side)
    for (int i = 0; i < 6; ++i) q[6 * side + i] = Vector3d(0.3, -0.2, 0.6)[i % 3];
  const Jet expected = series.gradient.dot(q);
  for (int o = 0; o < 3; ++o) CHECK(along.value.c[o] == Approx(expected.c[o]).margin(1e-12));
}

TEST_CASE("a drive measures what one body sees of the other") {
  const Direction of = GENERATE(Direction::ux, Direction::uz, Direction::ry);
  const Drive drive = turned_drive(of);
  const double before = stroke(drive, a, b).value;
  // both moved as one body
  const Matrix3d R = rotation_exp({1.2, 0.4, -0.7});
  const auto carried = [&](const JointBody& x) {
    return JointBody{R * x.position + Vector3d(0.3, 0.1, -0.5), R * x.rotation, x.reference};
  };
  CHECK(stroke(drive, carried(a), carried(b)).value == Approx(before).epsilon(1e-12));
  // at rest, then along the axis
  JointBody body, other;
  body.reference = body.position = a.reference;
  other.reference = other.position = b.reference;
  CHECK(std::abs(stroke(drive, body, other).value) < 1e-15);
  const Vector3d axis = drive.axes.col(index(of) % 3);
  if (is_rotation(of))
    body.rotation = rotation_exp(2.5 * axis);
  else
    body.position += 2.5 * axis;
  CHECK(stroke(drive, body, other).value == Approx(2.5).epsilon(1e-12));
}

TEST_CASE("the stroke of a turn is its angle about the axis, before or after one across it") {
  const Vector3d across(0, 0.4, -0.7);
  for (const double turn : {-2.9, -0.3, 0.0, 1e-9, 0.5, 3.1}) {
    const Matrix3d twist = rotation_exp({turn, 0, 0}), swing = rotation_exp(across);
    const Drive drive = make_drive(Direction::rx);
    for (const Matrix3d& Q : {Matrix3d(twist * swing), Matrix3d(swing * twist)}) {
      const JointBody body{a.position, b.rotation * Q, a.reference};
      CHECK(stroke(drive, body, b).value == Approx(turn).epsilon(1e-12).margin(1e-15));
      // the other body sees the same turn the other way
      CHECK(stroke(drive, b, body).value == Approx(-turn).epsilon(1e-12).margin(1e-15));
    }
  }
}

TEST_CASE("a turn about the axis alone has the axis as gradient and no second derivative") {
  const Drive drive = turned_drive(Direction::ry);
  const Vector3d axis = drive.axes.col(1);
  for (const double turn : {-1.7, 0.0, 0.6, 3.0}) {
    const DriveStroke<double> s =
        stroke(drive, {a.position, rotation_exp(turn * axis), a.reference}, {});
    CHECK((s.gradient.segment<3>(3) - axis).norm() < 1e-15);
    CHECK((s.curvature.block<3, 3>(3, 3).norm() < 1e-15));
  }
}

TEST_CASE("turns that keep the stroke have no second derivative of it either") {
  // a drive that is held bends no path of the body: its load adds nothing to support stiffness
  const DriveStroke<double> s = stroke(turned_drive(Direction::rz), a, {});
  const Matrix3d H = s.curvature.block<3, 3>(3, 3);
  REQUIRE(H.norm() > 0.1);
  const Vector3d W = s.gradient.segment<3>(3), u = W.unitOrthogonal(), v = W.cross(u);
  for (const Vector3d& x : {u, v}) {
    CHECK(std::abs(x.dot(H * u)) < 1e-15);
    CHECK(std::abs(x.dot(H * v)) < 1e-15);
  }
}

TEST_CASE("a displacement along a global axis against the ground is a coordinate") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies.push_back(m.bodies[0]);
  m.drives = {make_drive(Direction::uz, 1)};
  CHECK(coordinate_of(m.drives[0]) == 8);
  CHECK(conditional_drives(m).empty());
  m.drives = {make_drive(Direction::rz, 1)};
  CHECK_FALSE(coordinate_of(m.drives[0]));
  CHECK_FALSE(end_effector_direction(m, m.drives[0]));
  m.drives[0].other = 0;
  CHECK(conditional_drives(m) == std::vector<int>{0});
  m.drives[0] = make_drive(Direction::ux);
  CHECK(coordinate_of(m.drives[0]) == 0);
  m.drives[0].axes_change = true;
  CHECK_FALSE(coordinate_of(m.drives[0]));
  CHECK(end_effector_direction(m, m.drives[0]) == Direction::ux);
  m.drives[0].axes = rotation_exp({0, 0, 0.5 * M_PI});
  CHECK(end_effector_direction(m, m.drives[0]) == Direction::uy);
  m.drives[0].axes = rotation_exp({0, 0, 0.3});
  CHECK_FALSE(end_effector_direction(m, m.drives[0]));
  m.drives = {make_drive(Direction::ux), make_drive(Direction::rz)};
  CHECK(conditional_drives(m) == std::vector<int>{1});
  CHECK(prescribed_directions(m) == std::array<bool, 6>{true, false, false, false, false, true});
}

TEST_CASE("drives that cannot be are refused") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const auto rule = [&] { return why_not(check_rules(m)); };
  m.drives = {make_drive(Direction::uy, 3)};
  CHECK(rule() == "the drive: there is no body 3");
  m.drives = {make_drive(Direction::uy)};
  m.drives[0].other = 0;
  CHECK(rule() == "the drive: it drives a body against itself");
  m.drives[0].other = ground;
  m.drives[0].axes *= 2;
  CHECK_THAT(rule(), Contains("its axes must be orthonormal"));
  m.drives = {make_drive(Direction::uy), make_drive(Direction::ux)};
  CHECK_THAT(rule(), Contains("two drives have the name"));
  m.drives[0].name = "one";
  m.drives[1].name = "two";
  CHECK(rule().empty());
  m.drives[1].direction = Direction::uy;
  CHECK(rule() == "drive two: joints and other drives already hold it");
  m.drives = {make_drive(Direction::uy)};
  m.bodies[0].held[1] = true;
  CHECK(rule() == "the end-effector cannot move in the direction of the drive");
}
