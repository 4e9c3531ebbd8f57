#include "core/reduction/superelement/plate_body.hpp"

#include "core/reduction/superelement/condensation.hpp"
#include "core/reduction/superelement/linear_plate.hpp"

namespace flexopt {

std::shared_ptr<const PlateMesh> plate_body_mesh(const PlateBody& body, Interface interface) {
  const bool leaf = interface == Interface::rigid_edges;
  PlateShape shape = plate_shape(body.plate, body.mesh, leaf && body.free_edges[0]);
  shape.linear = !leaf;
  shape.transverse_shear = leaf && body.transverse_shear;
  return std::make_shared<PlateMesh>(shape);
}

PlateMatrices plate_matrices(const PlateBody& body, const PlateMesh& mesh) {
  const linear_plate::Matrices matrices = linear_plate::assemble(body, mesh);
  return {MatrixXd(matrices.stiffness), MatrixXd(matrices.mass)};
}

CondensedPlate condense(const PlateBody& body, const PlateCondensation& condensation) {
  return condense(body, condensation, plate_body_mesh(body, condensation.interface));
}

CondensedPlate condense(const PlateBody& body, const PlateCondensation& condensation,
                        std::shared_ptr<const PlateMesh> mesh) {
  LeafSpring flat = body.plate;
  flat.origin.setZero();
  flat.axes.setIdentity();
  const LeafScale scale(flat, mesh->shape().flexure);
  const auto condensed = std::make_shared<const Condensation>(body, condensation, mesh);
  return {mesh, scale, 0.5 * flat.length * Vector3d::UnitX(),
          in_units(condensed->model(), scale.length, scale.energy, scale.mass), condensed};
}

}  // namespace flexopt
