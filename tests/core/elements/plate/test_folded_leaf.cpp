// A leaf with an elastic fold: laws, closed forms and derivatives.
#include "core/elements/plate/plate_fold.hpp"
#include "core/elements/plate/strain_field.hpp"
#include "core/math/decompositions.hpp"
#include "core/mechanism/fold_corner.hpp"
#include "support/plate_laws.hpp"

using namespace flexopt;
using namespace flexopt::plate_laws;

namespace {

PlateShape shape(double place, double angle, double radius = 0) {
  return {.width = 0.3, .thickness = 0.006, .mesh = {6, 3}, .fold = LeafFold{place, angle, radius}};
}

}  // namespace

TEST_CASE("the legs of a fold keep their angle under every strain of the line") {
  for (const double angle : {0.7, M_PI / 2, -2.1}) {
    // r,x of the first leg stretched by 1.02 at right angles to a line stretched by 1 + 1e-6,
    // turned
    const Matrix3d R = rotation_exp({0.4, -0.7, 1.3});
    FoldNode<double> u;
    u.numbers << R * Vector3d(1.02, 0, 0), R * Vector3d(0, 1 + 1e-6, 0),
        R * Vector3d(0.01, 0.02, 0.3),  // the line turns about itself by 0.3/1.02
        0.99, 0.01, 0, 0;
    const auto second = FoldMap<double>::of(angle).value(u);
    const Vector3d a = R * Vector3d(std::cos(angle), 0, std::sin(angle)),
                   n = R * Vector3d(-std::sin(angle), 0, std::cos(angle)), t = R.col(1);
    CHECK(second[0].dot(n) == Approx(0).margin(1e-11));  // squares of strains
    CHECK(second[0].dot(a) == Approx(0.99 * 1.02));
    CHECK(second[0].dot(t) == Approx(0.01 * (1 + 1e-6)));
    CHECK(second[1].dot(n) == Approx(0.99 * 0.3));  // the same turn
  }
}

TEST_CASE("derivatives of the map at a fold are those of its values") {
  const auto node = [](const VectorXd& x) { return FoldNode<double>::of(x, 4, 0); };
  const VectorXd u = random_direction(16, 1), y = random_direction(16, 2),
                 z = random_direction(16, 3), w = random_direction(16, 4);
  const auto map = FoldMap<double>::of(0.8);
  const auto rate = [&](auto value) {  // of polynomials of the fifth degree
    FoldMap<double>::Pair slopes;
    for (int k = 0; k < 2; ++k)
      slopes[k] = test::slope_at_zero([&](double s) { return Vector3d(value(s)[k]); }, 1e-3);
    return slopes;
  };
  const auto check = [&](const auto& found, const auto& expected) {
    for (int k = 0; k < 2; ++k) CHECK((found[k] - expected[k]).norm() < 1e-10);
  };
  check(map.first(node(u), node(y)), rate([&](double s) { return map.value(node(u + s * y)); }));
  check(map.second(node(u), node(y), node(z)),
        rate([&](double s) { return map.first(node(u + s * z), node(y)); }));
  check(map.third(node(u), node(w), node(y), node(z)),
        rate([&](double s) { return map.second(node(u + s * w), node(y), node(z)); }));
  check(FoldMap<double>::rate(0.8).value(node(u)),
        rate([&](double s) { return FoldMap<double>::of(0.8 + s).value(node(u)); }));
}

TEST_CASE("a folded leaf is free of stress wherever it is moved rigidly") {
  for (const double radius : {0.0, 0.008})
    for (const auto& [place, angle] : {std::pair{0.5, M_PI / 2}, {0.3, -2.0}, {0.6, 0.4}})
      check_rigid_motions(std::make_shared<PlateMesh>(shape(place, angle, radius)));
}

TEST_CASE("force and tangent of a folded leaf are derivatives of its energy") {
  const double radius = GENERATE(0.0, 0.01);
  const auto mesh = std::make_shared<PlateMesh>(shape(0.45, 1.2, radius));
  PlateLeaf leaf(mesh);
  const PlateLeaf::State state = random_state(*mesh, 3, 0.05);
  const VectorXd d = random_direction(state.x.size(), 4);
  check_interior_derivatives(leaf, state, d);
  // solving and multiplying fit together, as far as the tangent of a random state lets them
  const VectorXd product = leaf.tangent_times(d);
  leaf.eliminate();
  MatrixXd back = product;
  leaf.solve(back);
  CHECK((back.col(0) - d).norm() < 1e-5 * d.norm());
}

