// Full leaves that reduced leaves of one model rebuild, and whether they are believed.
#include "core/reduction/tube/plate_pool.hpp"

#include <catch2/catch.hpp>

#include "core/reduction/tube/tube_leaf.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

const PlateShape flat{0.3, 0.005, 0.3, {6, 2}, true};

Matrix3d turn(double angle, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

}  // namespace

TEST_CASE("a rebuilt leaf with other forces than the reduced one is not believed") {
  LeafSpring spring = models::leaf({0.01, 0.02, 0.03}, {1, 0, 0}, 0.1, 0.03, 5e-4);
  spring.material.poissons_ratio = 0.3;
  spring.axes.setIdentity();
  spring.base = 0;
  TubeLeaf leaf(spring, std::make_shared<TubeModel>(std::make_shared<PlateMesh>(flat), TubeRange{}),
                0);
  const LeafScale scale(spring);
  const EdgePoses edges{
      scale.global(EdgePose{{0.01, 0.02, -0.01}, turn(0.015, {0.1, -1, 0.02})}),
      scale.global(EdgePose{{1.00996875, 0.02025, -0.0125}, turn(0.02, {-0.08, 1, 0.015})})};
  leaf.evaluate();
  for (int k = 0; k < 30; ++k) {  // the internal forces come to rest
    leaf.move(edges, Vector12d::Zero());
    leaf.evaluate();
  }
  (void)leaf.dynamics({2});
  CHECK_THAT(why_not(leaf.check_rebuilt()), Catch::Contains("has other forces by 0.028"));
}

TEST_CASE("a pool of plates keeps those that were used last") {
  PlatePool pool(std::make_shared<PlateMesh>(flat));
  const auto first = pool.new_state();
  PlateLeaf& plate = pool.take(first);
  CHECK(pool.find(first) == &plate);
  for (int k = 0; k < 7; ++k) pool.take(pool.new_state());
  CHECK(pool.find(first) == &plate);  // used again: the second is now the oldest
  pool.take(pool.new_state());
  CHECK(pool.find(first) == &plate);
  for (int k = 0; k < 8; ++k) pool.take(pool.new_state());
  CHECK(pool.find(first) == nullptr);
}
