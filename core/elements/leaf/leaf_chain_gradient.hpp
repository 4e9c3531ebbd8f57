#pragma once
// A LeafChain as exact derivatives need it: its internal unknowns are those of the segments, one
// segment after the other, then (displacement, spin) of the lines between, whose places and axes
// are numbers seen from the leaf's axes, lengths over L. A segment is a leaf of the length L/n.
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_chain.hpp"
#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"

namespace flexopt {

/// Linearisation of an evaluated leaf chain. The chain must outlive it.
class LeafChainLinear final : public LeafLinear {
 public:
  /// The segments of the chain, linearised, in order.
  LeafChainLinear(const LeafChain& chain, std::vector<std::unique_ptr<LeafLinear>> segments);

  int segments() const { return static_cast<int>(segments_.size()); }
  const LeafLinear& segment(int i) const { return *segments_[static_cast<std::size_t>(i)]; }
  const LeafScale& scale() const override { return scale_; }
  int unknowns() const override { return lines() + 6 * (segments() - 1); }
  int offset(int segment) const { return offset_[static_cast<std::size_t>(segment)]; }
  int lines() const { return offset_.back(); }  ///< first unknown of the lines between

  void solve(Eigen::Ref<MatrixXd> b) const override;
  MatrixXd static_shapes(const std::vector<int>& columns) const override;
  MatrixXd mass_times(const MatrixXd& V) const override;
  MatrixXd station_motion(const MatrixXd& V) const override;
  Answer<LeafGradient<double>> gradient(LeafRates& rates, const LeafRows& rows) const override;

 private:
  /// First row of an edge of a segment among (unknowns, edges).
  int edge_row(int segment, int edge) const;
  /// Rows of the segment, in its own units, from derivatives with respect to (unknowns, edges);
  /// forces are mapped the other way.
  MatrixXd segment_rows(int segment, const MatrixXd& V) const;
  void add_segment_force(int segment, double factor, const MatrixXd& rows, MatrixXd& V) const;

  const LeafChain* chain_;
  std::vector<std::unique_ptr<LeafLinear>> segments_;
  LeafScale scale_;
  std::vector<int> offset_;
  std::vector<MatrixXd> shapes_;  ///< of the segments by both their edges
};

class LeafChainGradient final : public LeafGradient<double> {
 public:
  using Segments = std::vector<std::unique_ptr<LeafGradient<double>>>;
  /// The segments must have been made for segment_rows(…); chain and `linear` must outlive this.
  LeafChainGradient(const LeafChainLinear& linear, Segments segments, const LeafRows& rows);

  /// Layout of a segment's vectors in those of the chain.
  static LeafRows segment_rows(const LeafChainLinear& linear, int segment, const LeafRows& rows);

  MatrixXd force_rates(const std::vector<LeafVariation<double>>& variations) const override;
  LeafQuadratic<double> quadratic(const MatrixXd& Y, const VectorXd& mu) const override;
  std::unique_ptr<LeafFields> fields(
      const MatrixXd& rows, const std::vector<LeafVariation<double>>& variations) const override;

 private:
  int body_row(int segment, int edge) const;
  MatrixXd own_rows(int segment, const MatrixXd& Y) const;
  void add_force(int segment, const MatrixXd& own, MatrixXd& rows) const;
  std::vector<LeafVariation<double>> own_variations(
      int segment, const std::vector<LeafVariation<double>>& variations) const;

  const LeafChainLinear* linear_;
  Segments segments_;
};

}  // namespace flexopt
