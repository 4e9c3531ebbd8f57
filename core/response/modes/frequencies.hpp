#pragma once
// Natural frequencies about an equilibrium, drive free and drive locked, with the modes sorted into
// drive, end-effector, intermediate body and leaf.
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "core/equilibrium/system.hpp"
#include "core/math/lanczos.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/response/response.hpp"

namespace flexopt {

/// The classical mass of a flexible body: that of the undeflected leaf, turned with its chord
/// frame. For comparison; the mass of a leaf follows its deflection by default.
class ConstantMass {
 public:
  /// Uses undeflected full leaves, whatever the accuracy of the model.
  ConstantMass(const Mechanism& mechanism, const ModelOptions& model);

  /// Craig–Bampton dynamics of a leaf of the assembled system: the undeflected leaf's mass,
  /// internal shapes and their frequencies, M = T M0 Tᵀ with T the turn of the chord frame (of the
  /// base edge, where the tip is free) for every vector of three.
  LeafDynamics dynamics(const System& system, int leaf, DynamicsRequest request);

 private:
  std::vector<std::unique_ptr<LeafElement>> undeflected_;
  std::map<std::tuple<int, int, bool>, LeafDynamics> known_;  ///< by (leaf, modes, shapes)
};

struct FrequencyOptions {
  int count = 8;
  bool free = true;           ///< whether frequencies with the drive free are wanted, too
  int leaf_modes = 2;         ///< fixed-interface modes per leaf, at least; 0: none
  double cutoff_ratio = 1.2;  ///< leaf modes up to this multiple of the highest frequency wanted
  ConstantMass* constant_mass = nullptr;  ///< instead of the leaves' own mass
  bool motions = true;                    ///< with Mode::motion
  bool shapes = false;                    ///< with the motions of bodies, leaves and elastic bodies
};

struct Frequencies {
  std::vector<Mode> free, locked;  ///< ascending; a negative frequency marks a growing motion
  double check = 0;                ///< largest internal correction of the condensed leaves
};

/// Matrices one below the other.
MatrixXd stacked(const std::vector<MatrixXd>& parts);

/// Root of the bodies' mass times their motions q (columns) in their own axes: first part of
/// Mode::motion.
MatrixXd body_motions(const System& system, const Eigen::Ref<const MatrixXd>& q);

/// Frequency of a squared one; negative of a negative [Hz].
double hertz(double omega2);

/// Modes by their squared frequencies, motions φ (columns; the bodies' rows first) and M φ: shares
/// of the modal kinetic energy. The drives' is that of the static motions `shapes` under drive
/// loads; the rest is split between the bodies and the motions of the leaves about their static
/// shapes, mixed terms half each. `carried(F)`: the share of forces that the bodies bear.
std::vector<Mode> classified_modes(const Mechanism& mechanism, const VectorXd& omega2,
                                   const MatrixXd& phi, const MatrixXd& M_phi, MatrixXd shapes,
                                   const LinearMap& mass, const LinearMap& carried);

/// Solves (K − ω² M) φ = 0 over the bodies and the leaves' fixed-interface modes. The system must
/// be assembled at an equilibrium. Of each leaf so many modes are taken as the frequencies need.
/// Nothing where some of the lowest are missing.
std::optional<Frequencies> natural_frequencies(System& system, const FrequencyOptions& options);

}  // namespace flexopt
