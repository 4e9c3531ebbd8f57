// What every model of a leaf owes the mechanism: its full model at the same edges, and an honest
// answer where it cannot do something.
#include "core/elements/plate/full_model.hpp"

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/elements/leaf/leaf_series.hpp"
#include "core/response/modes/mechanism_factor.hpp"
#include "core/response/path/frequency_derivatives.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

struct Case {
  const char* name;
  ModelOptions model;
};

ModelOptions reduced(Reduction method, Flexure flexure, std::array<int, 2> cut) {
  return {.flexure = flexure,
          .mesh = flexure == Flexure::beam ? std::array{8, 1} : std::array{8, 4},
          .method = method,
          .superelements = cut};
}

std::vector<Case> cases() {
  using enum Reduction;
  using enum Flexure;
  return {{"tube", reduced(mixed_potential, plate, {1, 0})},
          {"superelement", reduced(linear_craig_bampton, plate, {1, 0})},
          {"superelements", reduced(linear_craig_bampton, plate, {3, 0})},
          {"patches", reduced(linear_craig_bampton, plate, {4, 2})},
          {"beam superelements", reduced(linear_craig_bampton, beam, {3, 0})},
          {"modal", reduced(modal_derivatives, plate, {1, 0})},
          {"beam modal", reduced(modal_derivatives, beam, {1, 0})},
          {"manifold", reduced(quadratic_manifold, plate, {1, 0})},
          {"chain", reduced(modal_derivatives, plate, {2, 0})},
          {"beam chain", reduced(modal_derivatives, beam, {3, 0})},
          {"chain of manifolds", reduced(quadratic_manifold, plate, {2, 0})}};
}

/// Brought to internal equilibrium between held edges.
LeafEvaluation settled(LeafElement& leaf, const EdgePoses& edges) {
  for (int k = 0; k < 40 && leaf.evaluate().correction > 1e-11; ++k)
    leaf.move(edges, Vector12d::Zero());
  return leaf.evaluation();
}

Mechanism turned_leaf() {
  Mechanism m = models::single_leaf(0.1, 0.03, 5e-4);
  m.leaves[0].axes = rotation_exp({0.3, -0.2, 0.5}) * m.leaves[0].axes;
  m.bodies[0].reference = m.bodies[0].center_of_mass = m.leaves[0].tip_middle();
  return m;
}

EdgePoses edges_of(const System& system) {
  return {system.edge_pose(0, 0), system.edge_pose(0, 1)};
}

/// A body that only has what every leaf must have.
class BareLeaf final : public LeafElement {
 public:
  explicit BareLeaf(FullLeaf full) : full_(std::move(full)) {}

  void move(const EdgePoses& edges, const Vector12d& dq) override { full_.move(edges, dq); }
  const LeafEvaluation& evaluate() override { return evaluation_ = full_.evaluate(); }
  std::unique_ptr<LeafElement> full_model(const std::string& reason) override {
    return full_.full_model(reason);
  }
  std::unique_ptr<LeafState> save() const override { return full_.save(); }
  void restore(const LeafState& state) override { full_.restore(state); }
  LeafDynamics dynamics(DynamicsRequest request) override { return full_.dynamics(request); }
  LeafStress stress() override { return full_.stress(); }
  LeafShape shape() override { return full_.shape(); }
  std::vector<Vector3d> material_points(const std::vector<std::array<double, 2>>& places) override {
    if (lost) return {places.size(), Vector3d::Constant(std::nan(""))};
    return full_.material_points(places);
  }
  LeafReport report() const override { return {.model = "bare", .reason = {}, .check = 0}; }

  bool lost = false;  ///< where its points are

 private:
  FullLeaf full_;
};

}  // namespace

TEST_CASE("the full model of a reduced leaf is the full leaf's equilibrium between its edges") {
  const Mechanism m = turned_leaf();
  for (const Case& c : cases()) {
    INFO(c.name);
    System system(m, make_reduced_leaves(m, c.model, 0.02));
    System reference(m, make_full_leaves(m, c.model));
    REQUIRE(step_to(system, 0.018, {}).converged);  // a manifold is hard to bend further
    REQUIRE(step_to(reference, 0.018, {}).converged);
    LeafElement& leaf = system.leaf(0);
    REQUIRE(!leaf.is_full());

    const auto full = leaf.full_model("asked for");
    REQUIRE(full);
    CHECK(full->is_full());
    CHECK(full->report().model == "full");
    CHECK(full->report().reason == "asked for");
    const EdgePoses edges = edges_of(system);
    const LeafEvaluation found = settled(*full, edges);
    REQUIRE(found.correction < 1e-10);
    CHECK(found.negative_pivots == 0);
    for (const double end : {0.0, 1.0})
      CHECK(
          (full->material_point(end, 0.5) - edges[static_cast<std::size_t>(end)].position).norm() <
          1e-12);

    // the full leaf that came from rest, brought between the same edges
    LeafElement& other = reference.leaf(0);
    Vector12d dq;
    for (int e = 0; e < 2; ++e) {
      const EdgePose from = reference.edge_pose(0, e);
      dq.segment<6>(6 * e) << edges[e].position - from.position,
          rotation_log(edges[e].axes * from.axes.transpose());
    }
    other.evaluate();
    other.move(edges, dq);
    const LeafEvaluation expected = settled(other, edges);
    REQUIRE(expected.correction < 1e-10);
    CHECK(found.energy == Approx(expected.energy).epsilon(1e-8));
    CHECK((found.force - expected.force).norm() < 1e-7 * expected.force.norm());
    CHECK((found.tangent - expected.tangent).norm() < 1e-7 * expected.tangent.norm());
  }
}

