// Exact derivatives with respect to sizes and factors of leaves with profiles, against differences.
#include "core/mechanism/profile.hpp"
#include "support/gradient_checks.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::vector<Number> parameters{{"length", 0.1},  {"width", 0.03}, {"thickness", 0.5e-3},
                                     {"poisson", 0.3}, {"taper", 0.6},  {"notch", 1.2},
                                     {"place", 0.45},  {"along", 0.62}};

/// A taper of the width, a notch of the thickness.
void set_profiles(LeafSpring& l, const Values& p) {
  for (const double s : profile_stations()) {
    l.width_profile.push_back(1 - (1 - p[4]) * s * s);
    l.thickness_profile.push_back(1 + p[5] * (s - p[6]) * (s - p[6]));
  }
}

Mechanism guide(const Values& p, bool linear) {
  const Material material{"steel", 2e11, p[3], 7800, {}};
  Mechanism m{.bodies = {models::body({p[0], 0.001, 0.002}, 0.4, 3e-4)},
              .drives = {make_drive(Direction::uy)}};
  for (const double y : {0.03, -0.03}) {
    LeafSpring l = models::leaf({0, y, 0}, {1, 0.02, 0}, p[0], p[1], p[2], material);
    if (linear) {
      l.width_profile = {1, p[4]};
      l.thickness_profile = {p[5], 1};
    } else {
      set_profiles(l, p);
    }
    m.leaves.push_back(l);
  }
  return m;
}

void check(bool linear, Flexure flexure, Accuracy accuracy, std::vector<std::size_t> along) {
  check_loaded_guide({[&](const Values& p) { return guide(p, linear); }, parameters, along, 10.0},
                     flexure, accuracy, 0.012);
}

}  // namespace

TEST_CASE("gradients of tapered leaves agree with differences", "[slow]") {
  check(true, Flexure::beam, Accuracy::full, {0, 1, 2, 4, 5});
  check(true, Flexure::plate, Accuracy::full, {1, 3, 4, 5});
}

TEST_CASE("gradients of leaves with a profile agree with differences", "[slow]") {
  check(false, Flexure::beam, Accuracy::full, {2, 4, 5, 6});
  check(false, Flexure::plate, Accuracy::full, {2, 4, 6});
}

TEST_CASE("gradients of the default method with profiles agree with differences") {
  check(false, Flexure::plate, Accuracy::reduced, {4, 5});
}

TEST_CASE("gradients of a driven point of a leaf with profiles agree with differences") {
  const auto make = [](const Values& p) {
    LeafSpring l = models::leaf({0, 0, 0}, {1, 0, 0}, p[0], p[1], p[2]);
    set_profiles(l, p);
    const double width = p[1] * (1 - (1 - p[4]) * p[7] * p[7]);
    return driven_point(l, p[7], 0.4, {p[7] * p[0], 0, -0.1 * width});
  };
  check_driven_point({make, parameters, {1, 4, 5, 6, 7}, 10.0});
}
