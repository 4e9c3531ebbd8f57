#pragma once
// Solid cells of isotropic material: shape functions, integration points and their rates while the
// nodes move, matrices of one cell.
#include <span>
#include <vector>

#include "core/math/types.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Numbers of the nodes of one cell: three of each, a column a node, and one of each. On the stack.
using CellPlaces = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 20>;
using CellValues = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 20, 1>;

/// Points for the energy: 2 × 2 × 2 of a hexahedron (C3D20R), 3 × 3 of a wedge (C3D15), 4 of a
/// tetrahedron (C3D10). Points for the mass: those of the hexahedron again, of the others a rule
/// that is exact to degree 4 where the cell is straight.
enum class SolidRule { energy, mass };

/// A place of a reference cell: (ξ, η, ζ) in [−1, 1]³ of a hexahedron; of a wedge two triangular
/// coordinates and ζ in [−1, 1]; three volume coordinates of a tetrahedron.
struct ReferencePoint {
  double weight = 0;  ///< of integration over the reference cell
  CellValues shape;   ///< N
  CellPlaces slopes;  ///< ∂N/∂ξ
};
/// Shape functions there, without a weight.
ReferencePoint reference_point(SolidCell cell, const Vector3d& place);
/// Place of a node of the reference cell.
Vector3d reference_node(SolidCell cell, int node);
/// Integration points of a reference cell. Kept for good.
const std::vector<ReferencePoint>& reference_points(SolidCell cell, SolidRule rule);

/// A point of a cell in space.
struct SolidPoint {
  double weight = 0;     ///< of integration: that of the reference cell · det J [m³]
  CellPlaces gradients;  ///< ∂N/∂X [1/m]
};
SolidPoint solid_point(const ReferencePoint& at, const CellPlaces& nodes);
/// Rates while the nodes move by `motion`, in closed form with L = ∂(motion)/∂X:
/// d(∂N/∂X) = −Lᵀ ∂N/∂X, d weight = weight tr L.
SolidPoint point_rate(const SolidPoint& at, const CellPlaces& motion);

/// Stress σ = λ tr ε + 2 μ ε of a strain.
struct ElasticLaw {
  double lambda = 0, mu = 0;  ///< [Pa]

  explicit ElasticLaw(const Material& material);
  /// Rate along a change of the material.
  ElasticLaw(const Material& material, const Material& direction);
  /// Stress of the symmetric part of a gradient of displacement ∂u_i/∂X_j.
  Matrix3d stress(const Matrix3d& slopes) const {
    Matrix3d s = mu * (slopes + slopes.transpose());
    s.diagonal().array() += lambda * slopes.trace();
    return s;
  }
};

/// Stiffness over the displacements of the nodes, x y z of one after the other, 3n × 3n [N/m].
void cell_stiffness(SolidCell cell, const CellPlaces& nodes, const ElasticLaw& law, MatrixXd& K);
/// Mass ∫ρ N_a N_b of one direction, n × n [kg].
void cell_mass(SolidCell cell, const CellPlaces& nodes, double density, MatrixXd& M);
/// Its rate.
void cell_mass_rate(SolidCell cell, const CellPlaces& nodes, double density,
                    const CellPlaces& motion, double density_rate, MatrixXd& M);

/// Places of the nodes of a cell.
CellPlaces places_of(const std::vector<Vector3d>& places, std::span<const int> nodes);

/// Fields (3 rows for each node of the mesh, a column for each field) at the nodes of a cell: rows
/// x y z of one field after the other, a column for each node. A gradient of all of them is then
/// sums of columns: slopes.col(j) = Σ_a of_cell.col(a) · gradients(j, a).
void gather_fields(const Eigen::Ref<const MatrixXd>& fields, std::span<const int> nodes,
                   MatrixXd& of_cell);
/// Adds such numbers of a cell to those of the mesh.
void scatter_fields(const MatrixXd& of_cell, std::span<const int> nodes, MatrixXd& fields);
/// ∂u_i/∂X_j of all fields: rows as in `of_cell`, columns j; resized.
void slopes_of(const MatrixXd& of_cell, const CellPlaces& gradients, MatrixXd& slopes);
/// Adds the forces Σ_j stresses(·, j) gradients(j, a) of stresses that have the form of slopes.
void add_forces(const MatrixXd& stresses, const CellPlaces& gradients, MatrixXd& of_cell);

/// Calls visit(cell, nodes) for each cell of a mesh.
template <class Visit>
void for_each_cell(const SolidCells& cells, Visit&& visit) {
  for (const SolidCells::Block& block : cells.blocks) {
    const auto n = static_cast<std::size_t>(nodes_of(block.cell));
    for (std::size_t first = 0; first + n <= block.nodes.size(); first += n)
      visit(block.cell, std::span<const int>(block.nodes).subspan(first, n));
  }
}

}  // namespace flexopt
