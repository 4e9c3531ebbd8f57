#include "core/reduction/tube/kept_places.hpp"

#include <catch2/catch.hpp>

using namespace flexopt;

namespace {

TubeDynamics::Place place(double sigma, double axial = 2) {
  return {sigma, 0.01, -0.02, Vector3d(axial, 0.1, 0.3)};
}

}  // namespace

TEST_CASE("leaves that stand alike but for rounding share what was made for the first") {
  KeptPlaces<double> kept;
  int made = 0;
  const auto make = [&] { return 7.0 + made++; };
  CHECK(*kept.at(place(0.3), make) == 7);
  CHECK(*kept.at(place(0.3 + 1e-14, 2 - 1e-13), make) == 7);
  CHECK(made == 1);
  CHECK(*kept.at(place(0.3 + 1e-10), make) == 8);
  TubeDynamics::Place mirrored = place(0.3);
  mirrored.twist *= -1;
  CHECK(*kept.at(mirrored, make) == 9);
  kept = {};
  CHECK(*kept.at(place(0.3), make) == 10);
}

TEST_CASE("what is asked for of many places stays good when it is dropped") {
  KeptPlaces<double> kept;
  const auto first = kept.at(place(0.1), [] { return 1.0; });
  for (int i = 2; i < 12; ++i) (void)kept.at(place(0.1 * i), [&] { return 1.0 * i; });
  CHECK(*first == 1);
  CHECK(*kept.at(place(0.1), [] { return -1.0; }) == -1);       // made anew
  CHECK(*kept.at(place(0.1 * 11), [] { return -1.0; }) == 11);  // one of the last
}

TEST_CASE("at rest all that is alike is zero") {
  KeptPlaces<int> kept;
  CHECK(*kept.at({}, [] { return 1; }) == 1);
  CHECK(*kept.at({}, [] { return 2; }) == 1);
}
