// Plates of any contour as wedges: closed forms of volume and area, angles, Jacobians, derivatives
// of nodes, refusals.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>

#include "designs/solids/mesh_plan.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

constexpr double pi = std::numbers::pi, mm = 1e-3;

template <class S>
ContourCornerT<S> corner(S x, S y, S fillet = S(0.0)) {
  return {{x, y}, fillet, std::nullopt};
}

// The way from the last corner to (x, y) and, from there, half a circle of this radius to
// (x, y) + 2 radius (tx, ty), bulging to the left for turn = 1.
template <class S>
void notch(ContourT<S>& contour, S x, S y, double tx, double ty, S radius, double turn) {
  contour.push_back(corner<S>(x, y));
  ContourCornerT<S> end = corner<S>(x + radius * (2 * tx), y + radius * (2 * ty));
  end.through = {x + radius * (tx - turn * ty), y + radius * (ty + turn * tx)};
  contour.push_back(end);
}

// 60 × 50 mm with a window: two upright links between two bars, each with two notch hinges whose
// ligaments are t thick and whose arcs have the radius R; links 2 R + t wide.
template <class S>
PlateShapeT<S> four_notches(S R, S t) {
  const S width = 60 * mm, height = 50 * mm, wide = R * 2.0 + t, low = S(15 * mm),
          high = height - low;
  ContourT<S> outline = {corner<S>(0.0, 0.0), corner<S>(width, 0.0)};
  notch<S>(outline, width, low - R, 0, 1, R, 1);
  notch<S>(outline, width, high - R, 0, 1, R, 1);
  outline.push_back(corner<S>(width, height));
  outline.push_back(corner<S>(0.0, height));
  notch<S>(outline, 0.0, high + R, 0, -1, R, 1);
  notch<S>(outline, 0.0, low + R, 0, -1, R, 1);
  const S left = wide, right = width - wide, below = low - R - 2 * mm, above = high + R + 2 * mm;
  ContourT<S> window = {corner<S>(left, below, S(1 * mm)), corner<S>(right, below, S(1 * mm))};
  notch<S>(window, right, low - R, 0, 1, R, -1);
  notch<S>(window, right, high - R, 0, 1, R, -1);
  window.push_back(corner<S>(right, above, S(1 * mm)));
  window.push_back(corner<S>(left, above, S(1 * mm)));
  notch<S>(window, left, high + R, 0, -1, R, -1);
  notch<S>(window, left, low + R, 0, -1, R, -1);
  return {outline, {window}, {}, S(10 * mm)};
}

template <class S>
PatchT<S> patch(const char* name, Vector3<S> center, Vector3<S> u, Vector3<S> v) {
  return {center, u, v, name};
}