TEST_CASE("the full model of a leaf with a material point leads to its equilibrium") {
  for (const bool free_tip : {false, true}) {
    INFO("free tip " << free_tip);
    const Mechanism single = models::single_leaf(0.1, 0.03, 5e-4);
    const Mechanism m =
        free_tip ? models::free_tip(single) : models::clamped_at_both(single, 0.5, 0.5);
    const LeafPoint& point = *m.leaves[0].point;
    const ModelOptions model = reduced(Reduction::linear_craig_bampton, Flexure::plate, {4, 2});
    System system(m, make_reduced_leaves(m, model, 2e-3));
    System reference(m, make_full_leaves(m, model));
    const double stroke = free_tip ? 0.02 : 1e-3;
    REQUIRE(step_to(system, stroke, {}).converged);
    const Equilibrium expected = step_to(reference, stroke, {});
    REQUIRE(expected.converged);

    auto full = system.leaf(0).full_model("asked for");
    CHECK(settled(*full, edges_of(system)).correction < 1e-10);
    // the point, or the mean of the tip edge by the trapezoidal rule
    Vector3d place = Vector3d::Zero();
    constexpr int n = 200;
    for (int k = 0; k <= n; ++k)
      place += (k == 0 || k == n ? 0.5 : 1.0) / n *
               full->material_point(point.along, free_tip ? k / double(n) : point.across);
    CHECK((place - system.pose(0).position).norm() < 1e-9);
    system.replace_leaf(0, std::move(full));
    const Equilibrium found = solve_equilibrium(system, stroke, {});
    REQUIRE(found.converged);
    CHECK(found.drive_load == Approx(expected.drive_load).epsilon(1e-7));
  }
}

TEST_CASE("a full model comes from the undeflected leaf where other places lead nowhere") {
  const Mechanism m = turned_leaf();
  const auto mesh = std::make_shared<PlateMesh>(leaf_shape(m.leaves[0], {}));
  const LeafSpring& leaf = m.leaves[0];
  BareLeaf other(FullLeaf(leaf, mesh, 0));
  other.lost = true;
  other.evaluate();
  // a tip turned by 1 rad on the arc of constant curvature, the whole turned with its base
  const Matrix3d base = rotation_exp({-0.4, 1.2, 0.7}) * leaf.axes;
  const double angle = 1.0;
  LeafHold hold;
  hold.edges[0] = {leaf.origin + Vector3d(0.03, -0.02, 0.05), base};
  hold.edges[1] = {hold.edges[0].position +
                       leaf.length / angle *
                           (std::sin(angle) * base.col(0) - (1 - std::cos(angle)) * base.col(2)),
                   base * rotation_exp({0, angle, 0})};
  const auto full = full_model_in_place(other, hold, leaf, mesh, 0, "asked for");
  const LeafEvaluation at = settled(*full, hold.edges);
  REQUIRE(at.correction < 1e-10);
  CHECK(at.negative_pivots == 0);
  // between a strip that bends freely and one without anticlastic curvature
  const double EI = leaf.material.youngs_modulus * leaf.width * std::pow(leaf.thickness, 3) / 12,
               energy = 0.5 * EI * angle * angle / leaf.length;
  CHECK(at.energy > energy);
  CHECK(at.energy < energy / (1 - 0.3 * 0.3));
}

TEST_CASE("the full model of a full leaf is a copy that keeps its report") {
  const Mechanism m = turned_leaf();
  const auto mesh = std::make_shared<PlateMesh>(leaf_shape(m.leaves[0], {}));
  FullLeaf leaf(m.leaves[0], mesh, 0, "it has no two rigid edges");
  leaf.evaluate();
  const auto copy = leaf.full_model("another reason");
  CHECK(copy->is_full());
  CHECK(copy->report().reason == "it has no two rigid edges");
  CHECK((copy->evaluate().tangent - leaf.evaluation().tangent).norm() == 0);
}

