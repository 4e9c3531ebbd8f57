// Named points: compliance, linear models, transfers and transmissibility from and to them.
#include "core/response/modes/point_forces.hpp"

#include "core/math/rotation.hpp"
#include "core/response/gradients/point_gradients.hpp"
#include "core/response/modes/dynamics_measures.hpp"
#include "core/response/modes/state_space.hpp"
#include "support/gradient_checks.hpp"
#include "support/strokes.hpp"
#include "tests/core/response/modes/dense_pencil.hpp"

using namespace flexopt;
using namespace flexopt::test;
using Complex = std::complex<double>;

namespace {

NamedPoint on_body(std::string name, int body, const Vector3d& at,
                   std::optional<Vector6d> direction = {}) {
  return {.name = std::move(name), .body = body, .at = at, .direction = direction};
}
NamedPoint on_leaf(std::string name, int leaf, double along, double across) {
  return {.name = std::move(name), .leaf = leaf, .along = along, .across = across};
}

Vector6d unit(Direction d) { return Vector6d::Unit(index(d)); }
Vector6d along(const Vector3d& v) {
  return (Vector6d() << v.normalized(), Vector3d::Zero()).finished();
}

MatrixXd forces_at(const MechanismFactor& factor, const std::vector<NamedPoint>& points) {
  LeafRates rates;
  const Answer<MatrixXd> forces = point_forces(factor, points, rates);
  REQUIRE(forces);
  return *forces;
}
MatrixXd compliance_between(const MechanismFactor& factor, const std::vector<NamedPoint>& points) {
  const MatrixXd forces = forces_at(factor, points);
  return forces.transpose() * factor.solve(forces);
}

Mechanism stage() {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.004, -0.006);
  return m;
}
const Vector3d sensor(0.2, 0.01, 0.02);

Complex shift(double f, double damping) {
  return 4 * M_PI * M_PI * f * f / Complex(1, 2 * damping);
}

// A guide whose end-effector leans, with a point that its length moves away from.
const std::vector<Number> numbers{{"length", 0.1},   {"thickness", 0.6e-3}, {"mass", 0.2},
                                  {"centre", 0.01},  {"angle", 0.3},        {"width", 0.02},
                                  {"modulus", 2e11}, {"ratio", 0.3}};
Mechanism leaning(const Values& p) {
  Mechanism m{.bodies = {models::body({p[0], 0.001, 0.002}, p[2], 2e-4)},
              .drives = {make_drive(Direction::uy)}};
  m.bodies[0].center_of_mass += Vector3d(p[3], 0.5 * p[3], -0.3 * p[3]);
  for (const double side : {1.0, -1.0})
    m.leaves.push_back(models::leaf({0, 0.03 * side, 0}, {1, -0.3 * side * p[4], 0}, p[0], p[5],
                                    p[1], {"steel", p[6], p[7], 7800, {}}));
  return m;
}

}  // namespace

TEST_CASE("compliance between points of a body is that of O with their levers") {
  const Mechanism m = stage();
  const BentMechanism at = bent(m, 0.012, models::full(Flexure::plate, {6, 2}));
  const MechanismFactor& factor = *at.factor;
  const JointBody& now = at.system->pose(0);
  const NamedPoint motor = on_body("motor", 0, {0.02, -0.03, 0.01}, along({1, 2, -0.5})),
                   turn = on_body("turn", 0, sensor, unit(Direction::rz)),
                   encoder = on_body("encoder", 0, sensor),
                   O{.name = "O", .body = 0, .direction = unit(Direction::uy)};
  Matrix6d C;
  {
    MatrixXd loads = MatrixXd::Zero(factor.size(), 6);
    loads.topRows<6>().setIdentity();
    C = factor.solve(loads).topRows<6>();
  }
  MatrixXd levers = MatrixXd::Zero(6, 6);  // of motor, turn, encoder x y z, O
  const auto place = [&](const Vector3d& from) -> Vector3d {
    return now.rotation * (from - now.reference);
  };
  levers.col(0) << motor.direction->head<3>(),
      place({0.02, -0.03, 0.01}).cross(motor.direction->head<3>());
  levers.col(1) = unit(Direction::rz);
  levers.block<3, 3>(0, 2).setIdentity();
  levers.block<3, 3>(3, 2) = hat(place(sensor));
  levers.col(5) = unit(Direction::uy);
  const MatrixXd found = compliance_between(factor, {motor, turn, encoder, O}),
                 expected = levers.transpose() * C * levers;
  CHECK((found - expected).norm() <= 1e-10 * expected.norm());
  CHECK((found - found.transpose()).norm() <= 1e-10 * found.norm());
}

