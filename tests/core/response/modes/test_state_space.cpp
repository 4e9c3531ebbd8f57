// The linear model about an equilibrium: its poles, its static gain, its answers.
#include "core/response/modes/state_space.hpp"

#include <Eigen/Eigenvalues>
#include <utility>

#include "core/math/rotation.hpp"
#include "core/response/modes/mechanism_factor.hpp"
#include "support/strokes.hpp"
#include "tests/core/response/modes/dense_pencil.hpp"

using namespace flexopt;
using namespace flexopt::test;
using Complex = std::complex<double>;

namespace {

StrokeRequest request_of(std::vector<double> points, StateSpaceRequest wanted) {
  return {.points = std::move(points),
          .loads = {.constant = {{.force = {2, 0.3, -1}, .moment = {0.01, 0.02, -0.01}}}},
          .values = PathValues::differentiable,
          .frequencies = 5,
          .state_space = std::move(wanted)};
}

int output(const StateSpace& model, const std::string& name) {
  for (std::size_t k = 0; k < model.outputs.size(); ++k)
    if (model.outputs[k].name == name) return static_cast<int>(k);
  FAIL(name);
  return 0;
}
int input(const StateSpace& model, const std::string& name) {
  for (std::size_t k = 0; k < model.inputs.size(); ++k)
    if (model.inputs[k].name == name) return static_cast<int>(k);
  FAIL(name);
  return 0;
}

/// Outputs × inputs at a frequency [Hz]: (H3).
Eigen::MatrixXcd frequency_response(const StateSpace& model, double frequency) {
  const double omega = 2 * M_PI * frequency;
  Eigen::MatrixXcd H = model.residual.cast<Complex>();
  for (Eigen::Index k = 0; k < model.omega2.size(); ++k) {
    const Complex of_mode(model.omega2[k] - omega * omega,
                          2 * model.damping[k] * omega * std::sqrt(std::abs(model.omega2[k])));
    H += (model.motions.col(k) * model.forces.row(k)).cast<Complex>() / of_mode;
  }
  return H;
}

/// ẋ = A x + B u, y = C x + D u with x the modal amplitudes and their velocities.
struct StateMatrices {
  MatrixXd A, B, C, D;
};
StateMatrices state_matrices(const StateSpace& model) {
  const Eigen::Index n = model.omega2.size();
  StateMatrices state{MatrixXd::Zero(2 * n, 2 * n), MatrixXd::Zero(2 * n, model.forces.cols()),
                      MatrixXd::Zero(model.motions.rows(), 2 * n), model.residual};
  state.A.topRightCorner(n, n).setIdentity();
  state.A.bottomLeftCorner(n, n).diagonal() = -model.omega2;
  state.A.bottomRightCorner(n, n).diagonal() =
      -2 * model.damping.cwiseProduct(model.omega2.cwiseAbs().cwiseSqrt());
  state.B.bottomRows(n) = model.forces;
  state.C.leftCols(n) = model.motions;
  return state;
}

}  // namespace

