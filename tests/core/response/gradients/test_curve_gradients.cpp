// Exact derivatives with respect to the angle and the sizes of curved leaves, against differences.
#include "core/mechanism/profile.hpp"
#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::vector<Number> parameters{{"chord", 0.1},   {"width", 0.03}, {"thickness", 0.5e-3},
                                     {"poisson", 0.3}, {"angle", 0.7},  {"tilt", 0.2},
                                     {"taper", 0.6},   {"along", 0.6}};

LeafSpring curved(const Vector3d& base, const Vector3d& along, const Values& p, double angle,
                  const Material& material) {
  LeafSpring l = models::leaf(base, along, p[0] / sine_ratio(0.5 * angle), p[1], p[2], material);
  l.curve = angle;
  return l;
}

/// Two arcs that bulge outwards, each with a taper if asked for.
Mechanism guide(const Values& p, bool varies) {
  const Material material{"steel", 2e11, p[3], 7800, {}};
  Mechanism m{.bodies = {models::body({p[0], 0.001, 0.002}, 0.4, 3e-4)},
              .drives = {make_drive(Direction::uy)}};
  for (const double side : {1.0, -1.0}) {
    LeafSpring l = curved({0, 0.03 * side, 0}, {1, p[5] * side, 0}, p, side * p[4], material);
    if (varies) {
      l.width_profile = {1, p[6]};
      l.thickness_profile = {1.2, 1};
    }
    m.leaves.push_back(l);
  }
  return m;
}

void check(bool varies, Flexure flexure, Accuracy accuracy, std::vector<std::size_t> along) {
  check_loaded_guide({[&](const Values& p) { return guide(p, varies); }, parameters, along, 10.0},
                     flexure, accuracy, 0.008);
}

}  // namespace

TEST_CASE("gradients of curved leaves agree with differences", "[slow]") {
  check(false, Flexure::beam, Accuracy::full, {0, 1, 2, 4, 5});
  check(false, Flexure::plate, Accuracy::full, {0, 1, 2, 3, 4, 5});
}

TEST_CASE("gradients of curved leaves that taper agree with differences", "[slow]") {
  check(true, Flexure::beam, Accuracy::full, {2, 4, 6});
  check(true, Flexure::plate, Accuracy::full, {2, 4, 6});
}

TEST_CASE("gradients of the default method with curved leaves agree with differences", "[slow]") {
  check(false, Flexure::plate, Accuracy::reduced, {2, 4});
}

TEST_CASE("gradients of a driven point of a curved leaf agree with differences", "[slow]") {
  const auto make = [](const Values& p) {
    const LeafSpring l =
        curved({0, 0, 0}, {1, 0, 0}, p, p[4], Material{"steel", 2e11, p[3], 7800, {}});
    const ArcPoint<double> at = l.middle(p[7]);
    return driven_point(
        l, p[7], 0.4, l.origin + l.axes * Vector3d(l.length * at.x, -0.1 * p[1], l.length * at.z));
  };
  check_driven_point({make, parameters, {0, 1, 2, 4, 7}, 10.0});
}
