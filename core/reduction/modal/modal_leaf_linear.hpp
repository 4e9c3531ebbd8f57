#pragma once
// A ModalLeaf linearised: its internal unknowns are the amplitudes.
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/reduction/modal/modal_leaf.hpp"

namespace flexopt {

/// Of an evaluated leaf, which must outlive it.
class ModalLeafLinear final : public LeafLinear {
 public:
  explicit ModalLeafLinear(const ModalLeaf& leaf)
      : leaf_(&leaf), rates_(leaf.rates()), mass_(leaf.plate().mass(rates_)) {}

  const LeafScale& scale() const override { return leaf_->scale(); }
  int unknowns() const override { return leaf_->model().amplitudes(); }
  void solve(Eigen::Ref<MatrixXd> b) const override { b = (leaf_->inverse() * b).eval(); }
  MatrixXd static_shapes(const std::vector<int>& columns) const override;
  MatrixXd mass_times(const MatrixXd& V) const override;
  MatrixXd station_motion(const MatrixXd& V) const override;
  Answer<LeafGradient<double>> gradient(LeafRates& rates, const LeafRows& rows) const override;

 private:
  const ModalLeaf* leaf_;
  MatrixXd rates_, mass_;  ///< by (edges, amplitudes)
};

}  // namespace flexopt
