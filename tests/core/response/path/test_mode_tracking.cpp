// Modes are followed along the path by their motions:
// core/response/path/mode_tracking.cpp.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/ridders.hpp"
#include "core/response/path/frequency_derivatives.hpp"

using namespace flexopt;

namespace {

/// A mode whose compliance along the stroke is c + a s⁴; its parabola at rest is the constant c.
struct Truth {
  double c, a;
  int motion;
  double compliance(double s) const { return c + a * s * s * s * s; }
};

VectorXd motion_of(int k) { return VectorXd::Unit(4, k); }

Mode mode(const Truth& t, double s) {
  Mode m;
  m.frequency = 1 / (2 * M_PI * std::sqrt(t.compliance(s)));
  m.motion = motion_of(t.motion);
  return m;
}

std::vector<FrequencyDerivatives> derivatives(const std::vector<Truth>& truths) {
  std::vector<FrequencyDerivatives> all;
  for (const Truth& t : truths) {
    FrequencyDerivatives d;
    d.mode = mode(t, 0);
    d.omega2 = 1 / t.c;
    d.compliance = t.c;
    all.push_back(d);
  }
  return all;
}

/// Points with the modes in ascending order of frequency.
std::vector<PathPoint> path(const std::vector<Truth>& truths, const std::vector<double>& strokes) {
  std::vector<PathPoint> points;
  for (const double s : strokes) {
    PathPoint p;
    p.stroke = s;
    p.status = PointStatus::converged;
    for (const Truth& t : truths) p.modes_free.push_back(mode(t, s));
    std::sort(p.modes_free.begin(), p.modes_free.end(),
              [](const Mode& a, const Mode& b) { return a.frequency < b.frequency; });
    points.push_back(p);
  }
  return points;
}

const std::vector<double> outward{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8};

}  // namespace

TEST_CASE("a parabola is valid to where it is off by two per cent, through modes that cross") {
  // the second one begins lower and ends higher: at 0.5 they have changed ranks
  const std::vector<Truth> truths{{1, 0.3, 0}, {1.01, -0.02, 1}};
  auto modes = derivatives(truths);
  const auto points = path(truths, outward);
  REQUIRE(points.back().modes_free[0].motion == motion_of(0));
  REQUIRE(points.front().modes_free[0].motion == motion_of(1));
  set_validity(modes, points);
  REQUIRE(modes[0].omega2_valid_to);
  REQUIRE(modes[0].compliance_valid_to);
  CHECK(*modes[0].omega2_valid_to == Approx(std::pow(0.02 / 0.3, 0.25)).epsilon(0.01));
  CHECK(*modes[0].compliance_valid_to == Approx(std::pow(0.02 / 0.98 / 0.3, 0.25)).epsilon(0.01));
  CHECK_FALSE(modes[1].omega2_valid_to);  // to the end of the path
  CHECK_FALSE(modes[1].compliance_valid_to);
}

TEST_CASE("of both sides of the stroke the shorter one counts") {
  const std::vector<Truth> forth{{1, 0.3, 0}}, back{{1, 3, 0}};
  auto points = path(back, {-0.6, -0.5, -0.4, -0.3, -0.2, -0.1});
  for (const PathPoint& p : path(forth, outward)) points.push_back(p);
  auto modes = derivatives(forth);
  set_validity(modes, points);
  REQUIRE(modes[0].omega2_valid_to);
  CHECK(*modes[0].omega2_valid_to == Approx(std::pow(0.02 / 3, 0.25)).epsilon(0.01));
}

TEST_CASE("a mode that leaves the list, and a path that ends, take nothing back") {
  const std::vector<Truth> truths{{1, 3, 0}};
  auto modes = derivatives(truths);
  auto points = path(truths, outward);
  for (PathPoint& p : points)
    if (p.stroke > 0.15) p.modes_free[0].motion = motion_of(2);  // another mode took its place
  set_validity(modes, points);
  CHECK_FALSE(modes[0].omega2_valid_to);
  points = path(truths, outward);
  for (PathPoint& p : points)
    if (p.stroke > 0.15) p.status = PointStatus::not_reached;
  set_validity(modes, points);
  CHECK_FALSE(modes[0].omega2_valid_to);
}

TEST_CASE("the screening frequency is that of the parabola of the compliance, or none") {
  FrequencyDerivatives d;
  d.compliance = 4e-4;
  d.d_compliance = 1e-3;
  d.d2_compliance = -0.02;
  const double s = 0.1, c = 4e-4 + 1e-4 - 1e-4;
  REQUIRE(screening_frequency(d, s));
  CHECK(*screening_frequency(d, s) == Approx(1 / (2 * M_PI * std::sqrt(c))));
  CHECK_FALSE(screening_frequency(d, 1));
}

