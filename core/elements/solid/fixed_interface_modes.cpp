#include "core/elements/solid/fixed_interface_modes.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/elements/solid/kept_by_content.hpp"
#include "core/elements/solid/solid_condensation.hpp"
#include "core/elements/solid/solid_products.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/lanczos.hpp"

namespace flexopt {
namespace {

constexpr std::size_t most_kept_mode_bytes = std::size_t{256} << 20;

// What the shapes of a body start from: a step of inverse iteration leads from them to its own, so
// that these follow the design smoothly.
struct NominalModes {
  MatrixXd shapes;  // of unit mass times that of the body
  VectorXd omega2;
};

NominalModes modes_of(const ElasticBody& body, int count) {
  const std::shared_ptr<const Condensation> whole = condensation(body);
  const int unknowns = whole->solid.unknowns;
  count = std::min(count, unknowns / 3);
  const double size = std::sqrt(whole->solid.model.total_mass);
  if (count == 0 || size == 0) return {MatrixXd(3 * body.nodes.size(), 0), VectorXd()};
  constexpr int width = 4;  // equal modes of a symmetric body
  const LowestPairs found = lowest_pairs(
      static_cast<int>(3 * body.nodes.size()), count, width,
      [&](const MatrixXd& B) { return whole->held_answer(B); },
      [&](const MatrixXd& B) { return mass_product(body, B); });
  assert(found.converged);  // the stiffness is definite, and the space has room for all that count
  return {size * found.vectors, found.values};
}

std::size_t mode_bytes(const FixedInterfaceModes& of) {
  return sizeof(double) * static_cast<std::size_t>(of.shapes.size() + of.stiffness.size() +
                                                   of.mass.size() + of.coupling.size());
}

// What the modes of a body depend on.
ContentKey key_of(const ElasticBody& body, int count) {
  ContentKey key;
  add_content(body, key);
  if (body.nominal) add_sizes(*body.nominal, key);
  key.add(&count, 1);
  return key;
}

std::shared_ptr<const NominalModes> nominal_modes(const ElasticBody& body, int count) {
  static KeptByContent<NominalModes> kept(most_kept_mode_bytes);
  const ElasticBody& nominal = body.nominal ? *body.nominal : body;
  return kept.get(
      key_of(nominal, count).take(),
      [&] { return std::make_shared<const NominalModes>(modes_of(nominal, count)); },
      [](const NominalModes& modes) {
        return sizeof(double) * static_cast<std::size_t>(modes.shapes.size());
      });
}

FixedInterfaceModes imported_modes(const ImportedMatrices& matrices) {
  const Eigen::Index m = matrices.modes;
  return {{},
          matrices.stiffness.bottomRightCorner(m, m),
          matrices.mass.bottomRightCorner(m, m),
          matrices.mass.topRightCorner(matrices.mass.rows() - m, m)};
}

// K Ξ = M Ξ₀ Ω₀² of the nominal shapes Ξ₀: equal to these where the design is the nominal one.
FixedInterfaceModes modes_from(const ElasticBody& body, const NominalModes& nominal) {
  const std::shared_ptr<const Condensation> whole = condensation(body);
  FixedInterfaceModes modes;
  const MatrixXd forces =
      mass_product(body, MatrixXd(nominal.shapes * nominal.omega2.asDiagonal()));
  modes.shapes = whole->held_answer(forces);
  modes.stiffness = symmetric_part(modes.shapes.transpose() * forces);
  const MatrixXd inertia = mass_product(body, modes.shapes);
  modes.mass = symmetric_part(modes.shapes.transpose() * inertia);
  modes.coupling = whole->solid.fields.transpose() * inertia;
  return modes;
}

FixedInterfaceModes zero_rates(const FixedInterfaceModes& of) {
  return {{}, 0 * of.stiffness, 0 * of.mass, 0 * of.coupling};
}

FixedInterfaceModes rates_from(const ElasticBody& body, const ElasticBody& direction,
                               const NominalModes& nominal, const FixedInterfaceModes& modes) {
  const std::shared_ptr<const Condensation> whole = condensation(body);
  const MatrixXd& Xi = modes.shapes;
  const MatrixXd moving = nominal.shapes * nominal.omega2.asDiagonal(),
                 forces = mass_product(body, moving),
                 force_rates = mass_product_rate(body, direction, moving),
                 stiffness = stiffness_product_rate(body, direction, Xi),
                 inertia = mass_product(body, Xi),
                 inertia_rates = mass_product_rate(body, direction, Xi);
  const MatrixXd shapes = whole->held_answer(force_rates - stiffness);
  FixedInterfaceModes rates;
  rates.stiffness = symmetric_part(Xi.transpose() * stiffness + 2 * shapes.transpose() * forces);
  rates.mass = symmetric_part(Xi.transpose() * inertia_rates + 2 * shapes.transpose() * inertia);
  rates.coupling = field_rates(body, direction)->fields.transpose() * inertia +
                   whole->solid.fields.transpose() * inertia_rates +
                   whole->mass_fields.transpose() * shapes;
  return rates;
}

}  // namespace

MatrixXd FixedInterfaceModes::root_of_mass() const {
  return count() == 0 ? mass : MatrixXd(Cholesky(mass).lower().transpose());
}

double FixedInterfaceModes::highest() const {
  const double omega2 = SymmetricEigen(stiffness, mass).eigenvalues().maxCoeff();
  return std::sqrt(omega2) / (2 * std::numbers::pi);
}

std::shared_ptr<const FixedInterfaceModes> fixed_interface_modes(const ElasticBody& body,
                                                                 int count) {
  if (body.imported)
    return std::make_shared<const FixedInterfaceModes>(imported_modes(*body.imported));
  static KeptByContent<FixedInterfaceModes> kept(most_kept_mode_bytes);
  return kept.get(
      key_of(body, count).take(),
      [&] {
        return std::make_shared<const FixedInterfaceModes>(
            modes_from(body, *nominal_modes(body, count)));
      },
      mode_bytes);
}

std::shared_ptr<const FixedInterfaceModes> fixed_interface_mode_rates(const ElasticBody& body,
                                                                      const ElasticBody& direction,
                                                                      int count) {
  const std::shared_ptr<const FixedInterfaceModes> modes = fixed_interface_modes(body, count);
  if (body.imported) return std::make_shared<const FixedInterfaceModes>(zero_rates(*modes));
  static KeptByContent<FixedInterfaceModes> kept(most_kept_mode_bytes);
  ContentKey key = key_of(body, count);
  add_sizes(direction, key);
  return kept.get(
      key.take(),
      [&] {
        return std::make_shared<const FixedInterfaceModes>(
            rates_from(body, direction, *nominal_modes(body, count), *modes));
      },
      mode_bytes);
}

}  // namespace flexopt
