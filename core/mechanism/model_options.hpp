#pragma once
// How a mechanism is modelled and solved. Plain data.
#include <array>
#include <memory>

#include "core/mechanism/mechanism.hpp"

namespace flexopt {

class TubeAtlas;

enum class Accuracy { reduced, full };

/// How a reduced leaf is made.
enum class Reduction {
  mixed_potential,       ///< one tube for the whole leaf
  linear_craig_bampton,  ///< linear superelements in floating frames
  modal_derivatives,     ///< full superelements projected on boundary modes and their derivatives
  quadratic_manifold,    ///< as modal_derivatives, whose amplitudes follow the boundary's
};

/// Which fields are added to the boundary modes.
enum class ModalDerivativeSet {
  bending,     ///< derivatives of the two bending modes by each other: three
  all,         ///< derivatives of all six deformations by each other
  third_order  ///< all, and the third-order fields of the static solution
};

/// Kinematics of a leaf: a thin plate, or a beam whose lines across stay straight.
enum class Flexure { plate, beam };

/// Whether the clamped ends of a beam hold the warping of its section.
enum class Warping { clamped, free };

/// Mass of the leaves in the frequencies.
enum class LeafMass {
  consistent,  ///< of the deflected leaf
  constant,    ///< of the undeflected one, turned with its chord frame
};

/// Whether reduced leaves are looked up in an atlas instead of built.
enum class AtlasUse {
  off,
  automatic,  ///< where there is one
  required
};

/// Elements [along, across] per leaf where nothing else is asked for.
inline constexpr std::array<int, 2> default_mesh{12, 5};

/// How a mechanism is modelled.
struct ModelOptions {
  Accuracy accuracy = Accuracy::reduced;
  Flexure flexure = Flexure::plate;
  Warping warping = Warping::clamped;      ///< of beams
  std::array<int, 2> mesh = default_mesh;  ///< elements [along, across]; a beam has 1 across
  bool free_edge_torsion = true;  ///< 3-D torsion layer of the free edges; off: thin-shell limit
  bool transverse_shear = true;   ///< of the leaves; off: Kirchhoff's plate, Euler's beam
  Reduction method = Reduction::mixed_potential;
  /// Superelements along a leaf and across (linear ones only); across 0: of two nodes, between
  /// rigid lines.
  std::array<int, 2> superelements{1, 0};
  ModalDerivativeSet modal_derivatives = ModalDerivativeSet::all;  ///< of Reduction of that name
  int degree = 5;  ///< of the reduced potential: 5 or 7
  LeafMass mass = LeafMass::consistent;
  /// Fixed-interface modes kept per leaf for frequencies, at least; 0: none, nor any other internal
  /// shape, so that leaves only move as their edges make them.
  int leaf_modes = 2;
  AtlasUse atlas_use = AtlasUse::automatic;
  /// Look-up table for leaves of this mesh; null: every leaf model is built. The reader of the job
  /// opens the file.
  std::shared_ptr<const TubeAtlas> atlas = {};
};

/// A wire is a beam and a folded leaf a plate, whatever the other leaves are.
inline Flexure flexure_of(const LeafSpring& leaf, const ModelOptions& model) {
  if (leaf.fold) return Flexure::plate;
  return leaf.section == Section::circular ? Flexure::beam : model.flexure;
}

/// Newton's iteration and the step control of the path.
struct NewtonOptions {
  double tolerance = 1e-9;  ///< largest last correction, lengths divided by the leaf length [-]
  int max_iterations = 25;
  int max_halvings = 8;  ///< of a step of the stroke or of the loads before the path is given up
};

}  // namespace flexopt
