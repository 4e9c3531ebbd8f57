// What equal leaves of a mechanism share.
#include "core/response/models/leaf_models.hpp"

#include <catch2/catch.hpp>

#include "core/reduction/tube/tube_leaf.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

// The models of both leaves of a guide, the second one longer by so much.
bool share_a_model(double longer) {
  Mechanism guide = models::guide(0.06, 0.02, 3e-4);
  guide.leaves[1].length *= 1 + longer;
  ModelOptions model{.mesh = {4, 2}};
  const auto leaves = make_reduced_leaves(guide, model, 2e-3);
  const auto* one = dynamic_cast<const TubeLeaf*>(leaves[0].get());
  const auto* other = dynamic_cast<const TubeLeaf*>(leaves[1].get());
  REQUIRE(one);
  REQUIRE(other);
  return one->model() == other->model();
}

}  // namespace

TEST_CASE("leaves share a model unless more than rounding tells them apart") {
  CHECK(share_a_model(0));
  CHECK(share_a_model(4e-16));
  CHECK(!share_a_model(1e-11));
}

TEST_CASE("shapes are alike where rounding alone tells them apart") {
  PlateShape shape{0.3, 0.005, 0.3, {4, 2}};
  shape.curve = 0.4;
  PlateShape other = shape;
  other.width *= 1 + 4e-16;
  other.curve = 0.4 * (1 - 4e-16);
  CHECK(other != shape);
  CHECK(alike(shape, other));
  other.thickness *= 1 + 1e-12;
  CHECK(!alike(shape, other));
  other = shape;
  other.curve.reset();
  CHECK(!alike(shape, other));
  other = shape;
  other.mesh = {6, 2};
  CHECK(!alike(shape, other));
}