TEST_CASE("a point of the end-effector is O of the mechanism rebuilt with O there") {
  const Mechanism m = stage();
  Mechanism rebuilt = m;
  rebuilt.bodies[0].reference = sensor;
  const ModelOptions model = models::full(Flexure::plate, {6, 2});
  System still(m, make_full_leaves(m, model)), moved(rebuilt, make_full_leaves(rebuilt, model));
  MatrixXd compliance[2];
  for (System* system : {&still, &moved}) {
    system->assemble();
    const auto factor = MechanismFactor::of(*system);
    REQUIRE(factor);
    const NamedPoint at =
        system == &still ? on_body("sensor", 0, sensor) : NamedPoint{.name = "O", .body = 0};
    compliance[system == &moved] = compliance_between(*factor, {at});
  }
  CHECK((compliance[0] - compliance[1]).norm() <= 1e-8 * compliance[1].norm());
}

TEST_CASE("points of leaves obey Maxwell and the clamped beam") {
  const Material steel{"m", 2e11, 0, 7800, {}};
  const double L = 0.1, w = 0.004, t = 2e-4, EI = steel.youngs_modulus * w * t * t * t / 12;
  const Mechanism leaf = models::single_leaf(L, w, t, Direction::uy, steel);
  const BentMechanism rest = bent(leaf, 0, models::full(Flexure::plate, {16, 2}));
  NamedPoint middle = on_leaf("middle", 0, 0.5, 0.5);
  middle.direction = unit(Direction::uy);
  const NamedPoint tip{.name = "tip", .body = 0, .direction = unit(Direction::uy)};
  const MatrixXd C = compliance_between(*rest.factor, {middle, tip});
  CHECK(C(0, 1) == Approx(5 * L * L * L / (48 * EI)).epsilon(2e-3));
  CHECK(C(0, 0) == Approx(L * L * L / (24 * EI)).epsilon(2e-3));
  CHECK(C(1, 1) == Approx(L * L * L / (3 * EI)).epsilon(2e-3));

  const Mechanism m = stage();
  const BentMechanism at = bent(m, 0.012, models::full(Flexure::plate, {6, 2}));
  const std::vector<NamedPoint> points{on_leaf("a", 0, 0.4, 0.1), on_leaf("b", 1, 0.73, 0.8),
                                       on_body("c", 0, sensor)};
  const MatrixXd both = compliance_between(*at.factor, points);
  REQUIRE(both.rows() == 9);
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < i; ++j)
      CHECK(std::abs(both(i, j) - both(j, i)) <= 1e-10 * std::sqrt(both(i, i) * both(j, j)));
}