// Volume from the shape functions of C3D15, with the least Jacobian at the points of integration
// over that of the same wedge at its middle. 7 × 3 points: exact to degree 5.
struct Measured {
  double volume = 0, jacobian = 1, angle = 180;
};
std::array<std::array<double, 3>, 15> slopes(double r, double s, double z) {
  const double L[3] = {1 - r - s, r, s}, dL[3][2] = {{-1, -1}, {1, 0}, {0, 1}};
  std::array<std::array<double, 3>, 15> d{};
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    for (int top = 0; top < 2; ++top) {
      const double c = top ? 1 : -1, h = 1 + c * z;
      // N = ½ L (2 L − 1)(1 ± z) − ½ L (1 − z²), and 2 L_i L_j (1 ± z)
      for (int k = 0; k < 2; ++k) {
        d[i + 3 * top][k] = 0.5 * dL[i][k] * ((4 * L[i] - 1) * h - (1 - z * z));
        d[6 + i + 3 * top][k] = 2 * (dL[i][k] * L[j] + L[i] * dL[j][k]) * h;
      }
      d[i + 3 * top][2] = 0.5 * L[i] * (2 * L[i] - 1) * c + L[i] * z;
      d[6 + i + 3 * top][2] = 2 * L[i] * L[j] * c;
    }
    for (int k = 0; k < 2; ++k) d[12 + i][k] = dL[i][k] * (1 - z * z);
    d[12 + i][2] = -2 * L[i] * z;
  }
  return d;
}
double jacobian(const int* cell, const std::vector<Vector3d>& nodes, double r, double s, double z) {
  const auto d = slopes(r, s, z);
  Matrix3d J = Matrix3d::Zero();
  for (int n = 0; n < 15; ++n)
    for (int k = 0; k < 3; ++k) J.col(k) += d[n][k] * nodes[cell[n]];
  return J.determinant();
}
Measured measured(const SolidPlan& plan, const std::vector<Vector3d>& nodes) {
  const double a = 0.470142064105115, b = 0.101286507323456, depth = std::sqrt(0.6);
  const double points[7][3] = {
      {1. / 3, 1. / 3, 0.1125},          {a, a, 0.066197076394253},
      {1 - 2 * a, a, 0.066197076394253}, {a, 1 - 2 * a, 0.066197076394253},
      {b, b, 0.0629695902724136},        {1 - 2 * b, b, 0.0629695902724136},
      {b, 1 - 2 * b, 0.0629695902724136}};
  Measured all;
  const auto& block = plan.cells->blocks[0];
  for (int e = 0; e < block.count(); ++e) {
    const int* cell = &block.nodes[15 * e];
    const double middle = jacobian(cell, nodes, 1. / 3, 1. / 3, 0);
    for (const auto& [r, s, weight] : points)
      for (const auto& [z, share] : {std::pair{-depth, 5. / 9}, {0., 8. / 9}, {depth, 5. / 9}}) {
        const double J = jacobian(cell, nodes, r, s, z);
        all.volume += J * weight * share;
        all.jacobian = std::min(all.jacobian, middle > 0 ? J / middle : -1);
      }
    for (int n = 0; n < 3; ++n)
      all.jacobian = std::min(all.jacobian, jacobian(cell, nodes, n == 1, n == 2, -1) / middle);
    for (int i = 0; i < 3; ++i) {
      const Vector3d to = nodes[cell[(i + 1) % 3]] - nodes[cell[i]],
                     by = nodes[cell[(i + 2) % 3]] - nodes[cell[i]];
      all.angle = std::min(all.angle, std::atan2(to.cross(by).norm(), to.dot(by)) * 180 / pi);
    }
  }
  return all;
}

struct Meshed {
  SolidPlan plan;
  std::vector<Vector3d> nodes;
  Measured measure;
};
Meshed meshed(const PlateShapeT<double>& plate, const std::vector<PatchT<double>>& patches = {},
              const MeshDensity& density = {}) {
  const Answer<SolidPlan> plan = plan_mesh(plate, patches, density);
  INFO(why_not(plan));
  REQUIRE(plan);
  const auto nodes = place_nodes<double>(*plan, plate, patches);
  REQUIRE(static_cast<int>(nodes.size()) == plan->cells->nodes);
  return {*plan, nodes, measured(*plan, nodes)};
}

// A rectangle of round corners with a round hole and a triangular window.
PlateShapeT<double> plate_with_holes() {
  PlateShapeT<double> plate;
  for (const auto& [x, y] : {std::pair{0., 0.}, {80., 0.}, {80., 40.}, {0., 40.}})
    plate.outline.push_back(corner(x * mm, y * mm, 6 * mm));
  plate.windows.push_back(
      {corner(12 * mm, 10 * mm), corner(35 * mm, 10 * mm), corner(12 * mm, 30 * mm)});
  plate.holes.push_back({{60 * mm, 20 * mm}, 8 * mm});
  plate.thickness = 5 * mm;
  return plate;
}

}  // namespace

TEST_CASE("volumes of plates are those of their contours to the accuracy of quadratic sides") {
  // A parabola through three points of an arc of the angle a: its area is off by R² a⁵/960·…, less
  // than 1e-5 of the circle's for a = π/8.
  const Meshed holes = meshed(plate_with_holes());
  const double area = 80 * 40 - (4 - pi) * 36 - 23 * 20 / 2. - pi * 64;
  CHECK(holes.measure.volume == Approx(area * 5e-9).epsilon(2e-5));
  CHECK(holes.measure.jacobian > 0.3);

  PlateShapeT<double> ring;  // half a ring: two arcs and two lines
  ring.outline = {corner(10 * mm, 0.), corner(20 * mm, 0.), corner(-20 * mm, 0.),
                  corner(-10 * mm, 0.)};
  ring.outline[2].through = {0., 20 * mm};
  ring.outline[0].through = {0., 10 * mm};
  ring.thickness = 3 * mm;
  CHECK(meshed(ring).measure.volume == Approx(pi * 150 * 3e-9).epsilon(2e-5));

  // A fillet of the radius 5 between a line and the unit arc of radius 20 about the origin: the
  // quarter disc loses at each end of the arc what is outside the fillet's circle.
  PlateShapeT<double> quarter;
  quarter.outline = {corner(0., 0.), corner(20 * mm, 0., 5 * mm), corner(0., 20 * mm)};
  quarter.outline[2].through = {20 * mm * std::cos(0.7), 20 * mm * std::sin(0.7)};
  quarter.thickness = 4 * mm;
  // centre (c, 5), |centre| = 15; foot on the arc at the angle of the centre
  const double c = std::sqrt(200.), turn = std::atan2(5, c);
  const double inside = 5 * c / 2 + 25 * (pi / 2 + turn) / 2;  // beside the axis, below the ray
  CHECK(meshed(quarter).measure.volume ==
        Approx((400 * (pi / 2 - turn) / 2 + inside) * 4e-9).epsilon(2e-5));
}

