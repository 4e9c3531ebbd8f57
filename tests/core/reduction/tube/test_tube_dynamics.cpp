// The tables of a tube leaf's internal dynamics: their expansion against exact states, the laws of
// mass, and the frequencies of mechanisms against full leaves.
#include "core/math/decompositions.hpp"
#include "core/reduction/atlas/expanded_leaf.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "support/monomials.hpp"
#include "support/strokes.hpp"
#include "support/synthetic_leaf.hpp"

using namespace flexopt;

namespace {
constexpr int P = TubeDynamics::amplitudes;

std::shared_ptr<TubeModel> tabulated_tube(const PlateShape& shape) {
  auto model = std::make_shared<TubeModel>(std::make_shared<PlateMesh>(shape), TubeRange{});
  model->make_dynamics();
  return model;
}

const PlateShape flat{0.3, 0.005, 0.3, {6, 2}, true};

// Squares of the lowest internal frequencies, edges held.
VectorXd held(const TubeDynamics::Answer& answer) {
  return SymmetricEigen(answer.stiffness, answer.mass.bottomRightCorner<P, P>())
      .eigenvalues()
      .head(4);
}

StrokeRequest sweep(double end, int points, int frequencies) {
  return {.points = models::evenly(end, points),
          .outputs = {Output::equilibrium, Output::frequencies_free, Output::frequencies_locked},
          .frequencies = frequencies};
}

}  // namespace

TEST_CASE("the internal loads of narrow and of wide leaves are independent on every mesh") {
  // with loads that are nearly the same, the tables depend on how their numbers were rounded
  for (const std::array<int, 2>& mesh :
       std::initializer_list<std::array<int, 2>>{{4, 2}, {6, 2}, {8, 4}})
    for (const double width : {0.03, 0.1, 0.5, 2.0}) {
      INFO(mesh[0] << " x " << mesh[1] << " elements, w/L " << width);
      const auto numbers = [&](double w) {
        return bent_states({w, 0.005, 0.3, mesh, true}, {1, -1}, ray_directions(-1), {0.0},
                           {.dynamics = true})
            .dynamics.front();
      };
      const PlateShape shape{width, 0.005, 0.3, mesh, true};
      const auto plate = std::make_shared<PlateMesh>(shape);
      ChordLeaf leaf(plate);
      REQUIRE(leaf.solve(Vector3d::Zero(), Vector3d::Zero()).converged);
      const MatrixXd k = expand_dynamics(leaf, ray_directions(-1), internal_loads(*plate)).k[0];
      const VectorXd unit = k.diagonal().cwiseSqrt().cwiseInverse();
      CHECK(symmetric_eigenvalues(unit.asDiagonal() * k * unit.asDiagonal()).minCoeff() > 0.7);
      // a width of 1e-10 more changes no number by anything that counts
      const DynamicsNode a = numbers(width), b = numbers(width * (1 + 1e-10)),
                         weights = TubeDynamics::weights(a, shape, 0.05);
      for (MatrixXd StateTable::*part : {&StateTable::even, &StateTable::odd})
        CHECK((a.table.*part - b.table.*part)
                  .cwiseProduct(weights.table.*part)
                  .cwiseAbs()
                  .maxCoeff() < 1e-6);
    }
}

TEST_CASE("the expansion of the dynamics is that of exact states to second order") {
  const auto mesh = std::make_shared<PlateMesh>(flat);
  const Eigen::Matrix2d ray = synthetic::s_ray();
  ChordLeaf leaf(mesh);
  const InternalLoads loads = internal_loads(*mesh);
  const Vector3d scale = tube_force_scale(flat);
  REQUIRE(leaf.solve({0.1, 0.1, 0}, Vector3d::Zero()).converged);
  const ChordLeaf node = leaf;
  const DynamicsExpansion e = expand_dynamics(leaf, ray, loads);
  double rest[2][6];
  for (int n = 0; n < 2; ++n) {
    Vector6d x;
    x << 0.01, 0.01, 0.004, 1, 0.5, -0.3;
    x /= 1 << n;
    leaf = node;
    for (int again = 0; again < 2; ++again)
      REQUIRE(
          leaf.solve({0.1 + x[0] + x[1], 0.1 + x[0] - x[1], x[2]}, scale.cwiseProduct(x.tail<3>()))
              .converged);
    const DynamicsExpansion exact = expand_dynamics(leaf, ray, loads);
    const MatrixPolynomial DynamicsExpansion::*parts[] = {
        &DynamicsExpansion::k, &DynamicsExpansion::G,    &DynamicsExpansion::g,
        &DynamicsExpansion::F, &DynamicsExpansion::mass, &DynamicsExpansion::stations};
    for (int p = 0; p < 6; ++p)
      rest[n][p] =
          ((exact.*parts[p])[0] - test::polynomial_value(e.*parts[p], {x.data(), 6})).norm();
  }
  for (int p = 0; p < 6; ++p) {
    INFO("part " << p);
    CHECK(std::log2(rest[0][p] / rest[1][p]) > 2.7);
  }
}

TEST_CASE("a tabulated leaf that moves as a rigid body has its whole mass") {
  const auto model = tabulated_tube(flat);
  REQUIRE(model->dynamics());
  for (const double sigma : {0.0, 0.12, -0.25}) {
    const TubeDynamics::Answer a =
        model->dynamics()->evaluate({sigma, 0.01, 0.002, {0.4, 0.1, -0.2}});
    REQUIRE(a.reason.empty());
    const Matrix3d slide = a.mass.topLeftCorner<3, 3>();
    CHECK((slide - flat.width * Matrix3d::Identity()).norm() < 1e-9 * flat.width);
    CHECK((a.mass - a.mass.transpose()).norm() < 1e-12 * a.mass.norm());
    CHECK(SymmetricEigen(a.stiffness).eigenvalues().minCoeff() > 0);
    CHECK(SymmetricEigen(a.mass.bottomRightCorner<P, P>()).eigenvalues().minCoeff() > 0);
  }
}

