// Mechanisms with curved leaves: against the elastica, turned and mirrored, reduced against full.
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

constexpr double deg = M_PI / 180;

LeafSpring curved(const Vector3d& base, const Vector3d& tip, double angle, double width,
                  double thickness) {
  const double chord = (tip - base).norm();
  LeafSpring l = models::leaf(base, tip - base, chord / sine_ratio(0.5 * angle), width, thickness);
  l.curve = angle;
  return l;
}

/// A rigid tip at O, turned about z.
Mechanism hinge(double chord, double angle, double width, double thickness) {
  Mechanism m{.bodies = {models::body({chord, 0, 0}, 0.3, 3e-4)},
              .leaves = {curved({0, 0, 0}, {chord, 0, 0}, angle, width, thickness)},
              .drives = {make_drive(Direction::rz)}};
  return m;
}

/// Two arcs that bulge away from each other, moved across.
Mechanism guide(double angle, double width, double thickness) {
  Mechanism m{.bodies = {models::body({0.08, 0, 0}, 0.3, 3e-4)},
              .drives = {make_drive(Direction::uy)}};
  for (const double y : {0.03, -0.03})
    m.leaves.push_back(curved({0, y, 0}, {0.08, y, 0}, y > 0 ? -angle : angle, width, thickness));
  return m;
}

/// Two arcs that cross, side by side.
Mechanism cross_hinge(double angle) {
  Mechanism m{.bodies = {models::body({0, 0, 0}, 0.3, 3e-4)},
              .drives = {make_drive(Direction::rz)}};
  for (const double side : {1.0, -1.0})
    m.leaves.push_back(curved({-0.02, -0.02 * side, 0.0105 * side},
                              {0.02, 0.02 * side, 0.0105 * side}, angle, 0.02, 3e-4));
  return m;
}

StrokeResponse evaluated(const Mechanism& m, const ModelOptions& model,
                         std::vector<double> points) {
  REQUIRE(check_rules(m));
  return test::evaluated(m, model, {.points = std::move(points), .frequencies = 4});
}

ModelOptions model_of(Accuracy accuracy, Flexure flexure = Flexure::plate) {
  return {.accuracy = accuracy, .flexure = flexure};
}

/// Largest relative difference of the answers that both have.
double difference(const StrokeResponse& a, const StrokeResponse& b) {
  double most = 0;
  const auto add = [&](double x, double y) { most = std::max(most, std::abs(x / y - 1)); };
  REQUIRE(a.path.size() == b.path.size());
  for (std::size_t i = 0; i < a.path.size(); ++i) {
    const PathPoint &p = a.path[i], &q = b.path[i];
    if (p.stroke != 0) add(p.drive_load, q.drive_load);
    add(p.drive_stiffness, q.drive_stiffness);
    for (int d = 0; d < 6; ++d)
      if (p.support_stiffness[d] && q.support_stiffness[d])
        add(*p.support_stiffness[d], *q.support_stiffness[d]);
    for (std::size_t k = 0; k < p.frequencies_locked.size(); ++k)
      add(p.frequencies_locked[k], q.frequencies_locked[k]);
  }
  return most;
}

}  // namespace

TEST_CASE("a curved beam under a moment bends from arc to arc") {
  const double chord = 0.06, angle = 60 * deg, width = 4e-3, thickness = 4e-4;
  const Mechanism m = hinge(chord, angle, width, thickness);
  const LeafSpring& leaf = m.leaves[0];
  const double EI = leaf.material.youngs_modulus * width * std::pow(thickness, 3) / 12;
  const StrokeResponse r = evaluated(m, model_of(Accuracy::full, Flexure::beam), {0, 20 * deg});
  const PathPoint& p = r.path[1];
  CHECK(std::abs(r.path[0].drive_load) < 1e-9 * p.drive_load);
  CHECK(p.drive_load == Approx(EI * 20 * deg / leaf.length).epsilon(1e-4));
  // this arc bulges to -y and the turn about +z bends it further, to 80 deg; its base stays
  const ArcPoint<double> end = arc_point(80 * deg, 1.0);
  const double turn = 10 * deg;  // of its chord
  const Vector3d tip = leaf.length * end.x * Vector3d(std::cos(turn), std::sin(turn), 0);
  CHECK((p.displacement - (tip - Vector3d(chord, 0, 0))).norm() < 1e-5 * chord);
  // E t/2 times the change of curvature
  CHECK(
      p.max_stress->value ==
      Approx(leaf.material.youngs_modulus * thickness / 2 * 20 * deg / leaf.length).epsilon(2e-3));
}

TEST_CASE("reduced curved leaves agree with full ones", "[slow]") {
  const auto compare = [](const Mechanism& m, const std::vector<double>& points, double tolerance) {
    const StrokeResponse reduced = evaluated(m, model_of(Accuracy::reduced), points),
                         full = evaluated(m, model_of(Accuracy::full), points);
    CHECK(difference(reduced, full) < tolerance);
    return reduced;
  };
  compare(hinge(0.06, 30 * deg, 0.02, 4e-4), {-20 * deg, -10 * deg, 0, 10 * deg, 20 * deg}, 2e-3);
  compare(hinge(0.06, -90 * deg, 0.02, 6e-4), {-20 * deg, 0, 20 * deg}, 2e-3);
  compare(guide(30 * deg, 0.02, 4e-4), {-2e-3, 0, 2e-3}, 2e-3);
  Mechanism along = guide(90 * deg, 0.02, 4e-4);  // pulled along the chords
  along.drives = {make_drive(Direction::ux)};
  compare(along, {-1e-3, -3e-4, 3e-4, 1e-3}, 4e-3);
  compare(cross_hinge(20 * deg), {-20 * deg, 0, 20 * deg}, 2e-3);
}

TEST_CASE("the mass of an undeflected arc is that of the deflected one at rest") {
  ModelOptions constant = model_of(Accuracy::full);
  constant.mass = LeafMass::constant;
  const Mechanism m = cross_hinge(50 * deg);
  const StrokeResponse a = evaluated(m, constant, {0}),
                       b = evaluated(m, model_of(Accuracy::full), {0});
  CHECK(difference(a, b) < 1e-9);
}

TEST_CASE("a point on an arc stands on it, and nowhere else") {
  const Mechanism m = hinge(0.06, 60 * deg, 0.02, 4e-4);
  const LeafSpring& leaf = m.leaves[0];
  const ArcPoint<double> at = leaf.middle(0.3);
  const Vector3d place =
      leaf.origin + leaf.axes * Vector3d(at.x * leaf.length, 4e-3, at.z * leaf.length);
  const auto probe = point_on_leaf(m, "p", place);
  REQUIRE(probe);
  CHECK(probe->along == Approx(0.3));
  CHECK(probe->across == Approx(0.7));
  CHECK_FALSE(point_on_leaf(m, "p", {0.03, 0, 0}));
  const StrokeResponse r = evaluate_stroke(m, model_of(Accuracy::full), {.named_points = {*probe}});
  CHECK(r.path[0].named_points[0].norm() < 1e-7 * 0.06);  // what the mesh's arc is off its circle
}
