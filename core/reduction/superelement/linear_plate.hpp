#pragma once
// A linear plate or beam on its mesh and how interface nodes hold it: equations (R11)–(R13) of
// README.md. Lengths over L, energies over D, masses over ρ t L⁴.
#include <Eigen/SparseCore>
#include <vector>

#include "core/reduction/superelement/plate_body.hpp"

namespace flexopt::linear_plate {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

/// Numbers of the nodal dofs, in the order of PlateLeaf::nodal: function k of component c at node
/// (i, j).
struct Dofs {
  int per_line, lines;
  explicit Dofs(const PlateMesh& mesh) : per_line(mesh.functions_per_line()), lines(mesh.lines()) {}
  int operator()(int i, int j, int c, int k) const {
    return 3 * per_line * i + per_line * c + 4 * j + k;
  }
  int count() const { return 3 * per_line * lines; }
};

/// Over that of the plate; 0 where the cell is left out.
inline double cell_thickness(const PlateBody& body, int i, int j) {
  return body.cells.size() == 0 ? 1.0 : body.cells(i, j);
}

/// Unconstrained, dofs × dofs. The membrane takes the integration rule of the plate leaf.
struct Matrices {
  SparseMatrix stiffness, mass;
};
Matrices assemble(const PlateBody& body, const PlateMesh& mesh);
/// Nodal dofs as a linear map of interface coordinates and free unknowns: the part that the shape
/// does not enter.
struct FreeDofs {
  Triplets free;  ///< (dof, unknown, factor)
  int unknowns = 0;
  std::vector<bool> held;  ///< dofs already spoken for

  explicit FreeDofs(const PlateMesh& mesh) : held(Dofs(mesh).count(), false) {}
  void release(int dof) {
    free.emplace_back(dof, unknowns++, 1.0);
    held[dof] = true;
  }
  void hold(int dof) { held[dof] = true; }
};

/// The part that the shape enters, for m interface nodes.
struct Interfaces {
  std::vector<Vector3d> nodes;
  MatrixXd boundary;               ///< dofs × 6m
  MatrixXd penalty, penalty_mass;  ///< 6m × 6m, added to K_CB and M_CB; may be empty
  MatrixXd middle;  ///< 6 × dofs: displacement and rotation (w,y, −w,x, ½(v,x − u,y)) in the middle
};
/// Holds and releases what the interface nodes decide about; all other dofs are left open.
Interfaces interfaces(const PlateMesh& mesh, const PlateCondensation& condensation, FreeDofs& free);
}  // namespace flexopt::linear_plate
