// The tube leaf against the full leaf on the same mesh, and the switches at its limits.
#include "core/reduction/tube/tube_leaf.hpp"
#include "support/monomials.hpp"
#include "support/strokes.hpp"
#include "support/synthetic_leaf.hpp"

using namespace flexopt;

namespace {

struct Errors {
  double drive = 0, motion = 0, support = 0, frequency = 0, stress = 0;
};

// Worst relative differences over the path.
Errors compare(const Mechanism& mechanism, const StrokeRequest& request,
               const ModelOptions& model = {}) {
  const StrokeResponse full = test::evaluated(mechanism, test::full(model), request),
                       reduced = test::evaluated(mechanism, model, request);
  Errors worst;
  worst.frequency = test::frequency_error(reduced, full);
  double motion = 0;
  for (const PathPoint& p : full.path)
    motion = std::max(
        motion,
        (p.displacement - p.displacement.dot(Vector3d::UnitY()) * Vector3d::UnitY()).norm());
  for (std::size_t k = 0; k < full.path.size(); ++k) {
    const PathPoint &a = full.path[k], &b = reduced.path[k];
    if (a.stroke != 0) {
      worst.drive = std::max(worst.drive, std::abs(b.drive_load / a.drive_load - 1));
      worst.stress =
          std::max(worst.stress, std::abs(b.max_stress->value / a.max_stress->value - 1));
    }
    worst.motion = std::max(worst.motion, (a.displacement - b.displacement).norm() / motion);
    worst.support = std::max(worst.support, test::support_error(b, a));
  }
  return worst;
}

StrokeRequest to(double end, int points, int frequencies = 6) {
  return {.points = models::evenly(end, points), .frequencies = frequencies};
}

void check_expansion(const PlateShape& shape) {
  const auto mesh = std::make_shared<PlateMesh>(shape);
  const Eigen::Matrix2d ray = synthetic::s_ray();
  const Vector3d scale = tube_force_scale(mesh->shape());
  for (const int order : {2, 3}) {
    ChordLeaf leaf(mesh);
    REQUIRE(leaf.solve({0.1, 0.1, 0}, Vector3d::Zero()).converged);
    const ChordLeaf node = leaf;
    const TubeExpansion e = expand(leaf, 0.1, ray, order);
    const MonomialTable& table = order == 2 ? monomials<6, 5>() : monomials<6, 7>();
    REQUIRE(static_cast<int>(e.W.size()) == table.size());
    CHECK(e.W[0] == Approx(node.potential()).epsilon(1e-9));
    double rest[2];
    for (int k = 0; k < 2; ++k) {
      const double h = 1.0 / (1 << k);
      // even powers of (φ, M1, M2) only, as the potential uses them: a state mirrored in the width
      // has the same potential, so the mean of both is compared
      const double x[6] = {0.05 * h, 0.02 * h, 0, 6 * h, 0, 0};
      leaf = node;
      REQUIRE(
          leaf.solve({0.1 + x[0] + x[1], 0.1 + x[0] - x[1], 0}, {scale[0] * x[3], 0, 0}).converged);
      rest[k] = std::abs(test::polynomial_value(table, e.W, x) - leaf.potential());
    }
    REQUIRE(rest[0] > 1e-10);
    CHECK(std::log2(rest[0] / rest[1]) > 2 * order + 1.3);
  }
}

struct Size {
  double length, width, thickness;  ///< [mm]
};

/// Returns the errors, of which the stress is left to check.
Errors check_agreement(const Mechanism& mechanism, const StrokeRequest& request, const Size& l) {
  const Errors e = compare(mechanism, request);
  INFO("w²/(Lt) = " << l.width * l.width / l.length / l.thickness);
  CHECK(e.drive < 1e-4);
  CHECK(e.motion < 1e-4);
  CHECK(e.support < 3e-3);
  CHECK(e.frequency < 3e-3);
  return e;
}

}  // namespace

TEST_CASE("an expansion reproduces the potential about a bent state to degree five and seven") {
  check_expansion({0.3, 0.005, 0.3, {6, 2}, true});
}

TEST_CASE("so does the expansion of a curved leaf") {
  PlateShape shape{0.3, 0.005, 0.3, {6, 2}, true};
  shape.curve = 0.5;
  check_expansion(shape);
  shape.width_profile = {1, 0.7};
  check_expansion(shape);
  shape = {0.1, 0.005, 0.3, {6, 1}, true};
  shape.flexure = Flexure::beam;
  shape.curve = -0.8;
  check_expansion(shape);
}

TEST_CASE("where its elements stand adds nothing to the potential of a leaf") {
  // places of the size of the leaf in the forms of bending would be rounded to 3e-12
  const auto mesh = std::make_shared<PlateMesh>(PlateShape{0.375, 0.0044, 0.3, {12, 5}, true});
  ChordLeaf leaf(mesh);
  REQUIRE(leaf.solve(Vector3d::Zero(), Vector3d::Zero()).converged);
  CHECK(std::abs(expand(leaf, 0, synthetic::s_ray(), 2).W[0]) < 5e-13);
}

