// Factors of shoulder fillets: worked by hand, against another fit of the same charts, their
// slopes.
#include "core/elements/leaf/fillet.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace flexopt;

TEST_CASE("factors of a fillet of half the thickness are those worked by hand") {
  // docs/stress.md: h/r = 4, sqrt(h/r) = 2, 2h/D = 0.8; C1 = 2.862 of both, C2 … C4:
  const double tension = 2.862 - 0.426 * 0.8 - 0.998 * 0.64 - 0.438 * 0.512,
               bending = 2.862 - 2.085 * 0.8 - 0.498 * 0.64 + 0.721 * 0.512;
  const NotchFactors k = fillet_factors(0.5);
  CHECK(k.membrane == Approx(tension).epsilon(1e-12));
  CHECK(k.bending == Approx(bending).epsilon(1e-12));
  CHECK(k.membrane == Approx(1.658).epsilon(1e-3));
  CHECK(k.bending == Approx(1.244).epsilon(1e-3));
}

TEST_CASE("factors of fillets agree with Pilkey's fit of Peterson's charts within 4 %") {
  // W. D. Pilkey, Peterson's Stress Concentration Factors, 2nd ed., charts 3.2a and 3.8a, h/r >= 2
  constexpr double tension[4][3] = {{1.020, 1.009, -0.048},
                                    {-0.065, -0.165, -0.007},
                                    {-3.459, 1.266, -0.016},
                                    {3.505, -2.109, 0.069}};
  constexpr double bending[4][3] = {{1.058, 1.002, -0.038},
                                    {-3.652, 1.639, -0.436},
                                    {6.170, -5.687, 1.175},
                                    {-2.558, 3.046, -0.701}};
  const auto factor = [](const double(&constants)[4][3], double u) {
    double sum = 0, power = 1;
    for (const auto& c : constants) {
      sum += power * (c[0] + c[1] * std::sqrt(u) + c[2] * u);
      power *= 0.8;
    }
    return sum;
  };
  for (const double r : {0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0}) {
    const NotchFactors k = fillet_factors(r);
    CHECK(k.membrane == Approx(factor(tension, 2 / r)).epsilon(0.04));
    CHECK(k.bending == Approx(factor(bending, 2 / r)).epsilon(0.02));
  }
}

TEST_CASE("factors of fillets fall with the radius, towards one, by their slopes") {
  NotchFactors before = fillet_factors(least_fillet);
  for (double r = 0.12; r <= largest_fillet; r += 0.02) {
    const NotchFactors k = fillet_factors(r), slope = fillet_factor_slopes(r);
    CHECK(k.bending > 1);
    CHECK(k.membrane > k.bending);
    // the two ranges of the formula meet at r = t within 4.4e-4
    CHECK(k.membrane < before.membrane + 5e-4);
    CHECK(k.bending < before.bending + 5e-4);
    before = k;
    if (std::abs(r - 1) < 0.01 || r + 1e-5 > largest_fillet) continue;
    constexpr double d = 1e-5;
    const NotchFactors up = fillet_factors(r + d), down = fillet_factors(r - d);
    CHECK(slope.membrane == Approx((up.membrane - down.membrane) / (2 * d)).epsilon(1e-6));
    CHECK(slope.bending == Approx((up.bending - down.bending) / (2 * d)).epsilon(1e-6));
  }
  CHECK(fillet_factors(largest_fillet).bending < 1.05);
}
