// Springs and bushings: energy, force and tangent are derivatives of each other, nothing changes by
// motions of the whole, and the rates are those of differences.
#include "core/mechanism/spring.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/ridders.hpp"
#include "core/math/rotation.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

Matrix6d some_matrix() {
  Matrix6d A;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) A(i, j) = std::sin(1.3 * i + 2.1 * j + 0.4 * i * j);
  Matrix6d K = A * A.transpose() + 0.5 * Matrix6d::Identity();
  Vector6d unit;
  unit << 1, 1, 1, 0.1, 0.1, 0.1;  // of a matter of 100 mm
  return 2e3 * unit.asDiagonal() * K * unit.asDiagonal();
}

Spring point_spring() {
  return {.name = "spring",
          .body = 0,
          .other = 1,
          .place = {0.03, 0.01, -0.02},
          .other_place = {0.11, -0.02, 0.04},
          .stiffness = 3e3,
          .free_length = 0.08};
}
// Lengths on both sides of every state of these tests.
Spring spring_with_line() {
  Spring spring = point_spring();
  spring.stiffness = spring.free_length = 0;
  spring.line = {{0.02, 5}, {0.05, 12}, {0.07, 25}, {0.12, 40}, {0.3, 400}};
  return spring;
}
Spring bushing() {
  return {.name = "bushing",
          .body = 0,
          .other = 1,
          .place = {0.05, 0.02, 0.01},
          .matrix = some_matrix()};
}

// Two bodies far from where they were.
struct Bodies {
  JointBody body{{0.04, -0.02, 0.03}, rotation_exp({0.5, -0.9, 0.7}), {0.01, 0.02, 0}};
  JointBody other{{0.09, 0.03, -0.01}, rotation_exp({-0.4, 0.2, 0.8}), {0.1, 0, 0.03}};
};

Vector12d some_motion(double phase) {
  Vector12d y;
  for (int i = 0; i < 12; ++i) y[i] = std::sin(phase + 2.4 * i) * (i % 6 < 3 ? 0.1 : 1.0);
  return y;
}

JointBody moved(const JointBody& at, const Vector6d& y) {
  return {at.position + y.head<3>(), rotation_exp(y.tail<3>()) * at.rotation, at.reference};
}
Bodies moved(const Bodies& at, const Vector12d& y) {
  return {moved(at.body, y.head<6>()), moved(at.other, y.tail<6>())};
}

std::vector<double> listed(const MatrixXd& A) { return {A.data(), A.data() + A.size()}; }

// Largest deviation from differences, beside what these are known to and the largest entry.
double deviation(const MatrixXd& exact, const Derivatives& d) {
  double worst = 0;
  const double size = exact.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < exact.size(); ++i)
    worst = std::max(worst, (std::abs(exact.data()[i] - d.value[i]) - 5 * d.error[i]) / size);
  return worst;
}

}  // namespace

TEST_CASE("the force of a spring is the gradient of its energy, the tangent its derivative") {
  const Spring spring = GENERATE(point_spring(), spring_with_line(), bushing());
  INFO(spring.name);
  const Bodies at;
  const SpringForces here = spring_forces(spring, at.body, at.other);
  REQUIRE(here.energy > 0);
  CHECK((here.tangent - here.tangent.transpose()).norm() <= 1e-15 * here.tangent.norm());
  for (const double phase : {0.1, 1.7, 3.0}) {
    const Vector12d y = some_motion(phase);
    const auto along = [&](double s) {
      const Bodies there = moved(at, s * y);
      return spring_forces(spring, there.body, there.other);
    };
    const double work = here.force.dot(y);
    const Derivatives energy =
        ridders([&](double s) { return std::vector{along(s).energy}; }, 0, 0.1);
    CHECK(deviation(MatrixXd::Constant(1, 1, work), energy) < 1e-11);
    // moments of spins: their derivative is K − ½ hat(m)
    Vector12d change = here.tangent * y;
    for (int k : {3, 9})
      change.segment<3>(k) -= 0.5 * here.force.segment<3>(k).cross(y.segment<3>(k));
    const Derivatives force = ridders([&](double s) { return listed(along(s).force); }, 0, 0.1);
    CHECK(deviation(change, force) < 1e-11);
  }
}

