#include "core/elements/plate/plate_stress.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/ridders.hpp"

using namespace flexopt;

namespace {

constexpr double E = 200e9, nu = 0.3;

PlateShape shape_of(double width, double thickness, double poissons_ratio = nu) {
  return {.width = width, .thickness = thickness, .poissons_ratio = poissons_ratio};
}

Strains strains(double e11, double e22, double g12, double k11 = 0, double k22 = 0,
                double k12 = 0) {
  return (Strains() << e11, e22, g12, k11, k22, k12).finished();
}

const std::vector<double> stations_x{0.05, 0.2, 0.4, 0.6, 0.8, 0.95},
    stations_y{-0.18, -0.06, 0.06, 0.18};

/// Strains that are bilinear in the place, with a part along the parameter p.
Strains bilinear(double x, double y, double p = 0) {
  Strains a = strains(1e-3, -3e-4, 2e-4, 0.5, -0.1, 0.05);
  const Strains b = strains(-4e-4, 1e-4, 1e-4, 0.3, 0.2, -0.1);
  const Strains c = strains(2e-4, 2e-4, -3e-4, -0.4, 0.1, 0.2);
  const Strains d = strains(1e-4, -2e-4, 1e-4, 0.2, -0.3, 0.1);
  a += p * strains(2e-4, 1e-4, -1e-4, 0.4, 0.1, -0.2);
  return a + x * b + y * c + x * y * d;
}

StrainField field(double p = 0) {
  std::vector<Strains> values;
  for (const double x : stations_x)
    for (const double y : stations_y) values.push_back(bilinear(x, y, p));
  return {stations_x, stations_y, values};
}

}  // namespace

TEST_CASE("uniaxial tension, shear and bending have their textbook von Mises stress") {
  const PlateShape shape = shape_of(0.4, 0.01);
  const auto stress = [&](const Strains& e, double side = 1) {
    return von_mises(section_stress(shape, e, E), side);
  };
  const Strains tension = strains(1e-3, -nu * 1e-3, 0);
  CHECK(stress(tension) == Approx(E * 1e-3));
  CHECK(stress(tension, -1) == Approx(E * 1e-3));
  CHECK(stress(strains(0, 0, 1e-3)) == Approx(std::sqrt(3.0) * E / (2 * (1 + nu)) * 1e-3));
  // bent to a cylinder, no curvature across: σ11 = E/(1 − ν²) ½ t κ, σ22 = ν σ11
  const double s11 = E / (1 - nu * nu) * 0.5 * 0.01 * 0.2;
  const Strains bending = strains(0, 0, 0, 0.2);
  CHECK(stress(bending) == Approx(s11 * std::sqrt(1 - nu + nu * nu)));
  CHECK(stress(bending, -1) == Approx(stress(bending)));
  // tension and bending add up on one side and cancel on the other
  const Strains both = strains(1e-3, -nu * 1e-3, 0, 0.2, -nu * 0.2, 0);
  CHECK(stress(both) + stress(both, -1) == Approx(2 * E * 1e-3));
  CHECK(std::abs(stress(both) - stress(both, -1)) == Approx(2 * E * 0.5 * 0.01 * 0.2));
}

TEST_CASE("a strain field gives bilinear strains exactly, beyond its stations too") {
  const StrainField f = field();
  for (const double x : {0.0, 0.05, 0.31, 0.95, 1.0})
    for (const double y : {-0.2, -0.1, 0.0, 0.18, 0.2})
      CHECK((f.at(x, y) - bilinear(x, y)).norm() < 1e-14);
}

TEST_CASE("the largest stress is that of its place, and no place outside the corners has more") {
  const PlateShape shape = shape_of(0.4, 0.01);
  const StrainField f = field();
  const StressPeak peak = plate_stress(f, shape, E, 3).largest();
  CHECK(peak.leaf == 3);
  const auto at = [&](double along, double across, double side) {
    return von_mises(section_stress(shape, f.at(along, (across - 0.5) * shape.width), E), side);
  };
  CHECK(peak.value == Approx(at(peak.along, peak.across, peak.on_positive_normal ? 1 : -1)));
  const double zone = 0.1 * shape.width;  // a tenth of the shorter side
  const auto in_corner = [&](double x, double y) {
    return std::min(x, 1 - x) < zone * (1 - 1e-9) &&
           std::min(y, 1 - y) * shape.width < zone * (1 - 1e-9);
  };
  CHECK_FALSE(in_corner(peak.along, peak.across));
  double most = 0;
  for (int i = 0; i <= 64; ++i)
    for (int j = 0; j <= 64; ++j)
      if (!in_corner(i / 64.0, j / 64.0))
        most = std::max({most, at(i / 64.0, j / 64.0, 1), at(i / 64.0, j / 64.0, -1)});
  CHECK(peak.value >= 0.99 * most);
  CHECK(peak.value <= 1.01 * most);
}

TEST_CASE("the largest of all places of large stress is the largest stress") {
  const PlateShape shape = shape_of(0.4, 0.01);
  // two humps along the leaf, on opposite surfaces
  std::vector<double> x;
  for (int i = 0; i <= 40; ++i) x.push_back(i / 40.0);
  std::vector<Strains> values;
  for (const double at : x)
    for (int j = 0; j < 4; ++j)
      values.push_back(strains(1e-4, 0, 0, 0.3 * std::sin(2 * 3.14159265358979 * at)));
  const StrainField f(x, stations_y, values);
  const std::vector<StressPeak> peaks = plate_stress(f, shape, E, 0).peaks();
  REQUIRE(peaks.size() >= 2);
  double most = 0;
  bool positive = false, negative = false;
  for (const StressPeak& p : peaks) {
    most = std::max(most, p.value);
    (p.on_positive_normal ? positive : negative) = true;
  }
  CHECK(positive);
  CHECK(negative);
  CHECK(most == Approx(plate_stress(f, shape, E, 0).largest().value));
}

TEST_CASE("the derivative of a stress peak is that of the stress at its station") {
  const double thickness_rate = 2e-3, poisson_rate = 0.05, modulus_rate = 30e9;
  const PlateShape shape = shape_of(0.4, 0.01);
  const StressPeak peak = plate_stress(field(), shape, E, 0).largest();
  const auto value = [&](double p) {
    const PlateShape moved = shape_of(0.4, 0.01 + p * thickness_rate, nu + p * poisson_rate);
    const SectionStress s = section_stress(
        moved, field(p).at(peak.along, (peak.across - 0.5) * 0.4), E + p * modulus_rate);
    return std::vector<double>{von_mises(s, peak.on_positive_normal ? 1 : -1)};
  };
  StressRate rate;
  rate.shape = Vector3d(0, thickness_rate, poisson_rate);
  rate.youngs_modulus = modulus_rate;
  const auto at_station = [](int i, int j) {
    const double x = stations_x[i], y = stations_y[j];
    return moving(bilinear(x, y), Strains(bilinear(x, y, 1) - bilinear(x, y)));
  };
  const double expected = ridders(value, 0, 0.05).value[0];
  REQUIRE(std::abs(expected) > 1e6);
  const std::vector<Dual1> along(stations_x.begin(), stations_x.end());
  const VectorXd rates = section_rates(shape, {along, stations_y, at_station},
                                       {{peak.along, peak.across_section}}, E, rate);
  CHECK(rates.dot(von_mises_slopes(peak)) == Approx(expected).epsilon(1e-8));
}
