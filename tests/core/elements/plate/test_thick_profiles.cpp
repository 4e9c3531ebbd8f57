// Transverse shear takes no more energy than the bending has, however the thickness varies.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/equilibrium/stroke_path.hpp"
#include "core/mechanism/profile.hpp"
#include "core/response/models/leaf_models.hpp"
#include "support/models.hpp"

using namespace flexopt;

TEST_CASE("thick leaves whose thickness varies steeply are stable at rest",
          "[plate][beam][shear]") {
  Mechanism mechanism = models::single_leaf(0.1, GENERATE(0.05, 0.2), 4e-3, Direction::rz);
  LeafSpring& leaf = mechanism.leaves.front();
  // a notch: 4 mm in the middle, 64 mm at both ends
  for (const double s : profile_stations())
    leaf.thickness_profile.push_back(1 + 15 * (1 - std::sqrt(1 - std::pow(2 * s - 1, 2))));
  ModelOptions model;
  model.accuracy = Accuracy::full;
  model.flexure = GENERATE(Flexure::plate, Flexure::beam);
  model.mesh = GENERATE(std::array{6, 2}, std::array{10, 4}, std::array{20, 8});
  System system(mechanism, make_full_leaves(mechanism, model));
  system.assemble();
  CHECK(negative_pivots(system, true) == 0);
  CHECK(negative_pivots(system, false) == 0);
}