TEST_CASE("a motion of both bodies leaves the energy of a spring alone and turns its forces") {
  const Spring spring = GENERATE(point_spring(), spring_with_line(), bushing());
  const Bodies at;
  const SpringForces here = spring_forces(spring, at.body, at.other);
  const Matrix3d R = rotation_exp({1.1, 0.3, -2.0});
  const Vector3d shift(0.4, -0.7, 0.2);
  const auto all = [&](const JointBody& b) {
    return JointBody{R * b.position + shift, R * b.rotation, b.reference};
  };
  const SpringForces there = spring_forces(spring, all(at.body), all(at.other));
  CHECK(there.energy == Approx(here.energy).epsilon(1e-13));
  Matrix12d turn = Matrix12d::Zero();
  for (int k = 0; k < 12; k += 3) turn.block<3, 3>(k, k) = R;
  CHECK((there.force - turn * here.force).norm() < 1e-12 * here.force.norm());
  CHECK((there.tangent - turn * here.tangent * turn.transpose()).norm() <
        1e-12 * here.tangent.norm());
  // forces balance: no work on a motion of the whole
  Vector12d rigid;
  const Vector3d spin(0.3, -0.8, 0.5);
  rigid << spin.cross(at.body.position), spin, spin.cross(at.other.position), spin;
  CHECK(std::abs(here.force.dot(rigid)) < 1e-12 * here.force.norm());
}

TEST_CASE("which of its bodies a spring names first makes no difference") {
  const Spring spring = GENERATE(point_spring(), spring_with_line(), bushing());
  Spring other = spring;
  if (!spring.matrix) std::swap(other.place, other.other_place);
  const Bodies at;
  const SpringForces here = spring_forces(spring, at.body, at.other),
                     there = spring_forces(other, at.other, at.body);
  CHECK(there.energy == Approx(here.energy).epsilon(1e-13));
  Vector12d force;
  force << there.force.tail<6>(), there.force.head<6>();
  CHECK((force - here.force).norm() < 1e-12 * here.force.norm());
  CHECK((there.tangent.bottomLeftCorner<6, 6>() - here.tangent.topRightCorner<6, 6>()).norm() <
        1e-12 * here.tangent.norm());
}

TEST_CASE("a bushing at rest has its matrix about its place") {
  const Spring spring = bushing();
  const JointBody body{{0.01, 0.02, 0}, Matrix3d::Identity(), {0.01, 0.02, 0}};
  const SpringForces f = spring_forces(spring, body, JointBody{});
  CHECK(f.energy == 0);
  CHECK(f.force.norm() == 0);
  Matrix6d at_place = Matrix6d::Identity();
  at_place.topRightCorner<3, 3>() = -hat(spring.place - body.reference);
  const Matrix6d K = at_place.transpose() * *spring.matrix * at_place;
  CHECK((f.tangent.topLeftCorner<6, 6>() - K).norm() < 1e-14 * K.norm());
}

TEST_CASE("a bushing turned about one axis has the moment of the turn") {
  Spring spring = bushing();
  spring.matrix = Matrix6d::Zero();
  (*spring.matrix)(5, 5) = 0.7;
  for (const double angle : {1e-9, 0.01, 1.0, 3.0}) {
    const JointBody body{{}, rotation_exp({0, 0, angle}), {}};
    JointBody at = body;
    at.position.setZero();
    const SpringForces f = spring_forces(spring, at, JointBody{});
    CHECK(f.force[5] == Approx(0.7 * angle).epsilon(1e-12));
    CHECK(f.energy == Approx(0.35 * angle * angle).epsilon(1e-12));
  }
}

TEST_CASE("a spring pulls along its line with stiffness times stretch") {
  const Spring spring = point_spring();
  const Bodies at;
  const SpringForces f = spring_forces(spring, at.body, at.other);
  const Vector3d a = at.body.position + at.body.rotation * (spring.place - at.body.reference),
                 b = at.other.position +
                     at.other.rotation * (spring.other_place - at.other.reference);
  const double length = (a - b).norm(), pull = 3e3 * (length - 0.08);
  CHECK((f.force.head<3>() - pull / length * (a - b)).norm() < 1e-12 * std::abs(pull));
  CHECK(f.energy == Approx(0.5 * pull * pull / 3e3));
}

