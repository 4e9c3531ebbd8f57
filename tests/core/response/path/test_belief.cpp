// Every number of reduced leaves is that of full ones, whatever carries it.
#include "support/own_leaves.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

/// Of the reduced leaves against full ones on the same mesh.
Disagreement between_models(const Mechanism& mechanism, ModelOptions model,
                            const StrokeRequest& request) {
  model.accuracy = Accuracy::reduced;
  const StrokeResponse reduced = evaluate_stroke(mechanism, model, request);
  model.accuracy = Accuracy::full;
  const StrokeResponse full = evaluate_stroke(mechanism, model, request);
  REQUIRE(full.status == Status::ok);
  REQUIRE(reduced.status == Status::ok);
  return largest_disagreement(reduced, full);
}

/// 50 × 10 × 0.2 mm, its tip held in all directions but those that are driven.
Mechanism fixed_leaf(const std::vector<Direction>& driven) {
  Mechanism leaf = models::single_leaf(0.05, 0.01, 2e-4);
  leaf.bodies[0].held.fill(true);
  leaf.drives.clear();
  for (const Direction d : driven) {
    leaf.bodies[0].held[static_cast<std::size_t>(index(d))] = false;
    leaf.drives.push_back(make_drive(d));
    leaf.drives.back().name = direction_names[static_cast<std::size_t>(index(d))];
  }
  return leaf;
}

StrokeRequest statics(const std::vector<VectorXd>& strokes) {
  StrokeRequest request{.points = {}, .outputs = {Output::equilibrium, Output::stiffness}};
  for (const VectorXd& s : strokes) {
    request.points.push_back(s[0]);
    if (s.size() > 1) request.strokes.push_back(s);
  }
  return request;
}

VectorXd numbers(std::initializer_list<double> list) {
  return Eigen::Map<const VectorXd>(list.begin(), static_cast<Eigen::Index>(list.size()));
}

}  // namespace

TEST_CASE("a leaf between held ends that is pulled sideways is as stiff as it is") {
  const Mechanism leaf = fixed_leaf({Direction::uy});
  const ModelOptions beams{.flexure = Flexure::beam};
  const StrokeRequest request = statics({numbers({1e-3}), numbers({2e-3}), numbers({3e-3})});
  const StrokeResponse response = test::evaluated(leaf, beams, request);
  CHECK(response.path[0].drive_load == Approx(2.04).epsilon(3e-3));
  CHECK(response.path[2].drive_load == Approx(46.87).epsilon(3e-3));
  CHECK(between_models(leaf, beams, request).relative < 3e-3);
}

TEST_CASE("a leaf between driven ends carries what it carries between held ones") {
  const Mechanism leaf = fixed_leaf({Direction::ux, Direction::uy, Direction::rz});
  const StrokeRequest request = statics({numbers({0, 1e-3, 0}), numbers({0, 3e-3, 0})});
  const StrokeResponse response = test::evaluated(leaf, {}, request);
  CHECK(response.path[1].drive_loads[0] == Approx(743).epsilon(3e-3));
  CHECK(response.path[1].drive_loads[1] == Approx(47.25).epsilon(3e-3));
  CHECK(between_models(leaf, {}, request).relative < 3e-3);
}

TEST_CASE("what drives and held directions carry is that of full leaves, of any mechanism") {
  const unsigned seed = GENERATE(5U, 9U, 16U);
  const OwnLeaves own = own_leaves(seed);
  CAPTURE(own.what);
  CHECK(between_models(own.mechanism, own.model, own.request).relative < 0.01);
}

TEST_CASE("the same of more mechanisms", "[slow]") {
  for (unsigned seed = 6; seed < 28; ++seed) {
    OwnLeaves own = own_leaves(seed);
    CAPTURE(seed, own.what);
    const StrokeResponse reduced = evaluate_stroke(own.mechanism, own.model, own.request);
    own.model.accuracy = Accuracy::full;
    const StrokeResponse full = evaluate_stroke(own.mechanism, own.model, own.request);
    CHECK(reduced.status == full.status);
    const Disagreement worst = largest_disagreement(reduced, full);
    CAPTURE(worst.number, worst.point, worst.found, worst.expected);
    CHECK(worst.relative < 0.01);
  }
}
