// A full leaf linearised about its present state.
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/elements/plate/full_leaf.hpp"
#include "core/elements/plate/plate_gradient.hpp"
#include "core/elements/plate/plate_series.hpp"

namespace flexopt {
namespace {

/// Linearisation of an assembled full leaf. The leaf must outlive it.
class FullLeafLinear final : public LeafLinear {
 public:
  explicit FullLeafLinear(FullLeaf& leaf) : leaf_(&leaf) { leaf.invert_pivots(); }

  const LeafScale& scale() const override { return leaf_->scale(); }
  int unknowns() const override { return leaf_->plate().unknowns(); }
  void solve(Eigen::Ref<MatrixXd> b) const override { leaf_->plate().solve(b); }
  MatrixXd static_shapes(const std::vector<int>& columns) const override {
    return leaf_->plate().static_shapes(columns);
  }
  MatrixXd mass_times(const MatrixXd& V) const override { return leaf_->plate().mass_times(V); }
  MatrixXd station_motion(const MatrixXd& V) const override {
    return leaf_station_motion(leaf_->plate(), leaf_->scale(), V);
  }
  Answer<std::unique_ptr<LeafGradient<double>>> gradient(LeafRates& rates,
                                                         const LeafRows& rows) const override {
    const PlateLeaf& plate = leaf_->plate();
    return std::make_unique<PlateGradient<double>>(
        plate, shared_mesh_rate(rates, plate.shared_mesh()), rows, present_state(plate));
  }
  Answer<std::unique_ptr<LeafSeries>> series() const override {
    return std::make_unique<PlateSeries>(leaf_->plate());
  }

 private:
  const FullLeaf* leaf_;
};

}  // namespace

Answer<std::unique_ptr<LeafLinear>> FullLeaf::linearise() {
  return std::make_unique<FullLeafLinear>(*this);
}

}  // namespace flexopt
