// Where a tube leaf is believed, and what takes its place where it is not.
#include "core/equilibrium/edge_compliance.hpp"
#include "core/reduction/tube/tube_leaf.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

StrokeRequest statics(double end, int points) {
  return {.points = models::evenly(end, points),
          .outputs = {Output::equilibrium, Output::stiffness}};
}

struct Outcome {
  double support = 0, drive = 0;  ///< worst relative errors
  // leaves and points
  int replaced = 0;  ///< by the full one
  int centred = 0;   ///< of degree 5, expanded anew
  int of_degree_7 = 0;
};

Outcome compare(const Mechanism& mechanism, const StrokeRequest& request) {
  const StrokeResponse full = test::evaluated(mechanism, test::full(), request),
                       reduced = test::evaluated(mechanism, {}, request);
  Outcome worst;
  double load = 0;
  for (const PathPoint& p : full.path) load = std::max(load, std::abs(p.drive_load));
  for (std::size_t k = 0; k < full.path.size(); ++k) {
    const PathPoint &a = full.path[k], &b = reduced.path[k];
    worst.drive = std::max(worst.drive, std::abs(b.drive_load - a.drive_load) / load);
    worst.support = std::max(worst.support, test::support_error(b, a));
    for (const LeafReport& leaf : b.leaves) {
      worst.replaced += leaf.replaced;
      worst.centred += leaf.degree == 5 && !leaf.reason.empty();
      worst.of_degree_7 += leaf.degree == 7;
      CHECK((leaf.degree == 7) <= !leaf.reason.empty());
    }
  }
  return worst;
}

/// Two leaves that cross side by side under a load along x, `share` of that which buckles them.
Mechanism cross_hinge() {
  return models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.02}});
}
LoadCase pressed(double share) { return {.constant = {{.force = {-49.5 * share, 0, 0}}}}; }

}  // namespace

TEST_CASE("a leaf that is held by nothing else changes as its mechanism does") {
  Mechanism single = models::single_leaf(0.1, 0.03, 5e-4);
  single.drives.clear();
  const LoadCase loads{.constant = {},
                       .growing = {{.force = {0.5, 2, 0.3}, .moment = {0.01, 0, 0}}}};
  System system(single, make_reduced_leaves(single, {}, 1, loads), loads);
  REQUIRE(step_load(system, {.constant = 1, .growing = 1}, {}).converged);
  const auto* leaf = dynamic_cast<const TubeLeaf*>(&system.leaf(0));
  REQUIRE(leaf);
  EdgeCompliance compliance(system);
  auto about = compliance.of(0);
  REQUIRE(about);
  const double held = leaf->changes_in(*about).held;
  REQUIRE(held > 1e-8);

  // what else holds the tip can only make the change smaller
  about->compliance *= 0.25;
  CHECK(leaf->changes_in(*about).held == Approx(0.25 * held));
}

TEST_CASE("leaves that would buckle alone are believed where the mechanism is stable") {
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4);
  StrokeRequest request = statics(0.02, 3);
  // more than half of the load at which the drive, if it were free, would give way
  request.loads.constant = {{.force = {-75, 0, 0}}};
  const Outcome of = compare(guide, request);
  CHECK(of.replaced == 0);
  CHECK(of.support < 2e-3);
  CHECK(of.drive < 1e-4);
}

TEST_CASE("a hinge under a payload is followed by better potentials, not by full leaves") {
  StrokeRequest request = statics(M_PI / 4, 7);
  request.loads = pressed(0.5);
  const Outcome of = compare(cross_hinge(), request);
  CHECK(of.replaced == 0);
  CHECK(of.centred > 0);
  CHECK(of.of_degree_7 > 0);
  CHECK(of.support < 4e-3);
  CHECK(of.drive < 1e-4);
}

