#include "core/elements/solid/mesh_energy.hpp"

#include "core/elements/solid/solid_condensation.hpp"
#include "core/elements/solid/solid_element.hpp"
#include "core/elements/solid/solid_stress.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

// Displacements to second order inside, exact on the patches.
VectorXd displacements(const ElasticBody& body, const CondensedSolid& solid,
                       const VectorXd& local) {
  VectorXd u = solid_displacements(solid, local);
  for (std::size_t a = 0; a < body.interfaces.size(); ++a) {
    const Vector6d at = local.segment<6>(6 * static_cast<Eigen::Index>(a));
    const Matrix3d turn = rotation_exp(at.tail<3>()) - Matrix3d::Identity();
    for (const int node : body.interfaces[a].patch)
      u.segment<3>(3 * node) = at.head<3>() + turn * (body.nodes[static_cast<std::size_t>(node)] -
                                                      body.interfaces[a].origin);
  }
  return u;
}

double model_energy(const ElasticModel& model, const VectorXd& local) {
  const VectorXd e = model.basis.transpose() * local;
  const Eigen::Index m = e.size();
  const VectorXd ee = (e * e.transpose()).reshaped();
  const double cubic = e.dot((MatrixXd::Map(model.cubic.data(), m, m * m) * ee)),
               quartic = ee.dot(MatrixXd::Map(model.quartic.data(), m * m, m * m) * ee);
  return 0.5 * local.dot(model.stiffness * local) + cubic / 6 + quartic / 24;
}

}  // namespace

// (U11): the fields inside miss terms of third order, which are the answer to the forces there.
double left_out_energy(const ElasticBody& body, const CondensedSolid& solid,
                       const VectorXd& local) {
  const MatrixXd u = displacements(body, solid, local);
  MatrixXd forces = MatrixXd::Zero(u.rows(), 1), own, pull;
  double energy = 0;
  const ElasticLaw law(body.material);
  for_each_cell(*body.cells, [&](SolidCell cell, std::span<const int> nodes) {
    const CellPlaces places = places_of(body.nodes, nodes);
    gather_fields(u, nodes, own);
    pull.setZero(own.rows(), own.cols());
    for (const ReferencePoint& at : reference_points(cell, SolidRule::energy)) {
      const SolidPoint point = solid_point(at, places);
      const Matrix3d H = own * point.gradients.transpose(),
                     strain = 0.5 * (H + H.transpose() + H.transpose() * H),
                     stress = point.weight * law.stress(strain);
      energy += 0.5 * strain.cwiseProduct(stress).sum();
      add_forces(stress + H * stress, point.gradients, pull);
    }
    scatter_fields(pull, nodes, forces);
  });
  energy -= 0.5 * forces.col(0).dot(condensation(body)->held_answer(forces).col(0));
  return energy / model_energy(solid.model, local) - 1;
}

}  // namespace flexopt