TEST_CASE("a fold of no angle is a flat leaf") {
  PlateShape folded = shape(0.5, 0, 0.01), flat = folded;
  folded.mesh = {8, 4};
  flat.mesh = {16, 4};
  flat.fold.reset();
  PlateLeaf a(std::make_shared<PlateMesh>(folded)), b(std::make_shared<PlateMesh>(flat));
  a.assemble();
  b.assemble();
  const SymmetricEigen of_a(MatrixXd(a.tangent())), of_b(MatrixXd(b.tangent()));
  for (int k = 6; k < 12; ++k)
    CHECK(of_a.eigenvalues()[k] == Approx(of_b.eigenvalues()[k]).epsilon(1e-3));
  const auto modes_a = a.modes(4), modes_b = b.modes(4);
  for (int k = 0; k < 4; ++k) CHECK(modes_a[k].omega2 == Approx(modes_b[k].omega2).epsilon(2e-4));
}

TEST_CASE("stiffness of an L frame in its plane") {
  for (const auto& [place, angle, radius] :
       {std::tuple{0.5, M_PI / 2, 0.0}, {0.35, -1.9, 0.0}, {0.5, 1.9, 0.012}, {0.5, -2.3, 0.02}}) {
    PlateShape s = shape(place, angle, radius);
    s.poissons_ratio = 0;  // no bending across
    s.free_edge_torsion = false;
    const auto mesh = std::make_shared<PlateMesh>(s);
    PlateLeaf leaf(mesh);
    leaf.assemble();
    const double EI = mesh->bending_stiffness(), EA = 12 * EI / (s.thickness * s.thickness),
                 GA = 5.0 / 12 * EA;
    const auto legs = [&, place = place, angle = angle](double at) {
      return at < place ? ArcPoint<double>{at, 0, 1, 0} : leg_point(place, angle, at);
    };
    Matrix3d C = flexibility_in_plane(legs, EI, EA, GA);
    // what the corner does not bend, in the middle of where it is missing
    const double shorter = corner_shortening(angle, radius, s.thickness);
    for (const double side : {-1.0, 1.0}) {
      const Vector3d moment =
          moment_at(legs(place + side * (4.0 / 9) * (160.0 / 133) * shorter), legs(1));
      C -= shorter / EI * moment * moment.transpose();
    }
    check_flexibility(flexibility(leaf, in_its_plane), C, 1e-4);
  }
}

TEST_CASE("moments on both ends of a folded strip turn them by that of shorter legs") {
  // of no Poisson's ratio: exact; else the line holds the section straight, and the moment is
  // larger in its middle
  for (const auto& [nu, tolerance] : {std::pair{0.0, 1e-6}, {0.3, 0.06}}) {
    const auto turning = [nu = nu](double radius) {
      PlateShape s = shape(0.5, 2.1, radius);
      s.poissons_ratio = nu;
      const PlateMesh mesh(s);
      PlateLeaf leaf(std::make_shared<PlateMesh>(s));
      leaf.assemble();
      return flexibility(leaf, in_its_plane)(2, 2) * mesh.bending_stiffness();
    };
    const auto shorter = [](double radius) {
      return 2 * corner_shortening(2.1, radius, shape(0.5, 2.1).thickness);
    };
    if (nu == 0) CHECK(turning(0) == Approx(1 - shorter(0)).epsilon(1e-6));
    for (const double radius : {0.004, 0.01, 0.02}) {
      REQUIRE(shorter(radius) > 0.009);
      CHECK(turning(0) - turning(radius) ==
            Approx(shorter(radius) - shorter(0)).epsilon(tolerance));
    }
  }
}

TEST_CASE("under one moment a folded strip has one curvature, also beside its corner") {
  for (const double radius : {0.0, 0.004, 0.03}) {  // the last one reaches over several elements
    PlateShape s = shape(0.45, -1.7, radius);
    s.poissons_ratio = 0;
    const auto mesh = std::make_shared<PlateMesh>(s);
    PlateLeaf leaf(mesh);
    leaf.assemble();
    const double moment = 1e-6;
    Vector12d dq = Vector12d::Zero();
    dq(in_its_plane) = moment * flexibility(leaf, in_its_plane).col(2);
    leaf.step(moved(leaf.state().edges, dq), leaf.internal_step(dq), dq);
    const MatrixXd strains = recovered_strains(*mesh, leaf.nodal()).values();
    const double curvature = moment / mesh->bending_stiffness();
    CHECK((strains.col(3).cwiseAbs().array() - curvature).abs().maxCoeff() < 1e-4 * curvature);
  }
}

TEST_CASE("operators change along place, angle and radius of a fold as their differences do") {
  // short elements, so that the corner reaches over several of them; and long ones
  const double radius = GENERATE(0.002, 0.03);
  check_mesh_rate(shape(0.4, 1.3, radius),
                  {{.fold = {.place = 1.0}},
                   {.fold = {.place = 0.3, .angle = -0.6}},
                   {.fold = {.radius = 1.0}},
                   {.fold = {.place = -0.1, .angle = 0.3, .radius = 0.02}}});
}
