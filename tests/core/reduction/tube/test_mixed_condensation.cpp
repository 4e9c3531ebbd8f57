#include "core/reduction/tube/mixed_condensation.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "support/moved.hpp"
#include "support/synthetic_leaf.hpp"

using namespace flexopt;
using namespace flexopt::synthetic;

namespace {

const EdgePoses undeflected{
    {{Vector3d::Zero(), Matrix3d::Identity()}, {Vector3d(length, 0, 0), Matrix3d::Identity()}}};

/// Deformations of a bent leaf with moderate forces: the stiff ones near what the bend asks for.
Vector6d bent(Random& random) {
  const double th1 = random(0.25), th2 = random(0.25);
  Vector6d e;
  e << -length * (th1 * th1 - 0.5 * th1 * th2 + th2 * th2) / 15 * (1 + random(0.02)), th1,
      random(0.002), th2, random(0.002), random(0.02);
  return e;
}

/// Newton's method for R = 0 at fixed e; whether it converged.
bool relax(const TubePotential& t, const Vector6d& e, MixedState& state) {
  for (int step = 0; step < 20; ++step) {
    condense(t, e, state);
    const Vector3d off = state.F_inverse * state.R;
    if (off.cwiseAbs().maxCoeff() <= 1e-12 * std::max(1.0, state.f.cwiseAbs().maxCoeff()))
      return true;
    state.f -= off;
  }
  return false;
}

MixedEnergy relaxed(const TubePotential& t, const Vector6d& e, MixedState state = {}) {
  REQUIRE(relax(t, e, state));
  return condense(t, e, state);
}

/// A bent leaf whose forces are relaxed.
struct Relaxed {
  Vector6d e;
  MixedState state;
  MixedEnergy energy;

  Relaxed(const TubePotential& tube, Random& random) : e(bent(random)) {
    REQUIRE(relax(tube, e, state));
    energy = condense(tube, e, state);
  }
};

/// Sizes of deformations that count alike.
const Vector6d sizes = (Vector6d() << 1e-4, 0.1, 1e-2, 0.1, 1e-2, 0.1).finished();

/// The leaf bent by 0.2 rad at both ends (S shape), forces relaxed.
struct BentLeaf {
  TubePotential tube = synthetic::tube(s_ray());
  EdgePoses edges = undeflected;
  ReducedState state;
  ReducedResponse response;

  BentLeaf() {
    edges[1].position += Vector3d(-0.0012, 1e-5, 0.02);
    edges[1].axes = rotation_exp(Vector3d(0.01, -0.03, 2e-4)) * edges[1].axes;
    relax_forces();
  }
  void relax_forces() {
    REQUIRE(evaluate_reduced_leaf(tube, length, edges, state, response));
    REQUIRE(relax(tube, response.frame.e, state.mixed));
    REQUIRE(evaluate_reduced_leaf(tube, length, edges, state, response));
  }
};

struct NewtonRun {
  std::vector<double> residual;  ///< of the free tip, lengths scaled
  EdgePoses edges;
  ReducedState state;
  bool converged = false;
};

/// Base clamped; the tip's directions `held` move by `by` in the first step, the others are free
/// under the dead tip load. Mixed Newton: forces follow the linearised increment.
NewtonRun solve(const TubePotential& tube, const std::vector<int>& held, const Vector6d& by,
                const Vector6d& load) {
  NewtonRun run{{}, undeflected, {}, false};
  ReducedState& state = run.state;
  ReducedResponse r;
  Vector6d unit;  // N or N m
  unit << Vector3d::Constant(1 / length), Vector3d::Ones();
  std::vector<bool> is_held(6, false);
  for (int k : held) is_held[k] = true;
  for (int step = 0; step < 20; ++step) {
    if (!evaluate_reduced_leaf(tube, length, run.edges, state, r)) return run;
    Vector6d g = r.force.tail<6>() - load;
    Matrix6d K = r.tangent.bottomRightCorner<6, 6>();
    Vector6d imposed = Vector6d::Zero();
    for (int k = 0; k < 6; ++k)
      if (is_held[k] && step == 0) imposed[k] = by[k];
    g += K * imposed;
    for (int k = 0; k < 6; ++k)
      if (is_held[k]) {
        K.row(k).setZero();
        K.col(k).setZero();
        K(k, k) = 1;
        g[k] = -imposed[k];
      }
    Vector12d dq = Vector12d::Zero();
    dq.tail<6>() = -K.partialPivLu().solve(g);
    for (int k = 0; k < 6; ++k)
      if (is_held[k]) g[k] = 0;
    if (step > 0) run.residual.push_back(g.cwiseQuotient(unit).norm());
    if (step > 0 && run.residual.back() < 1e-11) {
      run.converged = true;
      return run;
    }
    follow(state, dq);
    run.edges = moved(run.edges, dq);
  }
  return run;
}

}  // namespace