TEST_CASE("full leaves take over where reduced ones find no equilibrium, and say so", "[slow]") {
  // beyond the reach of the reduced models: stretched by more than 5 %, or without equilibrium
  struct Lost {
    const char* name;
    Mechanism mechanism;
    ModelOptions model;
    double stroke;  ///< [m]
  };
  const Mechanism guide = models::guide(0.1, 0.03, 5e-4),
                  leaf = models::single_leaf(0.1, 0.03, 5e-4);
  using enum Reduction;
  for (const Lost& c :
       {Lost{"superelement", guide, reduced(linear_craig_bampton, Flexure::plate, {1, 0}), 0.07},
        Lost{"manifold", leaf, reduced(quadratic_manifold, Flexure::plate, {1, 0}), 0.07},
        Lost{"chain", leaf, reduced(quadratic_manifold, Flexure::plate, {2, 0}), 0.085}}) {
    INFO(c.name);
    const StrokeRequest request{.points = {c.stroke}, .outputs = test::without_stress()};
    const StrokeResponse found = test::evaluated(c.mechanism, c.model, request),
                         expected = test::evaluated(c.mechanism, test::full(c.model), request);
    for (const LeafReport& report : found.path[0].leaves) {
      CHECK(report.model == "full");
      CHECK(report.reason == "no equilibrium with reduced leaves");
    }
    CHECK(found.path[0].drive_load == Approx(expected.path[0].drive_load).epsilon(1e-6));
    const Matrix6d &C = found.path[0].compliance_locked, &D = expected.path[0].compliance_locked;
    CHECK((C - D).norm() < 1e-6 * D.norm());
  }
}

TEST_CASE("a leaf without a linearised interior says so by its model's name") {
  const Mechanism m = models::single_leaf(0.1, 0.03, 5e-4);
  const auto mesh = std::make_shared<PlateMesh>(leaf_shape(m.leaves[0], {}));
  std::vector<std::unique_ptr<LeafElement>> bare;
  bare.push_back(std::make_unique<BareLeaf>(FullLeaf(m.leaves[0], mesh, 0)));
  System system(m, std::move(bare));
  system.assemble();
  const Answer<MechanismFactor> none = MechanismFactor::of(system);
  REQUIRE(!none);
  CHECK(none.error() == "leaf 0: the model \"bare\" has no linearised interior");
  CHECK_FALSE(system.leaf(0).check_interior({}));

  System tube(m, make_reduced_leaves(m, {}, 0.01));
  tube.assemble();
  CHECK(MechanismFactor::of(tube).error() == "leaf 0: its tube was built, not looked up");
  CHECK_FALSE(tube.leaf(0).check_interior({}));
}

TEST_CASE("a full leaf has a gradient and a series, and a leaf of a compared method has neither") {
  const Mechanism m = models::single_leaf(0.1, 0.03, 5e-4);
  for (const Case& c : cases()) {
    if (c.model.method == Reduction::mixed_potential) continue;
    INFO(c.name);
    System system(m, make_reduced_leaves(m, c.model, 0.01));
    system.assemble();
    const Answer<MechanismFactor> factor = MechanismFactor::of(system);
    REQUIRE(!factor);
    CHECK(factor.error() ==
          "leaf 0: the model \"" + system.leaf(0).report().model + "\" has no linearised interior");
    CHECK(!system.leaf(0).check_interior({}));
  }
  System system(m, make_full_leaves(m, {}));
  system.assemble();
  const Answer<MechanismFactor> factor = MechanismFactor::of(system);
  REQUIRE(factor);
  CHECK(system.leaf(0).check_interior({}));
  const MechanismFactor::Leaf& leaf = factor->leaves()[0];
  CHECK(leaf.full);
  LeafRates rates;
  CHECK(leaf.linear->gradient(rates, leaf.rows));
  CHECK(leaf.linear->series());
}

TEST_CASE("what leaves share is made once for the same data and the same kind of rate") {
  LeafRates rates;
  const auto a = std::make_shared<const int>(1), b = std::make_shared<const int>(2);
  int made = 0;
  const auto twice = [&](const std::shared_ptr<const int>& of) {
    return rates.of<double>(of, [&] {
      ++made;
      return 2.0 * *of;
    });
  };
  CHECK(*twice(a) == 2);
  CHECK(twice(a) == twice(a));
  CHECK(*twice(b) == 4);
  CHECK(made == 2);
  CHECK(*rates.of<int>(a, [&] { return 10 * *a; }) == 10);
  CHECK(*twice(a) == 2);
  CHECK(made == 2);
}