TEST_CASE("a line of forces is smooth, goes through its table and on straight") {
  Spring spring = spring_with_line();
  for (const auto& [length, force] : spring.line)
    CHECK(pull_at(spring, length) == Approx(force).epsilon(1e-13));
  const double step = 1e-7;
  const auto slope = [&](double length, double h) {
    return (pull_at(spring, length + h) - pull_at(spring, length)) / h;
  };
  for (const auto& [length, force] : spring.line)
    CHECK(slope(length, -step) == Approx(slope(length, step)).epsilon(1e-4));
  CHECK(slope(0.4, 0.1) == Approx(slope(0.3, step)).epsilon(1e-4));
  CHECK(slope(0.005, 0.01) == Approx(slope(0.02, -step)).epsilon(1e-4));
  // a straight line is a spring of one stiffness
  for (auto& [length, force] : spring.line) force = 3e3 * (length - 0.08);
  const Bodies at;
  const SpringForces a = spring_forces(spring, at.body, at.other),
                     b = spring_forces(point_spring(), at.body, at.other);
  CHECK((a.force - b.force).norm() < 1e-12 * b.force.norm());
  CHECK((a.tangent - b.tangent).norm() < 1e-12 * b.tangent.norm());
}

TEST_CASE("a line of forces rises and falls as its table does") {
  Spring spring = spring_with_line();
  spring.line = {{0.03, -2}, {0.05, 1}, {0.06, 1}, {0.08, 8}};
  double before = -1e9;
  for (double length = 0.02; length < 0.1; length += 1e-4) {
    const double pull = pull_at(spring, length);
    CHECK(pull >= before - 1e-12);
    if (length > 0.0501 && length < 0.0599) CHECK(pull == Approx(1).epsilon(1e-12));
    if (length > 0.0801) CHECK(pull == Approx(8 + 350 * (length - 0.08)).epsilon(1e-12));
    before = pull;
  }
}

TEST_CASE("forces of springs along a path are its series") {
  const Spring spring = GENERATE(point_spring(), spring_with_line(), bushing());
  const Bodies at;
  const Vector12d y = some_motion(0.6);
  // bodies that move by y s: exp(s ω) R
  const auto body = [&](const JointBody& b, const Vector6d& v, double s) {
    const JointBody now = moved(b, s * v);
    JointBodyOf<Jet> path;
    const Matrix3d W = hat(Vector3d(v.tail<3>()));
    path.position = jets(Series<Vector3d>{now.position, v.head<3>(), Vector3d::Zero()});
    path.rotation =
        jets(Series<Matrix3d>{now.rotation, W * now.rotation, 0.5 * W * W * now.rotation});
    path.reference = b.reference;
    return path;
  };
  const auto along = [&](double s) {
    return spring_forces(spring, body(at.body, y.head<6>(), s), body(at.other, y.tail<6>(), s));
  };
  const SpringForcesOf<Jet> here = along(0);
  const SpringForces now = spring_forces(spring, at.body, at.other);
  CHECK((coefficients(here.force, 0) - now.force).norm() <= 1e-14 * now.force.norm());
  CHECK((coefficients(here.tangent, 0) - now.tangent).norm() <= 1e-14 * now.tangent.norm());
  for (const int order : {1, 2}) {
    const auto lower = [&](double s, const auto& of) {
      return listed(MatrixXd(coefficients(of(along(s)), order - 1)));
    };
    const auto force = [](const SpringForcesOf<Jet>& f) { return f.force; };
    const auto tangent = [](const SpringForcesOf<Jet>& f) { return f.tangent; };
    CHECK(deviation(order * MatrixXd(coefficients(here.force, order)),
                    ridders([&](double s) { return lower(s, force); }, 0, 0.1)) < 1e-10);
    CHECK(deviation(order * MatrixXd(coefficients(here.tangent, order)),
                    ridders([&](double s) { return lower(s, tangent); }, 0, 0.1)) < 1e-10);
  }
}

