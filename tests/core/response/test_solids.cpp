// Leaves with their thickness, wires and boxes as images of three coordinates, and how they move.
#include "core/response/solids.hpp"

#include <catch2/catch.hpp>

#include "core/math/ridders.hpp"
#include "core/mechanism/each_number.hpp"
#include "support/models.hpp"

using namespace flexopt;

namespace {

constexpr int leaf = 0, wire = 1, box = 2;

// A tapered leaf, a wire and a box, none of them along the axes.
Mechanism sample() {
  Mechanism m = models::guide(0.1, 0.03, 5e-4);
  const Matrix3d turn = Eigen::AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (LeafSpring& l : m.leaves) l.axes = turn * l.axes;
  m.leaves[0].width_profile = {1, 1.5};
  m.leaves[0].thickness_profile = {2, 1};
  m.leaves[1].section = Section::circular;
  m.leaves[1].width = m.leaves[1].thickness;
  BodyBoxT<double> cuboid{{0.1, 0.01, 0.02}, Matrix3d::Zero()};
  cuboid.half_edges = turn * Vector3d(0.01, 0.02, 0.03).asDiagonal();
  m.bodies[0].box = cuboid;
  return m;
}

// A bend of the whole room, so that leaves are curved.
Vector3d bent(const Vector3d& x) {
  return {x[0] + 3 * x[1] * x[2], x[1] + 2 * x[0] * x[0], x[2] - x[0] * x[1]};
}
Matrix3d bend_slope(const Vector3d& x) {
  Matrix3d s;
  s << 1, 3 * x[2], 3 * x[1], 4 * x[0], 1, 0, -x[1], -x[0], 1;
  return s;
}

const Matrix3d body_turn = Eigen::AngleAxisd(0.3, Vector3d::UnitY()).toRotationMatrix();

Solids bent_solids(const Mechanism& m) {
  std::vector<JointBody> bodies;
  for (const RigidBody& b : m.bodies) bodies.push_back({bent(b.reference), body_turn});
  return {m,
          [&](int i, const std::vector<std::array<double, 2>>& points) {
            std::vector<Vector3d> places;
            for (const auto& [along, across] : points)
              places.push_back(
                  bent(undeflected_place(m.leaves[static_cast<std::size_t>(i)], along, across)));
            return places;
          },
          bodies};
}

}  // namespace

TEST_CASE("the points of an undeflected leaf, a wire and a box are where geometry has them") {
  const Mechanism m = sample();
  const Solids solids = Solids::undeflected(m);
  REQUIRE(solids.count() == 3);
  const LeafSpring &l = m.leaves[0], &w = m.leaves[1];
  for (const double s : {0.0, 0.13, 0.5, 0.77, 1.0})
    for (const double c : {0.0, 0.4, 1.0})
      for (const double h : {-1.0, 0.3, 1.0}) {
        const Vector3d expected =
            l.origin + l.axes * Vector3d(s * l.length, (c - 0.5) * l.width * (1 + 0.5 * s),
                                         0.5 * h * l.thickness * (2 - s));
        CHECK((solids.place({leaf, {s, c, h}}) - expected).norm() < 1e-15);
        const Vector3d on_wire = solids.place({wire, {s, 2 * c, 1}}) - w.origin;
        const double along = w.axes.col(0).dot(on_wire);
        CHECK(along == Approx(s * w.length).margin(1e-15));
        CHECK((on_wire - along * w.axes.col(0)).norm() == Approx(0.5 * w.thickness));
        const BodyBoxT<double>& b = *m.bodies[0].box;
        CHECK(
            (solids.place({box, {s, c, h}}) - b.center - b.half_edges * Vector3d(s, c, h)).norm() <
            1e-16);
      }
}

