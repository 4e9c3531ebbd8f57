// Leaves whose width and thickness vary along them: laws, closed forms and derivatives.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/elements/plate/plate_leaf.hpp"
#include "core/elements/plate/plate_mesh_rate.hpp"
#include "core/math/rotation.hpp"
#include "core/mechanism/profile.hpp"
#include "support/plate_laws.hpp"

using namespace flexopt;

namespace {

template <class F>
std::vector<double> sampled(const F& f) {
  std::vector<double> p;
  for (const double s : profile_stations()) p.push_back(f(s));
  return p;
}

double wave(double s) { return 1 + 0.3 * std::sin(4 * s) - 0.2 * s; }
double notch(double s) { return 1 + 8 * (s - 0.45) * (s - 0.45); }

PlateShape shape(Flexure flexure, bool varies = true) {
  PlateShape s{.width = 0.4, .thickness = 0.01, .mesh = {6, 3}};
  s.flexure = flexure;
  if (varies) {
    s.width_profile = sampled(wave);
    s.thickness_profile = sampled(notch);
  }
  return s;
}

double difference(const PlateMesh& a, const PlateMesh& b) {
  double most = 0;
  for (int i = 0; i < a.elements_along(); ++i)
    for (int j = 0; j < a.elements_across(); ++j) {
      const PlateMesh::Element &p = a.element(i, j), &q = b.element(i, j);
      most = std::max({most, (p.bending - q.bending).norm() / p.bending.norm(),
                       (p.mass - q.mass).norm() / p.mass.norm(),
                       (p.gradient - q.gradient).norm() / p.gradient.norm(),
                       (p.weight - q.weight).matrix().norm() / p.weight.matrix().norm()});
    }
  return most;
}

}  // namespace

TEST_CASE("a profile of ones is a uniform leaf", "[profile]") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    const PlateMesh uniform(shape(flexure, false));
    PlateShape ones = shape(flexure, false);
    ones.width_profile = ones.thickness_profile = {1, 1};
    CHECK(difference(uniform, PlateMesh(ones)) < 1e-13);
    ones.width_profile = ones.thickness_profile = sampled([](double) { return 1.0; });
    CHECK(difference(uniform, PlateMesh(ones)) < 1e-12);
    CHECK(PlateMesh(ones).bending_stiffness() == Approx(uniform.bending_stiffness()));
  }
}

TEST_CASE("only the product of reference and factors counts", "[profile]") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    const PlateShape a = shape(flexure);
    PlateShape b = a;
    b.width *= 2;
    for (double& factor : b.width_profile) factor /= 2;
    PlateLeaf one(std::make_shared<PlateMesh>(a)), other(std::make_shared<PlateMesh>(b));
    one.assemble();
    other.assemble();
    CHECK((one.tangent() - other.tangent()).norm() < 1e-9 * one.tangent().norm());
    PlateShape c = a;
    c.thickness *= 2;
    for (double& factor : c.thickness_profile) factor /= 2;
    PlateLeaf thick(std::make_shared<PlateMesh>(c));
    thick.assemble();  // energies over D of a thickness twice as large
    CHECK((one.tangent() - 8 * thick.tangent()).norm() < 1e-9 * one.tangent().norm());
  }
}

TEST_CASE("a leaf of any profile is at rest, and where it is moved rigidly", "[profile]") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    PlateLeaf leaf(std::make_shared<PlateMesh>(shape(flexure)));
    leaf.assemble();
    CHECK(std::abs(leaf.energy()) < 2e-10);  // rounding: entries of the stiffness are of size 2e5
    CHECK(leaf.residual().norm() < 1e-7);
    CHECK(leaf.edge_force().norm() < 1e-7);
    CHECK(leaf.negative_pivots() == 0);
    const Matrix12d K = leaf.tangent();
    Eigen::Matrix<double, 12, 6> rigid = Eigen::Matrix<double, 12, 6>::Zero();
    for (int e = 0; e < 2; ++e) {
      rigid.block<3, 3>(6 * e, 0).setIdentity();
      rigid.block<3, 3>(6 * e, 3) = -hat(e * Vector3d::UnitX());
      rigid.block<3, 3>(6 * e + 3, 3).setIdentity();
    }
    CHECK((K * rigid).norm() < 1e-9 * K.norm());
    CHECK((K - K.transpose()).norm() < 1e-10 * K.norm());
  }
}