TEST_CASE("poles are the listed frequencies, the static gain is the compliance") {
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4),
                  hinge = models::three_leaf_hinge(0.08, 0.02, 4e-4);
  Mechanism leaf = models::single_leaf(0.08, 0.01, 5e-4, Direction::rz);  // which the loads tilt
  leaf.bodies[0].mass = 0.3;
  leaf.bodies[0].inertia = 1e-4 * Matrix3d::Identity();
  for (const Mechanism* m : {&guide, &hinge, &std::as_const(leaf)}) {
    const bool turns = m != &guide;
    const StrokeRequest request =
        request_of({0, turns ? 0.2 : 0.015}, {.modes = 5, .damping = {0.02}});
    const StrokeResponse response = evaluated(*m, models::full(Flexure::plate, {6, 2}), request);
    for (const PathPoint& point : response.path) {
      REQUIRE(point.state_space);
      const StateSpace& model = *point.state_space;
      REQUIRE(model.omega2.size() == 5);
      const StateMatrices state = state_matrices(model);
      Eigen::VectorXcd poles = Eigen::EigenSolver<MatrixXd>(state.A, false).eigenvalues();
      std::ranges::sort(poles, {}, [](const Complex& s) { return std::abs(s); });
      for (int k = 0; k < 5; ++k) {
        CHECK(
            std::abs(poles[2 * k]) ==
            Approx(2 * M_PI * point.frequencies_free[static_cast<std::size_t>(k)]).epsilon(1e-10));
        CHECK(-poles[2 * k].real() / std::abs(poles[2 * k]) == Approx(0.02).epsilon(1e-8));
      }
      // by A, B, C, D as by the modes
      const MatrixXd still = state.D - state.C * state.A.inverse() * state.B;
      const MatrixXd gain = frequency_response(model, 0).real();
      CHECK((still - gain).norm() <= 1e-10 * gain.norm());
      const int load = input(model, "load.ux"), drive = input(model, "drive_load"),
                stroke = output(model, "stroke");
      const Matrix6d C = gain.block<6, 6>(0, load);
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) {
          const double unit = std::sqrt(point.compliance_free(i, i) * point.compliance_free(j, j));
          CHECK(std::abs(C(i, j) - point.compliance_free(i, j)) <= 1e-10 * unit);
        }
      CHECK(gain(stroke, drive) == Approx(1 / point.drive_stiffness).epsilon(1e-10));
      // the drive is that of the end-effector: about the axis half-way between z and where z is now
      Vector6d along = Vector6d::Unit(1);
      if (turns) {
        const Vector3d z = Vector3d::UnitZ(), now = rotation_exp(point.rotation) * z;
        along << 0, 0, 0, (z + now) / (1 + z.dot(now));
      }
      const Eigen::RowVectorXd moves = along.transpose() * gain.topRows<6>();
      CHECK((gain.row(stroke) - moves).norm() <= 1e-12 * moves.norm());
      const VectorXd loaded = gain.middleCols<6>(load) * along;
      CHECK((gain.col(drive) - loaded).norm() <= 1e-12 * loaded.norm());
    }
  }
}

TEST_CASE("answers are those of the pencil solved at the frequency") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.bodies[0].center_of_mass += Vector3d(0.01, 0.004, -0.006);
  const BentMechanism at = bent(m, 0.012, models::full(Flexure::beam, {6, 1}));
  const MechanismFactor& factor = *at.factor;
  const RigidMotion rigid = rigid_motion(factor);
  LeafRates rates;
  double before = 1;
  for (const int modes : {4, 10, 30}) {
    const auto lists = full_modes(factor, modes, 0);
    REQUIRE(lists);
    const Answer<StateSpace> built =
        state_space(factor, {.modes = modes, .damping = {0.0}}, {}, lists->free, rates);
    REQUIRE(built);
    const StateSpace& model = *built;
    REQUIRE(model.omega2.size() == modes);
    double worst = 0;
    for (const double f : {1.0, 0.37 * std::sqrt(model.omega2[3]) / (2 * M_PI),
                           0.9 * std::sqrt(model.omega2[2]) / (2 * M_PI)}) {
      const Complex sigma = 4 * M_PI * M_PI * f * f;
      const Eigen::MatrixXcd H = frequency_response(model, f);
      for (std::size_t k = 0; k < model.inputs.size(); ++k) {
        VectorXd force = VectorXd::Zero(factor.size());
        if (k == 0)
          force[1] = 1;
        else if (k < 7)
          force = -rigid.inertia.col(static_cast<Eigen::Index>(k) - 1);
        else
          force[static_cast<Eigen::Index>(k) - 7] = 1;
        const Eigen::VectorXcd expected = pencil_answer(factor, false, sigma, force);
        for (int i = 0; i < 6; ++i)
          worst = std::max(worst, std::abs(H(i, static_cast<Eigen::Index>(k)) - expected[i]) /
                                      expected.head(6).segment(i < 3 ? 0 : 3, 3).norm());
      }
    }
    // what is left out goes with the fourth power of the frequency over that of the first mode left
    CHECK(worst < 0.5 * before);
    before = worst;
  }
  CHECK(before < 1e-6);
}

