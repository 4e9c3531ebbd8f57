#include "core/reduction/superelement/plate_body.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/math/lanczos.hpp"
#include "core/reduction/superelement/linear_plate.hpp"

namespace flexopt {

std::shared_ptr<const PlateMesh> plate_body_mesh(const PlateBody& body, Interface interface) {
  const bool leaf = interface == Interface::rigid_edges;
  PlateShape shape = plate_shape(body.plate, body.mesh, leaf && body.free_edges[0]);
  shape.linear = !leaf;
  shape.transverse_shear = leaf && body.transverse_shear;
  return std::make_shared<PlateMesh>(shape);
}

namespace {

using namespace linear_plate;

// Modes beyond the kept ones: they make the gap behind the kept ones wide.
constexpr int guard = 3;

bool in_use(const PlateBody& body, const PlateMesh& mesh, int i, int j) {
  for (int p = i - 1; p <= i; ++p)
    for (int q = j - 1; q <= j; ++q)
      if (p >= 0 && q >= 0 && p < mesh.elements_along() && q < mesh.elements_across() &&
          cell_thickness(body, p, q) > 0)
        return true;
  return false;
}

MatrixXd symmetric(const MatrixXd& A) { return 0.5 * (A + A.transpose()); }

// [boundary, coupling; couplingᵀ, modal].
MatrixXd bordered(const MatrixXd& boundary, const MatrixXd& coupling, const MatrixXd& modal) {
  const Eigen::Index n = boundary.rows(), k = modal.rows();
  MatrixXd A(n + k, n + k);
  A.topLeftCorner(n, n) = symmetric(boundary);
  A.topRightCorner(n, k) = coupling;
  A.bottomLeftCorner(k, n) = coupling.transpose();
  A.bottomRightCorner(k, k) = symmetric(modal);
  return A;
}

// K_CB, M_CB and Φ_CB of (R11): lengths over L, energies over D, masses over ρ t L⁴.
SuperelementModel condensed(const PlateBody& body, const PlateCondensation& condensation,
                            const PlateMesh& mesh) {
  [[maybe_unused]] const int nx = mesh.elements_along(), ny = mesh.elements_across();
  assert(body.cells.size() == 0 || (body.cells.rows() == nx && body.cells.cols() == ny));
  const Dofs dof(mesh);
  FreeDofs free(mesh);
  const Interfaces c = interfaces(mesh, condensation, free);
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j < mesh.nodes_per_line(); ++j)
      if (in_use(body, mesh, i, j))
        for (int d = 0; d < 3; ++d)
          for (int k = 0; k < 4; ++k)
            if (!free.held[dof(i, j, d, k)]) free.release(dof(i, j, d, k));

  const Matrices matrices = assemble(body, mesh);
  const SparseMatrix &stiffness = matrices.stiffness, &mass = matrices.mass;
  SparseMatrix to_dofs(dof.count(), free.unknowns);  // of the free unknowns
  to_dofs.setFromTriplets(free.free.begin(), free.free.end());
  const Eigen::SimplicialLDLT<SparseMatrix> factor(
      SparseMatrix(to_dofs.transpose() * stiffness * to_dofs));
  assert(factor.info() == Eigen::Success);

  // boundary modes Φ = B − F K_ff⁻¹ Fᵀ K B, vibration modes F ψ (R11)
  const MatrixXd KB = stiffness * c.boundary;
  MatrixXd boundary = c.boundary - to_dofs * factor.solve(MatrixXd(to_dofs.transpose() * KB));
  const int kept = std::min(condensation.vibration_modes, free.unknowns / 4);
  VectorXd omega2;
  MatrixXd modes(free.unknowns, 0);  // M-orthonormal
  if (kept > 0) {
    const SparseMatrix free_mass = to_dofs.transpose() * mass * to_dofs;
    const LowestPairs pairs = lowest_pairs(
        free.unknowns, std::min(kept + guard, free.unknowns / 2), 2,
        [&](const MatrixXd& X) -> MatrixXd { return factor.solve(X); },
        [&](const MatrixXd& X) -> MatrixXd { return free_mass * X; }, 1e-9);
    assert(pairs.converged);
    omega2 = pairs.values.head(kept);
    modes = pairs.vectors.leftCols(kept);
  }
  const MatrixXd V = to_dofs * modes;
  SuperelementModel model;
  for (const Vector3d& node : c.nodes) model.nodes.push_back(node - 0.5 * Vector3d::UnitX());
  MatrixXd K = boundary.transpose() * (stiffness * boundary),
           M = boundary.transpose() * (mass * boundary);
  if (c.penalty.size() > 0) {
    K += c.penalty;
    M += c.penalty_mass;
  }
  model.stiffness = bordered(K, MatrixXd::Zero(K.rows(), kept), MatrixXd(omega2.asDiagonal()));
  model.mass = bordered(M, boundary.transpose() * (mass * V), MatrixXd::Identity(kept, kept));
  model.frame_modes = c.middle * boundary;
  model.recovery = std::move(boundary);
  return model;
}

// A model in units of its body in other units: L, D and ρ t L⁴ of the body.
SuperelementModel in_units(const SuperelementModel& model, double length, double energy,
                           double mass) {
  const int n = model.coordinates();
  VectorXd unit = VectorXd::Constant(model.stiffness.rows(), 1 / std::sqrt(mass));
  for (int i = 0; i < n; i += 6) {
    unit.segment<3>(i).setConstant(1 / length);
    unit.segment<3>(i + 3).setOnes();
  }
  SuperelementModel other;
  for (const Vector3d& node : model.nodes) other.nodes.push_back(length * node);
  other.stiffness = energy * unit.asDiagonal() * model.stiffness * unit.asDiagonal();
  other.mass = mass * unit.asDiagonal() * model.mass * unit.asDiagonal();
  other.frame_modes = model.frame_modes * unit.head(n).asDiagonal();
  other.frame_modes.topRows<3>() *= length;
  other.recovery = model.recovery * unit.head(n).asDiagonal();
  return other;
}

}  // namespace

CondensedPlate condense(const PlateBody& body, const PlateCondensation& condensation) {
  return condense(body, condensation, plate_body_mesh(body, condensation.interface));
}

CondensedPlate condense(const PlateBody& body, const PlateCondensation& condensation,
                        std::shared_ptr<const PlateMesh> mesh) {
  LeafSpring flat = body.plate;
  flat.origin.setZero();
  flat.axes.setIdentity();
  const LeafScale scale(flat, mesh->shape().flexure);
  return {mesh, scale, 0.5 * flat.length * Vector3d::UnitX(),
          in_units(condensed(body, condensation, *mesh), scale.length, scale.energy, scale.mass)};
}

CondensedPlate condense_beam(const LeafSpring& beam, int elements, Warping warping,
                             int vibration_modes, bool transverse_shear) {
  assert(elements >= 2 && elements % 2 == 0);
  const ModelOptions options{.flexure = Flexure::beam,
                             .warping = warping,
                             .mesh = {elements, 1},
                             .transverse_shear = transverse_shear};
  const PlateBody body{beam, {elements, 1}};
  return condense(
      body,
      {.interface = Interface::rigid_edges, .mesh_nodes = {}, .vibration_modes = vibration_modes},
      std::make_shared<const PlateMesh>(leaf_shape(beam, options)));
}

}  // namespace flexopt