TEST_CASE("a tabulated leaf vibrates as its mirror images do") {
  const auto model = tabulated_tube(flat);
  REQUIRE(model->dynamics());
  const TubeDynamics& tables = *model->dynamics();
  const VectorXd here = held(tables.evaluate({0.17, 0.01, 0.003, {0.6, 0.3, -0.2}}));
  REQUIRE(here.minCoeff() > 0);
  for (const TubeDynamics::Place& image :
       {TubeDynamics::Place{-0.17, -0.01, -0.003, {0.6, 0.3, -0.2}},   // of the thickness
        TubeDynamics::Place{0.17, 0.01, -0.003, {0.6, -0.3, 0.2}}}) {  // across the width
    const VectorXd there = held(tables.evaluate(image));
    CHECK((there - here).cwiseQuotient(here).cwiseAbs().maxCoeff() < 1e-9);
  }
  const VectorXd other = held(tables.evaluate({0.17, 0.01, 0.003, {-0.6, 0.3, -0.2}}));
  CHECK((other - here).cwiseQuotient(here).cwiseAbs().maxCoeff() > 1e-3);
}

TEST_CASE("frequencies from tables are those of full leaves, both ways") {
  const double end = GENERATE(1.0, -1.0) * M_PI / 6;
  Mechanism hinge = models::hinge(0.1, 3.5e-4, {{1, 0.0125, 0.02}, {-1, -0.0125, 0.02}});
  hinge.bodies[0] = models::body({0, 0, 0}, 0.01, 1e-6);
  const StrokeRequest request = sweep(end, 41, 6);
  const StrokeResponse found = test::evaluated(hinge, {}, request);
  for (std::size_t k = 1; k < found.path.size(); ++k)  // rest belongs to the other side
    for (const LeafReport& leaf : found.path[k].leaves) {
      CHECK(leaf.reason.empty());
      CHECK(leaf.check == 0);  // nothing was condensed
    }
  StrokeRequest some = request;
  some.points = {request.points[0], request.points[10], request.points[25], request.points[40]};
  StrokeResponse at_some = found;
  at_some.path = {found.path[0], found.path[10], found.path[25], found.path[40]};
  CHECK(test::frequency_error(at_some,
                              test::evaluated(hinge, test::full({.leaf_modes = 12}), some)) < 2e-3);
}

TEST_CASE("tables are made where they pay, and leaves beyond them are condensed and say so") {
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4, 0.1, 1.0);
  const StrokeResponse few = evaluate_stroke(guide, {}, sweep(0.01, 3, 4));
  for (const PathPoint& p : few.path)
    for (const LeafReport& leaf : p.leaves) {
      CHECK(leaf.reason.empty());
      CHECK(leaf.check > 0);  // condensed
    }
  // frequencies far above the internal motions that the tables hold
  Mechanism light = guide;
  light.bodies[0] = models::body({0.1, 0, 0}, 0.01, 1e-6);
  const StrokeResponse many = test::evaluated(light, {}, sweep(0.01, 41, 20));
  for (const LeafReport& leaf : many.path.back().leaves)
    CHECK_THAT(leaf.reason, Catch::Contains("more internal modes than the tables have"));
}

TEST_CASE("leaves with a profile, curved ones, beams and very wide ones have no tables") {
  const auto change = GENERATE(
      as<void (*)(PlateShape&)>(),
      [](PlateShape& s) {
        s.thickness_profile = {1, 0.8};
      },
      [](PlateShape& s) { s.curve = 0.3; },
      [](PlateShape& s) { s.mesh[1] = 1, s.flexure = Flexure::beam; },
      [](PlateShape& s) { s.thickness = s.width * s.width / 1300; });
  PlateShape shape = flat;
  change(shape);
  const auto model = tabulated_tube(shape);
  CHECK(!model->dynamics());
  if (shape.thickness == flat.thickness) CHECK(!model->stress());  // wide ones may have these
}

TEST_CASE("tables grow with their tube") {
  TubeModel model(std::make_shared<PlateMesh>(flat), {.sigma_max = 0.05});
  REQUIRE(model.built());
  model.make_dynamics();
  REQUIRE(model.dynamics());
  REQUIRE(model.stress());
  REQUIRE(model.extend(0.2));
  CHECK(model.potential().last_sigma() == Approx(0.2));
  // at a bent state the tables are its own expansion, whatever its neighbours
  const TubeDynamics::Answer grown = model.dynamics()->evaluate({0.2, 0, 0, Vector3d::Zero()});
  REQUIRE(grown.reason.empty());
  TubeModel whole(std::make_shared<PlateMesh>(flat), {.sigma_max = 0.2});
  whole.make_dynamics();
  const VectorXd a = held(grown),
                 b = held(whole.dynamics()->evaluate({0.2, 0, 0, Vector3d::Zero()}));
  CHECK((a - b).cwiseQuotient(b).cwiseAbs().maxCoeff() < 1e-6);
  const auto strains = [](TubeModel& of) {
    return of.stress()->evaluate({0.2, 0, 0, Vector3d::Zero()}).strains.at(0.1, 0.05);
  };
  CHECK((strains(model) - strains(whole)).norm() < 1e-6 * strains(whole).norm());
}
