#pragma once
// A mechanism of full leaves linearised about an equilibrium, with the interiors of the leaves as
// unknowns: K⁻¹ B and M B of all of them on the leaves' own factors.
#include <memory>
#include <vector>

#include "core/elements/full_leaf.hpp"
#include "core/elements/plate_gradient.hpp"
#include "core/equilibrium/system.hpp"

namespace flexopt {

/// Vectors are (displacement, spin) of every body, then the internal unknowns of every leaf.
class MechanismFactor {
 public:
  /// The system must be assembled at an equilibrium; its leaves be FullLeaf without material
  /// points. `rates`: of the leaves' meshes, equal leaves sharing one.
  MechanismFactor(System& system, const std::vector<std::shared_ptr<const PlateMeshRate>>& rates);

  int size() const { return size_; }
  int bodies() const { return bodies_; }  ///< coordinates of the bodies
  const System& system() const { return *system_; }

  MatrixXd solve(const MatrixXd& B) const;         ///< drive free
  MatrixXd solve_locked(const MatrixXd& B) const;  ///< drive held
  MatrixXd mass(const MatrixXd& B) const;

  /// State and drive load (last row) that balance forces B at a constant stroke.
  MatrixXd balance(const MatrixXd& B) const;

  struct Leaf {
    const FullLeaf* full;
    std::unique_ptr<PlateGradient> gradient;
    int offset, unknowns;
    std::array<int, 2> body;  ///< of the edges, or −1
    MatrixXd shapes;          ///< unknowns per increment of (base body, tip body), global
  };
  const std::vector<Leaf>& leaves() const { return leaves_; }
  /// Motion of the mechanism that follows statically from that of the bodies.
  VectorXd static_motion(const VectorXd& bodies) const;
  /// What natural_frequencies() calls Mode::motion.
  VectorXd motion(const VectorXd& y) const;
  /// K⁻¹ e of the drive.
  const VectorXd& drive_answer() const { return drive_answer_; }
  int drive() const { return drive_; }  ///< its row

  /// Rows of a leaf for PlateGradient.
  MatrixXd leaf_rows(const Leaf& leaf, const MatrixXd& Y) const;
  /// Y += factor · rows of PlateGradient, as forces.
  void add_leaf_force(const Leaf& leaf, double factor, const MatrixXd& rows, MatrixXd& Y) const;
  void clear_held(MatrixXd& Y) const;

 private:
  MatrixXd condensed(const MatrixXd& B) const;
  MatrixXd expanded(const MatrixXd& B, const MatrixXd& q) const;

  const System* system_;
  int bodies_ = 0, size_ = 0, drive_ = 0;
  std::vector<Leaf> leaves_;
  VectorXd scale_;
  Eigen::PartialPivLU<MatrixXd> tangent_;  ///< of the bodies, scaled
  VectorXd drive_answer_;                  ///< K⁻¹ e of the drive
  MatrixXd body_mass_;
};

}  // namespace flexopt
