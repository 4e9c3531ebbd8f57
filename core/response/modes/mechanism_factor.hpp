#pragma once
// A mechanism linearised about an equilibrium, with the interiors of the leaves, the
// forces at their material points and the multipliers of the joints as unknowns: K⁻¹ B and M B of
// all of them on the leaves' own factors.
#include <memory>
#include <optional>
#include <vector>

#include "core/elements/leaf/leaf_linear.hpp"
#include "core/elements/leaf/leaf_rows.hpp"
#include "core/equilibrium/free_motions.hpp"
#include "core/math/answer.hpp"
#include "core/math/decompositions.hpp"
#include "core/math/lanczos.hpp"

namespace flexopt {

/// Vectors are (displacement, spin) of every body, then of every leaf its internal unknowns and the
/// force at its material point, if it has one, then of every elastic body its fixed-interface
/// modes, then the multipliers of the joints and of the drives that are no coordinates. The row of
/// such a force or multiplier is its condition. Free drives have no multiplier, and nothing counts
/// in its row.
class MechanismFactor {
 public:
  /// The system must be assembled at an equilibrium; its state is kept. None where a leaf has no
  /// linearised interior. Elastic bodies have fixed-interface modes for so many frequencies; for 0
  /// none.
  static Answer<MechanismFactor> of(System& system, int frequencies = 0);

  int size() const { return size_; }
  int bodies() const { return bodies_; }                             ///< coordinates of the bodies
  int conditions() const { return system_->constraints().count(); }  ///< of joints and drives
  int drives() const { return static_cast<int>(system_->drives().size()); }
  const System& system() const { return *system_; }

  MatrixXd solve(const MatrixXd& B) const;         ///< drives free, but for those that stay held
  MatrixXd solve_locked(const MatrixXd& B) const;  ///< drives held
  MatrixXd solve_held(const MatrixXd& B) const;    ///< all bodies held
  MatrixXd mass(const MatrixXd& B) const;
  /// solve() or solve_locked(), and mass(), as maps that live as long as this.
  LinearMap solver(bool drives_held) const {
    return
        [this, drives_held](const MatrixXd& B) { return drives_held ? solve_locked(B) : solve(B); };
  }
  LinearMap masses() const {
    return [this](const MatrixXd& B) { return mass(B); };
  }
  /// Motions that bodies moving by the columns of q leave the leaves in, without force on them.
  MatrixXd static_motion(const MatrixXd& q) const;

  /// State and drive loads (last rows) that balance forces B while the strokes (rows) grow by
  /// `strokes` (column by column), or while drives are free, but for those that stay held.
  MatrixXd balance(const MatrixXd& B, const std::optional<MatrixXd>& strokes) const;
  /// Balances while the strokes stay (`driven`), or while drives are free.
  MatrixXd balance(const MatrixXd& B, bool driven) const {
    return balance(
        B, driven ? std::optional<MatrixXd>(MatrixXd::Zero(drives(), B.cols())) : std::nullopt);
  }

  struct Leaf {
    std::shared_ptr<const LeafLinear> linear;
    bool full;  ///< at full accuracy
    LeafRows rows;
    int offset;  ///< of its internal rows in a vector
    struct Side {
      int body, column, size;  ///< where (base body, tip body, point) have its coordinates
    };
    std::vector<Side> sides;   ///< those that move
    MatrixXd shapes;           ///< unknowns per increment of (base body, tip body, point), global
    MatrixXd point_stiffness;  ///< condensed: 3 × 15

    int row(const Side& side) const { return rows.internal() + side.column; }
  };
  const std::vector<Leaf>& leaves() const { return leaves_; }
  struct ElasticInside {
    int offset;  ///< of the modes in a vector
    std::shared_ptr<const FixedInterfaceModes> modes;
    MatrixXd coupling;  ///< held_coupling()
    Lu stiffness;

    int count() const { return static_cast<int>(modes->count()); }
  };
  /// The insides of all elastic bodies; there are none for 0 frequencies.
  const std::vector<ElasticInside>& elastic() const { return elastic_; }
  /// For how many frequencies elastic bodies have modes.
  int frequencies() const { return frequencies_; }
  /// Forces B on the bodies and the conditions, those on the leaves carried there by their static
  /// shapes.
  MatrixXd condensed(const MatrixXd& B) const;
  /// What natural_frequencies() calls Mode::motion.
  MatrixXd motion(const MatrixXd& Y) const;
  /// K⁻¹ E of the forces E of unit drive loads, a column for each drive, all of them free.
  const MatrixXd& drive_answers() const { return drive_answers_; }
  /// Motions of unit strokes, one drive each, the others held, and of conditions the multipliers
  /// that this takes.
  MatrixXd drive_shapes() const;
  /// C and D of (S13), of those drives that are free where others stay held.
  struct FreeDrives {
    MatrixXd shapes, compliance;
  };
  FreeDrives free_drives() const;
  /// Rows of drives that are conditions and free.
  std::vector<int> drive_rows() const;

  /// Rows of a leaf in Y.
  MatrixXd leaf_rows(const Leaf& leaf, const MatrixXd& Y) const;
  /// Y += factor · rows of a leaf, as forces.
  void add_leaf_force(const Leaf& leaf, double factor, const MatrixXd& rows, MatrixXd& Y) const;
  void clear_held(MatrixXd& Y) const;

 private:
  MechanismFactor(System& system, std::vector<std::shared_ptr<const LeafLinear>> leaves,
                  int frequencies);
  void add_leaf(const System& system, int i, std::shared_ptr<const LeafLinear> linear);
  /// Motions of all unknowns from the motions q of the bodies and the multipliers; those of the
  /// leaves follow from q and their forces in B.
  MatrixXd expanded(const MatrixXd& B, const MatrixXd& q) const;

  const System* system_;
  int bodies_ = 0, size_ = 0, frequencies_ = 0;
  std::vector<Leaf> leaves_;
  std::vector<ElasticInside> elastic_;
  TangentFactor tangent_, locked_tangent_;  ///< of the bodies and the conditions
  MatrixXd drive_answers_;
  MatrixXd drive_compliance_;  ///< Eᵀ K⁻¹ E: strokes by drive loads, all drives free
  BlockMatrix body_mass_;
};

// The whole of a mechanism moved as one body, the ground with it: how its ground shakes it.

/// Columns: unit translations of everything along the global axes, then unit rotations about the
/// global axes through the origin, at the present state.
struct RigidMotion {
  MatrixXd motion;   ///< rows of the factor × 6: bodies, and leaves as their edges take them along
  MatrixXd inertia;  ///< M times it, that of the grounded edges included
};

RigidMotion rigid_motion(const MechanismFactor& factor);

/// Rows of a leaf's edges on the ground (LeafRows) for translations of the ground, 3 × columns.
MatrixXd grounded_rows(const MechanismFactor& factor, int leaf, const MatrixXd& translations);

}  // namespace flexopt