TEST_CASE("loads and motions of points are inputs and outputs of the linear model") {
  const Mechanism m = stage();
  const BentMechanism at = bent(m, 0.012, models::full(Flexure::plate, {6, 2}));
  const MechanismFactor& factor = *at.factor;
  const std::vector<NamedPoint> points{on_body("encoder", 0, sensor, along({0, 1, 1})),
                                       on_body("tilt", 0, sensor, unit(Direction::ry)),
                                       on_leaf("gauge", 1, 0.5, 0.5)};
  const auto lists = full_modes(factor, 6, 0);
  REQUIRE(lists);
  LeafRates rates;
  const Answer<StateSpace> model =
      state_space(factor, {.modes = 6, .damping = {0.01}}, points, lists->free, rates);
  REQUIRE(model);
  REQUIRE(model->inputs.size() == 1 + 12 + 5);
  REQUIRE(model->outputs.size() == 6 + 1 + 5);
  CHECK(model->inputs[13].name == "point.encoder");
  CHECK(model->inputs[14].unit == "N m");
  CHECK(model->outputs[8].unit == "rad");
  CHECK(model->outputs[11].name == "point.gauge.z");
  const MatrixXd still =
      model->residual + model->motions * model->omega2.cwiseInverse().asDiagonal() * model->forces;
  const MatrixXd expected = compliance_between(factor, points);
  CHECK((still.bottomRightCorner(5, 5) - expected).norm() <= 1e-9 * expected.norm());
  const Answer<StateSpace> none = state_space(
      factor, {.modes = 6, .damping = {0.01}, .sensors = false}, points, lists->free, rates);
  REQUIRE(none);
  CHECK(none->inputs.size() == 13);
}

TEST_CASE("a rigid stage on one spring answers as by hand") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].held = {true, false, true, true, true, true};
  for (LeafSpring& leaf : m.leaves) leaf.material.density = 1e-9;
  const BentMechanism at = bent(m, 0.01, models::beams(6));
  const double k = 1 / compliance_between(*at.factor, {{.name = "O", .body = 0}})(1, 1),
               mass = m.bodies[0].mass;
  const auto lists = full_modes(*at.factor, 1, 0);
  REQUIRE(lists);
  LeafRates rates;
  const Answer<StateSpace> model = state_space(
      *at.factor, {.modes = 1}, {on_body("e", 0, sensor, unit(Direction::uy))}, lists->free, rates);
  REQUIRE(model);
  CHECK(model->omega2[0] == Approx(k / mass).epsilon(1e-6));
  CHECK(model->motions(7, 0) * model->forces(0, 13) == Approx(1 / mass).epsilon(1e-6));
}

TEST_CASE("a transfer ends where its mass leaves the line, and from a drive to itself is its own") {
  Mechanism m = stage();
  m.bodies.push_back(models::intermediate({0, 0.08, 0.01}, 0.05, 1e-5));
  m.leaves.push_back(models::between(
      0, 1, models::leaf({0.1, 0.05, 0}, {-1, 0.3, 0}, 0.07, 0.03, 4e-4, m.leaves[0].material)));
  const BentMechanism at = bent(m, 0.01, models::beams(3));
  const MechanismFactor& factor = *at.factor;
  const std::vector<NamedPoint> points{{.name = "O", .body = 0, .direction = unit(Direction::uy)},
                                       on_body("encoder", 0, sensor, unit(Direction::uy)),
                                       on_body("beyond", 1, {0, 0.08, 0.01}, along({1, 1, 0}))};
  const double damping = 0.02;
  DynamicsRule rule{.damping = damping};
  for (const std::size_t from : {0, 1, 2})
    for (const std::size_t to : {0, 1, 2}) rule.transfers.push_back({from, to});
  LeafRates rates;
  const Answer<std::vector<TransferMeasure>> found = transfers(factor, rule, points, false, rates);
  REQUIRE(found);
  const auto own = dynamics_measures(factor, rule, true, false).bandwidths.at(0);
  REQUIRE(own);
  REQUIRE((*found)[0].bandwidth);
  CHECK(*(*found)[0].bandwidth == Approx(own->value).epsilon(1e-8));
  const MatrixXd forces = forces_at(factor, points);
  const MatrixXd C = forces.transpose() * factor.solve(forces);
  for (std::size_t k = 0; k < rule.transfers.size(); ++k) {
    const auto from = static_cast<Eigen::Index>(*rule.transfers[k].from),
               to = static_cast<Eigen::Index>(rule.transfers[k].to);
    const Transfer& transfer = (*found)[k];
    CHECK(transfer.compliance == Approx(C(to, from)).epsilon(1e-9));
    REQUIRE(transfer.bandwidth);
    const auto mass = [&](double f) {
      const Complex sigma = shift(f, damping);
      const Complex H = (forces.col(to).cast<Complex>().transpose() *
                         pencil_answer(factor, false, sigma, forces.col(from)))(0);
      return std::abs((1 / C(to, from) - 1.0 / H) / sigma);
    };
    const VectorXd y = factor.solve(forces.col(from)).col(0),
                   z = factor.solve(forces.col(to)).col(0);
    const double still = std::abs(z.dot(factor.mass(y).col(0))) / (C(to, from) * C(to, from));
    const auto excess = [&](double f) {
      return std::max(mass(f) / still, still / mass(f)) / M_SQRT2;
    };
    CHECK(excess(*transfer.bandwidth) == Approx(1).epsilon(1e-6));
    for (double f = 0.3 * *transfer.bandwidth; f < 0.99 * *transfer.bandwidth; f *= 1.2)
      CHECK(excess(f) < 1);
    CHECK(*transfer.bandwidth ==
          Approx(*(*found)[static_cast<std::size_t>(3 * to + from)].bandwidth).epsilon(1e-8));
  }
}

