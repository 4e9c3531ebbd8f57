#include "core/elements/solid/solid_condensation.hpp"

#include <algorithm>
#include <limits>

#include "core/elements/solid/kept_by_content.hpp"
#include "core/elements/solid/quartic.hpp"
#include "core/elements/solid/solid_products.hpp"
#include "core/elements/solid/solid_stress.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

/// Interfaces up to which the cubic term of a linear body is computed: beyond, it costs more than
/// the condensation itself.
constexpr int most_with_cubic = 6;

constexpr std::size_t most_kept_bytes = std::size_t{1} << 30;

MatrixXd motions(const std::vector<Vector3d>& origins, double shift) {
  MatrixXd rigid(6 * origins.size(), 6);
  for (std::size_t a = 0; a < origins.size(); ++a)
    rigid.middleRows<6>(6 * static_cast<Eigen::Index>(a)) << shift * Matrix3d::Identity(),
        -hat(origins[a]), Matrix3d::Zero(), shift * Matrix3d::Identity();
  return rigid;
}

// Patches of `body`, places of `places`.
MatrixXd motions_of_patches(const ElasticBody& body, const ElasticBody& places, double shift) {
  MatrixXd fields = MatrixXd::Zero(3 * static_cast<Eigen::Index>(body.nodes.size()),
                                   6 * static_cast<Eigen::Index>(body.interfaces.size()));
  for (std::size_t a = 0; a < body.interfaces.size(); ++a)
    for (const int node : body.interfaces[a].patch)
      fields.block<3, 6>(3 * node, 6 * static_cast<Eigen::Index>(a))
          << shift * Matrix3d::Identity(),
          -hat(
              Vector3d(places.nodes[static_cast<std::size_t>(node)] - places.interfaces[a].origin));
  return fields;
}

}  // namespace

MatrixXd rigid_motions(const std::vector<Vector3d>& origins) { return motions(origins, 1); }
MatrixXd rigid_motion_rates(const std::vector<Vector3d>& motion) { return motions(motion, 0); }

MatrixXd patch_fields(const ElasticBody& body) { return motions_of_patches(body, body, 1); }
MatrixXd patch_field_rates(const ElasticBody& body, const ElasticBody& direction) {
  return motions_of_patches(body, direction, 0);
}

std::vector<Vector3d> origins_of(const ElasticBody& body) {
  std::vector<Vector3d> origins;
  for (const ElasticInterface& i : body.interfaces) origins.push_back(i.origin);
  return origins;
}

RigidSplit::RigidSplit(const MatrixXd& K, const MatrixXd& rigid) {
  double turns = 0, displacements = 0;
  for (Eigen::Index k = 0; k < K.rows(); ++k)
    (k % 6 < 3 ? displacements : turns) += std::abs(K(k, k));
  MatrixXd weighted = rigid.transpose();
  for (Eigen::Index k = 0; k < K.rows(); ++k)
    if (k % 6 >= 3) weighted.col(k) *= turns / displacements;
  inverse = Lu(weighted * rigid).solve(weighted);
  elastic = MatrixXd::Identity(K.rows(), K.rows()) - rigid * inverse;
}

void add_rigid_moments(ElasticModel& model, const MatrixXd& rigid, const MatrixXd& moving) {
  model.moments = rigid.leftCols<3>().transpose() * model.mass;
  const MatrixXd whole = model.moments * rigid + moving;  // [m 1, −m ĉ]
  const Matrix3d turning = whole.rightCols<3>();
  model.total_mass = whole.leftCols<3>().trace() / 3;
  model.mass_moment = -0.5 * Vector3d(turning(2, 1) - turning(1, 2), turning(0, 2) - turning(2, 0),
                                      turning(1, 0) - turning(0, 1));
}

