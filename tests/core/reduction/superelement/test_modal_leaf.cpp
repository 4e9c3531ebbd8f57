#include "core/reduction/superelement/modal_leaf.hpp"

#include <Eigen/Dense>

#include "core/reduction/superelement/leaf_chain.hpp"
#include "support/leaf_laws.hpp"
#include "support/strokes.hpp"
#include "support/synthetic_leaf.hpp"

using namespace flexopt;

namespace {

ModelOptions modal(Flexure flexure, int segments, ModalDerivativeSet set = ModalDerivativeSet::all,
                   Reduction method = Reduction::modal_derivatives) {
  return {.flexure = flexure,
          .mesh = flexure == Flexure::beam ? std::array{8, 1} : std::array{6, 2},
          .method = method,
          .superelements = {segments, 0},
          .modal_derivatives = set};
}

Mechanism single(double width = 0.02) {
  Mechanism m = models::single_leaf(0.1, width, 5e-4);
  m.leaves[0].axes = rotation_exp({0.3, -0.2, 0.5}) * m.leaves[0].axes;
  m.bodies[0].reference = m.bodies[0].center_of_mass = m.leaves[0].tip_middle();
  return m;
}

std::unique_ptr<LeafElement> element(const Mechanism& m, const ModelOptions& model) {
  return std::move(make_reduced_leaves(m, model, 0)[0]);
}

struct Case {
  const char* name;
  ModelOptions model;
};
std::vector<Case> cases() {
  using enum ModalDerivativeSet;
  return {{"beam", modal(Flexure::beam, 1)},
          {"beam, bending", modal(Flexure::beam, 1, bending)},
          {"beam, third order", modal(Flexure::beam, 1, third_order)},
          {"beam, manifold", modal(Flexure::beam, 1, all, Reduction::quadratic_manifold)},
          {"beam, three", modal(Flexure::beam, 3)},
          {"beam, two manifolds", modal(Flexure::beam, 2, all, Reduction::quadratic_manifold)},
          {"plate", modal(Flexure::plate, 1)},
          {"plate, manifold", modal(Flexure::plate, 1, all, Reduction::quadratic_manifold)},
          {"plate, two", modal(Flexure::plate, 2)}};
}

/// Global increments per unit, by directions of the leaf: below its buckling.
Matrix12d units(const LeafSpring& leaf) {
  Matrix12d unit = Matrix12d::Zero();
  for (int e = 0; e < 12; e += 6) {
    unit.block<3, 3>(e, e) = leaf.axes * Vector3d(1e-6, 1e-5, 1e-3).asDiagonal();
    unit.block<3, 3>(e + 3, e + 3) = leaf.axes * Vector3d(0.05, 0.03, 1e-3).asDiagonal();
  }
  return unit;
}

Vector12d random_vector(const LeafSpring& leaf, synthetic::Random& random) {
  return units(leaf) * random.vector<12>();
}

}  // namespace

TEST_CASE("a modal leaf's force and tangent are the derivatives of its energy") {
  const Mechanism m = single();
  const Matrix12d unit = units(m.leaves[0]).transpose();
  for (const Case& c : cases()) {
    INFO(c.name);
    const auto leaf = element(m, c.model);
    synthetic::Random random(3);
    const EdgePoses rest = test::edges_at_rest(m.leaves[0]);
    const Vector12d first = random_vector(m.leaves[0], random);
    const LeafEvaluation at = test::settled(*leaf, rest, first);
    REQUIRE(at.correction < 1e-10);
    for (int k = 0; k < 4; ++k) {
      const Vector12d v = random_vector(m.leaves[0], random);
      test::check_leaf_derivatives(*leaf, moved(rest, first), v, 4e-3, unit,
                                   1e-7 * at.force.cwiseProduct(v).cwiseAbs().sum(), 1e-6);
    }
  }
}

TEST_CASE("a rigid motion leaves a modal leaf's energy alone and turns its forces", "[slow]") {
  const Mechanism m = single();
  for (const Case& c : cases()) {
    INFO(c.name);
    const auto leaf = element(m, c.model);
    synthetic::Random random(5);
    const EdgePoses rest = test::edges_at_rest(m.leaves[0]);
    const Vector12d first = random_vector(m.leaves[0], random);
    const LeafEvaluation at = test::settled(*leaf, rest, first);
    // turned about the origin in steps, so that inner lines can follow
    const Matrix3d step = rotation_exp({1e-3, -3e-3, 2e-3});
    Matrix3d R = Matrix3d::Identity();
    EdgePoses turned = moved(rest, first);
    for (int k = 0; k < 200; ++k) {
      Vector12d dq;
      for (int e = 0; e < 2; ++e) {
        const Vector3d place = step * turned[e].position;
        dq.segment<3>(6 * e) = place - turned[e].position;
        dq.segment<3>(6 * e + 3) = rotation_log(step);
        turned[e] = {place, step * turned[e].axes};
      }
      R = step * R;
      leaf->move(turned, dq);
      for (int i = 0; i < 40 && leaf->evaluate().correction > 1e-12; ++i)
        leaf->move(turned, Vector12d::Zero());
    }
    const LeafEvaluation& there = leaf->evaluate();
    CHECK(there.energy == Approx(at.energy).epsilon(1e-9));
    double scale = 0, error = 0;
    for (int k = 0; k < 4; ++k) {
      const Vector3d f = at.force.segment<3>(3 * k);
      scale = std::max(scale, f.norm());
      error = std::max(error, (there.force.segment<3>(3 * k) - R * f).norm());
    }
    CHECK(error < 1e-7 * scale);
    // its tangent turned by the same R: the rigid motions stay without energy
    CHECK(there.tangent.norm() == Approx(at.tangent.norm()).epsilon(1e-7));
  }
}