TEST_CASE("triangles of thirty contours have no angle below 15 degrees and no node is lost") {
  for (int n = 0; n < 30; ++n) {
    const double a = 0.5 + 0.5 * std::sin(2.4 * n), b = 0.5 + 0.5 * std::sin(1.3 * n + 1);
    PlateShapeT<double> plate;
    switch (n % 3) {
      case 0:
        plate = four_notches<double>((3 + 2 * a) * mm, (0.3 + 1.2 * b) * mm);
        break;
      case 1:
        plate = plate_with_holes();
        plate.holes[0].radius = (2 + 15 * a) * mm;
        plate.windows[0][1].at[0] = (20 + 20 * b) * mm;
        for (auto& at : plate.outline) at.fillet = 15 * b * mm;
        break;
      default:  // a lever of four corners, with bores at its ends
        plate.outline = {corner(0., 0., 2 * mm), corner(100 * mm, 20 * a * mm, 2 * mm),
                         corner(95 * mm, (25 + 20 * a) * mm), corner(-10 * mm, (20 + 20 * b) * mm)};
        plate.holes = {{{12 * mm, 12 * mm}, (1 + 5 * a) * mm},
                       {{85 * mm, (20 + 18 * a) * mm}, 2.5 * mm}};
        plate.thickness = 8 * mm;
    }
    const Meshed mesh = meshed(plate);
    CAPTURE(n, a, b, mesh.nodes.size());
    CHECK(mesh.measure.angle > 15);
    CHECK(mesh.measure.jacobian > 0.2);
    CHECK(mesh.nodes.size() < 16000);
    const auto& used = mesh.plan.cells->blocks[0].nodes;
    CHECK(std::set<int>(used.begin(), used.end()).size() == mesh.nodes.size());
  }
}

TEST_CASE("a monolithic plate of four notches has three triangles through each ligament") {
  const double R = 5 * mm, t = 1 * mm;
  const auto plate = four_notches(R, t);
  const Meshed mesh = meshed(plate);
  // bars and links, less the notches and the corners of the window
  const double wide = 2 * R + t,
               window = (60 * mm - 2 * wide) * (50 * mm - 2 * (15 * mm - R - 2 * mm));
  const double area = 60 * 50 * mm * mm - window + (4 - pi) * mm * mm - 8 * pi * R * R / 2;
  CHECK(mesh.measure.volume == Approx(area * 10 * mm).epsilon(3e-5));
  CHECK(mesh.measure.angle > 20);
  CHECK(mesh.nodes.size() > 2000);
  CHECK(mesh.nodes.size() < 10000);
  const auto& block = mesh.plan.cells->blocks[0];
  for (const double y : {15 * mm, 35 * mm}) {
    int crossed = 0;
    for (int e = 0; e < block.count() / 2; ++e) {
      int above = 0, across = 0;
      for (int i = 0; i < 3; ++i) {
        const Vector3d& at = mesh.nodes[block.nodes[15 * e + i]];
        above += at[1] > y + 1e-9;
        across += at[0] < wide;
      }
      crossed += across == 3 && above > 0 && above < 3;
    }
    CHECK(crossed >= 3);
  }
  // the same input gives the same bits
  CHECK(meshed(plate).nodes == mesh.nodes);
  CHECK(meshed(plate, {}, {.coarsening = 1.6}).nodes.size() < 0.6 * mesh.nodes.size());
}