TEST_CASE("frequencies of leaves under more than they carry alone are those of full ones",
          "[slow]") {
  // no equilibrium beyond 18 mm; at 15 mm the first step from the rebuilt state leads astray
  Mechanism guide = models::guide(0.1, 0.010204220006, 2.8105538191e-4, 0.036531182692);
  for (LeafSpring& leaf : guide.leaves) leaf.material.youngs_modulus = 210e9;
  StrokeRequest request = statics(0.03, 11);
  request.outputs = {Output::equilibrium, Output::frequencies_locked, Output::stress};
  request.frequencies = 3;
  request.loads.constant = {{.force = {-20, 0, -5}}};
  const StrokeResponse full = evaluate_stroke(guide, test::full(), request),
                       reduced = evaluate_stroke(guide, {}, request);
  double largest_step = 0;
  for (std::size_t k = 0; k < 7; ++k) {
    const PathPoint &a = full.path[k], &b = reduced.path[k];
    REQUIRE(a.status == PointStatus::converged);
    REQUIRE(b.status == PointStatus::converged);
    CHECK(test::frequency_error(b.frequencies_locked, a.frequencies_locked) < 1e-3);
    CHECK(b.max_stress->value == Approx(a.max_stress->value).epsilon(2e-3));
    for (const LeafReport& leaf : b.leaves) largest_step = std::max(largest_step, leaf.check);
  }
  CHECK(largest_step > 0.02);
}

TEST_CASE("a leaf tells where the full one that it rebuilds finds no equilibrium") {
  Mechanism single = models::single_leaf(0.1, 0.03, 5e-4);
  single.drives.clear();
  const LoadCase loads{.constant = {}, .growing = {{.force = {0.5, 2, 0.3}}}};
  System system(single, make_reduced_leaves(single, {}, 1, loads), loads);
  LeafElement& leaf = system.leaf(0);
  REQUIRE(dynamic_cast<TubeLeaf*>(&leaf));
  leaf.evaluate();
  const EdgePoses rest{EdgePose{Vector3d::Zero(), Matrix3d::Identity()},
                       EdgePose{Vector3d(0.1, 0, 0), Matrix3d::Identity()}};
  EdgePoses near = rest, far = rest;
  near[1].position += Vector3d(-6e-6, 0, 1e-3);
  far[1].position += Vector3d(-0.03, 0.02, 0.03);
  far[1].axes = rotation_exp(Vector3d(1.2, 0.4, 0.8));
  const auto believed_at = [&](const EdgePoses& edges) {
    for (int k = 0; k < 30; ++k) {  // the internal forces come to rest
      leaf.move(edges, Vector12d::Zero());
      leaf.evaluate();
    }
    leaf.dynamics({2});
    return leaf.check_rebuilt();
  };
  CHECK(believed_at(near));
  const auto before = leaf.save();
  CHECK_THAT(why_not(believed_at(far)), Catch::Contains("rebuilt, moves by"));
  leaf.restore(*before);
  CHECK(leaf.check_rebuilt());
}

TEST_CASE("an arc whose fields say little of it is right beside the full one") {
  Mechanism arc = models::single_leaf(0.1, 0.03, 5e-4);
  arc.drives.clear();
  arc.leaves[0].curve = 0.5;
  System system(arc, make_reduced_leaves(arc, {}, 1, {}));
  LeafElement& leaf = system.leaf(0);
  EdgePoses edges{system.edge_pose(0, 0), system.edge_pose(0, 1)};
  edges[1].position += Vector3d(2e-5, 0, 1e-4);
  for (int k = 0; k < 30; ++k) {  // the internal forces come to rest
    leaf.move(edges, Vector12d::Zero());
    leaf.evaluate();
  }
  CHECK(leaf.dynamics({2}).check > 1e-4);  // so it is compared
  CHECK(leaf.check_rebuilt());
}

TEST_CASE("the drive stiffness at rest is right near the load that buckles the free mechanism") {
  // the payload bends each leaf in its plane, which a mechanism with its drive held hardly feels
  Mechanism hinge = models::hinge(0.1, 3.8172e-4, {{1, 0.127, 0.249}, {-1, -0.127, 0.249}});
  for (LeafSpring& leaf : hinge.leaves) leaf.material.youngs_modulus = 11.28e6;
  StrokeRequest request = statics(0, 2);
  request.points = {0};
  request.loads.constant = {{.force = {-0.018, 0, 0}}};
  const StrokeResponse full = test::evaluated(hinge, test::full(), request),
                       reduced = test::evaluated(hinge, {}, request);
  CHECK(reduced.path[0].drive_stiffness == Approx(full.path[0].drive_stiffness).epsilon(2e-3));
}

TEST_CASE("leaves that the stroke pulls straight are expanded about their pull") {
  // between two grounds, driven across: the leaves stretch
  Mechanism bridge = models::single_leaf(0.04, 0.008, 3e-4);
  bridge.bodies[0].reference = bridge.bodies[0].center_of_mass = {0.04, 0, 0};
  bridge.leaves.push_back(models::leaf({0.08, 0, 0}, {-1, 0, 0}, 0.04, 0.008, 3e-4));
  const Outcome of = compare(bridge, statics(4e-4, 5));
  CHECK(of.replaced == 0);
  CHECK(of.centred > 0);
  CHECK(of.support < 2e-3);
  CHECK(of.drive < 1e-4);
}

