#pragma once
// Static condensation of a linear plate or beam to its interface nodes with its lowest
// fixed-interface modes, and the exact derivatives of both in the shape on the same factor:
// equation (R11) of core/reduction/README.md.
#include <Eigen/SparseCholesky>
#include <array>
#include <memory>

#include "core/reduction/superelement/plate_body.hpp"

namespace flexopt {

/// Models are in units of the body: lengths over L, energies over D, masses over ρ t L⁴.
class Condensation {
 public:
  Condensation(const PlateBody& body, const PlateCondensation& condensation,
               std::shared_ptr<const PlateMesh> mesh);

  const PlateMesh& mesh() const { return *mesh_; }
  const SuperelementModel& model() const { return model_; }

  /// Derivatives of the model in w/L, t/L, ν (of a wire: none in w/L, all in t/L). The kept modes
  /// do not turn into each other, so that the modes' block of K stays diagonal only where their
  /// frequencies are one; M stays 1 there. A mode that is left out and as high as a kept one is
  /// taken for not coupled to it.
  std::array<SuperelementModel, 3> shape_rates() const;

 private:
  using SparseMatrix = Eigen::SparseMatrix<double>;

  PlateBody body_;
  PlateCondensation condensation_;
  std::shared_ptr<const PlateMesh> mesh_;
  SparseMatrix stiffness_, mass_, free_;        ///< of all dofs; dofs by free unknowns
  SparseMatrix free_mass_;                      ///< Fᵀ M F
  Eigen::SimplicialLDLT<SparseMatrix> factor_;  ///< of Fᵀ K F
  MatrixXd boundary_;                           ///< Φ
  int kept_ = 0;
  VectorXd omega2_;  ///< of the kept modes and a few more
  MatrixXd modes_;   ///< ψ of them, M-orthonormal
  SuperelementModel model_;
};

/// A model in units of its body, or a rate of it, in other units: L, D and ρ t L⁴ of the body.
SuperelementModel in_units(const SuperelementModel& model, double length, double energy,
                           double mass);

}  // namespace flexopt