TEST_CASE(
    "patches of a plate hold the nodes on them, on side faces and on the faces of the plate") {
  const auto plate = plate_with_holes();
  const std::vector<PatchT<double>> patches = {
      patch<double>("leaf", {20 * mm, 0, 1 * mm}, {0.2 * mm, 0, 0}, {0, 0, 1 * mm}),
      patch<double>("end", {80 * mm, 20 * mm, 0}, {0, 0, 2.5 * mm}, {0, 5 * mm, 0}),
      patch<double>("top", {45 * mm, 30 * mm, 2.5 * mm}, {4 * mm, 0, 0}, {0, 3 * mm, 0}),
      patch<double>("bottom", {45 * mm, 37 * mm, -2.5 * mm}, {4 * mm, 0, 0}, {0, 3 * mm, 0})};
  const Meshed mesh = meshed(plate, patches);
  CHECK(mesh.measure.angle > 15);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    CAPTURE(patches[p].name);
    const Vector3d &c = patches[p].center, u = patches[p].half_u, v = patches[p].half_v;
    double low[2] = {1, 1}, high[2] = {-1, -1};
    for (const int k : mesh.plan.patches[p])
      for (int d = 0; d < 2; ++d) {
        const Vector3d& along = d == 0 ? u : v;
        const double at = (mesh.nodes[k] - c).dot(along) / along.squaredNorm();
        low[d] = std::min(low[d], at);
        high[d] = std::max(high[d], at);
      }
    CHECK(mesh.plan.patches[p].size() >= 8);
    for (int d = 0; d < 2; ++d) {
      CHECK(low[d] == Approx(-1).epsilon(1e-9));
      CHECK(high[d] == Approx(1).epsilon(1e-9));
    }
  }
}

TEST_CASE("nodes of a contour follow shape and patches with exact derivatives") {
  const auto shape = [](auto s) {
    using S = decltype(s);
    PlateShapeT<S> plate = four_notches<S>(5 * mm + s, 1 * mm + s * 0.3);
    plate.outline[0].at[0] -= s;
    plate.outline[0].fillet = 3 * mm + s * 2.0;
    plate.holes.push_back({{S(30 * mm) + s, S(4 * mm)}, S(1.5 * mm) - s * 0.2});
    plate.thickness += s * 3.0;
    return plate;
  };
  const auto patches = [](auto s) {
    using S = decltype(s);
    return std::vector<PatchT<S>>{
        patch<S>("low", {S(48 * mm) + s, S(0.0), S(0.0)}, {S(2 * mm), S(0.0), S(0.0)},
                 {S(0.0), S(0.0), S(3 * mm) + s}),
        patch<S>("flat", {S(30 * mm) + s, S(46 * mm), S(5 * mm) + s * 1.5},
                 {S(4 * mm) + s, S(0.0), S(0.0)}, {S(0.0), S(1.5 * mm), S(0.0)})};
  };
  const Meshed nominal = meshed(shape(0.0), patches(0.0));
  const auto at = [&](double s) { return place_nodes<double>(nominal.plan, shape(s), patches(s)); };
  const Dual1 one = Dual1::variable(0, 0);
  const auto rates = place_nodes<Dual1>(nominal.plan, shape(one), patches(one));
  const double h = 1e-6;  // of a shape of 5 mm: third derivatives give 1e-7
  const auto ahead = at(h), behind = at(-h);
  double off = 0, largest = 0, moved = 0;
  for (std::size_t k = 0; k < rates.size(); ++k)
    for (int d = 0; d < 3; ++d) {
      const double rate = rates[k][d].derivatives[0];
      off = std::max(off, std::abs(rate - (ahead[k][d] - behind[k][d]) / (2 * h)));
      largest = std::max(largest, std::abs(rate));
      moved = std::max(moved, std::abs(rates[k][d].value - nominal.nodes[k][d]));
    }
  CHECK(largest > 1);
  CHECK(off < 1e-6);
  CHECK(moved < 1e-15);
  // the mesh of a larger notch is still good, and its contours are the true ones
  const auto larger = at(0.3 * mm);
  const Measured measure = measured(nominal.plan, larger);
  const Meshed anew = meshed(shape(0.3 * mm), patches(0.3 * mm));
  CHECK(measure.jacobian > 0.1);
  CHECK(measure.volume == Approx(anew.measure.volume).epsilon(5e-5));
}

