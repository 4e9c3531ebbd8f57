// The corner of an elastic fold against plane elasticity and the torsion of its section.
#include "core/mechanism/fold_corner.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "support/slopes.hpp"

using namespace flexopt;

namespace {

constexpr double degrees = M_PI / 180;

struct Corner {
  double turn, radius;       // [deg], over t
  double bending, twisting;  // s/t, s_xy/t
};

// tests/benchmarks/calculix/corner_in_plane.py: elements of t/500 at the inner corner, which are
// within 0.4 % of half as long ones.
const Corner corners[] = {
    {20, 0, 0.0026, -0.0036},    {60, 0, 0.0345, -0.0378},    {90, 0, 0.1202, -0.1087},
    {120, 0, 0.3689, -0.2954},   {130, 0, 0.5400, -0.4260},   {150, 0, 1.2769, -1.0255},
    {20, 0.2, 0.0012, -0.0010},  {45, 0.2, 0.0097, 0.0072},   {60, 0.2, 0.0262, 0.0258},
    {90, 0.2, 0.1233, 0.1301},   {120, 0.2, 0.4355, 0.4506},  {130, 0.2, 0.6575, 0.6753},
    {150, 0.2, 1.6352, 1.6586},  {160, 0.2, 2.9259, 2.9521},  {170, 0.2, 6.8903, 6.9192},
    {20, 0.35, 0.0012, -0.0005}, {45, 0.35, 0.0123, 0.0117},  {60, 0.35, 0.0343, 0.0360},
    {90, 0.35, 0.1588, 0.1665},  {120, 0.35, 0.5460, 0.5599}, {130, 0.35, 0.8183, 0.8342},
    {150, 0.35, 2.0110, 2.0310}, {160, 0.35, 3.5810, 3.6031}, {170, 0.35, 8.3976, 8.4217},
    {20, 0.5, 0.0012, -0.0001},  {45, 0.5, 0.0153, 0.0158},   {60, 0.5, 0.0429, 0.0455},
    {90, 0.5, 0.1938, 0.2014},   {120, 0.5, 0.6540, 0.6666},  {130, 0.5, 0.9759, 0.9901},
    {150, 0.5, 2.3822, 2.3997},  {160, 0.5, 4.2309, 4.2500},  {170, 0.5, 9.8990, 9.9198},
    {20, 1, 0.0017, 0.0013},     {45, 1, 0.0266, 0.0283},     {60, 1, 0.0719, 0.0751},
    {90, 1, 0.3070, 0.3133},     {120, 1, 1.0063, 1.0156},    {130, 1, 1.4920, 1.5023},
    {150, 1, 3.6074, 3.6198},    {160, 1, 6.3833, 6.3967},    {170, 1, 14.8885, 14.9029},
    {20, 2, 0.0033, 0.0035},     {45, 2, 0.0497, 0.0513},     {60, 2, 0.1285, 0.1310},
    {90, 2, 0.5271, 0.5314},     {120, 2, 1.6991, 1.7052},    {130, 2, 2.5109, 2.5176},
    {150, 2, 6.0411, 6.0489},    {160, 2, 10.6698, 10.6783},  {170, 2, 24.8474, 24.8564},
    {20, 5, 0.0091, 0.0094},     {45, 5, 0.1162, 0.1172},     {60, 5, 0.2927, 0.2941},
    {90, 5, 1.1758, 1.1780},     {120, 5, 3.7606, 3.7635},    {130, 5, 5.5486, 5.5518},
    {150, 5, 13.3191, 13.3229},  {160, 5, 23.5044, 23.5084},  {170, 5, 54.6971, 54.7014},
};

}  // namespace

TEST_CASE("a corner takes from its legs what plane elasticity and torsion say") {
  for (const Corner& c : corners) {
    CAPTURE(c.turn, c.radius);
    const double psi = c.turn * degrees;
    CHECK(corner_shortening(psi, c.radius, 1.0) == Approx(c.bending).epsilon(0.006).margin(0.006));
    CHECK(corner_shortening_of_twist(psi, c.radius, 1.0) ==
          Approx(c.twisting).epsilon(0.006).margin(0.006));
  }
}

TEST_CASE("a corner takes from its legs in proportion to its size, and nothing where it is flat") {
  for (const double radius : {0.0, 0.1, 0.7, 4.0}) {
    CHECK(corner_shortening(0.0, radius, 1.0) == 0);
    CHECK(corner_shortening_of_twist(0.0, radius, 1.0) == 0);
    CHECK(corner_cut(0.0, radius, 1.0) == 0);
    for (const double psi : {1e-200, 1e-9, 1e-3, 0.1, 1.0, 2.0, 3.0}) {
      const double s = corner_shortening(psi, radius, 1.0);
      CHECK(s >= 0);
      CHECK(s < corner_reach(psi, radius, 1.0));
      CHECK(std::abs(corner_shortening_of_twist(psi, radius, 1.0)) <
            corner_reach(psi, radius, 1.0));
      CHECK(corner_cut(psi, radius, 1.0) < corner_reach(psi, radius, 1.0));
      CHECK(corner_shortening(-psi, radius, 1.0) == s);
      CHECK(corner_shortening(psi, 0.003 * radius, 0.003) == Approx(0.003 * s));
    }
  }
}

TEST_CASE("what a corner takes changes as its differences do") {
  const auto all = [](auto angle, auto radius, auto thickness) {
    using S = decltype(angle);
    return std::array<S, 4>{corner_reach<S>(angle, radius, thickness),
                            corner_cut<S>(angle, radius, thickness),
                            corner_shortening<S>(angle, radius, thickness),
                            corner_shortening_of_twist<S>(angle, radius, thickness)};
  };
  for (const double psi : {-2.2, 0.04, 0.1001, 1.0, 2.7})
    for (const double radius : {0.05, 0.13, 1.0}) {
      using Number = Dual<3>;
      const std::array<double, 3> at{psi, radius, 0.9};
      const auto rates =
          all(Number::variable(at[0], 0), Number::variable(at[1], 1), Number::variable(at[2], 2));
      for (std::size_t k = 0; k < 3; ++k) {
        const auto moved = [&](double by) {
          auto x = at;
          x[k] += by;
          return all(x[0], x[1], x[2]);
        };
        for (std::size_t i = 0; i < 4; ++i) {
          CAPTURE(psi, radius, k, i);
          const double slope = test::slope_at_zero([&](double by) { return moved(by)[i]; }, 1e-4);
          CHECK(rates[i].derivatives[k] == Approx(slope).margin(1e-9).epsilon(1e-8));
        }
      }
    }
}
