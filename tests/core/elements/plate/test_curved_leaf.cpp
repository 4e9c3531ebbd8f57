// Leaves that are circular arcs when stress-free: laws, closed forms and derivatives.
#include <functional>

#include "core/elements/plate/beam_section.hpp"
#include "support/plate_laws.hpp"

using namespace flexopt;
using namespace flexopt::plate_laws;

namespace {

double notch(double s) { return 1 + 2 * (s - 0.45) * (s - 0.45); }

PlateShape shape(Flexure flexure, double angle, bool varies = false) {
  PlateShape s{.width = 0.4, .thickness = 0.01, .mesh = {6, 3}, .flexure = flexure, .curve = angle};
  if (varies) {
    s.width_profile = sampled(wave);
    s.thickness_profile = sampled(notch);
  }
  return s;
}

struct Case {
  Flexure flexure;
  bool varies;
};
const Case cases[] = {
    {Flexure::plate, false}, {Flexure::plate, true}, {Flexure::beam, false}, {Flexure::beam, true}};

/// The end of an arc of unit length that starts where the leaf does, in its direction.
EdgePose end_of_arc(const PlateMesh& mesh, double angle) {
  const ArcPoint<double> from = arc_point(angle, 0.0), to = arc_point(angle, 1.0);
  const Matrix3d turn = mesh.line_pose(0).axes * from.axes().transpose();
  return {turn * Vector3d(to.x, 0, to.z), turn * to.axes()};
}

/// From tip(0) to tip(1), the interior in equilibrium on the way.
void settle(PlateLeaf& leaf, const std::function<EdgePose(double)>& tip) {
  constexpr int steps = 40, most = 20;
  leaf.assemble();
  for (int k = 1; k <= steps; ++k) {
    const EdgePose to = tip(static_cast<double>(k) / steps);
    for (int iteration = 0; iteration == 0 || leaf.correction() > 1e-7; ++iteration) {
      REQUIRE(iteration < most);
      const EdgePose from = leaf.state().edges[1];
      Vector12d dq = Vector12d::Zero();
      dq.segment<3>(6) = to.position - from.position;
      dq.tail<3>() = rotation_log(to.axes * from.axes.transpose());
      leaf.step({leaf.state().edges[0], to}, leaf.internal_step(dq), dq);
      leaf.assemble();
    }
  }
}

}  // namespace

TEST_CASE("places on an arc and their coordinates are inverse to each other") {
  for (const double angle : {1e-6, 0.4, -0.4, 3.1})
    for (const double s : {0.0, 0.3, 1.0}) {
      const ArcPoint<double> p = arc_point(angle, s);
      const double height = 0.02;
      const auto at = arc_coordinates(angle, p.x - height * p.sine, p.z + height * p.cosine);
      CHECK(at.along == Approx(s).margin(1e-9));
      CHECK(at.height == Approx(height).margin(1e-9));
    }
  // a half circle of the length 1 has the diameter 2/π and the height 1/π
  const ArcPoint<double> top = arc_point(M_PI, 0.5), end = arc_point(M_PI, 1.0);
  CHECK(end.x == Approx(2 / M_PI));
  CHECK(std::abs(end.z) < 1e-15);
  CHECK(top.z == Approx(1 / M_PI));
}

TEST_CASE("a curved leaf is free of stress where it was made, and wherever it is moved rigidly") {
  for (const auto& [flexure, varies] : cases)
    for (const double angle : {0.5, -1.6, M_PI})
      check_rigid_motions(std::make_shared<PlateMesh>(shape(flexure, angle, varies)));
}

TEST_CASE("an arc of no angle is a flat leaf") {
  for (const auto& [flexure, varies] : cases) {
    PlateShape flat = shape(flexure, 0, varies);
    PlateLeaf arc(std::make_shared<PlateMesh>(flat));
    flat.curve.reset();
    PlateLeaf leaf(std::make_shared<PlateMesh>(flat));
    arc.assemble();
    leaf.assemble();
    CHECK((arc.tangent() - leaf.tangent()).norm() < 1e-11 * leaf.tangent().norm());
    CHECK((arc.residual() - leaf.residual()).norm() < 1e-8);
  }
}

TEST_CASE("force and tangent of a curved leaf are derivatives of its energy") {
  for (const auto& [flexure, varies] : cases) {
    const auto mesh = std::make_shared<PlateMesh>(shape(flexure, 1.2, varies));
    PlateLeaf leaf(mesh);
    const PlateLeaf::State state = random_state(*mesh, 3);
    check_interior_derivatives(leaf, state, random_direction(state.x.size(), 4));
    // and with the edges
    Vector6d way;
    way << 0.2, 0.5, -0.3, 0.3, -0.7, 0.4;
    const auto move_edge = [&](double h) {
      PlateLeaf::State moved = state;
      moved.edges[1].position += h * way.head<3>();
      moved.edges[1].axes = rotation_exp(h * way.tail<3>()) * state.edges[1].axes;
      leaf.set_state(moved);
      leaf.linearise();
      return leaf.energy();
    };
    const double work = test::slope_at_zero(move_edge, 5e-5);
    move_edge(0);
    CHECK(leaf.edge_force().tail<6>().dot(way) == Approx(work).epsilon(1e-7));
  }
}

