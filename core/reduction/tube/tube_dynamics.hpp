#pragma once
// Internal dynamics of a tube leaf from tables: stiffness and mass of its internal amplitudes as
// polynomials about its bent states, joined along the ray as the fields are. Equations (D1) to
// (D5) of core/reduction/README.md.
#include <memory>
#include <vector>

#include "core/reduction/expansion/dynamics_expansion.hpp"

namespace flexopt {

/// Largest relative change of the internal stiffness by the last degree of its tables: beyond it a
/// frequency may be off by more than about 0.15 %.
inline constexpr double largest_dynamics_change = 0.03;

class TubeDynamics {
 public:
  static constexpr int amplitudes = field_loads;
  static constexpr int rates = 12 + amplitudes;  ///< those of DynamicsExpansion::mass

  /// No tables where loads.found is false. `leaf`: undeflected. `ray`: D of the tube.
  TubeDynamics(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, double force_centre);

  bool possible() const { return loads_.found; }
  /// The bent state at which `leaf` stands, beyond the others.
  void add(const ChordLeaf& leaf, double sigma);

  /// A state: along the ray (signed), off it, twist [rad]; forces over their scale.
  struct Place {
    double sigma = 0, tau = 0, twist = 0;
    Vector3d f = Vector3d::Zero();
  };
  /// In the scaled units of the plate, chord axes.
  struct Answer {
    /// Why the tables do not hold here; empty where they do.
    std::string reason;
    Eigen::Matrix<double, amplitudes, amplitudes> stiffness;
    /// Over (v, ω, rates of (σ, τ, φ), of (N, M1, M2) with the amplitudes' static parts, those of
    /// the amplitudes beyond their static parts).
    Eigen::Matrix<double, rates, rates> mass;
    /// ω² of the fifth of the eight internal motions between held edges, the smaller one of both
    /// neighbouring bent states: up to there every mode is well represented.
    double reach = 0;
  };
  /// Needs two bent states; sigma inside of them or their mirror images.
  Answer evaluate(const Place& place) const;
  /// By the last degree: |L⁻¹ (K⁻ − K) L⁻ᵀ|, K = L Lᵀ the internal stiffness, K⁻ the one to a
  /// total degree of 1.
  double change(const Place& place) const;
  /// Motion of the stations for the rates of Answer::mass, chord axes; 6 rows each.
  MatrixXd stations(const Place& place) const;

 private:
  struct Slot {
    int matrix, row, column;
  };
  struct Interval {
    double start, width;
    MatrixXd even, odd;              ///< entries × basis functions
    MatrixXd lower_even, lower_odd;  ///< of the stiffness alone, to a total degree of 1
  };
  struct Node {
    double sigma;
    MatrixXd even, odd;  ///< entries × monomials
    MatrixXd stations;   ///< entries × monomials, all parities
    double reach;
  };
  struct Entries;
  struct Local;

  void make_slots();
  Node make_node(const DynamicsExpansion& expansion, double sigma) const;
  Interval make_interval(const Node& a, const Node& b) const;
  Local locate(const Place& place) const;
  void read(const Local& at, bool all, int total, Entries& entries) const;
  VectorXd mirror_signs() const;

  Eigen::Matrix2d ray_;
  double force_centre_;
  InternalLoads loads_;
  std::vector<Slot> even_, odd_;
  int even_stiffness_ = 0, odd_stiffness_ = 0;  ///< so many of them come first
  std::vector<Node> nodes_;
  std::vector<Interval> intervals_;
};

}  // namespace flexopt
