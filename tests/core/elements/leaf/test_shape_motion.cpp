// LeafDynamics::shape_motion, from which modes are drawn, is the derivative of shape().
#include "support/leaf_laws.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

VectorXd places(LeafElement& leaf) {
  const LeafShape shape = leaf.shape();
  VectorXd all(3 * static_cast<Eigen::Index>(shape.deflected.size()));
  for (std::size_t i = 0; i < shape.deflected.size(); ++i)
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = shape.deflected[i];
  return all;
}

}  // namespace

TEST_CASE("The motion that modes are drawn with is the derivative of the shape") {
  Mechanism m = models::single_leaf(0.1, 0.03, 5e-4);
  m.leaves[0].axes = rotation_exp({0.3, -0.2, 0.5}) * m.leaves[0].axes;
  m.bodies[0].reference = m.bodies[0].center_of_mass = m.leaves[0].tip_middle();
  const LeafSpring& spring = m.leaves[0];
  const EdgePoses rest = test::edges_at_rest(spring);
  Vector12d bend = Vector12d::Zero(), way;
  bend.segment<3>(6) = spring.axes * Vector3d(-1e-5, 0, 4e-3);
  bend.segment<3>(9) = spring.axes * Vector3d(0.02, -0.03, 0);
  way << 0, 0, 0, 0, 0, 0, 0.2, -0.3, 0.5, 4, -6, 3;
  way.segment<3>(6) = (spring.axes * Vector3d(0, 0.01, 0.8)).eval();
  const double step = 2e-6;
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    CAPTURE(flexure);
    const auto leaf =
        std::move(make_full_leaves(
                      m, {.flexure = flexure,
                          .mesh = flexure == Flexure::beam ? std::array{8, 1} : std::array{6, 4}})
                      .front());
    constexpr int steps = 8;  // one alone need not converge
    for (int k = 0; k < steps; ++k)
      test::settled(*leaf, moved(rest, (1.0 * k / steps) * bend), (1.0 / steps) * bend);
    const LeafDynamics dynamics = leaf->dynamics({2, true});
    const VectorXd middle = places(*leaf);
    // The base is held: a model may leave its columns out.
    REQUIRE(dynamics.shape_motion.rows() == middle.size());
    REQUIRE(dynamics.shape_motion.cols() == dynamics.mass.cols());
    const VectorXd motion = dynamics.shape_motion.leftCols<12>() * way;
    const auto state = leaf->save();
    const EdgePoses bent = moved(rest, bend);
    const auto places_at = [&](double t) {
      leaf->restore(*state);
      leaf->move(bent, Vector12d::Zero());
      test::settled(*leaf, bent, t * way);
      return places(*leaf);
    };
    const VectorXd difference = (places_at(step) - places_at(-step)) / (2 * step);
    CHECK((motion - difference).cwiseAbs().maxCoeff() < 1e-5 * difference.cwiseAbs().maxCoeff());
    const LeafShape shape = leaf->shape();
    // Interior modes leave the clamped base where it is.
    for (int j = 0; j < shape.points_across; ++j)
      CHECK(dynamics.shape_motion.rightCols(dynamics.mode_frequencies.size())
                .middleRows<3>(3 * j * shape.points_along)
                .cwiseAbs()
                .maxCoeff() < 1e-9 * dynamics.shape_motion.cwiseAbs().maxCoeff());
  }
}
