// Leaves whose thickness varies steeply: transverse shear takes no more energy than the bending
// has, and strains that vary with the section cost nothing beyond the section's own stiffness.
#include "core/mechanism/profile.hpp"
#include "tip_stiffness.hpp"

using namespace flexopt;

namespace {

/// Of a notch between two rigid ends, about its middle.
double stiffness(const LeafSpring& leaf, Direction along, Others others, int elements) {
  return tip_stiffness(
      leaf, 0.5 * leaf.length, along, others,
      {.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {elements, 1}});
}

/// A circular or parabolic notch as deep as its half length.
LeafSpring notch(double ratio, bool circular) {
  constexpr double radius = 2e-3;
  LeafSpring leaf = models::leaf({0, 0, 0}, {1, 0, 0}, 2 * radius, 5 * radius, ratio * radius);
  for (const double s : profile_stations()) {
    const double x = 2 * s - 1, cut = circular ? 1 - std::sqrt(1 - x * x) : x * x;
    leaf.thickness_profile.push_back(1 + 2 / ratio * cut);
  }
  return leaf;
}

template <class F>
double integral(const LeafSpring& leaf, const F& density) {
  constexpr int samples = 20000;
  double sum = 0;
  for (int k = 0; k < samples; ++k) {
    const double s = (k + 0.5) / samples;
    sum += density(s, leaf.thickness * profile_at(leaf.thickness_profile, s));
  }
  return sum * leaf.length / samples;
}

}  // namespace

TEST_CASE("a beam of any thickness profile stretches by the integral of its sections on any mesh") {
  const double ratio = GENERATE(0.05, 0.1, 0.3, 0.5, 1.0);
  const bool circular = GENERATE(true, false);
  const LeafSpring leaf = notch(ratio, circular);
  const double E = leaf.material.youngs_modulus, w = leaf.width,
               exact = 1 / integral(leaf, [&](double, double t) { return 1 / (E * w * t); });
  for (const int along : {12, 24, 48}) {
    CAPTURE(ratio, circular, along);
    CHECK(stiffness(leaf, Direction::ux, Others::held, along) == Approx(exact).epsilon(1e-3));
  }
}

TEST_CASE("a beam of any thickness profile turns in its plane as its sections do") {
  const double ratio = GENERATE(0.05, 0.1, 0.3);
  const LeafSpring leaf = notch(ratio, GENERATE(true, false));
  const double E = leaf.material.youngs_modulus, w = leaf.width,
               exact =
                   1 / integral(leaf, [&](double, double t) { return 12 / (E * w * w * w * t); });
  CAPTURE(ratio);
  // the gradients of the shear soften it by (t/w)² of those of the bending
  CHECK(stiffness(leaf, Direction::ry, Others::free, 24) == Approx(exact).epsilon(0.02));
}

TEST_CASE("thick leaves whose thickness varies steeply are stable at rest") {
  Mechanism mechanism = models::single_leaf(0.1, GENERATE(0.05, 0.2), 4e-3, Direction::rz);
  LeafSpring& leaf = mechanism.leaves.front();
  // a notch: 4 mm in the middle, 64 mm at both ends
  for (const double s : profile_stations())
    leaf.thickness_profile.push_back(1 + 15 * (1 - std::sqrt(1 - std::pow(2 * s - 1, 2))));
  const ModelOptions model{
      .accuracy = Accuracy::full,
      .flexure = GENERATE(Flexure::plate, Flexure::beam),
      .mesh = GENERATE(std::array{6, 2}, std::array{10, 4}, std::array{20, 8})};
  System system(mechanism, make_full_leaves(mechanism, model));
  system.assemble();
  CHECK(negative_pivots(system, true) == 0);
  CHECK(negative_pivots(system, false) == 0);
}
