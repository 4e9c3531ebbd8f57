// The conditions of joints: derivatives by Taylor rates, what they allow, conditions that repeat
// others.
#include <catch2/catch.hpp>

#include "core/math/ridders.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/joint.hpp"
#include "support/models.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

constexpr JointType types[] = {JointType::rigid, JointType::revolute, JointType::spherical,
                               JointType::prismatic};

JointBody moved(const JointBody& b, const Vector6d& dq) {
  return {b.position + dq.head<3>(), rotation_exp(dq.tail<3>()) * b.rotation, b.reference};
}

Vector12d direction(double seed) {
  Vector12d d;
  for (int i = 0; i < 12; ++i) d[i] = std::sin(1 + seed + 2.3 * i);
  return d;
}

/// Two bodies in general places, some way off the conditions.
struct Pair {
  JointBody a{{0.3, -0.2, 0.5}, rotation_exp({0.4, -0.9, 0.3}), {0.1, 0.2, -0.1}};
  JointBody b{{-0.4, 0.1, 0.2}, rotation_exp({-0.3, 0.5, 0.8}), {0.2, -0.3, 0.4}};
  JointBody b_at(const Vector12d& d, double h) const { return moved(b, h * d.tail<6>()); }
  JointBody a_at(const Vector12d& d, double h) const { return moved(a, h * d.head<6>()); }
};

Joint joint(JointType type) {
  return {"joint", type, 0, 1, {0.7, 0.3, -0.6}, Vector3d(1, 2, -2) / 3};
}

}  // namespace

TEST_CASE("conditions of joints follow their first and second derivatives") {
  const JointType type = GENERATE(from_range(std::begin(types), std::end(types)));
  const Joint j = joint(type);
  const Pair pair;
  const JointConditions c = conditions(j, pair.a, pair.b);
  const JointSize size = size_of(type);
  REQUIRE(c.value.size() == size.conditions);
  REQUIRE(c.gradient.norm() > 0.1);
  const VectorXd weights = direction(3).head(size.conditions);
  const Matrix12d H = curvature(j, pair.a, pair.b, weights);
  CHECK((H - H.transpose()).norm() < 1e-14);
  REQUIRE(H.norm() > 0.1);
  const Vector12d d = direction(0.5);
  const auto rest = [&](double h) {  // what is left beyond first, beyond second order
    const VectorXd value = conditions(j, pair.a_at(d, h), pair.b_at(d, h)).value;
    const VectorXd first = value - c.value - h * c.gradient * d;
    return std::array<double, 2>{first.norm(),
                                 std::abs(weights.dot(first) - 0.5 * h * h * d.dot(H * d))};
  };
  const auto coarse = rest(1e-2), fine = rest(5e-3);
  CHECK(std::log2(coarse[0] / fine[0]) == Approx(2).margin(0.1));
  CHECK(std::log2(coarse[1] / fine[1]) == Approx(3).margin(0.1));
}

TEST_CASE("conditions of joints follow what they depend on") {
  const JointType type = GENERATE(from_range(std::begin(types), std::end(types)));
  const Pair pair;
  const JointState<double> state{joint(type), pair.a, pair.b,
                                 direction(3).head(size_of(type).conditions)};
  // the axis stands: where it moves, the choice of e2 and e3 does not bear on what is held
  const Vector12d d = direction(1.5), r = direction(2.5);
  const VectorXd dm = direction(4).head(size_of(type).conditions);
  const auto at = [&](double h) {
    JointState<double> s = state;
    s.body = moved(state.body, h * d.head<6>());
    s.other = moved(state.other, h * d.tail<6>());
    s.body.reference += h * r.head<3>();
    s.other.reference += h * r.segment<3>(3);
    s.joint.place += h * r.tail<3>();
    s.multipliers += h * dm;
    return s;
  };
  JointState<double> rate = at(0);
  rate.body = {d.head<3>(), hat(d.segment<3>(3)) * state.body.rotation, r.head<3>()};
  rate.other = {d.segment<3>(6), hat(d.tail<3>()) * state.other.rotation, r.segment<3>(3)};
  rate.joint.place = r.tail<3>();
  rate.joint.axis.setZero();
  rate.multipliers = dm;
  const JointRates<double> exact = joint_rates(state, rate);
  const Derivatives differences = ridders(
      [&](double h) {
        const JointState<double> s = at(h);
        const JointConditions c = conditions(s.joint, s.body, s.other);
        const Matrix12d H = curvature(s.joint, s.body, s.other, s.multipliers);
        std::vector<double> all(c.value.data(), c.value.data() + c.value.size());
        all.insert(all.end(), c.gradient.data(), c.gradient.data() + c.gradient.size());
        all.insert(all.end(), H.data(), H.data() + H.size());
        return all;
      },
      0, 0.05);
  std::size_t n = 0;
  const auto compare = [&](const auto& rates) {
    for (Eigen::Index i = 0; i < rates.size(); ++i, ++n)
      CHECK(rates.data()[i] == Approx(differences.value[n]).margin(1e-9));
  };
  compare(exact.conditions.value);
  compare(exact.conditions.gradient);
  compare(exact.curvature);
  CHECK(exact.curvature.norm() > 0.1);
}

