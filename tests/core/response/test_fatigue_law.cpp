// What a cycle does to a material: worked by hand, its laws, its derivatives.
#include "core/response/stress_safety.hpp"

#include <catch2/catch.hpp>

#include "support/models.hpp"

using namespace flexopt;

namespace {

Material strong() {
  Material m = models::steel();
  m.yield_strength = 1400e6;
  m.ultimate_strength = 1700e6;
  m.endurance_limit = 500e6;
  return m;
}

constexpr std::array rules{MeanStress::goodman, MeanStress::gerber, MeanStress::soderberg};

FatigueRule rule_of(MeanStress mean) {
  return {.stress_ratio = {}, .mean_stress = mean, .cycles = {}};
}

/// Largest stress of a cycle with the stress ratio R that the material endures [Pa].
double strength(const Material& m, double R, MeanStress mean) {
  return 1 / FatigueLaw(m, {R, mean}).use(0.5 * (1 - R), 0.5 * (1 + R)).value;
}

}  // namespace

TEST_CASE("safety of a pulsating stress is that worked by hand") {
  // 100 ± 100 MPa: Goodman 1/(0.2 + 0.0588235), Soderberg 1/(0.2 + 0.0714286),
  // Gerber 1/(0.1 + √(0.01 + 0.0588235²))
  const Material m = strong();
  const auto safety = [&](MeanStress mean) {
    return 1 / FatigueLaw(m, rule_of(mean)).use(100e6, 100e6).value;
  };
  CHECK(safety(MeanStress::goodman) == Approx(3.863636).epsilon(1e-6));
  CHECK(safety(MeanStress::soderberg) == Approx(3.684211).epsilon(1e-6));
  CHECK(safety(MeanStress::gerber) == Approx(4.629241).epsilon(1e-6));
  // N. E. Dowling, Mechanical Behavior of Materials, on mean stress: σar = σa/(1 − σm/σu)
  const auto reversed = [&](MeanStress mean) {
    return FatigueLaw(m, rule_of(mean)).reversed(100e6, 100e6)->value;
  };
  CHECK(reversed(MeanStress::goodman) == Approx(106.25e6));
  CHECK(reversed(MeanStress::gerber) == Approx(100e6 / (1 - 1 / 289.0)));
  CHECK(reversed(MeanStress::soderberg) == Approx(100e6 / (1 - 1 / 14.0)));
}

TEST_CASE("a cycle times its safety is on the line") {
  const Material m = strong();
  for (const MeanStress mean : rules)
    for (const double a : {0.0, 80e6, 600e6})
      for (const double mid : {-300e6, 0.0, 1e6, 400e6}) {
        const FatigueLaw law(m, rule_of(mean));
        const double use = law.use(a, mid).value;
        if (use == 0) continue;
        CHECK(law.use(a / use, mid / use).value == Approx(1));
        if (a > 0) CHECK(law.reversed(a / use, mid / use)->value == Approx(500e6));
      }
}

TEST_CASE("compression counts as no mean, and a mean beyond its limit has no amplitude") {
  const Material m = strong();
  for (const MeanStress mean : rules) {
    const FatigueLaw law(m, rule_of(mean));
    CHECK(law.use(100e6, -200e6).value == law.use(100e6, 0).value);
    CHECK(law.reversed(100e6, -200e6)->value == 100e6);
    CHECK_FALSE(law.reversed(1e6, law.limit()));
    CHECK(law.reversed(1e6, 0.99 * law.limit()));
  }
}

TEST_CASE("derivatives of use and reversed amplitude agree with differences") {
  const Material m = strong();
  for (const MeanStress mean : rules)
    for (const double mid : {-50e6, 30e6, 700e6}) {
      const FatigueLaw law(m, rule_of(mean));
      const double a = 120e6, h = 1e3;
      const auto check = [&](const auto& of) {
        const FatigueLaw::Answer here = of(a, mid);
        CHECK(here.per_amplitude ==
              Approx((of(a + h, mid).value - of(a - h, mid).value) / (2 * h)).epsilon(1e-7));
        CHECK(here.per_mean ==
              Approx((of(a, mid + h).value - of(a, mid - h).value) / (2 * h)).epsilon(1e-7));
      };
      check([&](double x, double y) { return law.use(x, y); });
      check([&](double x, double y) { return *law.reversed(x, y); });
    }
}

TEST_CASE("what a cycle of a stress ratio may reach is that of Goodman and Gerber") {
  const Material m = strong();
  CHECK(strength(m, -1, MeanStress::goodman) == Approx(500e6));
  CHECK(strength(m, -1, MeanStress::gerber) == Approx(500e6));
  CHECK(strength(m, 0, MeanStress::goodman) == Approx(772.73e6).epsilon(1e-5));
  CHECK(strength(m, 0, MeanStress::gerber) == Approx(925.8e6).epsilon(1e-3));
  for (const double ratio : {-0.7, 0.0, 0.4, 0.9}) {
    const double goodman = strength(m, ratio, MeanStress::goodman),
                 gerber = strength(m, ratio, MeanStress::gerber);
    const auto share = [&](double s, double power) {
      return 0.5 * s * (1 - ratio) / 500e6 + std::pow(0.5 * s * (1 + ratio) / 1700e6, power);
    };
    CHECK(share(goodman, 1) == Approx(1).epsilon(1e-12));
    CHECK(share(gerber, 2) == Approx(1).epsilon(1e-12));
    CHECK(gerber > goodman);
    CHECK(gerber < 1700e6 * (1 + 1e-12));
  }
}

TEST_CASE("what a material lacks is said") {
  Material m = strong();
  CHECK(suffices_for_fatigue(m, {}));
  CHECK(why_not(suffices_for_life(m, {})) == "s_n_curve");
  m.ultimate_strength.reset();
  CHECK(why_not(suffices_for_fatigue(m, {})) == "ultimate_strength");
  CHECK(suffices_for_fatigue(m, {-1}));
  CHECK(why_not(suffices_for_fatigue(m, {0})) == "ultimate_strength");
  CHECK(suffices_for_fatigue(m, rule_of(MeanStress::soderberg)));
  m = strong();
  FatigueRule cycles;
  cycles.cycles = 1e8;
  CHECK(why_not(suffices_for_fatigue(m, cycles)) == "s_n_curve");
  m.s_n_curve.emplace().points = {{1e4, 800e6}, {1e7, 450e6}};
  CHECK(why_not(suffices_for_fatigue(m, cycles)) == "s_n_curve that tells of 1e+08 cycles");
  m.s_n_curve->knee = 1e7;
  CHECK(suffices_for_fatigue(m, cycles));
  CHECK(FatigueLaw(m, cycles).use(450e6, 0).value == Approx(1));
  m.endurance_limit.reset();
  CHECK(FatigueLaw(m, {}).use(450e6, 0).value == Approx(1));
  m.s_n_curve->knee.reset();
  CHECK(why_not(suffices_for_fatigue(m, {})) == "endurance_limit, or s_n_curve with a knee");
  CHECK(suffices_for_life(m, {}));
}
