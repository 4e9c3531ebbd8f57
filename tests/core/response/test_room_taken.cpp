// Envelope, clearance and mass of the leaves: closed forms, and derivatives at bent states.
#include "core/response/room_taken.hpp"

#include "core/mechanism/profile.hpp"
#include "core/response/quantities.hpp"
#include "core/response/solids.hpp"
#include "support/gradient_checks.hpp"

using namespace flexopt;

namespace {

const ModelOptions beams = models::beams(6);

StrokeResponse respond(const Mechanism& m, std::vector<double> points) {
  StrokeRequest request{.points = std::move(points),
                        .outputs = {Output::envelope, Output::moving_envelope, Output::clearance},
                        .newton = {.tolerance = 1e-12}};
  StrokeResponse response = test::evaluated(m, beams, request);
  return response;
}

BodyBoxT<double> cuboid(const Vector3d& center, const Vector3d& edges) {
  return {center, Matrix3d((0.5 * edges).asDiagonal())};
}

// A hinge of two unequal leaves with a payload's box and a stage's.
Mechanism lopsided(const test::Values& v) {
  Mechanism m = models::hinge(
      v[0], v[1], {{1, 0.5 * (v[3] + v[2]), v[2]}, {-0.9, -0.5 * (v[3] + 0.8 * v[2]), 0.8 * v[2]}});
  m.leaves[0].thickness_profile = {1, 1 + v[5]};
  m.bodies[0].box = cuboid({v[0] * 0.6, 0.003, 0.001}, {v[4], 2 * v[4], 3 * v[4]});
  return m;
}

}  // namespace

TEST_CASE("envelope, clearance and leaf mass of a parallel guide at rest") {
  const double L = 0.1, w = 0.03, t = 5e-4, b = 0.06;
  const PathPoint p = respond(models::guide(L, w, t, b), {0}).path[0];
  REQUIRE(p.envelope);
  CHECK(p.envelope->box[0] == Approx(L).epsilon(1e-12));
  CHECK(p.envelope->box[1] == Approx(b + t).epsilon(1e-12));
  CHECK(p.envelope->box[2] == Approx(w).epsilon(1e-12));
  // about the line along z through O, the middle of the tips
  CHECK(p.envelope->cylinder == Approx(2 * std::hypot(L, 0.5 * (b + t))).epsilon(1e-12));
  REQUIRE(p.clearance);
  CHECK(p.clearance->value == Approx(b - t).epsilon(1e-12));
  CHECK(*p.leaf_mass == Approx(2 * 7800 * L * w * t).epsilon(1e-12));
  CHECK(p.moving_envelope->box.isApprox(p.envelope->box, 1e-9));
}

TEST_CASE("the cylinder of a hinge stands about its axis of rotation") {
  Mechanism m = models::hinge(0.1, 3.5e-4, {{1, 0.011, 0.02}, {-1, -0.011, 0.02}});
  const Envelope at_rest = *respond(m, {0}).path[0].envelope;
  CHECK(at_rest.cylinder == Approx(2 * std::hypot(0.05, 0.5 * 3.5e-4)).epsilon(1e-12));
  CHECK(at_rest.box[2] == Approx(0.042).epsilon(1e-12));
  const Matrix3d R = Eigen::AngleAxisd(0.7, Vector3d(1, 1, 0).normalized()).toRotationMatrix();
  m = test::moved_as_a_whole(m, R);
  CHECK(respond(m, {0}).path[0].envelope->cylinder == Approx(at_rest.cylinder).epsilon(1e-12));
  CHECK((cylinder_axis(m).along - R.col(2)).norm() < 1e-15);
}

TEST_CASE("the distance of crossed leaves is their gap, at rest and when they are bent") {
  const double gap = 1e-3;
  const Mechanism m =
      models::hinge(0.1, 3.5e-4, {{1, 0.5 * (gap + 0.02), 0.02}, {-1, -0.5 * (gap + 0.02), 0.02}});
  for (const PathPoint& p : respond(m, {0, 0.1, 0.3}).path) {
    REQUIRE(p.clearance);
    CHECK(p.clearance->value == Approx(gap).epsilon(p.stroke == 0 ? 1e-9 : 0.02));
  }
}

