#pragma once
// A leaf linearised about its present state, all its interior unknowns kept: what a mechanism needs
// of it for K⁻¹ B and M B, and for exact derivatives. Leaf axes and units as in LeafRows.
#include <optional>
#include <vector>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/elements/leaf/leaf_rates.hpp"
#include "core/elements/leaf/leaf_rows.hpp"
#include "core/elements/leaf/leaf_scale.hpp"
#include "core/math/answer.hpp"

namespace flexopt {

template <class S>
class LeafGradient;
class LeafSeries;

/// The interior of a leaf that has a few motions between held edges, and follows them and the edges
/// by static shapes.
struct InternalMotions {
  LeafDynamics dynamics;  ///< without stations and shapes
  MatrixXd unknowns;      ///< of the leaf, per unit of each motion: unknowns × motions
};

/// The leaf that it was made of must outlive it, and everything that it makes.
class LeafLinear {
 public:
  virtual ~LeafLinear() = default;

  virtual const LeafScale& scale() const = 0;
  virtual int unknowns() const = 0;
  /// K_ff⁻¹ b, edges and material point held.
  virtual void solve(Eigen::Ref<MatrixXd> b) const = 0;
  /// Static shapes dx/d(edges, point), all other coordinates held: unknowns × columns of 12 or 15.
  virtual MatrixXd static_shapes(const std::vector<int>& columns) const = 0;
  /// M V for rates V of the unknowns and the edges (+ 12 rows).
  virtual MatrixXd mass_times(const MatrixXd& V) const = 0;
  /// Internal motions of the leaf; nothing for a leaf with many unknowns.
  virtual std::optional<InternalMotions> internal_motions() const { return std::nullopt; }
  /// Frequency below which every mode between held edges is one of the unknowns [Hz]. Nothing: the
  /// unknowns contain all modes of the leaf.
  virtual std::optional<double> highest_mode() const { return std::nullopt; }
  /// Motion of stations for such rates, times the root of their mass: LeafDynamics::stations.
  virtual MatrixXd station_motion(const MatrixXd& V) const = 0;

  /// The share in exact gradients at the present state. `rows.unknowns` must be unknowns(). This
  /// must outlive it. None unless the model has one.
  virtual Answer<std::unique_ptr<LeafGradient<double>>> gradient(LeafRates& rates,
                                                                 const LeafRows& rows) const;
  /// The leaf along a path that starts at the present state. None unless the model has one.
  virtual Answer<std::unique_ptr<LeafSeries>> series() const;
};

}  // namespace flexopt
