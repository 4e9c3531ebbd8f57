#pragma once
// Internal dynamics of a tube leaf from tables: stiffness and mass of its internal amplitudes as
// polynomials about its bent states, joined along the ray as the fields are. Equations (D1) to
// (D5) of core/reduction/README.md.
#include <array>
#include <cassert>
#include <memory>
#include <vector>

#include "core/reduction/expansion/dynamics_expansion.hpp"
#include "core/reduction/tube/state_table.hpp"

namespace flexopt {

/// Largest relative change of the internal stiffness by the last degree of its tables. Calibrated
/// against full leaves: frequencies are then off by 0.21 % at most where the mechanism carries
/// thirty times the mass of its leaves, by 0.8 % where it carries as much as they weigh.
inline constexpr double largest_dynamics_change = 0.06;

/// Tables about one bent state.
struct DynamicsNode {
  StateTable table;
  MatrixXd stations;  ///< entries of the stations' motion × (1, σ); empty where not wanted
};
enum class StationsWanted { no, yes };
/// `leaf` stands at the bent state `sigma` of the ray, the first column of `ray`. `units`: U of the
/// amplitudes U⁻ᵀ a that the tables are over; where it is empty, it becomes that of this state, at
/// which the stiffness k of these amplitudes is 1.
DynamicsNode dynamics_node(const ChordLeaf& leaf, double sigma, const Eigen::Matrix2d& ray,
                           const InternalLoads& loads, MatrixXd& units);

/// What the tables about every bent state change by, parameter by parameter as in TubeNodeRates.
using DynamicsRates = std::vector<std::vector<StateTable>>;

struct DynamicsEntries;

class TubeDynamics {
 public:
  static constexpr int amplitudes = field_loads;
  static constexpr int rates = 12 + amplitudes;  ///< those of DynamicsExpansion::mass

  /// Numbers of even and of odd entries of a table.
  static std::array<int, 2> entries();

  explicit TubeDynamics(double force_centre) : force_centre_(force_centre) {}

  /// Adds a bent state beyond the others.
  void add(DynamicsNode node);
  double last_sigma() const { return nodes_.back().table.sigma; }
  const DynamicsNode& node(std::size_t i) const { return nodes_[i]; }

  /// What a unit of each number does, relative to the diagonals of the matrices, at states as they
  /// occur, so far `along` the ray from the bent state.
  static DynamicsNode weights(const DynamicsNode& node, const PlateShape& shape, double along);

  /// A state: along the ray (signed), off it, twist [rad]; forces over their scale.
  struct Place {
    double sigma = 0, tau = 0, twist = 0;
    Vector3d f = Vector3d::Zero();
  };
  /// A place among the tables: between the nodes interval and interval + 1, mirrored to σ ≥ 0.
  struct Local {
    bool mirrored = false;
    std::size_t interval = 0;
    double sigma = 0;
    std::array<double, 5> z{};  ///< (τ, φ, N, M1, M2) of the tables
  };
  /// Locates a place among the bent states, of which there must be two.
  Local locate(const Place& place) const;
  /// Likewise among any nodes, of which sigma(node) returns the σ.
  template <class Nodes, class Sigma>
  static Local locate_among(const Nodes& nodes, const Sigma& sigma, const Place& place,
                            double force_centre) {
    assert(nodes.size() >= 2);
    Local at;
    at.mirrored = place.sigma < 0;
    const double sign = at.mirrored ? -1 : 1;
    at.sigma = sign * place.sigma;
    while (at.interval + 2 < nodes.size() && at.sigma > sigma(nodes[at.interval + 1]))
      ++at.interval;
    at.z = {sign * place.tau, sign * place.twist, place.f[0] - force_centre, place.f[1],
            place.f[2]};
    return at;
  }

  /// Dynamics of the leaf in the scaled units of the plate, chord axes.
  struct Answer {
    /// Why the tables are not valid here; empty where they are.
    std::string reason;
    double change = 0;  ///< TubeDynamics::change() there, where it was asked for
    Eigen::Matrix<double, amplitudes, amplitudes> stiffness;
    /// Mass over (v, ω, rates of (θ1y, θ2y, φ), of (N, M1, M2) with the amplitudes' static parts,
    /// those of the amplitudes beyond their static parts).
    Eigen::Matrix<double, rates, rates> mass;
    /// ω² of the sixth of the ten internal motions between held edges, the smaller one of both
    /// neighbouring bent states: up to there every mode is well represented.
    double reach = 0;
  };
  /// Needs two bent states; sigma inside of them or their mirror images.
  Answer evaluate(const Place& place) const;
  /// Change by the last degree: |L⁻¹ (K⁻ − K) L⁻ᵀ|, K = L Lᵀ the internal stiffness, K⁻ that of
  /// total degree 1.
  double change(const Place& place) const;
  bool has_stations() const { return nodes_.back().stations.size() > 0; }
  /// Motion of the stations for the rates of Answer::mass, chord axes; 6 rows each.
  MatrixXd stations(const Place& place) const;

 private:
  static constexpr int reach_mode = 5;
  void read(const Local& at, bool all, int total, DynamicsEntries& entries) const;

  double force_centre_;
  std::vector<DynamicsNode> nodes_;
  std::vector<double> reach_;  ///< ω² of each node: Answer::reach
};

}  // namespace flexopt