TEST_CASE("condensed gradient and Hessian are derivatives of the condensed energy") {
  Random random(21);
  const TubePotential t = tube(skew_ray());
  for (int n = 0; n < 10; ++n) {
    const Relaxed leaf(t, random);
    const Vector6d d = random.vector<6>().cwiseProduct(sizes);
    const MixedEnergy& m = leaf.energy;
    CHECK(m.gap.norm() < 1e-12);
    const auto first = [&](double h) {
      return std::abs(relaxed(t, leaf.e + h * d, leaf.state).energy - m.energy -
                      h * m.gradient.dot(d));
    };
    const auto second = [&](double h) {
      const Vector6d r =
          relaxed(t, leaf.e + h * d, leaf.state).gradient - m.gradient - h * m.hessian * d;
      return r.cwiseProduct(sizes).norm();
    };
    REQUIRE(m.gradient.norm() > 1e-3);
    CHECK(rate(first(1e-1), first(1e-2)) == Approx(2).margin(0.1));
    CHECK(rate(second(1e-1), second(1e-2)) == Approx(2).margin(0.15));
    CHECK(m.hessian == m.hessian.transpose());
  }
}

TEST_CASE("the conjugate forces are the derivatives by the stiff deformations") {
  Random random(22);
  const TubePotential t = tube(c_ray());
  const Relaxed leaf(t, random);
  const MixedEnergy& m = leaf.energy;
  const Vector3d& f = leaf.state.f;
  REQUIRE(f.norm() > 1e-3);
  CHECK(m.gradient[elongation] == Approx(force_scale[0] * f[0]).epsilon(1e-10));
  CHECK(m.gradient[theta1z] == Approx(force_scale[1] * f[1]).epsilon(1e-10));
  CHECK(m.gradient[theta2z] == Approx(force_scale[2] * f[2]).epsilon(1e-10));
}

TEST_CASE("energy and gradient are right to first order in the residual") {
  Random random(23);
  const TubePotential t = tube(s_ray());
  const Relaxed leaf(t, random);
  const MixedEnergy& m = leaf.energy;
  const Vector3d d = random.vector<3>();
  const auto off = [&](double h) {
    MixedState s = leaf.state;
    s.f += h * d;
    return condense(t, leaf.e, s);
  };
  REQUIRE(off(1e-1).gap.norm() > 1e-6);
  CHECK(rate((off(1e-1).gradient - m.gradient).norm(), (off(1e-2).gradient - m.gradient).norm()) ==
        Approx(2).margin(0.1));
  CHECK(rate(std::abs(off(1e-1).energy - m.energy), std::abs(off(1e-2).energy - m.energy)) ==
        Approx(3).margin(0.2));
}

TEST_CASE("following an increment leaves a second-order gap") {
  Random random(24);
  const TubePotential t = tube(s_ray());
  const Relaxed leaf(t, random);
  const Vector6d d = random.vector<6>().cwiseProduct(sizes);
  const auto gap = [&](double h) {
    MixedState s = leaf.state;
    follow(s, h * d);
    return condense(t, leaf.e + h * d, s).gap.norm();
  };
  CHECK(rate(gap(1e-1), gap(1e-2)) == Approx(2).margin(0.1));

  // two half increments are one, an increment of zero is none
  MixedState once = leaf.state, twice = leaf.state;
  follow(once, d);
  follow(twice, 0.5 * d);
  follow(twice, 0.5 * d);
  CHECK((once.f - twice.f).norm() < 1e-12 * once.f.norm());
  // and nothing moves before the first evaluation
  MixedState fresh;
  follow(fresh, d);
  CHECK(fresh.f.norm() == 0);
}

TEST_CASE("the undeflected reduced leaf has the stiffness of its potential") {
  // beam in the plane of bending: 4, 2 EI/L for the end rotations
  const TubePotential t = tube(s_ray());
  ReducedState state;
  ReducedResponse r;
  REQUIRE(evaluate_reduced_leaf(t, length, undeflected, state, r));
  CHECK(r.force.norm() == 0);
  CHECK(r.mixed.energy == 0);
  CHECK(r.tangent(10, 10) == Approx(4 * EI_over_L));
  CHECK(r.tangent(4, 10) == Approx(2 * EI_over_L));
  CHECK(r.tangent(8, 8) == Approx(12 * EI_over_L / (length * length)));
  CHECK(r.tangent(9, 9) == Approx(0.8 * EI_over_L));
  CHECK(r.tangent(6, 6) == Approx(force_scale[0] * force_scale[0] / (2 * 0.0008 * EI_over_L)));
  CHECK(r.tangent(2, 8) == Approx(-r.tangent(8, 8)));
}