TEST_CASE("a rebuilt field is the full leaf's to second order in the transverse state") {
  const auto mesh = std::make_shared<PlateMesh>(PlateShape{0.3, 0.005, 0.3, {8, 4}, true});
  TubeModel model(mesh, {.sigma_max = 0.3});
  REQUIRE(model.built());
  const Vector3d scale = tube_force_scale(mesh->shape());
  ChordLeaf leaf(mesh);
  for (const double side : {1.0, -1.0}) {
    leaf = ChordLeaf(mesh);
    const Vector3d s(0.2 * side, 0.2 * side, 0), f(0.3, 0, 0);
    REQUIRE(leaf.solve(s, scale.cwiseProduct(f)).converged);
    CHECK((model.fields(s, f) - leaf.unknowns()).cwiseAbs().maxCoeff() < 2e-4);
  }
}

TEST_CASE("a tube about moments is the leaf under them") {
  const auto mesh = std::make_shared<PlateMesh>(PlateShape{0.3, 0.005, 0.3, {8, 4}, true});
  const Vector3d scale = tube_force_scale(mesh->shape());
  TubeRange range{
      .ray = {1, -1}, .sigma_max = 0.3, .force_centre = -6, .moment_centre = {1.5, -0.7}};
  for (const int order : {2, 3}) {
    range.order = order;
    TubeModel model(mesh, range);
    REQUIRE(model.built());
    for (const double side : {1.0, -1.0}) {
      ChordLeaf leaf(mesh);
      const Vector3d s(0.17 * side, -0.16 * side, 0.004), f(-6.4, 1.6, -0.6);
      REQUIRE(leaf.solve(s, scale.cwiseProduct(f)).converged);
      const PotentialValue p = model.potential().evaluate(s, f);
      CHECK(p.value == Approx(leaf.potential()).epsilon(1e-5));
      const Vector3d stiff = -p.gradient.tail<3>().cwiseQuotient(scale);
      CHECK((stiff - leaf.stiff()).norm() < 1e-3 * leaf.stiff().norm());
      CHECK((model.fields(s, f) - leaf.unknowns()).cwiseAbs().maxCoeff() < 2e-4);
    }
  }
}

TEST_CASE("reduced guides agree with full ones from slender to very wide leaves", "[slow]") {
  // w²/(L t) = 2, 18, 45, 67, 120, 240
  const Size l = GENERATE(Size{100, 10, .5}, Size{100, 30, .5}, Size{100, 30, .2}, Size{60, 40, .4},
                          Size{60, 60, .5}, Size{60, 60, .25});
  const Errors e =
      check_agreement(models::guide(l.length * 1e-3, l.width * 1e-3, l.thickness * 1e-3, 1.0),
                      to(0.3e-3 * l.length, 7), l);
  CHECK(e.stress < 1e-2);
}

TEST_CASE("reduced hinges agree with full ones to 45 degrees, both ways", "[slow]") {
  const double sign = GENERATE(1.0, -1.0);
  const Size l =
      GENERATE(Size{100, 10, .5}, Size{100, 30, .5}, Size{60, 40, .4}, Size{60, 60, .25});
  check_agreement(models::three_leaf_hinge(l.length * 1e-3, l.width * 1e-3, l.thickness * 1e-3),
                  to(sign * M_PI / 4, 6), l);
}

TEST_CASE("a leaf that leaves the box is replaced, and the result says so") {
  // A guide driven sideways by a heavy payload twists and loads its leaves far off the ray.
  const Mechanism m = models::three_leaf_hinge(0.06, 0.04, 4e-4);
  StrokeRequest request = to(30 * M_PI / 180, 4, 4);
  // half of the load at which a pinned pair of leaves would buckle, against the leaves
  const double EI = 200e9 * 0.04 * std::pow(4e-4, 3) / 12 / 0.91;
  request.loads.constant = {{.force = {0, 0.5 * 4 * M_PI * M_PI * EI / (0.06 * 0.06), 0}}};
  const Errors e = compare(m, request);
  CHECK(e.drive < 1e-2);
  CHECK(e.support < 1e-2);
  CHECK(e.frequency < 1e-2);

  StrokeRequest sideways = to(0.005, 2, 0);
  sideways.loads.constant = {{.moment = {2, 0, 1}}};
  const StrokeResponse r =
      test::evaluated(models::single_leaf(0.1, 0.03, 5e-4), ModelOptions{}, sideways);
  CHECK(r.path[1].leaves[0].model == "full");
  CHECK(!r.path[1].leaves[0].reason.empty());
}