TEST_CASE("rates of a spring along its numbers and a motion are those of differences") {
  const Spring spring = GENERATE(point_spring(), spring_with_line(), bushing());
  const Bodies at;
  Spring rate{.name = "rate", .place = {0.3, -0.2, 0.5}};
  if (spring.matrix) {
    const Matrix6d A = some_matrix();
    rate.matrix = 0.3 * A.cwiseProduct(A) / A.norm();
    (*rate.matrix)(0, 4) += 50;  // of one entry alone: half of it each way
  } else {
    rate.other_place = {-0.1, 0.4, 0.2};
    rate.stiffness = 5e3;
    rate.free_length = 0.07;
    rate.line = spring.line;
    for (std::size_t i = 0; i < rate.line.size(); ++i) rate.line[i] = {0.01 * i, 30.0 - 20.0 * i};
  }
  const Vector12d y = some_motion(2.2);
  const Vector3d reference_rate[2] = {{0.1, 0.2, -0.3}, {0.2, -0.4, 0.1}};
  const auto along = [&](double s) {
    Spring now = spring;
    now.place += s * rate.place;
    if (now.matrix) {
      *now.matrix += s * *rate.matrix;
    } else {
      now.other_place += s * rate.other_place;
      now.stiffness += s * rate.stiffness;
      now.free_length += s * rate.free_length;
      for (std::size_t i = 0; i < now.line.size(); ++i)
        for (std::size_t k = 0; k < 2; ++k) now.line[i][k] += s * rate.line[i][k];
    }
    Bodies there = moved(at, s * y);
    there.body.reference += s * reference_rate[0];
    there.other.reference += s * reference_rate[1];
    return spring_forces(now, there.body, there.other);
  };
  const auto moving = [&](const JointBody& b, const Vector6d& v, const Vector3d& reference) {
    return JointBody{v.head<3>(), hat(Vector3d(v.tail<3>())) * b.rotation, reference};
  };
  const SpringForces r = spring_rates<double>(
      {&spring, at.body, at.other}, {&rate, moving(at.body, y.head<6>(), reference_rate[0]),
                                     moving(at.other, y.tail<6>(), reference_rate[1])});
  CHECK(deviation(r.force, ridders([&](double s) { return listed(along(s).force); }, 0, 2e-3)) <
        1e-10);
  CHECK(deviation(r.tangent, ridders([&](double s) { return listed(along(s).tangent); }, 0, 2e-3)) <
        1e-10);
}

TEST_CASE("springs that cannot be are refused with their name") {
  CHECK(check_rules(point_spring(), 2));
  CHECK(check_rules(bushing(), 2));
  const auto rule = [](Spring spring, auto change) {
    change(spring);
    return why_not(check_rules(spring, 2));
  };
  CHECK_THAT(rule(point_spring(), [](Spring& s) { s.other = 2; }), Contains("no body 2"));
  CHECK_THAT(rule(point_spring(), [](Spring& s) { s.other = 0; }), Contains("to itself"));
  CHECK_THAT(rule(point_spring(), [](Spring& s) { s.other_place = s.place; }),
             Contains("spring: its two ends coincide"));
  CHECK_THAT(rule(point_spring(), [](Spring& s) { s.stiffness = -1; }), Contains("stiffness"));
  CHECK_THAT(rule(point_spring(), [](Spring& s) { s.free_length = -0.1; }),
             Contains("free length"));
  CHECK(check_rules(spring_with_line(), 2));
  CHECK_THAT(rule(spring_with_line(), [](Spring& s) { s.line[2][0] = 0.04; }), Contains("ascend"));
  CHECK_THAT(rule(spring_with_line(), [](Spring& s) { s.line.resize(1); }),
             Contains("two lengths"));
  CHECK_THAT(rule(point_spring(), [](Spring& s) { s.place[1] = NAN; }), Contains("finite"));
  CHECK_THAT(rule(bushing(), [](Spring& s) { (*s.matrix)(0, 1) += 100; }), Contains("symmetric"));
  CHECK_THAT(rule(bushing(), [](Spring& s) { (*s.matrix)(3, 3) *= -1; }), Contains("negative"));
  CHECK_THAT(rule(bushing(), [](Spring& s) { (*s.matrix)(0, 1) = (*s.matrix)(1, 0) = 1e9; }),
             Contains("semidefinite"));
  CHECK_THAT(rule(bushing(),
                  [](Spring& s) {
                    s.matrix = Matrix6d::Zero();
                    (*s.matrix)(0, 1) = (*s.matrix)(1, 0) = 1;
                  }),
             Contains("semidefinite"));
  CHECK(rule(bushing(), [](Spring& s) { s.matrix = Matrix6d::Zero(); }).empty());
}
