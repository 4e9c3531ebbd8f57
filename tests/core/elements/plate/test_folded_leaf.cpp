// A leaf with an elastic fold: laws, closed forms and derivatives.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/elements/plate/plate_fold.hpp"
#include "core/elements/plate/plate_leaf.hpp"
#include "core/elements/plate/plate_mesh_rate.hpp"
#include "core/elements/plate/strain_field.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/fold_corner.hpp"
#include "support/plate_laws.hpp"

using namespace flexopt;
using namespace flexopt::plate_laws;

namespace {

PlateShape shape(double place, double angle, double radius = 0) {
  PlateShape s{.width = 0.3, .thickness = 0.006, .mesh = {6, 3}};
  s.fold = LeafFold{place, angle, radius};
  return s;
}

}  // namespace

TEST_CASE("the legs of a fold keep their angle under every strain of the line", "[fold]") {
  for (const double angle : {0.7, M_PI / 2, -2.1}) {
    // r,x of the first leg stretched by 1.02 at right angles to a line stretched by 1 + 1e-6,
    // turned
    const Matrix3d R = rotation_exp({0.4, -0.7, 1.3});
    FoldNode<double> u = FoldNode<double>::zero();
    u.along = R * Vector3d(1.02, 0, 0);
    u.across = R * Vector3d(0, 1 + 1e-6, 0);
    u.both = R * Vector3d(0.01, 0.02, 0.3);  // the line turns about itself by 0.3/1.02
    u.stretch = 0.99;
    u.shear = 0.01;
    const auto second = FoldMap<double>::of(angle).value(u);
    const Vector3d a = R * Vector3d(std::cos(angle), 0, std::sin(angle)),
                   n = R * Vector3d(-std::sin(angle), 0, std::cos(angle)), t = R.col(1);
    CHECK(second[0].dot(n) == Approx(0).margin(1e-11));  // squares of strains
    CHECK(second[0].dot(a) == Approx(0.99 * 1.02));
    CHECK(second[0].dot(t) == Approx(0.01 * (1 + 1e-6)));
    CHECK(second[1].dot(n) == Approx(0.99 * 0.3));  // the same turn
  }
}

TEST_CASE("derivatives of the map at a fold are those of its values", "[fold]") {
  const auto node = [](const VectorXd& x) { return FoldNode<double>::of(x, 4, 0); };
  const VectorXd u = random_direction(16, 1), y = random_direction(16, 2),
                 z = random_direction(16, 3), w = random_direction(16, 4);
  const auto map = FoldMap<double>::of(0.8);
  const double h = 1e-3;  // of polynomials of the fifth degree
  const auto rate = [&](auto value) {
    FoldMap<double>::Pair sum{Vector3d::Zero(), Vector3d::Zero()};
    for (const auto& [at, weight] : {std::pair{h, 8.0}, {-h, -8.0}, {2 * h, -1.0}, {-2 * h, 1.0}}) {
      const auto p = value(at);
      for (int k = 0; k < 2; ++k) sum[k] += weight / (12 * h) * p[k];
    }
    return sum;
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

TEST_CASE("a folded leaf is free of stress wherever it is moved rigidly", "[fold]") {
  for (const double radius : {0.0, 0.008})
    for (const auto& [place, angle] : {std::pair{0.5, M_PI / 2}, {0.3, -2.0}, {0.6, 0.4}})
      check_rigid_motions(std::make_shared<PlateMesh>(shape(place, angle, radius)));
}

TEST_CASE("force and tangent of a folded leaf are derivatives of its energy", "[fold]") {
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

TEST_CASE("a fold of no angle is a flat leaf", "[fold]") {
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

TEST_CASE("stiffness of an L frame in its plane", "[fold]") {
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
    const Vector3d tip = mesh->line_pose(mesh->lines() - 1).position;
    Matrix3d C = Matrix3d::Zero();
    constexpr int points = 2000;
    for (int k = 0; k < points; ++k) {
      const double at = (k + 0.5) / points;
      const ArcPoint<double> p =
          at < place ? ArcPoint<double>{at, 0, 1, 0} : leg_point(place, angle, at);
      // of Fx, Fz and My at the tip: moment about y at s, and pull along the leg
      const Vector3d moment(tip[2] - p.z, -(tip[0] - p.x), 1), pull(p.cosine, p.sine, 0),
          cut(-p.sine, p.cosine, 0);
      C += (moment * moment.transpose() / EI + pull * pull.transpose() / EA +
            cut * cut.transpose() / GA) /
           points;
    }
    // what the corner does not bend, in the middle of where it is missing
    const double shorter = corner_shortening(angle, radius, s.thickness);
    for (const double side : {-1.0, 1.0}) {
      const double at = place + side * (4.0 / 9) * (160.0 / 133) * shorter;
      const ArcPoint<double> p =
          at < place ? ArcPoint<double>{at, 0, 1, 0} : leg_point(place, angle, at);
      const Vector3d moment(tip[2] - p.z, -(tip[0] - p.x), 1);
      C -= shorter / EI * moment * moment.transpose();
    }
    Matrix3d K;
    const int rows[] = {6, 8, 10};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) K(i, j) = leaf.tangent()(rows[i], rows[j]);
    const Matrix3d found = K.inverse();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        CHECK(std::abs(found(i, j) - C(i, j)) < 1e-4 * std::sqrt(C(i, i) * C(j, j)));
  }
}

TEST_CASE("moments on both ends of a folded strip turn them by that of shorter legs", "[fold]") {
  // of no Poisson's ratio: exact; else the line holds the section straight, and the moment is
  // larger in its middle
  for (const auto& [nu, tolerance] : {std::pair{0.0, 1e-6}, {0.3, 0.06}}) {
    const auto flexibility = [nu = nu](double radius) {
      PlateShape s = shape(0.5, 2.1, radius);
      s.poissons_ratio = nu;
      const PlateMesh mesh(s);
      PlateLeaf leaf(std::make_shared<PlateMesh>(s));
      leaf.assemble();
      Matrix3d K;
      const int rows[] = {6, 8, 10};  // ux, uz and ry of the tip
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) K(i, j) = leaf.tangent()(rows[i], rows[j]);
      return Matrix3d(K.inverse())(2, 2) * mesh.bending_stiffness();
    };
    const auto shorter = [](double radius) {
      return 2 * corner_shortening(2.1, radius, shape(0.5, 2.1).thickness);
    };
    if (nu == 0) CHECK(flexibility(0) == Approx(1 - shorter(0)).epsilon(1e-6));
    for (const double radius : {0.004, 0.01, 0.02}) {
      REQUIRE(shorter(radius) > 0.009);
      CHECK(flexibility(0) - flexibility(radius) ==
            Approx(shorter(radius) - shorter(0)).epsilon(tolerance));
    }
  }
}

TEST_CASE("under one moment a folded strip has one curvature, also beside its corner", "[fold]") {
  for (const double radius : {0.0, 0.004, 0.03}) {  // the last one reaches over several elements
    PlateShape s = shape(0.45, -1.7, radius);
    s.poissons_ratio = 0;
    const auto mesh = std::make_shared<PlateMesh>(s);
    PlateLeaf leaf(mesh);
    leaf.assemble();
    const int rows[] = {6, 8, 10};  // ux, uz and ry of the tip
    Matrix3d K;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) K(i, j) = leaf.tangent()(rows[i], rows[j]);
    const double moment = 1e-6;
    const Vector3d by = K.inverse() * Vector3d(0, 0, moment);
    Vector12d dq = Vector12d::Zero();
    for (int i = 0; i < 3; ++i) dq[rows[i]] = by[i];
    leaf.step(moved(leaf.state().edges, dq), leaf.internal_step(dq), dq);
    const MatrixXd strains = recovered_strains(*mesh, leaf.nodal()).values();
    const double curvature = moment / mesh->bending_stiffness();
    CHECK((strains.col(3).cwiseAbs().array() - curvature).abs().maxCoeff() < 1e-4 * curvature);
  }
}

