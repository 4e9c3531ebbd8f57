#include "core/mechanism/s_n_curve.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace flexopt;

namespace {

SnCurve table() {
  SnCurve curve;
  curve.points = {{1e4, 800e6}, {1e7, 450e6}, {1e9, 400e6}};
  return curve;
}

/// 4340 steel: N. E. Dowling, Mechanical Behavior of Materials, table 14.1: σf′ = 1758 MPa, b =
/// −0.0977.
SnCurve line() {
  SnCurve curve;
  curve.basquin = Basquin{1758e6, -0.0977};
  return curve;
}

}  // namespace

TEST_CASE("a life by Basquin is that worked by hand") {
  // 2N = (500/1758)^(-1/0.0977) = 3.516^10.23541 = 10^(0.546049*10.23541) = 10^5.58903
  const Life life = life_at(line(), 500e6);
  CHECK(life.log10_cycles == Approx(5.58903 - std::log10(2.0)).epsilon(2e-6));
  CHECK(life.slope == Approx(-1 / 0.0977));
  CHECK(life.range == LifeRange::within);
  CHECK(life_at(line(), 1758e6).log10_cycles == Approx(-std::log10(2.0)));
  CHECK(life_at(line(), 1758e6).range == LifeRange::short_of_curve);
}

TEST_CASE("a table is straight in log over log, through its points") {
  for (const SnCurve::Point& p : table().points) {
    CHECK(life_at(table(), p.amplitude).log10_cycles == Approx(std::log10(p.cycles)));
    CHECK(*strength_at(table(), p.cycles) == Approx(p.amplitude));
  }
  CHECK(*strength_at(table(), 1e8) == Approx(std::sqrt(450e6 * 400e6)));
  CHECK(life_at(table(), std::sqrt(450e6 * 400e6)).log10_cycles == Approx(8));
  CHECK_FALSE(strength_at(table(), 1e3));
  CHECK_FALSE(strength_at(table(), 1e10));
  CHECK(life_at(table(), 900e6).range == LifeRange::short_of_curve);
  CHECK(life_at(table(), 390e6).range == LifeRange::beyond_curve);
  CHECK_FALSE(endurance_of(table()));
}

TEST_CASE("below the knee is endurance, and the life goes on smoothly with the stress") {
  SnCurve curve = table();
  curve.knee = 1e8;
  const double knee = std::sqrt(450e6 * 400e6);
  CHECK(*endurance_of(curve) == Approx(knee));
  CHECK(*strength_at(curve, 1e12) == Approx(knee));
  CHECK(life_at(curve, 1.001 * knee).range == LifeRange::within);
  CHECK(life_at(curve, 0.999 * knee).range == LifeRange::without_end);
  CHECK(life_at(curve, 0.1 * knee).range == LifeRange::without_end);
  CHECK(life_at(curve, 0.999 * knee).slope == life_at(curve, 1.001 * knee).slope);
  SnCurve steep = line();
  steep.knee = 1e6;
  CHECK(life_at(steep, *endurance_of(steep)).log10_cycles == Approx(6));
}

TEST_CASE("the slope of a life is its derivative") {
  for (const SnCurve& curve : {table(), line()})
    for (const double s : {900e6, 600e6, 430e6, 350e6}) {
      const double h = 1e-4, up = life_at(curve, s * std::pow(10.0, h)).log10_cycles,
                   down = life_at(curve, s * std::pow(10.0, -h)).log10_cycles;
      CHECK(life_at(curve, s).slope == Approx((up - down) / (2 * h)).epsilon(1e-8));
      CHECK(life_at(curve, s).slope < 0);
    }
}
