// Vibrations inside elastic bodies: against the mesh itself, and rates against differences.
#include "core/elements/solid/fixed_interface_modes.hpp"

#include <catch2/catch.hpp>

#include "core/elements/solid/block_mesh.hpp"
#include "core/elements/solid/solid_products.hpp"

using namespace flexopt;
using namespace flexopt::test;

namespace {

constexpr int count = 8;

// A block whose sizes, place of an interface and constants move with h.
ElasticBody block(SolidCell cell, double h) {
  ElasticBody body =
      block_body(cell, {3, 2, 2}, material(70e9 + 3e9 * h, 0.33 + 0.05 * h, 2700 + 500 * h),
                 [&](int i, int j, int k) {
                   const double x = 0.01 * i, y = 0.004 * j, z = 0.005 * k;
                   return Vector3d(x + h * (0.3 * x + y), y + 3 * x * x + h * x * y,
                                   z - 2 * x * y + 0.2 * h * z);
                 });
  body.interfaces[0].origin += h * Vector3d(1e-3, -2e-3, 1e-3);
  return body;
}

ElasticBody rate_of(SolidCell cell) {
  ElasticBody d = block(cell, 1), at = block(cell, 0);
  for (std::size_t k = 0; k < d.nodes.size(); ++k) d.nodes[k] -= at.nodes[k];
  for (std::size_t a = 0; a < d.interfaces.size(); ++a)
    d.interfaces[a].origin -= at.interfaces[a].origin;
  d.material = material(3e9, 0.05, 500);
  return d;
}

}  // namespace

TEST_CASE("fixed-interface modes are eigenvectors of the mesh and meet interfaces by mass alone") {
  for (const SolidCell cell : {SolidCell::hexahedron, SolidCell::tetrahedron}) {
    const ElasticBody body = block(cell, 0);
    const auto solid = condensed(body);
    const auto modes = fixed_interface_modes(body, count);
    REQUIRE(modes->count() == count);
    const MatrixXd K = stiffness_product(body, modes->shapes),
                   M = mass_product(body, modes->shapes);
    MatrixXd left = K;
    for (Eigen::Index k = 0; k < count; ++k)
      left.col(k) -= modes->stiffness(k, k) / modes->mass(k, k) * M.col(k);
    for (const ElasticInterface& interface : body.interfaces)
      for (const int node : interface.patch) {
        CHECK(modes->shapes.middleRows(3 * node, 3).isZero(0));
        left.middleRows(3 * node, 3).setZero();
      }
    CHECK(left.norm() < 1e-6 * K.norm());
    CHECK((solid->fields.transpose() * K).norm() < 1e-9 * K.norm() * solid->fields.norm());
    CHECK((modes->coupling - solid->fields.transpose() * M).norm() < 1e-12 * M.norm());
    const MatrixXd off = modes->mass - MatrixXd(modes->mass.diagonal().asDiagonal());
    CHECK(off.norm() < 1e-6 * modes->mass.norm());
  }
}

TEST_CASE("rates of fixed-interface modes are those of the same mesh moved") {
  for (const SolidCell cell : {SolidCell::hexahedron, SolidCell::wedge}) {
    const auto nominal = std::make_shared<const ElasticBody>(block(cell, 0.02));
    const auto at = [&](double h) {
      ElasticBody body = block(cell, h);
      body.nominal = nominal;
      return body;
    };
    const double h = 1e-4;
    const auto less = fixed_interface_modes(at(-h), count),
               more = fixed_interface_modes(at(h), count),
               rates = fixed_interface_mode_rates(at(0), rate_of(cell), count);
    const auto close = [&](const MatrixXd& rate, const MatrixXd& high, const MatrixXd& low) {
      const MatrixXd slope = (high - low) / (2 * h);
      CHECK((rate - slope).norm() < 1e-6 * slope.norm());
    };
    close(rates->stiffness, more->stiffness, less->stiffness);
    close(rates->mass, more->mass, less->mass);
    close(rates->coupling, more->coupling, less->coupling);
    CHECK(rates->shapes.size() == 0);  // the kept rates would be as large as the mesh
  }
}