TEST_CASE("joints allow what their names say and nothing else") {
  const JointType type = GENERATE(from_range(std::begin(types), std::end(types)));
  const Joint j = joint(type);
  JointBody a;
  a.reference = a.position = {0.1, 0.2, -0.1};
  JointBody b;
  b.reference = b.position = {0.2, -0.3, 0.4};
  CHECK(conditions(j, a, b).value.norm() < 1e-15);
  // finite motion of b about or along the joint, then both together
  const Matrix3d turn = type == JointType::revolute    ? rotation_exp(0.8 * j.axis)
                        : type == JointType::spherical ? rotation_exp({0.3, -0.8, 0.5})
                                                       : Matrix3d::Identity();
  b.position = j.place + turn * (b.reference - j.place);
  b.rotation = turn;
  if (type == JointType::prismatic) b.position += 0.3 * j.axis;
  const Matrix3d R = rotation_exp({1.2, 0.4, -0.7});
  for (JointBody* body : {&a, &b}) {
    body->position = R * body->position + Vector3d(0.3, 0.1, -0.5);
    body->rotation = R * body->rotation;
  }
  CHECK(conditions(j, a, b).value.norm() < 1e-15);
  // the conditions are independent, and as many as the freedom they take
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(MatrixXd(conditions(j, a, b).gradient));
  const int freedom = type == JointType::rigid ? 0 : type == JointType::spherical ? 3 : 1;
  CHECK(qr.rank() == 6 - freedom);
  CHECK(size_of(type).conditions == 6 - freedom);
}

TEST_CASE("rules of joints are named when broken") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const auto rule = [](const Mechanism& mechanism) { return why_not(check_rules(mechanism)); };
  m.bodies.push_back(models::body({0.12, 0, 0}, 0.1, 1e-5));
  m.bodies.back().name = "second";
  CHECK_THAT(rule(m), Contains("second: no leaf ties it to the ground"));
  Joint tie{"tie", JointType::rigid, 0, 1, {0.11, 0, 0}};
  m.joints = {tie};
  CHECK(rule(m) == "");
  m.joints[0].other = 7;
  CHECK_THAT(rule(m), Contains("tie: there is no body 7"));
  m.joints[0].other = 0;
  CHECK_THAT(rule(m), Contains("tie: it ties a body to itself"));
  m.joints[0] = tie;
  m.joints[0].type = JointType::revolute;
  m.joints[0].axis = {0, 0, 2};
  CHECK_THAT(rule(m), Contains("tie: its axis must have the length one"));
  m.joints[0] = tie;
  m.joints[0].place[1] = std::nan("");
  CHECK_THAT(rule(m), Contains("tie: its place is not finite"));
}

TEST_CASE("joints that repeat others are named, with how many conditions too many") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies.push_back(models::body({0.12, 0, 0}, 0.1, 1e-5));
  m.joints = {{"first", JointType::rigid, 0, 1, {0.11, 0, 0}},
              {"second", JointType::revolute, 0, 1, {0.11, 0.02, 0}, Vector3d::UnitZ()}};
  CHECK_THAT(why_not(check_rules(m)), Contains("second: 5 of its 5 conditions are already fixed"));
  m.joints[0].type =
      JointType::spherical;  // no shift along the line between both places, no turn about it
  CHECK_THAT(why_not(check_rules(m)), Contains("second: 2 of its 5 conditions are already fixed"));
  m.joints = {{"slide", JointType::prismatic, 1, ground, {0.12, 0, 0}, Vector3d::UnitX()},
              {"tie", JointType::rigid, 0, 1, {0.11, 0, 0}}};
  CHECK(why_not(check_rules(m)) ==
        "the joints hold the end-effector in the direction of the drive");
  m.joints[0].type = JointType::rigid;
  CHECK_THAT(why_not(check_rules(m)), Contains("is one rigid body with the ground, by tie, slide"));
}

TEST_CASE("rigid joints make one body of several") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  for (int k = 0; k < 4; ++k) m.bodies.push_back(m.bodies[0]);
  m.end_effector = 1;
  m.joints = {{"a", JointType::rigid, 2, 3, Vector3d::Zero()},
              {"b", JointType::rigid, 0, 1, Vector3d::Zero()},
              {"c", JointType::spherical, 0, 2, Vector3d::Zero()},
              {"d", JointType::rigid, ground, 4, Vector3d::Zero()}};
  CHECK(rigid_groups(m) == std::vector<int>{1, 1, 2, 2, ground});
}