TEST_CASE("the force of a leaf with profiles is the derivative of its energy", "[profile]") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    const auto mesh = std::make_shared<PlateMesh>(shape(flexure));
    PlateLeaf leaf(mesh);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u(-1, 1);
    PlateLeaf::State state = PlateLeaf::undeflected(*mesh);
    state.edges[1].position += Vector3d(-0.01, 0.01, 0.1);
    state.edges[1].axes = rotation_exp({0.1, 0.2, 0.03});
    for (double& x : state.x) x += 0.003 * u(random);
    VectorXd d(state.x.size());
    for (double& x : d) x = u(random);
    const auto energy = [&](double h) {
      PlateLeaf::State moved = state;
      moved.x += h * d;
      leaf.set_state(moved);
      leaf.linearise();
      return leaf.energy();
    };
    const auto slope = [&](double h) { return (energy(h) - energy(-h)) / (2 * h); };
    const double difference = (4 * slope(5e-5) - slope(1e-4)) / 3;
    energy(0);
    CHECK(leaf.residual().dot(d) == Approx(difference).epsilon(1e-7));
    CHECK(d.dot(VectorXd(leaf.tangent_times(d))) ==
          Approx([&] {
            const auto bend = [&](double h) {
              return (energy(h) - 2 * energy(0) + energy(-h)) / (h * h);
            };
            const double value = (4 * bend(1e-3) - bend(2e-3)) / 3;
            energy(0);
            return value;
          }())
              .epsilon(1e-5));
  }
}

TEST_CASE("operators change along sizes and profiles as their differences do", "[profile]") {
  for (const Flexure flexure : {Flexure::plate, Flexure::beam}) {
    const PlateShape at = shape(flexure);
    const PlateMesh mesh(at);
    const std::vector<ProfileRate> profiles{
        {sampled([](double s) { return s * s; }), {}},
        {{}, sampled([](double s) { return std::cos(3 * s); })}};
    const PlateMeshRate rate(mesh, profiles);
    REQUIRE(rate.directions() == 5);
    for (int p = 0; p < 5; ++p) {
      const auto moved = [&](double h) {
        return PlateMesh(plate_laws::moved(at, rate.direction[p], h));
      };
      const double h = p == 1 ? 1e-5 : 1e-4;
      const PlateMesh plus = moved(h), minus = moved(-h), plus2 = moved(2 * h),
                      minus2 = moved(-2 * h);
      const PlateMeshRate::Shape& by = rate.shape[p];
      const auto compare = [&](const auto& found, auto part) {
        const auto d =
            ((8 * (part(plus) - part(minus)) - (part(plus2) - part(minus2))) / (12 * h)).eval();
        CHECK((found - d).matrix().norm() <=
              1e-8 * d.matrix().norm() + 1e-7 * part(mesh).matrix().norm());
      };
      const int ny = mesh.elements_across();
      for (int i = 0; i < mesh.elements_along(); ++i)
        for (int j = 0; j < ny; ++j) {
          const std::size_t k = i * ny + j;
          using Matrix16 = PlateMesh::Matrix16;
          const Matrix16 none = Matrix16::Zero();
          const auto operator_of = [&](auto member) {
            return [&, member](const PlateMesh& m) -> Matrix16 { return m.element(i, j).*member; };
          };
          compare(by.bending[k], operator_of(&PlateMesh::Element::bending));
          compare(by.mass.empty() ? none : by.mass[k], operator_of(&PlateMesh::Element::mass));
          compare(by.gradient.empty() ? none : by.gradient[k],
                  operator_of(&PlateMesh::Element::gradient));
          compare(by.weight.empty() ? PlateMesh::Weights(PlateMesh::Weights::Zero()) : by.weight[k],
                  [&](const PlateMesh& m) -> PlateMesh::Weights { return m.element(i, j).weight; });
        }
      for (int line = 0; line < mesh.lines(); ++line) {
        compare(by.undeflected.empty() ? MatrixXd::Zero(mesh.functions_per_line(), 3).eval()
                                       : by.undeflected[line],
                [&](const PlateMesh& m) -> MatrixXd { return m.undeflected(line); });
      }
    }
  }
}