TEST_CASE("a sensor on a clamped edge moves with its body, and static sag is 1/ω²") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request = request_of({0.01}, {.modes = 3, .damping = {0.01, 0.02, 0.03}});
  request.named_points = {{"corner", 0, 1.0, 1.0}, {"middle", 1, 0.5, 0.5}};
  const StrokeResponse response = evaluated(m, models::full(Flexure::plate, {6, 2}), request);
  const StateSpace& model = *response.path[0].state_space;
  CHECK(model.damping == Vector3d(0.01, 0.02, 0.03));
  CHECK(model.outputs.size() == 6 + 1 + 2 * 3);
  const LeafSpring& leaf = m.leaves[0];
  const Vector3d undeflected = leaf.tip_middle() + 0.5 * leaf.width * leaf.axes.col(1) -
                               m.bodies[0].reference,
                 turn = response.path[0].rotation;
  const Vector3d arm =
      (turn.norm() > 0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()) * undeflected
                       : undeflected);
  for (const double f : {0.0, 40.0}) {
    const Eigen::MatrixXcd H = frequency_response(model, f);
    const int corner = output(model, "point.corner.x");
    for (Eigen::Index k = 0; k < H.cols(); ++k) {
      const Eigen::Vector3cd u = H.block<3, 1>(0, k), w = H.block<3, 1>(3, k);
      const Eigen::Vector3cd expected = u - hat(arm).cast<Complex>() * w;
      CHECK((H.block<3, 1>(corner, k) - expected).norm() <= 1e-8 * (u.norm() + 0.1 * w.norm()));
    }
  }
  // beside a point of a drive nothing else moves as fast: one mass alone
  m.bodies[0].held = {true, false, true, true, true, true};
  for (LeafSpring& l : m.leaves) l.material.density = 1e-9;
  request.named_points.clear();
  request.state_space->damping = {0.01};
  request.state_space->modes = 1;
  const PathPoint held = evaluate_stroke(m, models::full(Flexure::beam, {6, 1}), request).path[0];
  REQUIRE(held.state_space);
  const double omega2 = held.state_space->omega2[0];
  CHECK(omega2 == Approx(held.drive_stiffness / m.bodies[0].mass).epsilon(1e-6));
  const MatrixXd still = frequency_response(*held.state_space, 0).real();
  CHECK(still(1, input(*held.state_space, "ground.uy")) == Approx(-1 / omega2).epsilon(1e-6));
}

TEST_CASE("points as they are modelled have the model of their full leaves") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request = request_of({0.01, 0.02}, {.modes = 4, .damping = {0.02}, .points = {1}});
  request.dynamics = {0.02, {}};
  ModelOptions model{.mesh = {6, 2}};
  const StrokeResponse exact = evaluate_stroke(m, model, request);
  request.values = PathValues::as_modelled;
  const StrokeResponse reduced = evaluated(m, model, request);
  CHECK_FALSE(reduced.path[0].state_space);
  REQUIRE(reduced.path[1].state_space);
  CHECK((reduced.path[1].state_space->omega2 - exact.path[1].state_space->omega2).norm() <=
        1e-8 * exact.path[1].state_space->omega2.norm());
  for (std::size_t k = 0; k < 2; ++k) {
    const std::optional<double> found = reduced.path[k].bandwidths.at(0),
                                wanted = exact.path[k].bandwidths.at(0);
    REQUIRE(found.has_value() == wanted.has_value());
    CHECK(wanted.has_value() == (k == 1));  // before, no mode moves enough with the drive
    if (wanted) CHECK(*found == Approx(*wanted).epsilon(1e-7));
  }
}