Condensation::Condensation(const ElasticBody& body) {
  ElasticModel& model = solid.model;
  model.origins = origins_of(body);
  if (body.imported) {
    const auto rows = 6 * static_cast<Eigen::Index>(body.interfaces.size());
    model.stiffness = body.imported->stiffness.topLeftCorner(rows, rows);
    model.mass = body.imported->mass.topLeftCorner(rows, rows);
  } else {
    reduce(body);
  }
  MatrixXd& K = model.stiffness;
  const MatrixXd rigid = rigid_motions(model.origins);
  solid.rigid_residual = (K * rigid).cwiseAbs().maxCoeff() / K.cwiseAbs().maxCoeff();
  const MatrixXd P = RigidSplit(K, rigid).elastic;
  K = symmetric_part(P.transpose() * K * P);
  add_rigid_moments(model, rigid, MatrixXd::Zero(3, 6));
  if (body.degree == ElasticDegree::quartic)
    add_quartic(
        body, [&](const MatrixXd& forces) { return held_answer(forces); }, solid);
  else if (!body.imported && model.interfaces() <= most_with_cubic)
    add_cubic(body, stiffness_fields, solid);
}

void Condensation::reduce(const ElasticBody& body) {
  std::vector<int> number(body.nodes.size(), 0);
  for (const ElasticInterface& i : body.interfaces)
    for (const int node : i.patch) number[static_cast<std::size_t>(node)] = -1;
  for (std::size_t k = 0; k < number.size(); ++k)
    if (number[k] == 0) {
      number[k] = static_cast<int>(free_nodes_.size());
      free_nodes_.push_back(static_cast<int>(k));
    }
  const auto count = static_cast<int>(free_nodes_.size());
  solid.unknowns = 3 * count;
  if (count > 0)
    if (auto factor = DefiniteFactor::of(free_stiffness(body, number, count)))
      factor_ = std::move(*factor);
  solid.surface = solid_surface(body);
  const MatrixXd held = patch_fields(body);
  MatrixXd& fields = solid.fields;
  fields = held - held_answer(stiffness_product(body, held));
  stiffness_fields = stiffness_product(body, fields);
  mass_fields = mass_product(body, fields);
  solid.model.stiffness = fields.transpose() * stiffness_fields;
  solid.model.mass = symmetric_part(fields.transpose() * mass_fields);
}

MatrixXd Condensation::held_answer(const MatrixXd& forces) const {
  MatrixXd inside(solid.unknowns, forces.cols()),
      answer = MatrixXd::Zero(forces.rows(), forces.cols());
  for (std::size_t k = 0; k < free_nodes_.size(); ++k)
    inside.middleRows<3>(3 * static_cast<Eigen::Index>(k)) =
        forces.middleRows<3>(3 * free_nodes_[k]);
  if (factor_)
    factor_->solve(inside);
  else
    inside.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < free_nodes_.size(); ++k)
    answer.middleRows<3>(3 * free_nodes_[k]) =
        inside.middleRows<3>(3 * static_cast<Eigen::Index>(k));
  return answer;
}

std::size_t Condensation::bytes() const {
  const Eigen::Index numbers = solid.fields.size() + solid.second_fields.size() +
                               stiffness_fields.size() + mass_fields.size() +
                               2 * solid.model.mass.size();
  return sizeof(double) * (static_cast<std::size_t>(numbers) + solid.model.cubic.size() +
                           solid.model.quartic.size()) +
         (factor_ ? factor_->bytes() : 0);
}

std::shared_ptr<const Condensation> condensation(const ElasticBody& body) {
  static KeptByContent<Condensation> kept(most_kept_bytes);
  ContentKey key;
  add_content(body, key);
  return kept.get(
      key.take(), [&] { return std::make_shared<const Condensation>(body); },
      [](const Condensation& c) { return c.bytes(); });
}

std::shared_ptr<const CondensedSolid> condensed(const ElasticBody& body) {
  const std::shared_ptr<const Condensation> whole = condensation(body);
  return {whole, &whole->solid};
}

}  // namespace flexopt
