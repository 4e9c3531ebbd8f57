#include "core/reduction/superelement/superelement_gradient.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/ridders.hpp"
#include "superelement_bodies.hpp"

using namespace flexopt;
using namespace flexopt::bodies;
using flexopt::synthetic::Random;

namespace {

// A direction in which all data of a model change, symmetric where they are.
SuperelementModel random_rate(const SuperelementModel& model, Random& random) {
  SuperelementModel rate = model;
  const auto vary = [&](MatrixXd& A, bool symmetric) {
    for (double& x : A.reshaped()) x *= random();
    if (symmetric) A = (A + A.transpose()).eval();
  };
  const int n = model.coordinates(), k = static_cast<int>(model.stiffness.rows()) - n;
  vary(rate.stiffness, true);
  vary(rate.mass, true);
  if (k > 0) {  // a full block of the modes
    const double size = model.stiffness.bottomRightCorner(k, k).norm();
    for (double& x : rate.stiffness.bottomRightCorner(k, k).reshaped()) x = size * random();
    rate.stiffness.bottomRightCorner(k, k) +=
        rate.stiffness.bottomRightCorner(k, k).transpose().eval();
  }
  vary(rate.frame_modes, false);
  for (Vector3d& X : rate.nodes) X = random.vector<3>(0.1 * model.size());
  return rate;
}

SuperelementModel moved_model(const SuperelementModel& model, const SuperelementModel& rate,
                              double t) {
  SuperelementModel m = model;
  for (std::size_t a = 0; a < m.nodes.size(); ++a) m.nodes[a] += t * rate.nodes[a];
  m.stiffness += t * rate.stiffness;
  m.mass += t * rate.mass;
  m.frame_modes += t * rate.frame_modes;
  return m;
}

std::vector<NodePose> moved_nodes(const std::vector<NodePose>& nodes, const VectorXd& z, double t) {
  std::vector<NodePose> result = nodes;
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    result[a].position += t * z.segment<3>(6 * a);
    result[a].axes = rotation_exp(t * z.segment<3>(6 * a + 3)) * result[a].axes;
  }
  return result;
}

struct Values {
  VectorXd force;
  double stiffness = 0, mass = 0;
};
Values values(const SuperelementModel& model, const std::vector<NodePose>& nodes,
              const VectorXd& y) {
  Superelement element(model);
  REQUIRE(element.evaluate(nodes));
  const int n = model.coordinates(), k = static_cast<int>(y.size()) - n;
  const VectorXd a = y.tail(k);
  return {element.force(),
          y.head(n).dot(element.tangent() * y.head(n)) +
              a.dot(model.stiffness.bottomRightCorner(k, k) * a),
          y.dot(element.mass() * y)};
}

struct Case {
  int nodes, modes;
  double stretch, bend;
};

}  // namespace