TEST_CASE("a hinge without payload needs none of them") {
  const StrokeResponse response = test::evaluated(cross_hinge(), {}, statics(M_PI / 6, 4));
  for (const PathPoint& p : response.path)
    for (const LeafReport& leaf : p.leaves) {
      CHECK(leaf.degree == 5);
      CHECK(leaf.reason.empty());
    }
}

TEST_CASE("equal leaves share what takes over from their model") {
  const auto mesh = std::make_shared<PlateMesh>(PlateShape{0.3, 0.005, 0.3, {8, 4}, true});
  TubeModel model(mesh, {.sigma_max = 0.3});
  const Vector3d forces(-8, 0.5, -0.2);
  const auto first = model.successor(2, {1, 1}, forces, 0.15);
  REQUIRE(first);
  CHECK(model.successor(2, {1, 1}, forces, 0.15) == first);
  CHECK(model.successor(3, {1, 1}, forces, 0.15) != first);
  CHECK(model.successor(2, {1, 1}, {-8, 0.5, 0.2}, 0.15) != first);

  // it starts with the two bent states about the leaf, and grows both ways
  CHECK(first->potential().nodes().size() == 2);
  CHECK(first->potential().degree() == 5);
  CHECK(first->potential().nodes().front().sigma <= 0.15);
  CHECK(first->potential().last_sigma() >= 0.15);
  const double before = first->potential().nodes().front().sigma;
  REQUIRE(first->extend(first->next_state(0.5 * before)));
  CHECK(first->potential().nodes().front().sigma < before);
  const double beyond = 1.01 * first->potential().last_sigma();
  REQUIRE(first->extend(first->next_state(beyond)));
  CHECK(first->potential().last_sigma() > beyond);

  // and is the leaf itself at its centre
  ChordLeaf leaf(mesh);
  const Vector3d s(0.2, 0.2, 0);
  REQUIRE(leaf.solve(s, forces.cwiseProduct(tube_force_scale(mesh->shape()))).converged);
  CHECK(first->potential().evaluate(s, forces).value == Approx(leaf.potential()).epsilon(1e-6));

  // along another ray, too, far off that of the first model
  const auto turned = model.successor(2, {1, 0.4}, forces, 0.15);
  REQUIRE(turned);
  const Vector3d off(0.2, 0.08, 0);
  REQUIRE(leaf.solve(off, forces.cwiseProduct(tube_force_scale(mesh->shape()))).converged);
  CHECK(turned->potential().locate(off).tau == Approx(0).margin(1e-12));
  CHECK(turned->potential().evaluate(off, forces).value == Approx(leaf.potential()).epsilon(1e-6));
}

TEST_CASE("equal leaves that go beyond their bent states together get one more of them") {
  const double L = 0.1;
  const Mechanism guide = models::guide(L, 0.3 * L, L / 60);
  const ModelOptions reduced{.mesh = {6, 2}}, full{.accuracy = Accuracy::full, .mesh = {6, 2}};
  const auto drive_stiffness = [](System& system) {
    const int d = system.driven_coordinates(true)[0];
    return system.tangent().dense()(d, d);
  };
  for (const double stroke : {0.03003, 0.0303, 0.0306, 0.033, 0.045}) {
    System whole(guide, make_full_leaves(guide, full));
    REQUIRE(step_to(whole, stroke * L, {}).converged);
    // made for a fraction of the stroke
    System system(guide, make_reduced_leaves(guide, reduced, 1e-3 * L));
    bool changed = true;
    for (int round = 0; changed && round < 5; ++round) {
      REQUIRE(step_to(system, stroke * L, {}).converged);
      changed = false;
      EdgeCompliance compliance(system);
      for (int i = 0; i < system.leaves(); ++i) {
        const LimitedRange::Refinement refinement =
            dynamic_cast<TubeLeaf&>(system.leaf(i)).refine([&] { return compliance.of(i); });
        REQUIRE_FALSE(refinement.replacement);
        changed = changed || refinement.changed;
      }
      if (changed) system.invalidate();
    }
    CHECK_FALSE(changed);
    CHECK(drive_stiffness(system) == Approx(drive_stiffness(whole)).epsilon(1e-6));
  }
}