TEST_CASE("a saved state of a modal leaf comes back") {
  const Mechanism m = single();
  for (const Case& c : cases()) {
    const auto leaf = element(m, c.model);
    synthetic::Random random(7);
    const EdgePoses rest = test::edges_at_rest(m.leaves[0]);
    const LeafEvaluation at = test::settled(*leaf, rest, random_vector(m.leaves[0], random));
    const auto state = leaf->save();
    test::settled(*leaf, rest, random_vector(m.leaves[0], random));
    leaf->restore(*state);
    const LeafEvaluation& back = leaf->evaluate();
    CHECK(back.energy == Approx(at.energy).epsilon(1e-12));
    CHECK((back.tangent - at.tangent).norm() < 1e-9 * at.tangent.norm());
  }
}

TEST_CASE("at rest a modal leaf has the full leaf's stiffness, boundary mass and stress") {
  for (const Flexure flexure : {Flexure::beam, Flexure::plate})
    for (const auto method : {Reduction::modal_derivatives, Reduction::quadratic_manifold}) {
      Mechanism m = single();
      m.leaves[0].base = 0;  // both edges move
      const ModelOptions model = modal(flexure, 1, ModalDerivativeSet::all, method);
      const auto leaf = element(m, model);
      FullLeaf full(m.leaves[0], std::make_shared<PlateMesh>(leaf_shape(m.leaves[0], model)), 0);
      leaf->evaluate();
      full.evaluate();
      CHECK((leaf->evaluation().tangent - full.evaluation().tangent).norm() <
            1e-9 * full.evaluation().tangent.norm());
      const LeafDynamics a = leaf->dynamics(0), b = full.dynamics(0);
      CHECK((a.mass.topLeftCorner<12, 12>() - b.mass.topLeftCorner<12, 12>()).norm() <
            1e-8 * b.mass.topLeftCorner<12, 12>().norm());
      CHECK((leaf->material_point(0.5, 0.5) - full.material_point(0.5, 0.5)).norm() < 1e-12);
    }
}

TEST_CASE("a chain of full leaves is the full leaf of a beam cut there") {
  const Mechanism m = models::guide(0.1, 0.01, 5e-4);
  ModelOptions model = modal(Flexure::beam, 2, ModalDerivativeSet::third_order);
  model.mesh = {16, 1};
  StrokeRequest request{.points = {0, 0.02}, .frequencies = 4};
  request.outputs.remove(Output::frequency_derivatives);
  request.outputs.add(Output::shapes);
  const StrokeResponse cut = test::evaluated(m, model, request);
  model.accuracy = Accuracy::full;
  model.warping = Warping::free;  // as at the cuts
  const StrokeResponse full = evaluate_stroke(m, model, request);
  for (int k : {0, 1}) {
    const PathPoint &a = cut.path[k], &b = full.path[k];
    CHECK(a.leaves[0].model == "modal_derivatives");
    if (k == 1) CHECK(a.drive_load == Approx(b.drive_load).epsilon(1e-3));
    CHECK(test::support_error(a, b) < 5e-3);
    CHECK(test::frequency_error(a.frequencies_locked, b.frequencies_locked) < 5e-3);
    if (k == 1) CHECK(a.max_stress->value == Approx(b.max_stress->value).epsilon(1e-2));
    REQUIRE(a.shapes[0].points_along == 17);
    CHECK((a.shapes[0].deflected.back() - b.shapes[0].deflected.back()).norm() < 1e-6);
    CHECK((a.shapes[0].deflected[8] - b.shapes[0].deflected[8]).norm() < 1e-5);
  }
}

TEST_CASE("modal derivatives follow a guide better than superelements, third-order ones fully") {
  // Section 5.1 of the method: support stiffness of one superelement 60×, 15× and 1 % too stiff
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeRequest request{.points = {0.01, 0.02, 0.03}, .outputs = test::without_stress()};
  ModelOptions model = modal(Flexure::beam, 1);
  model.mesh = {10, 1};
  const PathPoint full = evaluate_stroke(m, test::full(model), request).path[2];
  const auto point = [&](ModalDerivativeSet set, int segments) {
    model.modal_derivatives = set;
    model.superelements = {segments, 0};
    return test::evaluated(m, model, request).path[2];
  };
  using enum ModalDerivativeSet;
  const auto stiffer = [&](const PathPoint& p) {
    return *p.support_stiffness[0] / *full.support_stiffness[0];
  };
  const PathPoint b = point(bending, 1), a = point(all, 1), t = point(third_order, 1),
                  a4 = point(all, 4);
  CHECK(stiffer(b) > 30);
  CHECK(stiffer(a) > 5);
  CHECK(stiffer(a) < 25);
  CHECK(stiffer(t) == Approx(1).epsilon(1e-2));
  CHECK(stiffer(a4) == Approx(1).epsilon(1e-2));
  CHECK(b.drive_load / full.drive_load == Approx(1.016).epsilon(0.01));  // slightly stiffer
  CHECK(a.drive_load > full.drive_load);
  CHECK(t.drive_load == Approx(full.drive_load).epsilon(1e-4));
}

TEST_CASE("what a modal leaf cannot hold is full, and says so") {
  Mechanism m = models::single_leaf(0.1, 0.02, 5e-4);
  m.leaves[0].tip = free_edge;
  m.leaves[0].point = LeafPoint{0, 1.0, 0.5, true};
  const auto leaf = element(m, modal(Flexure::plate, 1));
  CHECK(leaf->report().model == "full");
  CHECK(leaf->report().reason == "it has no two rigid edges");
}
