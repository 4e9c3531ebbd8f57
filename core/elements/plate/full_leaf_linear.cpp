#include "core/elements/plate/full_leaf_linear.hpp"

#include "core/elements/plate/plate_gradient.hpp"
#include "core/elements/plate/plate_series.hpp"

namespace flexopt {

Answer<std::unique_ptr<LeafLinear>> FullLeaf::linearise() {
  return std::make_unique<FullLeafLinear>(*this);
}

Answer<std::unique_ptr<LeafGradient<double>>> FullLeafLinear::gradient(LeafRates& rates,
                                                                       const LeafRows& rows) const {
  const PlateLeaf& plate = leaf_->plate();
  return std::make_unique<PlateGradient<double>>(
      plate, shared_mesh_rate(rates, plate.shared_mesh()), rows, present_state(plate));
}

Answer<std::unique_ptr<LeafSeries>> FullLeafLinear::series() const {
  return std::make_unique<PlateSeries>(leaf_->plate());
}

}  // namespace flexopt
