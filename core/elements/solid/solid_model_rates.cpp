// Rates of a condensed body along a change of its sizes and its material, without a further
// factorisation: README.md.
#include "core/elements/solid/kept_by_content.hpp"
#include "core/elements/solid/quartic.hpp"
#include "core/elements/solid/solid_condensation.hpp"
#include "core/elements/solid/solid_products.hpp"

namespace flexopt {
namespace {

constexpr std::size_t most_kept_rate_bytes = std::size_t{256} << 20;

struct SolidRates {
  ElasticModel model;
  FieldRates fields;
};

// The rate of Pᵀ K P follows from that of K, which vanishes on rigid motions Φ: dK Φ = −K dΦ.
void project_rate(const ElasticModel& model, const MatrixXd& rigid, const MatrixXd& moving,
                  ElasticModel& rate) {
  const RigidSplit split(model.stiffness, rigid);
  rate.stiffness = symmetric_part(split.elastic.transpose() * rate.stiffness * split.elastic -
                                  2 * model.stiffness * moving * split.inverse);
}

SolidRates rates_of(const ElasticBody& body, const ElasticBody& direction) {
  const std::shared_ptr<const Condensation> whole = condensation(body);
  const ElasticModel& model = whole->solid.model;
  SolidRates rates;
  ElasticModel& rate = rates.model;
  rate.origins = origins_of(direction);
  rate.stiffness.setZero(model.stiffness.rows(), model.stiffness.cols());
  rate.mass = rate.stiffness;
  if (!body.imported) {
    const MatrixXd& fields = whole->solid.fields;
    const MatrixXd held = patch_field_rates(body, direction),
                   forces = stiffness_product_rate(body, direction, fields);
    MatrixXd& field_rate = rates.fields.fields;
    field_rate = held - whole->held_answer(forces + stiffness_product(body, held));
    rate.stiffness = symmetric_part(fields.transpose() * forces +
                                    2 * held.transpose() * whole->stiffness_fields);
    rate.mass = symmetric_part(fields.transpose() * mass_product_rate(body, direction, fields) +
                               2 * field_rate.transpose() * whole->mass_fields);
  }
  const MatrixXd rigid = rigid_motions(model.origins), moving = rigid_motion_rates(rate.origins);
  project_rate(model, rigid, moving, rate);
  add_rigid_moments(rate, rigid, model.moments * moving);
  if (body.degree == ElasticDegree::quartic) {
    rate.basis = model.basis;
    add_quartic_rate(
        body, direction, whole->solid,
        [&](const MatrixXd& load) { return whole->held_answer(load); }, rates.fields, rate);
  }
  return rates;
}

std::shared_ptr<const SolidRates> kept_rates(const ElasticBody& body,
                                             const ElasticBody& direction) {
  static KeptByContent<SolidRates> kept(most_kept_rate_bytes);
  ContentKey key;
  add_content(body, key);
  add_sizes(direction, key);
  return kept.get(
      key.take(), [&] { return std::make_shared<const SolidRates>(rates_of(body, direction)); },
      [](const SolidRates& r) {
        return sizeof(double) *
               (static_cast<std::size_t>(r.fields.fields.size() + r.fields.second_fields.size() +
                                         2 * r.model.mass.size()) +
                r.model.cubic.size() + r.model.quartic.size());
      });
}

}  // namespace

std::shared_ptr<const ElasticModel> model_rate(const ElasticBody& body,
                                               const ElasticBody& direction) {
  const std::shared_ptr<const SolidRates> rates = kept_rates(body, direction);
  return {rates, &rates->model};
}

std::shared_ptr<const FieldRates> field_rates(const ElasticBody& body,
                                              const ElasticBody& direction) {
  const std::shared_ptr<const SolidRates> rates = kept_rates(body, direction);
  return {rates, &rates->fields};
}

}  // namespace flexopt
