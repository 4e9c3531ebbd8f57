// Leaves whose width and thickness vary along them: laws, closed forms and derivatives.
#include "support/plate_laws.hpp"

using namespace flexopt;
using namespace flexopt::plate_laws;

namespace {

double notch(double s) { return 1 + 8 * (s - 0.45) * (s - 0.45); }

PlateShape shape(Flexure flexure, bool varies = true) {
  PlateShape s{.width = 0.4, .thickness = 0.01, .mesh = {6, 3}, .flexure = flexure};
  if (varies) {
    s.width_profile = sampled(wave);
    s.thickness_profile = sampled(notch);
  }
  return s;
}

double difference(const PlateMesh& a, const PlateMesh& b) {
  double most = 0;
  for (int i = 0; i < a.elements_along(); ++i)
    for (int j = 0; j < a.elements_across(); ++j) {
      const PlateMesh::Element &p = a.element(i, j), &q = b.element(i, j);
      most = std::max({most, (p.bending - q.bending).norm() / p.bending.norm(),
                       (p.mass - q.mass).norm() / p.mass.norm(),
                       (p.gradient - q.gradient).norm() / p.gradient.norm(),
                       (p.weight - q.weight).matrix().norm() / p.weight.matrix().norm()});
    }
  return most;
}

}  // namespace

TEST_CASE("a profile of ones is a uniform leaf") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    const PlateMesh uniform(shape(flexure, false));
    PlateShape ones = shape(flexure, false);
    ones.width_profile = ones.thickness_profile = {1, 1};
    CHECK(difference(uniform, PlateMesh(ones)) < 1e-13);
    ones.width_profile = ones.thickness_profile = sampled([](double) { return 1.0; });
    CHECK(difference(uniform, PlateMesh(ones)) < 1e-12);
    CHECK(PlateMesh(ones).bending_stiffness() == Approx(uniform.bending_stiffness()));
  }
}

TEST_CASE("only the product of reference and factors counts") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    const PlateShape a = shape(flexure);
    PlateShape b = a;
    b.width *= 2;
    for (double& factor : b.width_profile) factor /= 2;
    PlateLeaf one(std::make_shared<PlateMesh>(a)), other(std::make_shared<PlateMesh>(b));
    one.assemble();
    other.assemble();
    CHECK((one.tangent() - other.tangent()).norm() < 1e-9 * one.tangent().norm());
    PlateShape c = a;
    c.thickness *= 2;
    for (double& factor : c.thickness_profile) factor /= 2;
    PlateLeaf thick(std::make_shared<PlateMesh>(c));
    thick.assemble();  // energies over D of a thickness twice as large
    CHECK((one.tangent() - 8 * thick.tangent()).norm() < 1e-9 * one.tangent().norm());
  }
}

TEST_CASE("a leaf of any profile is at rest, and where it is moved rigidly") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam})
    check_rigid_motions(std::make_shared<PlateMesh>(shape(flexure)), 2e-10);
}

TEST_CASE("the force of a leaf with profiles is the derivative of its energy") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    PlateLeaf leaf(std::make_shared<PlateMesh>(shape(flexure)));
    const PlateLeaf::State state = random_state(leaf.mesh(), 3);
    check_interior_derivatives(leaf, state, random_direction(state.x.size(), 4));
  }
}

TEST_CASE("operators change along sizes and profiles as their differences do") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam})
    check_mesh_rate(shape(flexure), {{sampled([](double s) { return s * s; }), {}},
                                     {{}, sampled([](double s) { return std::cos(3 * s); })}});
}