TEST_CASE("the screening frequency's gradient is its derivative by the three numbers of the mode") {
  // ω², its first and its second derivative, each linear in a parameter
  const double value[3] = {2000, -3000, 9e4}, rate[3] = {150, 700, -2e4}, s = 0.07;
  const auto at = [&](double p) {
    double w[3];
    for (int k = 0; k < 3; ++k) w[k] = value[k] + rate[k] * p;
    FrequencyDerivatives d;
    d.omega2 = w[0];
    d.d_omega2 = w[1];
    d.d2_omega2 = w[2];
    d.compliance = 1 / w[0];
    d.d_compliance = -w[1] / (w[0] * w[0]);
    d.d2_compliance = -w[2] / (w[0] * w[0]) + 2 * w[1] * w[1] / (w[0] * w[0] * w[0]);
    return d;
  };
  FrequencyDerivativeGradients g;
  g.omega2 = VectorXd::Constant(1, rate[0]);
  g.d_omega2 = VectorXd::Constant(1, rate[1]);
  g.d2_omega2 = VectorXd::Constant(1, rate[2]);
  const double expected =
      ridders([&](double p) { return std::vector<double>{*screening_frequency(at(p), s)}; }, 0, 0.1)
          .value[0];
  REQUIRE(std::abs(expected) > 1e-3);
  CHECK(screening_gradient(at(0), g, s)[0] == Approx(expected).epsilon(1e-9));
}

TEST_CASE("of several drives a parabola counts along its own stroke, the others at zero") {
  const Truth first{1, 0.3, 0}, second{1, 3, 0};
  auto modes = derivatives({first});
  modes.push_back(derivatives({second}).front());
  modes[1].drive = 1;
  std::vector<PathPoint> points;
  const auto add = [&](const Truth& truth, double s, std::vector<double> strokes) {
    PathPoint p = path({truth}, {s}).front();
    p.strokes = std::move(strokes);
    p.stroke = p.strokes[0];
    points.push_back(std::move(p));
  };
  for (const double s : outward) {
    add(first, s, {s, 0});
    add(second, s, {0, s});
    if (s != 0) add({1, 1e3, 0}, s, {s, s});  // both at once: no matter of either
  }
  set_validity(modes, points);
  REQUIRE(modes[0].omega2_valid_to);
  REQUIRE(modes[1].omega2_valid_to);
  CHECK(*modes[0].omega2_valid_to == Approx(std::pow(0.02 / 0.3, 0.25)).epsilon(0.01));
  CHECK(*modes[1].omega2_valid_to == Approx(std::pow(0.02 / 3, 0.25)).epsilon(0.01));
}

TEST_CASE("along a way of several strokes the parabolas hold as far as along one stroke") {
  const std::vector<Truth> truths{{1, 0.4, 0}, {0.5, -0.3, 1}};
  std::vector<FrequencyDerivatives> along_one = derivatives(truths);
  std::vector<PathPoint> points = path(truths, outward);
  set_validity(along_one, points);
  REQUIRE(along_one[0].compliance_valid_to);

  FrequencyWay way{Eigen::Vector2d(3e-3, -0.2), derivatives(truths)};
  for (PathPoint& p : points) p.strokes = {p.stroke * 3e-3, p.stroke * -0.2};
  PathPoint beside = points.back();  // not on the way
  beside.strokes = {3e-3, 0.2};
  beside.modes_free.clear();
  points.push_back(beside);
  set_validity(way, points);
  for (std::size_t k = 0; k < truths.size(); ++k) {
    CHECK(*way.modes[k].compliance_valid_to == Approx(*along_one[k].compliance_valid_to));
    CHECK(*way.modes[k].omega2_valid_to == Approx(*along_one[k].omega2_valid_to));
  }
}

TEST_CASE("points of several strokes share ways") {
  StrokeRequest request;
  for (const double x : {-1.0, 0.0, 1.0, 2.0})
    for (const double y : {-1.0, 0.0, 1.0})
      request.strokes.push_back(Eigen::Vector2d(1e-3 * x, 0.1 * y));
  const std::vector<VectorXd> ways = stroke_ways(request);
  CHECK(ways.size() == 6);  // x, y, and the diagonals of both slopes
  for (const VectorXd& strokes : request.strokes) {
    const std::vector<double> at(strokes.begin(), strokes.end());
    int on = 0;
    for (const VectorXd& way : ways)
      if (const auto part = part_of_way(way, at)) {
        ++on;
        CHECK(std::abs(*part) <= 1);
        CHECK((*part * way - strokes).norm() < 1e-15);
      }
    CHECK(on == (strokes.isZero(0) ? 6 : 1));
  }
  request.strokes = {VectorXd::Zero(2)};
  CHECK(stroke_ways(request).size() == 1);
  request.strokes.clear();
  CHECK(stroke_ways(request).empty());
}