TEST_CASE("a load that does not move a point has no bandwidth there, and the transfer says why") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);  // the middle plane is one of symmetry
  const BentMechanism at = bent(m, 0, models::beams(3));
  const std::vector<NamedPoint> points{{.name = "O", .body = 0, .direction = unit(Direction::uy)},
                                       {.name = "up", .body = 0, .direction = unit(Direction::uz)}};
  DynamicsRule rule{.damping = 0.02};
  rule.transfers = {{0, 1}, {.from = 0, .to = 1, .of_motion = true}};
  LeafRates rates;
  const auto found = transfers(*at.factor, rule, points, false, rates);
  REQUIRE(found);
  for (const TransferMeasure& transfer : *found) {
    CHECK_FALSE(transfer.bandwidth);
    CHECK(transfer.no_bandwidth.reason == "a load at O does not move up");
    CHECK_FALSE(transfer.no_bandwidth.at_least);
  }
}

TEST_CASE("no motion is given to a point that a drive holds still") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const BentMechanism at = bent(m, 0, models::beams(3));
  const std::vector<NamedPoint> points{{.name = "O", .body = 0, .direction = unit(Direction::uy)},
                                       {.name = "up", .body = 0, .direction = unit(Direction::uz)}};
  DynamicsRule rule{.damping = 0.02};
  rule.transfers = {{.from = 0, .to = 1, .drive = DriveState::locked, .of_motion = true}};
  LeafRates rates;
  const auto found = transfers(*at.factor, rule, points, false, rates);
  REQUIRE_FALSE(found);
  CHECK(found.error() == "the motion of O is held, and no other can be given to it");
}

TEST_CASE("a bandwidth whose derivative was not found has none, not zero") {
  const Family family{leaning, numbers, {0}, 10};
  const Mechanism m = leaning(values_of(numbers));
  const ModelOptions model = models::beams(3);
  const BentMechanism at = bent(m, 0.01, model);
  DesignDirections design(m, {direction(family, 0).rate});
  const auto rates = design_rates(*at.factor, design, model);
  REQUIRE(rates);
  DynamicsMeasures measures;
  measures.transfers.emplace_back().bandwidth = 100;
  const PointGradients found =
      point_gradients(*at.factor, *rates, {.outputs = {Output::equilibrium}}, PathPoint(), {},
                      nullptr, &measures, {}, {});
  REQUIRE(found.transfer_bandwidths.size() == 1);
  CHECK_FALSE(found.transfer_bandwidths[0]);
}