TEST_CASE("over the stroke the envelope holds every state, the undeflected one too") {
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const StrokeResponse there = respond(m, {-0.02, 0.01}), one_way = respond(m, {0.01});
  const Envelope& moving = *there.path[0].moving_envelope;
  CHECK(moving.box[0] == Approx(0.1).epsilon(1e-4));
  // the tips of both leaves, 20 mm to one side and 10 mm to the other; no tilt to speak of
  CHECK(moving.box[1] == Approx(0.0605 + 0.03).epsilon(1e-3));
  CHECK(one_way.path[0].moving_envelope->box[1] == Approx(0.0605 + 0.01).epsilon(1e-3));
  CHECK(moving.box == there.path[1].moving_envelope->box);
  // the reach to the far side of O grows by the stroke; the leaf's roots stay where they are
  CHECK(moving.cylinder >= there.path[0].envelope->cylinder);
}

TEST_CASE("the furthest place between samples is found from either side of it") {
  // The base edge is not straight: along x by so much at its samples. The largest value of the
  // cubics lies between the second and the third, higher than the first.
  constexpr std::array<double, 5> height{3.3e-3, 2.4e-3, 0, -0.1, -0.4};
  const Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const auto reach = [&](bool image) {
    const Solids solids(m,
                        [&](int i, const std::vector<std::array<double, 2>>& points) {
                          std::vector<Vector3d> places;
                          for (const auto& [along, across] : points) {
                            const double from = image ? 1 - across : across;
                            places.push_back(undeflected_place(
                                m.leaves[static_cast<std::size_t>(i)], along, across));
                            if (i == 0)
                              places.back()[0] -=
                                  0.1 * (1 - along) *
                                  height[static_cast<std::size_t>(std::lround(4 * from))];
                          }
                          return places;
                        },
                        {{m.bodies[0].reference, Matrix3d::Identity()}});
    return -extents_of(solids).low[0];
  };
  CHECK(reach(false) > 2 * 0.1 * height[0]);
  CHECK(reach(true) == Approx(reach(false)).epsilon(1e-9));
}

TEST_CASE("two wires are apart by the distance of their lines less their diameter") {
  Mechanism m = models::guide(0.1, 1e-3, 1e-3);
  for (LeafSpring& l : m.leaves) l.section = Section::circular;
  // skew lines 3 mm apart that cross halfway
  m.leaves[0].axes.col(0) = Vector3d(1, 1, 0).normalized();
  m.leaves[1].axes.col(0) = Vector3d(1, -1, 0).normalized();
  for (LeafSpring& l : m.leaves) {
    l.axes.col(1) = Vector3d::UnitZ();
    l.axes.col(2) = l.axes.col(0).cross(Vector3d::UnitZ());
  }
  m.leaves[0].origin = Vector3d(0, 0, 0);
  m.leaves[1].origin = Vector3d(0, 0.05, 3e-3);
  const Solids solids = Solids::undeflected(m);
  const auto c = clearance_of(solids, {{0, 1}});
  REQUIRE(c);
  CHECK(c->value == Approx(2e-3).epsilon(1e-9));
  m.leaves[1].origin[2] = 0.4e-3;  // overlapping
  const auto over = clearance_of(Solids::undeflected(m), {{0, 1}});
  CHECK(over->value == Approx(0.4e-3 - 1e-3).epsilon(1e-9));
  const double volume = 2 * M_PI / 4 * 1e-6 * 0.1;
  CHECK(leaf_mass(m) == Approx(7800 * volume).epsilon(1e-9));
}

TEST_CASE("leaves and the box of a body that does not hold them are apart by what lies between") {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  RigidBody stage = models::body({0.05, 0.1, 0}, 0.1, 1e-5);
  stage.name = "stage";
  stage.box = cuboid({0.05, 0.06, 0}, {0.02, 0.04, 0.01});     // from y = 0.04 on; a leaf at 0.03
  m.bodies[0].box = cuboid({0.11, 0, 0}, {0.02, 0.08, 0.03});  // holds both leaves
  m.bodies.push_back(stage);
  const auto pairs = clearance_pairs(m);
  REQUIRE(pairs.size() == 3);  // of the leaves, and each with the stage
  const auto c = clearance_of(Solids::undeflected(m), pairs);
  CHECK(c->value == Approx(0.01 - 2.5e-4).epsilon(1e-12));
  CHECK(c->names == std::array<std::string, 2>{m.leaves[0].name, "stage"});
  // the leaf runs through the stage
  m.bodies[1].box->center[1] = 0.03;
  CHECK(clearance_of(Solids::undeflected(m), pairs)->value == 0);
}

