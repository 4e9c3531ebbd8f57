// Solid meshes condensed to their interfaces: closed forms of a box, rates against differences.
#include "core/elements/solid/solid_element.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/elements/solid/block_mesh.hpp"
#include "core/elements/solid/elastic_model.hpp"
#include "core/elements/solid/solid_condensation.hpp"
#include "core/elements/solid/solid_products.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

const std::array all_cells{SolidCell::hexahedron, SolidCell::wedge, SolidCell::tetrahedron};
const Material aluminium = material(70e9, 0.33, 2700);

double largest(const MatrixXd& a) { return a.cwiseAbs().maxCoeff(); }

/// A body whose cells are all distorted.
ElasticBody crooked(SolidCell cell) {
  return block_body(cell, {3, 2, 2}, aluminium, [](int i, int j, int k) -> Vector3d {
    const double x = 0.01 * i, y = 0.004 * j, z = 0.005 * k;
    return Vector3d(x + 4 * y * z, y + 3 * x * x + 0.1 * z, z - 2 * x * y + 0.05 * x);
  });
}

/// Some change of all its numbers.
ElasticBody some_change(const ElasticBody& body) {
  ElasticBody d = body;
  d.material = material(3e9, 0.05, 500);
  for (Vector3d& x : d.nodes) x = Vector3d(0.3 * x.x() + x.y(), x.x() * 2 * x.y(), 0.2 * x.z());
  for (ElasticInterface& i : d.interfaces) i.origin = Vector3d(1e-3, -2e-3, 0.1 * i.origin.x());
  return d;
}

ElasticBody moved(ElasticBody body, const ElasticBody& d, double h) {
  for (std::size_t k = 0; k < body.nodes.size(); ++k) body.nodes[k] += h * d.nodes[k];
  for (std::size_t a = 0; a < body.interfaces.size(); ++a)
    body.interfaces[a].origin += h * d.interfaces[a].origin;
  body.material.youngs_modulus += h * d.material.youngs_modulus;
  body.material.poissons_ratio += h * d.material.poissons_ratio;
  body.material.density += h * d.material.density;
  return body;
}

}  // namespace

TEST_CASE("a mesh of distorted solid cells has the energy of its volume in an even strain") {
  for (const SolidCell cell : all_cells) {
    const ElasticBody body = crooked(cell);
    Matrix3d slopes;
    slopes << 1e-3, 2e-3, -1e-3, 4e-4, -2e-3, 1e-3, 5e-4, 3e-4, 7e-4;
    MatrixXd field(3 * static_cast<Eigen::Index>(body.nodes.size()), 1);
    for (std::size_t k = 0; k < body.nodes.size(); ++k)
      field.middleRows<3>(3 * static_cast<Eigen::Index>(k)) = slopes * body.nodes[k];
    const MatrixXd force = stiffness_product(body, field);
    // the energy of even strain is that of the volume, whatever the cells
    double volume = 0;
    for_each_point(body, SolidRule::energy,
                   [&](const SolidPoint& p, const ReferencePoint&, std::span<const int>) {
                     volume += p.weight;
                   });
    const Matrix3d stress = ElasticLaw(aluminium).stress(slopes);
    const double energy = (stress.array() * slopes.array()).sum() * volume;
    CHECK((field.transpose() * force)(0, 0) == Approx(energy).epsilon(1e-11));
  }
}

TEST_CASE("mass and moments of a condensed box are those of the box") {
  const Vector3d lengths(0.06, 0.01, 0.02), turned(0.004, -0.002, 0.003);
  for (const SolidCell cell : all_cells) {
    ElasticBody body = box_body(cell, {3, 1, 2}, aluminium, lengths);
    for (Vector3d& x : body.nodes) x += turned;
    for (ElasticInterface& i : body.interfaces) i.origin += turned;
    const std::shared_ptr<const CondensedSolid> solid = condensed(body);
    const ElasticModel& model = solid->model;
    const double mass = 2700 * lengths.prod();
    CHECK(model.total_mass == Approx(mass).epsilon(1e-12));
    CHECK((model.mass_moment - mass * turned).norm() < 1e-12 * mass);
    const MatrixXd rigid = rigid_motions(model.origins);
    const Matrix3d inertia = (rigid.transpose() * model.mass * rigid).bottomRightCorner<3, 3>();
    const Vector3d squares = lengths.array().square() / 12 + turned.array().square();
    CHECK(inertia(0, 0) == Approx(mass * (squares.y() + squares.z())).epsilon(1e-11));
    CHECK(inertia(1, 2) == Approx(-mass * turned.y() * turned.z()).epsilon(1e-9));
    CHECK(largest(model.stiffness * rigid) < 1e-14 * largest(model.stiffness));
    CHECK(solid->rigid_residual < 1e-12);
  }
}

