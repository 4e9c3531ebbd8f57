// The full plate leaf: laws first, then derivatives, then closed forms.
#include "core/reduction/expansion/tube_expansion.hpp"
#include "support/plate_laws.hpp"

using namespace flexopt;
using namespace flexopt::plate_laws;

namespace {

std::shared_ptr<const PlateMesh> make_mesh(double w = 0.5, double t = 0.006,
                                           std::array<int, 2> mesh = {6, 3}) {
  return std::make_shared<PlateMesh>(PlateShape{w, t, 0.3, mesh, true});
}

// Moves the edges by dq and brings the internal unknowns to rest.
void move_to_rest(PlateLeaf& leaf, const Vector12d& dq) {
  const EdgePoses edges = moved(leaf.state().edges, dq);
  leaf.assemble();
  leaf.step(edges, leaf.internal_step(dq), dq);
  for (int k = 0; k < 20; ++k) {
    leaf.assemble();
    if (leaf.correction() < 1e-11) break;
    leaf.step(edges, leaf.internal_step(Vector12d::Zero()), Vector12d::Zero());
  }
  leaf.set_state(leaf.state());  // the tangent without linearised stresses
  leaf.assemble();
  REQUIRE(leaf.correction() < 1e-8);
}

// Bent, twisted and slightly pulled, in equilibrium between its edges.
void bend(PlateLeaf& leaf, const std::shared_ptr<const PlateMesh>& mesh) {
  ChordLeaf chord(mesh);
  REQUIRE(chord.solve({0.15, -0.1, 0.01}, {3, 0.2, 0.1}).converged);
  leaf.set_state(chord.plate().state());
  leaf.assemble();
  REQUIRE(leaf.correction() < 1e-8);
}

}  // namespace

TEST_CASE("a rigid motion stores no energy and turns force and tangent with it") {
  const auto mesh = make_mesh();
  PlateLeaf leaf(mesh);
  bend(leaf, mesh);
  REQUIRE(leaf.energy() > 1e-3);
  check_turned(leaf, 1e-9);
}

TEST_CASE("the internal force is the gradient of the energy and the tangent its Hessian") {
  check_energy_derivatives(make_mesh(), 4e-3, true);
}

TEST_CASE("the condensed tangent is the derivative of the condensed force and symmetric") {
  const auto mesh = make_mesh();
  PlateLeaf leaf(mesh);
  bend(leaf, mesh);
  const PlateLeaf::State state = leaf.state();
  const Matrix12d K = leaf.tangent();
  const Vector12d f = leaf.force();
  CHECK((K - K.transpose()).norm() < 1e-12 * K.norm());
  // rigid translations meet no stiffness
  for (int c = 0; c < 3; ++c) {
    Vector12d shift = Vector12d::Zero();
    shift[c] = shift[6 + c] = 1;
    CHECK((K * shift).norm() < 1e-9 * K.norm());
  }
  for (unsigned trial = 0; trial < 3; ++trial) {
    const Vector12d dq = random_direction(12, 17 + trial);
    const auto work = [&](double s) {
      leaf.set_state(state);
      move_to_rest(leaf, s * dq);
      return leaf.force().dot(dq);
    };
    // force · dq along a screw motion differs from dqᵀ K dq by no first-order term
    CHECK(test::slope_at_zero(work, 5e-6) == Approx(dq.dot(K * dq)).epsilon(1e-6));
  }
  CHECK(f.norm() > 0);
}

TEST_CASE("mass sums to density times volume, and to its moments of inertia") {
  const auto mesh = make_mesh(0.7, 0.01, {5, 4});
  const Matrix6d M = rigid_mass(mesh);
  const double area = 0.7, along = area / 3, across = area * 0.7 * 0.7 / 12;
  const double expected[] = {area, area, area, across, along, along + across};
  for (int c = 0; c < 6; ++c) CHECK(M(c, c) == Approx(expected[c]).epsilon(1e-9));
}

TEST_CASE("fixed-interface modes are mass-orthonormal and solve their eigenproblem") {
  const auto mesh = make_mesh(0.3, 0.005, {8, 4});
  PlateLeaf leaf(mesh);
  leaf.assemble();
  const auto modes = leaf.modes(6);
  REQUIRE(modes.size() == 6);
  for (std::size_t a = 0; a < modes.size(); ++a) {
    const VectorXd Mv = leaf.mass_times(modes[a].shape);
    for (std::size_t b = 0; b < modes.size(); ++b)
      CHECK(modes[b].shape.dot(Mv) == Approx(a == b ? 1 : 0).margin(1e-8));
    VectorXd x = Mv * modes[a].omega2;
    leaf.solve(x);
    CHECK((x - modes[a].shape).norm() < 1e-7 * modes[a].shape.norm());
    if (a > 0) CHECK(modes[a].omega2 >= modes[a - 1].omega2);
  }
  // first bending mode of a clamped–clamped strip with free edges: between the beam's 22.373² E I
  // (plane stress) and the same with plane strain
  const double low = (1 - 0.09) * 22.3733 * 22.3733, high = 22.3733 * 22.3733;
  CHECK(modes[0].omega2 > low);
  CHECK(modes[0].omega2 < high);
}