TEST_CASE("operators change along place, angle and radius of a fold as their differences do",
          "[fold]") {
  // short elements, so that the corner reaches over several of them; and long ones
  const double radius = GENERATE(0.002, 0.03);
  const PlateShape at = shape(0.4, 1.3, radius);
  const PlateMesh mesh(at);
  const PlateMeshRate rate(mesh, {{.fold_place = 1.0},
                                  {.fold_place = 0.3, .fold_angle = -0.6},
                                  {.fold_radius = 1.0},
                                  {.fold_place = -0.1, .fold_angle = 0.3, .fold_radius = 0.02}});
  for (int p = 0; p < rate.directions(); ++p) {
    const auto moved = [&](double h) {
      PlateShape s = at;
      const ShapeRate& along = rate.direction[p];
      s.width += h * along.size[0];
      s.thickness += h * along.size[1];
      s.poissons_ratio += h * along.size[2];
      s.fold->place += h * along.fold.place;
      s.fold->angle += h * along.fold.angle;
      s.fold->radius += h * along.fold.radius;
      return PlateMesh(s);
    };
    const double h = p == 1 ? 1e-5 : p >= 5 ? 2e-5 : 1e-4;
    const PlateMesh plus = moved(h), minus = moved(-h), plus2 = moved(2 * h),
                    minus2 = moved(-2 * h);
    const auto compare = [&](const MatrixXd& found, auto part) {
      const MatrixXd d = (8 * (part(plus) - part(minus)) - (part(plus2) - part(minus2))) / (12 * h);
      CHECK((found - d).norm() <= 1e-8 * d.norm() + 1e-7 * part(mesh).norm() + 1e-12);
    };
    const PlateMeshRate::Shape& by = rate.shape[p];
    const int ny = mesh.elements_across();
    for (int i = 0; i < mesh.elements_along(); ++i)
      for (int j = 0; j < ny; ++j)
        compare(by.bending[i * ny + j],
                [&](const PlateMesh& m) { return MatrixXd(m.element(i, j).bending); });
    for (int i = 0; i < mesh.elements_along(); ++i)
      for (int j = 0; j < ny; ++j)
        compare(by.mass.empty() ? MatrixXd::Zero(16, 16) : MatrixXd(by.mass[i * ny + j]),
                [&](const PlateMesh& m) { return MatrixXd(m.element(i, j).mass); });
    for (int line = 0; line < mesh.lines(); ++line)
      compare(by.undeflected.empty() ? MatrixXd::Zero(mesh.functions_per_line(), 3)
                                     : by.undeflected[line],
              [&](const PlateMesh& m) { return m.undeflected(line); });
  }
}