TEST_CASE("rates of a condensed body are those of differences") {
  for (const SolidCell cell : all_cells) {
    const ElasticBody body = crooked(cell), d = some_change(body);
    const double h = 1e-5;
    const auto plus = condensed(moved(body, d, h)), minus = condensed(moved(body, d, -h));
    const auto rate = model_rate(body, d);
    const auto check = [&](const MatrixXd& exact, const MatrixXd& up, const MatrixXd& down) {
      CHECK(largest((up - down) / (2 * h) - exact) < 1e-7 * largest(exact));
    };
    check(rate->stiffness, plus->model.stiffness, minus->model.stiffness);
    check(rate->mass, plus->model.mass, minus->model.mass);
    check(rate->moments, plus->model.moments, minus->model.moments);
    check(rate->mass_moment, plus->model.mass_moment, minus->model.mass_moment);
    check(field_rates(body, d)->fields, plus->fields, minus->fields);
    CHECK(field_rates(body, d) == field_rates(body, d));  // no copies
    CHECK((plus->model.total_mass - minus->model.total_mass) / (2 * h) ==
          Approx(rate->total_mass).epsilon(1e-7));
  }
}

TEST_CASE("a condensed body is reduced once, and anew where a number changes") {
  ElasticBody body = box_body(SolidCell::hexahedron, {2, 1, 1}, aluminium, {0.02, 0.01, 0.01});
  const auto first = condensed(body);
  CHECK(condensed(ElasticBody(body)) == first);
  body.nodes.back().x() += 1e-12;
  CHECK(condensed(body) != first);
}

TEST_CASE("meshes that cannot be condensed are told with their numbers") {
  const ElasticBody good =
      box_body(SolidCell::hexahedron, {2, 1, 1}, aluminium, {0.02, 0.01, 0.01});
  CHECK(check_solid(good));
  ElasticBody body = good;
  for (Vector3d& x : body.nodes) x.x() = -x.x();
  CHECK(why_not(check_solid(body)).find("det J = -") != std::string::npos);
  body = good;
  body.interfaces[1].patch.push_back(body.interfaces[0].patch[0]);
  CHECK(why_not(check_solid(body)).find("both hold node") != std::string::npos);
  body = good;
  body.interfaces[0].patch.resize(2);
  CHECK(why_not(check_solid(body)).find("on a line") != std::string::npos);
  body = good;
  for (Vector3d& x : body.nodes) x.y() *= 1e-4;
  CHECK(why_not(check_solid(body)).find("sides of ratio 10000") != std::string::npos);
}

// Radius 5 mm, ligament 1 mm, width 10 mm, 2 mm of full height at either end. Stiffnesses about the
// middle: of the turn that it is made for with all else free, of the others while this is held. The
// numbers are those of an independent program on the same mesh, whose matrices are C3D20R's.
TEST_CASE("a circular notch hinge has the stiffnesses of another program's solid") {
  const double radius = 5e-3, thickness = 1e-3, width = 10e-3, end = 2e-3, pi = std::acos(-1.0);
  const auto graded_z = [&](int k) {
    const auto even = [&](int n) { return n / 4.0 - 1 + 0.25 * std::sin(pi * (n / 4.0 - 1)) / pi; };
    return k % 2 == 0 ? even(k) : 0.5 * (even(k - 1) + even(k + 1));
  };
  ElasticBody body = block_body(
      SolidCell::hexahedron, {22, 3, 4}, aluminium, [&](int i, int j, int k) -> Vector3d {
        const double full = thickness + 2 * radius, s = (i - 22) / 20.0;
        const double angle = std::copysign(std::pow(std::min(std::abs(s), 1.0), 1.5), s) * pi / 2;
        const double beyond = std::max(std::abs(s) - 1, 0.0) * 10;  // in (0, 1]
        const double x = radius * std::sin(angle) + std::copysign(beyond * end, s);
        const double height = full - 2 * radius * std::cos(angle);
        return Vector3d(x, (j / 3.0 - 1) * height / 2, graded_z(k) * width / 2);
      });
  for (ElasticInterface& i : body.interfaces) i.origin.setZero();
  REQUIRE(check_solid(body));
  const MatrixXd K = condensed(body)->model.stiffness.bottomRightCorner<6, 6>();
  const MatrixXd free = K.inverse(), held = K.topLeftCorner<5, 5>().inverse();
  CHECK(1 / free(5, 5) == Approx(22.9307856492).epsilon(1e-8));
  const double expected[] = {118137384.62, 11749240.3895, 29576625.4887, 123.818011537,
                             971.044210756};
  for (int k = 0; k < 5; ++k) CHECK(1 / held(k, k) == Approx(expected[k]).epsilon(1e-8));
}
