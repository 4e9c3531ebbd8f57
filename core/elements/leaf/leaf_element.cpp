#include "core/elements/leaf/leaf_element.hpp"

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/elements/leaf/leaf_series.hpp"

namespace flexopt {

Answer<LeafLinear> LeafElement::linearise() {
  return {nullptr, "the model \"" + report().model + "\" has no linearised interior"};
}

Answer<LeafGradient<double>> LeafLinear::gradient(LeafRates&, const LeafRows&) const {
  return {nullptr, "its model has no exact derivatives"};
}

Answer<LeafSeries> LeafLinear::series() const {
  return {nullptr, "its model has no series along the stroke; full accuracy has"};
}

}  // namespace flexopt