TEST_CASE("derivatives of a superelement's tangent, mass and force agree with differences",
          "[reduction]") {
  for (const Case& c : {Case{2, 0, 0.02, 0.2}, Case{2, 2, 0.2, 0.9}, Case{3, 1, 0.05, 0.5},
                        Case{4, 0, 0.0, 0.0}, Case{4, 3, 0.03, 0.3}, Case{4, 2, 0.2, 0.8}}) {
    INFO(c.nodes << " nodes, stretch " << c.stretch << ", bend " << c.bend);
    const CondensedPlate body = irregular(40 + c.nodes, c.nodes, c.modes);
    const SuperelementModel& model = body.superelement;
    Random random(50 + c.nodes);
    std::vector<NodePose> nodes = deformed(model, random, c.stretch, c.bend);
    for (NodePose& node : nodes) node.axes = orthonormalised(node.axes);
    const std::vector<SuperelementModel> rates{random_rate(model, random),
                                               random_rate(model, random)};
    Superelement element(model);
    REQUIRE(element.evaluate(nodes));
    const SuperelementGradient gradient(element, rates);
    const int n = model.coordinates();
    const VectorXd unit = units(model);
    const auto increment = [&](int size) {
      VectorXd y(size);
      for (double& x : y) x = random();
      y.head(n) = (unit.asDiagonal() * y.head(n)).eval();
      return y;
    };
    const VectorXd y = increment(n + c.modes);
    const Values here = values(model, nodes, y);
    const double mu = 0.7 * here.stiffness / here.mass;
    SuperelementGradient::Quadratic q;
    gradient.quadratic(y, mu, q);
    CHECK(q.stiffness == Approx(here.stiffness).epsilon(1e-11));
    CHECK(q.mass == Approx(here.mass).epsilon(1e-12));
    CHECK(q.increment.dot(y) == Approx(2 * (here.stiffness - mu * here.mass)).epsilon(1e-10));
    const double size = std::abs(here.stiffness) + mu * here.mass;

    const auto form = [&](const Values& v) { return v.stiffness - mu * v.mass; };
    double worst = 0;
    for (int k = 0; k < 4; ++k) {
      const VectorXd z = increment(n);
      const Derivatives d = ridders(
          [&](double t) { return std::vector{form(values(model, moved_nodes(nodes, z, t), y))}; },
          0, 0.05, 9);
      worst = std::max(worst, std::abs(d.value[0] - q.state.dot(z)) / size);

      const VectorXd dy = increment(n + c.modes);
      const double both = form(values(model, nodes, y + dy)) - form(values(model, nodes, y - dy));
      CHECK(std::abs(both - 2 * q.increment.dot(dy)) < 1e-10 * size);
      const VectorXd df = gradient.force_rates(MatrixXd(z));
      const Derivatives f = ridders(
          [&](double t) {
            const VectorXd force = values(model, moved_nodes(nodes, z, t), y).force;
            return std::vector<double>(force.begin(), force.end());
          },
          0, 0.05, 9);
      const VectorXd differences = Eigen::Map<const VectorXd>(f.value.data(), n);
      CHECK((unit.asDiagonal() * (df - differences)).norm() <
            1e-9 * (unit.asDiagonal() * df).norm());
    }
    CHECK(worst < 1e-10);
    for (int p = 0; p < 2; ++p) {
      const Derivatives d = ridders(
          [&](double t) {
            const Values v = values(moved_model(model, rates[p], t), nodes, y);
            std::vector<double> all(v.force.begin(), v.force.end());
            all.push_back(form(v));
            return all;
          },
          0, 0.05, 9);
      CHECK(std::abs(d.value[n] - q.model[p]) < 1e-9 * std::max(size, std::abs(q.model[p])));
      const VectorXd differences = Eigen::Map<const VectorXd>(d.value.data(), n),
                     df = gradient.force_rates().col(p);
      // where nothing is deformed, the nodes' own places remain
      CHECK((unit.asDiagonal() * (df - differences)).norm() <
            1e-9 * (unit.asDiagonal() * df).norm());
    }
  }
}

TEST_CASE("derivatives of a superelement turn with it and do not see rigid motions",
          "[reduction]") {
  const CondensedPlate body = irregular(61, 4, 2);
  const SuperelementModel& model = body.superelement;
  Random random(61);
  const std::vector<NodePose> nodes = deformed(model, random, 0.05, 0.4);
  const std::vector<SuperelementModel> rates{random_rate(model, random)};
  const int n = model.coordinates();
  VectorXd y(n + 2);
  for (double& x : y) x = random();
  y.head(n) = (units(model).asDiagonal() * y.head(n)).eval();
  const auto quadratic = [&](const std::vector<NodePose>& at, const VectorXd& along) {
    Superelement element(model);
    REQUIRE(element.evaluate(at));
    SuperelementGradient::Quadratic q;
    SuperelementGradient(element, rates).quadratic(along, 1e3, q);
    return q;
  };
  const auto q = quadratic(nodes, y);
  const Matrix3d R = random_rotation(random, 2.0);
  VectorXd turned_y = y;
  turned_y.head(n) = turned(R, y.head(n));
  const auto p = quadratic(moved(nodes, R, {1, 2, 3}), turned_y);
  CHECK(p.stiffness == Approx(q.stiffness).epsilon(1e-10));
  CHECK((p.model - q.model).norm() < 1e-9 * q.model.norm());
  CHECK((p.state - turned(R, q.state)).norm() < 1e-9 * q.state.norm());
  // turning nodes and y together changes nothing: state and increments balance
  Vector6d state = Vector6d::Zero();
  double size = 0;
  for (int a = 0; a < 4; ++a) {
    const int i = 6 * a;
    const Vector3d force = q.state.segment<3>(i);
    state.head<3>() += force;
    state.tail<3>() += q.state.segment<3>(i + 3) +
                       (nodes[a].position - nodes[0].position).cross(force) +
                       Vector3d(y.segment<3>(i)).cross(Vector3d(q.increment.segment<3>(i))) +
                       Vector3d(y.segment<3>(i + 3)).cross(Vector3d(q.increment.segment<3>(i + 3)));
    size += force.norm();
  }
  CHECK(state.head<3>().norm() < 1e-10 * size);
  CHECK(state.tail<3>().norm() < 1e-10 * size * model.size());
}
