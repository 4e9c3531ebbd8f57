// Options of the dynamics: mass that follows the deflection or not, with and without internal
// shapes of the leaves.
#include <Eigen/Eigenvalues>

#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/response.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

struct Case {
  const char* name;
  Mechanism mechanism;
  double largest;
};

// A light end-effector: leaf modes among the first.
std::vector<Case> light() {
  Mechanism cross = models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.02}}, 0.01, 6e-7);
  Mechanism three = models::three_leaf_hinge(0.1, 0.04, 3.5e-4);
  three.bodies[0] = models::body({0, 0, 0}, 0.01, 6e-7);
  return {{"guide", models::guide(0.1, 0.03, 5e-4, 0.06, 0.01, 6e-7), 0.02},
          {"cross hinge", cross, M_PI / 6},
          {"three-flexure hinge", three, M_PI / 6}};
}

StrokeResponse path(const Case& c, const ModelOptions& model) {
  StrokeRequest request{.points = {0, 0.5 * c.largest, c.largest}, .frequencies = 6};
  request.outputs.remove(Output::frequency_derivatives);
  request.outputs.remove(Output::stress);
  StrokeResponse r = test::evaluated(c.mechanism, model, request);
  return r;
}

double worst(const PathPoint& a, const PathPoint& b) {
  double e = 0;
  REQUIRE(a.frequencies_free.size() == b.frequencies_free.size());
  for (std::size_t i = 0; i < b.frequencies_free.size(); ++i)
    e = std::max({e, std::abs(a.frequencies_free[i] / b.frequencies_free[i] - 1),
                  std::abs(a.frequencies_locked[i] / b.frequencies_locked[i] - 1)});
  return e;
}

}  // namespace

TEST_CASE("frequencies of the default model are within 0.3 % of full order, leaf modes too") {
  for (const Case& c : light()) {
    INFO(c.name);
    const StrokeResponse truth = path(c, {.accuracy = Accuracy::full, .leaf_modes = 40});
    const StrokeResponse found = path(c, {});
    for (std::size_t k = 0; k < found.path.size(); ++k) {
      INFO("point " << k);
      CHECK(worst(found.path[k], truth.path[k]) < 3e-3);
    }
  }
}

TEST_CASE("where nothing moves with the drive held there are no frequencies of that list") {
  Mechanism guide = models::guide(0.1, 0.03, 5e-4, 0.06, 0.01, 6e-7);
  guide.bodies[0].held = {true, false, true, true, true, true};
  const StrokeResponse r = path({"held", guide, 0.01}, {.leaf_modes = 0});
  for (const PathPoint& p : r.path) {
    CHECK(p.frequencies_locked.empty());
    CHECK(p.frequencies_free.size() == 1);
  }
}

TEST_CASE("as many frequencies as a job may ask for are right to the last", "[slow]") {
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4, 0.06, 0.01, 6e-7);
  StrokeRequest request{.frequencies = 100};
  request.outputs.remove(Output::frequency_derivatives);
  request.outputs.remove(Output::stress);
  const auto locked = [&](int leaf_modes) {
    const ModelOptions model{.accuracy = Accuracy::full, .mesh = {12, 5}, .leaf_modes = leaf_modes};
    const StrokeResponse r = test::evaluated(guide, model, request);
    return r.path[0].frequencies_locked;
  };
  const std::vector<double> found = locked(2), truth = locked(120);
  REQUIRE(found.size() == 100);
  REQUIRE(truth.size() == 100);
  for (std::size_t k = 0; k < found.size(); ++k) CHECK(found[k] == Approx(truth[k]).epsilon(2e-3));
}

TEST_CASE("constant mass is that of the undeflected leaf, and wrong where it is bent") {
  for (const Case& c : light()) {
    INFO(c.name);
    ModelOptions model{.accuracy = Accuracy::full, .leaf_modes = 8};
    const StrokeResponse consistent = path(c, model);
    model.mass = LeafMass::constant;
    const StrokeResponse constant = path(c, model);
    CHECK(worst(constant.path[0], consistent.path[0]) < 1e-9);
    CHECK(worst(constant.path[2], consistent.path[2]) > 1e-2);
    CHECK(constant.path[2].drive_load == consistent.path[2].drive_load);  // statics has no mass
  }
}

TEST_CASE("a constant mass only turns: its eigenvalues stay, its axes follow the chord") {
  const Case c = light()[1];
  const ModelOptions model{.accuracy = Accuracy::full};
  System system(c.mechanism, make_full_leaves(c.mechanism, model));
  system.assemble();
  ConstantMass constant(c.mechanism, model);
  const auto eigenvalues = [](const LeafDynamics& d) { return symmetric_eigenvalues(d.mass); };
  for (const int modes : {0, 2}) {
    System bent(c.mechanism, make_full_leaves(c.mechanism, model));
    REQUIRE(step_to(bent, 0.4, {}).converged);
    const LeafDynamics before = constant.dynamics(system, 0, modes),
                       after = constant.dynamics(bent, 0, modes);
    CHECK((modes > 0) == (after.mass.rows() > 12));
    CHECK((after.mass - after.mass.transpose()).norm() < 1e-12 * after.mass.norm());
    CHECK((eigenvalues(after) - eigenvalues(before)).norm() < 1e-12 * eigenvalues(before).norm());
    CHECK((after.mode_frequencies - before.mode_frequencies).norm() == 0);
    CHECK(after.internal_stiffness == before.internal_stiffness);
    // a rod's third of the leaf moves with its tip along the chord, which turned
    const EdgePose base = bent.edge_pose(0, 0), tip = bent.edge_pose(0, 1);
    const Vector3d chord = (tip.position - base.position).normalized();
    const LeafSpring& leaf = c.mechanism.leaves[0];
    const double own = leaf.material.density * leaf.length * leaf.width * leaf.thickness;
    CHECK(chord.dot(leaf.axes.col(0)) < 0.99);
    CHECK((after.mass.block<3, 3>(6, 6) * chord / own - chord / 3).norm() < 5e-3);
  }
}

TEST_CASE("without internal shapes every frequency is an upper bound, and leaf modes are absent",
          "[slow]") {
  for (const Case& c : light()) {
    INFO(c.name);
    ModelOptions model{.accuracy = Accuracy::full, .leaf_modes = 40};
    const StrokeResponse truth = path(c, model);
    model.leaf_modes = 0;
    const StrokeResponse bare = path(c, model);
    for (std::size_t k = 0; k < truth.path.size(); ++k) {
      const auto &found = bare.path[k].frequencies_free, &exact = truth.path[k].frequencies_free;
      REQUIRE(found.size() <= 6);
      for (std::size_t i = 0; i < found.size(); ++i) CHECK(found[i] > exact[i] * (1 - 1e-9));
      CHECK(found[0] == Approx(exact[0]).epsilon(2e-2));
      if (k == 0) CHECK(found.back() > 1.2 * exact[found.size() - 1]);
    }
  }
}