TEST_CASE("transmissibility to a point is that of the pencil") {
  const Mechanism m = stage();
  const BentMechanism at = bent(m, 0.012, models::beams(4));
  const MechanismFactor& factor = *at.factor;
  const NamedPoint encoder = on_body("encoder", 0, sensor, along({0.5, 0.2, 1}));
  DynamicsRule rule{.damping = 0.02, .transmissibility = {{Direction::uz, 20, 2000}}};
  rule.transmissibility->point = 0;
  const auto found = dynamics_measures(factor, rule, true, false, {encoder}).transmissibility;
  REQUIRE(found);
  const RigidMotion rigid = rigid_motion(factor);
  const VectorXd force = forces_at(factor, {encoder}).col(0);
  const Complex sigma = shift(found->frequency, 0.02);
  const Complex T = (*encoder.direction)[2] +
                    sigma * (force.cast<Complex>().transpose() *
                             pencil_answer(factor, false, sigma, rigid.inertia.col(2)))(0);
  CHECK(found->value == Approx(std::abs(T)).epsilon(1e-8));
  CHECK(std::abs(found->value -
                 dynamics_measures(factor, {0.02, {{Direction::uz, 20, 2000}}}, true, false)
                     .transmissibility->value) > 1e-3);
}

TEST_CASE("derivatives of the transmissibility to a point agree with differences") {
  StrokeRequest request{
      .points = {0, 0.01},
      .loads = {.constant = {{.force = {1, 0, -2}, .moment = {0.01, 0.02, -0.01}}}},
      .outputs = {Output::equilibrium, Output::dynamics}};
  request.dynamics = {.damping = 0.02, .transmissibility = {{Direction::uz, 20, 2000}}};
  request.dynamics->transmissibility->point = 0;
  request.named_points = {on_body("encoder", 0, sensor, along({0.5, 0.2, 1}))};
  CHECK(check_gradients({leaning, numbers, {0, 1, 2, 3, 4}, 10}, models::beams(6), request) >= 50);
}

TEST_CASE("a moved point takes another along, and the ground both, up to 3 dB less than at rest") {
  Mechanism m = stage();
  m.bodies.push_back(models::intermediate({0, 0.08, 0.01}, 0.05, 1e-5));
  m.leaves.push_back(models::between(
      0, 1, models::leaf({0.1, 0.05, 0}, {-1, 0.3, 0}, 0.07, 0.03, 4e-4, m.leaves[0].material)));
  const BentMechanism at = bent(m, 0.01, models::full(Flexure::plate, {4, 2}));
  const MechanismFactor& factor = *at.factor;
  NamedPoint middle = on_leaf("middle", 2, 0.4, 0.3);
  middle.direction = along({1, 2, 0});
  const std::vector<NamedPoint> points{on_body("encoder", 0, sensor, unit(Direction::uy)), middle};
  const double damping = 0.02;
  DynamicsRule rule{.damping = damping};
  rule.transfers = {{.from = 0, .to = 1, .of_motion = true},
                    {.from = 1, .to = 0, .of_motion = true},
                    {.to = 0},
                    {.to = 1}};
  LeafRates rates;
  const auto found = transfers(factor, rule, points, false, rates);
  REQUIRE(found);
  const MatrixXd forces = forces_at(factor, points), inertia = rigid_motion(factor).inertia;
  for (std::size_t k = 0; k < found->size(); ++k) {
    const auto to = static_cast<Eigen::Index>(rule.transfers[k].to);
    const auto ratio = [&](double f) -> Complex {
      const Complex sigma = shift(f, damping);
      const auto moved = [&](Eigen::Index of, const VectorXd& by) {
        return Complex((forces.col(of).cast<Complex>().transpose() *
                        pencil_answer(factor, false, sigma, by))(0));
      };
      if (rule.transfers[k].from)
        return moved(to, forces.col(1 - to)) / moved(1 - to, forces.col(1 - to));
      const Vector3d n = points[rule.transfers[k].to].direction->head<3>();
      return 1.0 + sigma * moved(to, inertia.leftCols<3>() * n);
    };
    const Transfer& transfer = (*found)[k];
    INFO(k);
    CHECK(transfer.compliance == Approx(ratio(1e-3).real()).epsilon(1e-6));
    REQUIRE(transfer.bandwidth);
    const double still = std::abs(transfer.compliance);
    CHECK(std::abs(ratio(*transfer.bandwidth)) / still == Approx(std::sqrt(0.5)).epsilon(1e-6));
    for (double f = 0.1 * *transfer.bandwidth; f < 0.99 * *transfer.bandwidth; f *= 1.1)
      CHECK(std::abs(ratio(f)) / still > std::sqrt(0.5));
  }
}