TEST_CASE("a rigid motion leaves energy, force and tangent alone") {
  Random random(25);
  BentLeaf leaf;
  REQUIRE(leaf.response.force.norm() > 1e-2);
  double worst = 0;
  for (int n = 0; n < 100; ++n) {
    const Matrix3d Q = rotation_exp(random.vector<3>(1.8));
    const Vector3d shift = random.vector<3>();
    EdgePoses y = leaf.edges;
    for (auto& edge : y) {
      edge.position = Q * edge.position + shift;
      edge.axes = Q * edge.axes;
    }
    Matrix12d Q4 = Matrix12d::Zero();
    for (int k = 0; k < 12; k += 3) Q4.block<3, 3>(k, k) = Q;
    ReducedState state = leaf.state;
    ReducedResponse r;
    REQUIRE(evaluate_reduced_leaf(leaf.tube, length, y, state, r));
    worst = std::max(
        {worst, std::abs(r.mixed.energy / leaf.response.mixed.energy - 1),
         (r.force - Q4 * leaf.response.force).norm() / r.force.norm(),
         (r.tangent - Q4 * leaf.response.tangent * Q4.transpose()).norm() / r.tangent.norm()});
  }
  CHECK(worst < 1e-10);
}

TEST_CASE("force and tangent are first and second derivative of the leaf's energy") {
  Random random(26);
  BentLeaf leaf;
  const Vector12d f = leaf.response.force;
  const Matrix12d K = leaf.response.tangent;
  CHECK(K == K.transpose());
  for (int n = 0; n < 5; ++n) {
    Vector12d dq = random.vector<12>();
    for (int k : {0, 6}) dq.segment<3>(k) *= length;
    dq *= 1e-2;
    const auto energy = [&](double h) {
      BentLeaf other = leaf;
      other.edges = moved(leaf.edges, h * dq);
      other.relax_forces();
      return other.response.mixed.energy;
    };
    const double E = energy(0);
    const auto first = [&](double h) { return std::abs(energy(h) - E - h * f.dot(dq)); };
    const auto second = [&](double h) {
      return std::abs(energy(h) - E - h * f.dot(dq) - 0.5 * h * h * dq.dot(K * dq));
    };
    CHECK(rate(first(1e-1), first(1e-2)) == Approx(2).margin(0.1));
    CHECK(rate(second(1e-1), second(1e-2)) == Approx(3).margin(0.2));
  }
}

TEST_CASE("mixed Newton converges quadratically") {
  // Dead forces only: a dead moment on a free rotation has no potential, and the symmetric tangent
  // misses its commutator −½ hat(M).
  const TubePotential t = tube(s_ray(), {0, 0.1, 0.3, 0.6});
  Vector6d load;
  load << 3.0, 0.5, 4.0, 0, 0, 0;
  const NewtonRun run = solve(t, {}, Vector6d::Zero(), load);
  REQUIRE(run.converged);
  CAPTURE(run.residual);
  CHECK(run.residual.size() <= 8);

  // Off the solution by h, forces following to first order: one step leaves h².
  Vector12d off = Vector12d::Zero();
  off.tail<6>() << 1e-4, 0.01, 0.01, 0.2, 0.1, 0.05;
  const auto left_over = [&](double h) {
    ReducedState state = run.state;
    ReducedResponse r;
    follow(state, h * off);
    EdgePoses edges = moved(run.edges, h * off);
    REQUIRE(evaluate_reduced_leaf(t, length, edges, state, r));
    Vector12d dq = Vector12d::Zero();
    dq.tail<6>() =
        -r.tangent.bottomRightCorner<6, 6>().partialPivLu().solve(r.force.tail<6>() - load);
    follow(state, dq);
    edges = moved(edges, dq);
    REQUIRE(evaluate_reduced_leaf(t, length, edges, state, r));
    return (r.force.tail<6>() - load).norm();
  };
  CHECK(rate(left_over(0.01), left_over(0.001)) == Approx(2).margin(0.15));
}

TEST_CASE("one step to a large stroke converges, both ways") {
  const TubePotential guided = tube(s_ray(), {0, 0.1, 0.35});
  const TubePotential rotated = tube(c_ray(), {0, 0.1, 0.45});
  for (double sign : {1.0, -1.0}) {
    Vector6d by = Vector6d::Zero();
    by[2] = sign * 0.3 * length;
    const NewtonRun a = solve(guided, {2, 3, 4, 5}, by, Vector6d::Zero());
    CHECK(a.converged);
    CHECK(a.residual.size() <= 8);
    CHECK(a.edges[1].position[2] == Approx(by[2]).epsilon(1e-9));
    CHECK(a.edges[1].position[0] < 0.97 * length);

    by.setZero();
    by[4] = sign * M_PI / 4;
    const NewtonRun b = solve(rotated, {4}, by, Vector6d::Zero());
    CHECK(b.converged);
    CHECK(b.residual.size() <= 10);
    CHECK(rotation_log(b.edges[1].axes)[1] == Approx(by[4]).epsilon(1e-9));
  }
}