TEST_CASE("an arc bends to another arc under a moment alone", "[slow]") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam})
    for (const double angle : {0.5, 1.0})
      for (const double other : {0.0, -0.7, 1.8}) {
        PlateShape s = shape(flexure, angle);
        s.mesh = {24, 3};
        s.poissons_ratio = 0;  // no bending across
        s.free_edge_torsion = false;
        const auto mesh = std::make_shared<PlateMesh>(s);
        PlateLeaf leaf(mesh);
        CAPTURE(static_cast<int>(flexure), angle, other);
        settle(leaf, [&](double at) { return end_of_arc(*mesh, angle + at * (other - angle)); });
        const double EI = mesh->bending_stiffness(), turn = other - angle;
        // The energy leaves open a stretch of (change of curvature × t)²/12. Here the places of the
        // ends forbid it: an axial force of EI turn² at most, and its moments.
        const double open = EI * turn * turn;
        CHECK(std::abs(leaf.energy() - 0.5 * EI * turn * turn) < 5e-4 * open);
        CHECK(std::abs(leaf.edge_force()[10] - EI * turn) < 1e-3 * open);
        CHECK(leaf.edge_force().segment<3>(6).norm() < 1.1 * open);
      }
}

TEST_CASE("stiffness of a ring segment in its plane") {
  for (const double angle : {0.3, M_PI / 2, M_PI})
    for (const double thickness : {0.005, 0.01}) {
      PlateShape s = shape(Flexure::beam, angle);
      s.thickness = thickness;
      s.mesh = {24, 1};
      const auto mesh = std::make_shared<PlateMesh>(s);
      PlateLeaf leaf(mesh);
      leaf.assemble();
      const double EI = mesh->bending_stiffness(), EA = 12 * EI / (thickness * thickness),
                   nu = s.poissons_ratio,
                   GA = 10 * (1 + nu) / (12 + 11 * nu) * shear_ratio(nu) * EA;
      const auto arc = [&](double at) { return arc_point(angle, at); };
      check_flexibility(flexibility(leaf, in_its_plane), flexibility_in_plane(arc, EI, EA, GA),
                        2e-4);
    }
}

TEST_CASE("stiffness of a ring segment out of its plane") {
  // a slender strip of which the ends warp: torsion, and bending in its own surface; and a wire
  for (const auto& [angle, circular] :
       {std::pair{0.6, false}, {M_PI / 2, false}, {M_PI, false}, {M_PI / 2, true}}) {
    PlateShape s{.width = circular ? 0.005 : 0.05, .thickness = 0.005, .mesh = {24, 1}};
    s.flexure = Flexure::beam;
    s.warping = Warping::free;
    s.section = circular ? Section::circular : Section::rectangular;
    s.curve = angle;
    const auto mesh = std::make_shared<PlateMesh>(s);
    PlateLeaf leaf(mesh);
    leaf.assemble();
    const BeamSection section = beam_section(s.section, s.width, 0.005, 0.3);
    const double per_D = 12 / std::pow(0.005, 3), GJ = per_D * section.J * shear_ratio(0.3),
                 EIs = per_D * section.I_strong,
                 GA = per_D * section.area * section.shear * shear_ratio(0.3);
    const ArcPoint<double> tip = arc_point(angle, 1.0);
    Matrix3d C = Matrix3d::Zero();
    constexpr int points = 2000;
    for (int k = 0; k < points; ++k) {
      const ArcPoint<double> p = arc_point(angle, (k + 0.5) / points);
      // of Fy, Mx and Mz at the tip: the moment at s, its parts along the arc and along the normal
      const Vector3d arm(tip.x - p.x, 0, tip.z - p.z), by_force = arm.cross(Vector3d::UnitY()),
                                                       along(p.cosine, 0, p.sine),
                                                       normal(-p.sine, 0, p.cosine);
      const Vector3d torque(by_force.dot(along), p.cosine, p.sine),
          bend(by_force.dot(normal), -p.sine, p.cosine), shear(1, 0, 0);
      C += (torque * torque.transpose() / GJ + bend * bend.transpose() / EIs +
            shear * shear.transpose() / GA) /
           points;
    }
    check_flexibility(flexibility(leaf, {7, 9, 11}), C, 5e-3);
  }
}

TEST_CASE("the compliance of an arc converges faster than the third power of its elements") {
  const auto compliance = [&](int along, bool shear) {
    PlateShape s = shape(Flexure::beam, M_PI / 2);
    s.mesh = {along, 1};
    s.transverse_shear = shear;
    PlateLeaf leaf(std::make_shared<PlateMesh>(s));
    leaf.assemble();
    return MatrixXd(leaf.tangent().bottomRightCorner<6, 6>().inverse());
  };
  for (const bool shear : {false, true}) {
    const MatrixXd fine = compliance(64, shear), coarse = compliance(8, shear),
                   twice = compliance(16, shear);
    for (const int i : {0, 2}) {  // of forces in its plane
      const double error = std::abs(coarse(i, i) / fine(i, i) - 1);
      CHECK(error > 1e-4);
      CHECK(error < 1e-2);
      // what (E12) adds has a slower part, 1e-5 of the compliance
      CHECK(std::abs(twice(i, i) / fine(i, i) - 1) < error / 8 + (shear ? 1e-5 : 0));
    }
  }
}

TEST_CASE("operators change along the angle of an arc as their differences do") {
  for (const auto& [flexure, varies] : cases) {
    std::vector<ProfileRate> directions{{{}, {}, 1.0}};
    if (varies) directions.push_back({sampled(wave), sampled(notch), 0.5});
    check_mesh_rate(shape(flexure, 0.9, varies), directions);
  }
}