TEST_CASE("leaves that are one piece at an edge or may cross are no pair") {
  Mechanism fold = models::guide(0.1, 0.03, 5e-4);
  fold.bodies.push_back(models::body({0.1, 0, 0}, 0, 0));
  fold.leaves[0] = models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4);
  fold.leaves[1] = models::leaf({0.1, 0, 0}, {0, 1, 0}, 0.1, 0.03, 5e-4);
  fold.leaves[0].tip = fold.leaves[1].base = 1;
  CHECK(clearance_pairs(fold).empty());
  // the halves of a leaf with a rigid middle
  fold.leaves[1] = models::leaf({0.15, 0, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4);
  fold.leaves[1].base = 1;
  CHECK(clearance_pairs(fold).empty());
  // the same edges on different bodies
  fold.leaves[1].base = ground;
  CHECK(clearance_pairs(fold).size() == 1);
  fold.leaves[0].may_cross = true;
  CHECK(clearance_pairs(fold).empty());
  CHECK_FALSE(clearance_of(Solids::undeflected(fold), {}));
}

TEST_CASE("the mass of a leaf is the integral of its section") {
  Mechanism m = models::single_leaf(0.1, 0.03, 5e-4);
  LeafSpring& l = m.leaves[0];
  l.width_profile = {1, 2};
  l.thickness_profile = {3, 1};
  // ∫ (1 + s)(3 − 2s) ds = 3 + 1/2 − 2/3
  CHECK(leaf_mass(m) == Approx(7800 * 0.1 * 0.03 * 5e-4 * (3.5 - 2.0 / 3)).epsilon(1e-12));
  l.width_profile.clear();
  l.thickness_profile.clear();
  for (const double s : profile_stations()) l.thickness_profile.push_back(1 + 4 * s * s);
  CHECK(leaf_mass(m) == Approx(7800 * 0.1 * 0.03 * 5e-4 * (1 + 4.0 / 3)).epsilon(1e-12));
}

TEST_CASE("a curved leaf takes the room of its arc, and weighs what its length does") {
  Mechanism m = models::single_leaf(0.1, 0.03, 5e-4);
  LeafSpring& l = m.leaves[0];
  const double angle = 1.2, radius = 0.1 / angle, t = 5e-4;
  l.curve = angle;
  m.bodies[0].reference = l.tip_middle();
  const Solids solids = Solids::undeflected(m);
  CHECK(leaf_mass(m) == Approx(7800 * 0.1 * 0.03 * t).epsilon(1e-12));
  const Extents extents = extents_of(solids);
  const Vector3d box = envelope_of({&extents}).box;
  const double high = radius * (1 - std::cos(angle / 2)) + t / 2 * (1 + std::cos(angle / 2)),
               wide = 2 * radius * std::sin(angle / 2) + t * std::sin(angle / 2);
  std::array<double, 3> sizes{box[0], box[1], box[2]}, expected{wide, high, 0.03};
  std::ranges::sort(sizes);
  std::ranges::sort(expected);
  for (std::size_t i = 0; i < 3; ++i) CHECK(sizes[i] == Approx(expected[i]).epsilon(1e-5));
}

TEST_CASE("envelopes, clearance and leaf mass follow the parameters as their differences do") {
  StrokeRequest request{.points = {0.2, 0.45},
                        .outputs = {Output::envelope, Output::moving_envelope, Output::clearance}};
  const std::vector<test::Number> numbers{{"length", 0.1}, {"thickness", 4e-4}, {"width", 0.02},
                                          {"gap", 1.3e-3}, {"box", 0.012},      {"taper", 0.3}};
  const test::Family family{lopsided, numbers, {0, 1, 2, 3, 4, 5}, 0.1};
  CHECK(test::check_gradients(family, beams, request) >= 6 * 2 * 10);
  const ModelOptions plates{.accuracy = Accuracy::reduced, .mesh = {4, 2}};
  request.points = {0.3};
  CHECK(test::check_gradients({lopsided, numbers, {0, 3}, 0.1}, plates, request) >= 2 * 10);
}

