// Leaves in one deformation, turned and mirrored against each other, share what was condensed.
#include "core/reduction/tube/equal_states.hpp"

#include <catch2/catch.hpp>

#include "core/reduction/tube/tube_leaf.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

const PlateShape flat{0.3, 0.005, 0.3, {6, 2}, true};

Matrix3d turn(double angle, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// Undeflected to here, in the axes of the leaf and over its length.
const EdgePoses bent{EdgePose{{0.01, 0.02, -0.01}, turn(0.00375, {0.1, -1, 0.02})},
                     EdgePose{{1.009998, 0.0200625, -0.010625}, turn(0.005, {-0.08, 1, 0.015})}};

/// The image of `bent` in a mirror, turned as a whole.
EdgePoses image(const Vector3d& mirror, const Matrix3d& turned) {
  const Matrix3d S = mirror.asDiagonal();
  EdgePoses edges = bent;
  for (EdgePose& edge : edges)
    edge = {turned * (S * edge.position) + Vector3d(0.1, -0.2, 0.3), turned * S * edge.axes * S};
  return edges;
}

/// Four times as far, where the tube about the flat leaf has other forces.
const EdgePoses far{EdgePose{{0.01, 0.02, -0.01}, turn(0.015, {0.1, -1, 0.02})},
                    EdgePose{{1.00996875, 0.02025, -0.0125}, turn(0.02, {-0.08, 1, 0.015})}};

std::unique_ptr<TubeLeaf> leaf_at(const std::shared_ptr<TubeModel>& model, const Matrix3d& axes,
                                  const EdgePoses& scaled) {
  LeafSpring spring = models::leaf({0.01, 0.02, 0.03}, {1, 0, 0}, 0.1, 0.03, 5e-4);
  spring.material.poissons_ratio = 0.3;
  spring.axes = axes;
  spring.base = 0;
  auto leaf = std::make_unique<TubeLeaf>(spring, model, 0);
  const LeafScale scale(spring);
  const EdgePoses edges{scale.global(scaled[0]), scale.global(scaled[1])};
  leaf->evaluate();
  for (int k = 0; k < 30; ++k) {  // the internal forces come to rest
    leaf->move(edges, Vector12d::Zero());
    leaf->evaluate();
  }
  return leaf;
}

std::shared_ptr<TubeModel> tube() {
  return std::make_shared<TubeModel>(std::make_shared<PlateMesh>(flat), TubeRange{});
}

}  // namespace

TEST_CASE("a leaf takes over the dynamics of one that stands as it does, turned or mirrored") {
  const Vector3d mirror =
      GENERATE(Vector3d(1, 1, 1), Vector3d(1, -1, 1), Vector3d(1, 1, -1), Vector3d(1, -1, -1));
  CAPTURE(mirror.transpose());
  const Matrix3d axes = turn(0.7, {1, 2, -1}), turned = turn(1.1, {0.3, -1, 2});
  const DynamicsRequest request(2, true);
  const auto shared = tube();
  const auto first = leaf_at(shared, Matrix3d::Identity(), bent);
  const LeafDynamics known = first->dynamics(request);
  const auto second = leaf_at(shared, axes, image(mirror, turned));
  const auto alone = leaf_at(tube(), axes, image(mirror, turned));
  const LeafDynamics taken = second->dynamics(request), own = alone->dynamics(request);

  // internal shapes are taken over as they are: only their signs may differ from those found anew
  REQUIRE(taken.mass.rows() == own.mass.rows());
  const Eigen::Index internal = own.mode_frequencies.size();
  CHECK(taken.mode_frequencies == known.mode_frequencies);
  CHECK((taken.mode_frequencies - own.mode_frequencies).norm() <
        1e-6 * own.mode_frequencies.norm());
  const auto same = [&](const MatrixXd& a, const MatrixXd& b) {
    return (a - b).norm() < 1e-6 * b.norm();
  };
  CHECK(same(taken.mass.topLeftCorner(12, 12), own.mass.topLeftCorner(12, 12)));
  CHECK(
      same(taken.mass.topRightCorner(12, 2).cwiseAbs(), own.mass.topRightCorner(12, 2).cwiseAbs()));
  CHECK(same(taken.stations.leftCols(12), own.stations.leftCols(12)));
  CHECK(same(taken.stations.rightCols(internal).leftCols(2).cwiseAbs(),
             own.stations.rightCols(internal).leftCols(2).cwiseAbs()));
  CHECK(same(taken.shape_motion.leftCols(12), own.shape_motion.leftCols(12)));
  CHECK(same(taken.shape_motion.middleCols(12, 2).cwiseAbs(),
             own.shape_motion.middleCols(12, 2).cwiseAbs()));
  // and so is the state that stresses and places are read from
  CHECK(second->stress().largest().value == Approx(alone->stress().largest().value).epsilon(1e-7));
  CHECK(second->stress().largest().value == Approx(first->stress().largest().value).epsilon(1e-7));
  for (const double along : {0.0, 0.3, 1.0})
    CHECK((second->material_point(along, 0.2) - alone->material_point(along, 0.2)).norm() < 1e-9);
}

TEST_CASE("what is not believed beside the full leaf is not taken over") {
  const auto shared = tube();
  const auto first = leaf_at(shared, Matrix3d::Identity(), far),
             second = leaf_at(shared, Matrix3d::Identity(), far);
  const LeafDynamics known = first->dynamics({2}), own = second->dynamics({2});
  for (const TubeLeaf* leaf : {first.get(), second.get()})
    CHECK_THAT(why_not(leaf->check_rebuilt()), Catch::Contains("has other forces by 0.028"));
  CHECK(own.mode_frequencies == known.mode_frequencies);
}

TEST_CASE("only leaves in equal deformations share") {
  const PlateMesh mesh(flat);
  LeafStand stand;
  stand.e << 1e-4, 0.1, 0.01, -0.08, 0.02, 0.03;
  stand.f = {1, 0.2, -0.1};
  stand.length = stand.energy = stand.mass = 1;
  stand.moving = {true, true};
  const VectorXd unknowns = PlateLeaf::undeflected(mesh).x;
  CondensedLeaf condensed;
  condensed.unknowns = unknowns;
  condensed.dynamics.mass = MatrixXd::Identity(12, 12);
  condensed.dynamics.stations = MatrixXd::Zero(6, 12);
  EqualStates states;
  states.keep(stand, 2, condensed, 4);
  CHECK(states.find(mesh, stand, 2));
  CHECK_FALSE(states.find(mesh, stand, 3));  // another request
  const auto changed = [&](auto change) {
    LeafStand other = stand;
    change(other);
    return states.find(mesh, other, 2).has_value();
  };
  CHECK_FALSE(changed([](LeafStand& s) { s.e[1] += 1e-7; }));
  CHECK_FALSE(changed([](LeafStand& s) { s.f[0] += 1e-6; }));
  CHECK_FALSE(changed([](LeafStand& s) { s.e[5] = -s.e[5]; }));  // no mirror does this alone
  CHECK_FALSE(changed([](LeafStand& s) { s.mass = 2; }));
  CHECK_FALSE(changed([](LeafStand& s) { s.moving[0] = false; }));
  CHECK(changed([](LeafStand& s) {  // mirrored in the thickness
    s.e[1] = -s.e[1];
    s.e[3] = -s.e[3];
    s.e[5] = -s.e[5];
  }));
  // the oldest makes room
  for (int k = 1; k <= 4; ++k) {
    LeafStand other = stand;
    other.e[0] += k;
    states.keep(other, 2, condensed, 4);
  }
  CHECK_FALSE(states.find(mesh, stand, 2));
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