TEST_CASE("a stretched plate has a stretched mesh") {
  PlateShapeT<double> plate = plate_with_holes();
  plate.holes.clear();
  for (auto& at : plate.outline) at.fillet = 0;
  const Meshed mesh = meshed(plate);
  auto longer = plate;
  for (auto* contour : {&longer.outline, &longer.windows[0]})
    for (auto& at : *contour) at.at[0] = 1.5 * at.at[0] + 0.2 * at.at[1];
  const auto nodes = place_nodes<double>(mesh.plan, longer, {});
  double off = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k)
    off = std::max(off, std::abs(nodes[k][0] - 1.5 * mesh.nodes[k][0] - 0.2 * mesh.nodes[k][1]));
  CHECK(off < 1e-13);
}

TEST_CASE("contours and patches that cannot be meshed are refused with the reason") {
  const auto why = [](const PlateShapeT<double>& plate,
                      const std::vector<PatchT<double>>& patches = {}) {
    return why_not(plan_mesh(plate, patches, {}));
  };
  const auto changed = [](auto change) {
    PlateShapeT<double> plate = plate_with_holes();
    change(plate);
    return plate;
  };
  CHECK(why(plate_with_holes()).empty());
  CHECK_THAT(why(changed([](auto& p) { std::swap(p.outline[1], p.outline[2]); })),
             Contains("outline and outline cross"));
  CHECK_THAT(why(changed([](auto& p) { p.windows[0][0].at[0] = -5 * mm; })),
             Contains("outline and windows[0] cross"));
  CHECK_THAT(why(changed([](auto& p) { p.holes[0].center[0] = 30 * mm; })),
             Contains("windows[0] and holes[0] cross"));
  CHECK_THAT(why(changed([](auto& p) { p.holes[0].center[0] = 200 * mm; })),
             Contains("holes[0] lies outside the outline"));
  CHECK_THAT(why(changed([](auto& p) {
               p.holes[0] = {{15 * mm, 15 * mm}, 1 * mm};
             })),
             Contains("holes[0] lies outside the outline or inside another"));
  CHECK_THAT(why(changed([](auto& p) { p.outline[0].fillet = 35 * mm; })),
             Contains("does not fit"));
  CHECK_THAT(
      why(changed([](auto& p) { p.outline[1].fillet = 20 * mm, p.outline[2].fillet = 20 * mm; })),
      Contains("does not fit"));
  CHECK_THAT(why(changed([](auto& p) {
               p.outline[1].through = {40 * mm, 0.};
             })),
             Contains("three points of a line"));
  CHECK_THAT(why(changed([](auto& p) {
               p.windows[0][1].at[1] = 9 * mm, p.windows[0][2].at = {35 * mm, 10 * mm};
             })),
             Contains("sharper than 10 degrees"));
  const auto plate = plate_with_holes();
  CHECK_THAT(why(plate, {patch<double>("A", {20 * mm, 1 * mm, 0}, {1 * mm, 0, 0}, {0, 0, 1 * mm})}),
             Contains("A lies on no straight side"));
  CHECK_THAT(why(plate, {patch<double>("A", {4 * mm, 0, 0}, {1 * mm, 0, 0}, {0, 0, 1 * mm})}),
             Contains("A lies on no straight side"));
  CHECK_THAT(why(plate, {patch<double>("A", {20 * mm, 0, 0}, {1 * mm, 0, 0}, {0, 0, 3 * mm})}),
             Contains("beyond the thickness"));
  CHECK_THAT(why(plate, {patch<double>("A", {20 * mm, 0, 0}, {1 * mm, 0, 1 * mm}, {0, 0, 1 * mm})}),
             Contains("inclined"));
  CHECK_THAT(
      why(plate, {patch<double>("A", {45 * mm, 20 * mm, 1 * mm}, {3 * mm, 0, 0}, {0, 3 * mm, 0})}),
      Contains("A lies on no face"));
  CHECK_THAT(why(plate, {patch<double>("A", {45 * mm, 20 * mm, 2.5 * mm}, {15 * mm, 0, 0},
                                       {0, 3 * mm, 0})}),
             Contains("A reaches beyond the contour"));
  CHECK_THAT(why(plate, {patch<double>("A", {60 * mm, 20 * mm, 2.5 * mm}, {12 * mm, 0, 0},
                                       {0, 7 * mm, 0})}),
             Contains("A has an outline that crosses"));
}