TEST_CASE("one mass on one spring is shaken up to its frequency times the root of 1 + sqrt 2") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].held = {true, false, true, true, true, true};
  for (LeafSpring& leaf : m.leaves) leaf.material.density = 1e-9;
  const BentMechanism at = bent(m, 0.01, models::beams(6));
  const double zeta = 0.05,
               k = 1 / compliance_between(*at.factor, {{.name = "O", .body = 0}})(1, 1),
               f0 = std::sqrt(k / m.bodies[0].mass) / (2 * M_PI);
  DynamicsRule rule{.damping = zeta};
  rule.transfers = {{.to = 0}};
  LeafRates rates;
  const auto found =
      transfers(*at.factor, rule, {on_body("e", 0, sensor, unit(Direction::uy))}, false, rates);
  REQUIRE(found);
  CHECK(*found->front().bandwidth ==
        Approx(f0 * std::sqrt(1 + std::sqrt(2 + 4 * zeta * zeta))).epsilon(1e-6));
}

TEST_CASE("derivatives of named points, transfers and gauges agree with differences", "[slow]") {
  NamedPoint middle = on_leaf("middle", 0, 0.4, 0.3), tilted = on_leaf("tilted", 1, 0.7, 1);
  middle.direction = along({1, 2, 0.5});
  tilted.direction = along({0.2, 1, -0.4});
  StrokeRequest request{
      .points = {0, 0.01},
      .loads = {.constant = {{.force = {1, 0, -2}, .moment = {0.01, 0.02, -0.01}}}},
      .outputs = {Output::equilibrium, Output::leaf_points, Output::transfers, Output::gauges,
                  Output::dynamics},
      .named_points = {on_body("encoder", 0, sensor, along({0.5, 0.2, 1})),
                       on_body("turn", 0, sensor, unit(Direction::rz)),
                       middle,
                       tilted,
                       {.name = "O", .body = 0, .direction = unit(Direction::uz)}},
      .gauges = {{"a", 0, 0.1, 0.5, true, 0.3}, {"b", 1, 0, 0.2, false, 0}},
      .bridges = {{"force", {{0, 1}, {1, -1}}, 2.05}}};
  // a gauge at the border of the corners that the largest stress leaves out stays where it is
  request.gauges.push_back({"border", 0, 0.02, 0.1});
  request.dynamics = {.damping = 0.02, .transmissibility = {{Direction::uz, 20, 2000}}};
  request.dynamics->transmissibility->point = 2;
  request.dynamics->transfers = {{.from = 0, .to = 2, .name = "a"},
                                 {.from = 1, .to = 0, .drive = DriveState::locked, .name = "b"},
                                 {.from = 2, .to = 3, .name = "c"},
                                 {.from = 2, .to = 0, .of_motion = true, .name = "d"},
                                 {.to = 0, .name = "e"},
                                 {.to = 3, .name = "f"}};
  SECTION("beams") {
    CHECK(check_gradients({leaning, numbers, {0, 1, 2, 3, 4, 5, 6, 7}, 10}, models::beams(6),
                          request) >= 300);
  }
  SECTION("plates") {
    CHECK(check_gradients({leaning, numbers, {0, 1, 2, 4, 5, 6, 7}, 10},
                          models::full(Flexure::plate, {4, 2}), request) >= 260);
  }
  SECTION("curved leaves") {
    const auto curved = [](const Values& p) {
      Mechanism m = leaning(p);
      m.leaves[0].curve = p[4];
      return m;
    };
    CHECK(check_gradients({curved, numbers, {0, 1, 4, 5}, 10}, models::full(Flexure::plate, {4, 2}),
                          request) >= 140);
  }
}