TEST_CASE("slopes and curvatures of the places are their derivatives") {
  const Mechanism m = sample();
  const Solids solids = bent_solids(m);
  for (int solid = 0; solid < 3; ++solid) {
    const Vector3d u(0.37, 0.61, solid == wire ? 1 : 0.3);
    const Solids::Local here = solids.local({solid, u});
    for (int k = 0; k < (solid == wire ? 2 : 3); ++k) {
      const auto slopes = ridders(
          [&](double x) {
            Vector3d at = u;
            at[k] = x;
            const Solids::Local there = solids.local({solid, at});
            std::vector<double> numbers(there.place.begin(), there.place.end());
            for (int j = 0; j < 3; ++j)
              for (int c = 0; c < 3; ++c) numbers.push_back(there.slopes(c, j));
            return numbers;
          },
          u[k], 0.01);
      for (int c = 0; c < 3; ++c) {
        CHECK(here.slopes(c, k) ==
              Approx(slopes.value[static_cast<std::size_t>(c)]).epsilon(1e-8).margin(1e-12));
        for (int j = k; j < (solid == wire ? 2 : 3); ++j) {
          const int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
          CHECK(here.curvatures[static_cast<std::size_t>(at[k][j])][c] ==
                Approx(slopes.value[static_cast<std::size_t>(3 + 3 * j + c)])
                    .epsilon(1e-7)
                    .margin(1e-11));
        }
      }
    }
  }
}

TEST_CASE("the surface of a bent leaf is interpolated to the fourth order") {
  const Mechanism m = sample();
  const Solids solids = bent_solids(m);
  for (const double s : {0.012, 0.31, 0.487, 0.99})
    for (const double c : {0.05, 0.45}) {
      const Vector3d x = undeflected_place(m.leaves[0], s, c);
      CHECK((solids.middle_place(leaf, s, c) - bent(x)).norm() < 1e-8);
    }
}

TEST_CASE("places of points follow the parameters that leaves and bodies move along") {
  const bool folded = GENERATE(false, true);
  CAPTURE(folded);
  Mechanism m = sample();
  if (folded) {
    m.leaves[0].width_profile.clear();
    m.leaves[0].thickness_profile.clear();
    m.leaves[0].fold = LeafFold{0.55, 1.2};
  } else {
    m.leaves[0].curve = 0.7;
  }
  // every number of the mechanism at a rate of its own
  Mechanism rate = zero_rate(m);
  double next = 0.3;
  each_number(rate, [&](double& x) { x = 1e-2 * (next = std::fmod(next * 1.7 + 0.11, 1.0)); });
  rate.leaves[1].width = rate.leaves[1].thickness;
  const std::vector<Mechanism> directions{rate};
  const auto moved = [&](double by) {
    std::vector<double> rates;
    each_number(rate, [&](double x) { rates.push_back(x); });
    Mechanism other = m;
    std::size_t i = 0;
    each_number(other, [&](double& x) { x += by * rates[i++]; });
    return other;
  };
  PlaceRates rates = undeflected_rates(m, directions);
  const PlaceRates still = rates;
  rates.leaf = [&](int i, double along, double across, const VectorXd& along_rates) -> MatrixXd {
    return bend_slope(undeflected_place(m.leaves[static_cast<std::size_t>(i)], along, across)) *
           still.leaf(i, along, across, along_rates);
  };
  rates.bodies[0].position = bend_slope(m.bodies[0].reference) * still.bodies[0].position;
  for (const bool deflected : {false, true})
    for (int solid = 0; solid < Solids::undeflected(m).count(); ++solid)
      for (const Vector3d& at : {Vector3d(0.02, 0.9, 1), Vector3d(0.5, 0.33, 1)}) {
        const SolidPoint point{solid, at};
        const Solids here = deflected ? bent_solids(m) : Solids::undeflected(m);
        const auto differences = ridders(
            [&](double by) {
              const Mechanism other = moved(by);
              const Solids solids = deflected ? bent_solids(other) : Solids::undeflected(other);
              const Vector3d place = solids.place(point);
              return std::vector<double>{place[0], place[1], place[2]};
            },
            0, 1e-3);
        const PlaceRates& with = deflected ? rates : still;
        const MatrixXd place = here.place_rates(point, with);
        CAPTURE(deflected, solid, at.transpose());
        REQUIRE(place.norm() > 0);
        for (int c = 0; c < 3; ++c) {
          const auto i = static_cast<std::size_t>(c);
          CHECK(place(c, 0) == Approx(differences.value[i]).epsilon(1e-8).margin(1e-10));
        }
      }
}
