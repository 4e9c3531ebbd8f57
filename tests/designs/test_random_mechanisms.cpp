// Laws that every mechanism keeps, for random design files: trees and loops of bodies, leaves
// of all kinds, joints, springs, bushings, frames, repeats and mirrored parts.
#include <algorithm>
#include <catch2/catch.hpp>

#include "support/mechanism_laws.hpp"
#include "support/nightly.hpp"
#include "support/temporary_folder.hpp"

using namespace flexopt;

namespace {

constexpr int count = 200;
const int checked = test::nightly() ? count : 40;

double limit(const laws::Deviation& d, bool reduced) {
  return std::max(1e-10, laws::known(d, reduced));
}

/// A law of the mechanisms of so many seeds; how many keep it to 1e-10.
template <class Law, class Limit>
int check_each(int seeds, const Law& law, const Limit& limit_of) {
  const test::TemporaryFolder folder;
  int exact = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const laws::Deviation d = law(random_design(seed, folder.path()), seed);
    INFO("seed " << seed << ": " << d.what);
    CHECK(d.size <= limit_of(d, seed));
    exact += d.size < 1e-10;
  }
  return exact;
}

/// Of a mechanism that is moved, mirrored before across the axis that the seed has in `mirrors`.
int check_moved(const std::string& mirrors) {
  return check_each(
      checked,
      [&](const RandomDesign& design, int seed) {
        const std::string mirror = mirrors.empty() ? "" : mirrors.substr(seed % 3, 1);
        return laws::motion_of_the_whole(design, seed, mirror, laws::coarse(seed, seed % 10 == 0));
      },
      [](const laws::Deviation& d, int seed) { return limit(d, seed % 10 == 0); });
}

}  // namespace

TEST_CASE("random mechanisms are of all kinds") {
  const test::TemporaryFolder folder;
  int leaves = 0, wires = 0, profiles = 0, joints = 0, springs = 0, bushings = 0, loops = 0,
      several = 0, massless = 0, held = 0, turned = 0, mirrored = 0, repeats = 0, nested = 0,
      curves = 0, folds = 0, points = 0, driven_points = 0;
  for (int seed = 0; seed < count; ++seed) {
    const RandomDesign design = random_design(seed, folder.path());
    const Mechanism m = design.make();
    leaves += static_cast<int>(m.leaves.size());
    for (const LeafSpring& leaf : m.leaves) {
      wires += leaf.section == Section::circular;
      curves += leaf.curve.has_value();
      folds += leaf.fold.has_value();
      points += leaf.point.has_value();
      profiles += !leaf.thickness_profile.empty() || !leaf.width_profile.empty();
    }
    joints += !design.document["joints"].empty();
    for (const Joint& joint : m.joints) turned += is_held(joint.type);
    driven_points += design.driven == "point";
    for (const Spring& spring : m.springs) (spring.matrix ? bushings : springs) += 1;
    loops += m.leaves.size() > m.bodies.size();
    several += m.bodies.size() > 3;
    for (const RigidBody& body : m.bodies) {
      massless += body.mass == 0;
      for (const bool still : body.held) held += still;
    }
    for (const auto& part : design.document["parts"]) mirrored += part.contains("mirror");
    for (const auto& frame : design.document["frames"]) {
      repeats += frame.contains("repeat");
      nested += frame.contains("in");
    }
  }
  CHECK(leaves > 3 * count / 2);
  for (const int number : {wires, profiles, joints, springs, bushings, loops, several, massless,
                           held, mirrored, repeats, nested, curves, folds, points, driven_points})
    CHECK(number >= 5);
  CHECK(turned > 0);
}

TEST_CASE("a random mechanism written flat, or without repeats, is the same to the last bit") {
  check_each(
      count, [](const RandomDesign& design, int) { return laws::ways_of_writing(design); },
      [](const laws::Deviation&, int) { return 0.0; });
}

TEST_CASE("every number of a random mechanism has its exact derivatives", "[slow]") {
  check_each(
      checked, [](const RandomDesign& design, int) { return laws::derivatives(design); },
      [](const laws::Deviation&, int) { return 1e-8; });
}

TEST_CASE("a random mechanism moved as a whole answers as before", "[slow]") {
  CHECK(check_moved("") > checked / 4);
}

TEST_CASE("a mirrored random mechanism has the mirrored answers", "[slow]") { check_moved("xyz"); }

TEST_CASE("a random mechanism's force is its energy's gradient, the tangent the Hessian",
          "[slow]") {
  check_each(
      checked,
      [](const RandomDesign& design, int seed) {
        return laws::energy(design, seed, laws::coarse(seed, false));
      },
      [](const laws::Deviation& d, int) {
        return std::max(2e-7, laws::known(d, false));  // rounding of energies
      });
}