TEST_CASE("each leg of a folded leaf is a solid of its own") {
  // legs of 60 mm along x and 40 mm along y
  Mechanism m = models::single_leaf(0.1, 0.03, 5e-4);
  m.leaves[0].fold = LeafFold{0.6, -0.5 * M_PI};
  m.bodies[0].reference = m.bodies[0].center_of_mass = {0.06, 0.04, 0};
  m.drives = {make_drive(Direction::ux)};
  const Solids solids = Solids::undeflected(m);
  REQUIRE(solids.count() == 2);
  REQUIRE((m.leaves[0].tip_middle() - Vector3d(0.06, 0.04, 0)).norm() < 1e-15);
  CHECK((solids.middle_place(0, 0.3, 0.5) - Vector3d(0.03, 0, 0)).norm() < 1e-15);
  CHECK((solids.middle_place(0, 0.8, 0.5) - Vector3d(0.06, 0.02, 0)).norm() < 1e-15);
  CHECK(clearance_pairs(m).empty());  // the legs are one piece
  const PathPoint p = respond(m, {0, 1e-3}).path[0];
  REQUIRE(p.envelope);
  // half the thickness beyond the fold and below the first leg
  CHECK((p.envelope->box - Vector3d(0.06 + 2.5e-4, 0.04 + 2.5e-4, 0.03)).norm() < 1e-12);

  // without what an arc of 1.5 t about a right angle cuts off; a mitred corner is a whole one
  CHECK(*p.leaf_mass == Approx(7800 * 0.1 * 0.03 * 5e-4).epsilon(1e-12));
  Mechanism bent = m;
  bent.leaves[0].fold->radius = 5e-4 / 0.1;
  CHECK(leaf_mass(bent) ==
        Approx(7800 * (0.1 - 2 * 7.5e-4 * (1 - M_PI / 4)) * 0.03 * 5e-4).epsilon(1e-12));

  // a straight leaf 12 mm beside the second leg, far from the first
  m.leaves.push_back(models::leaf({0.072, 0.02, 0}, {0, 1, 0}, 0.05, 0.03, 5e-4));
  m.leaves[1].tip = 0;
  m.bodies.front().reference = {0.06, 0.04, 0};
  const auto pairs = clearance_pairs(m);
  REQUIRE(pairs.size() == 2);
  const auto c = clearance_of(Solids::undeflected(m), pairs);
  CHECK(c->value == Approx(0.012 - 5e-4).epsilon(1e-12));
  CHECK(c->names[0] == m.leaves[0].name);
}

TEST_CASE("of nearly equally far ends the one beside which a leaf reaches furthest is found") {
  // An edge that rises towards d/24 beside one end, and falls at once from the other.
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  m.leaves.resize(1);
  const double L = m.leaves[0].length, w = m.leaves[0].width, d = 1e-5;
  for (const double other : {-1e-16, 0.0, 1e-16, 2e-9, 2e-7})
    for (const bool turned : {false, true}) {
      const auto edge = [&](double along) {
        const auto station = std::lround(20 * (turned ? 1 - along : along));
        return station == 0 ? 0 : station == 1 ? -d : station == 20 ? other : -5 * d;
      };
      const auto places = [&](int, const std::vector<std::array<double, 2>>& points) {
        std::vector<Vector3d> result;
        for (const auto& [along, across] : points)
          result.emplace_back(along * L, (across - 0.5) * w + edge(along), 0);
        return result;
      };
      std::vector<JointBody> bodies;
      for (const RigidBody& body : m.bodies) bodies.push_back({body.reference});
      const Extents extents = extents_of(Solids(m, places, bodies));
      CHECK(extents.high[1] == Approx(0.5 * w + d / 24).epsilon(1e-12));
    }
}
