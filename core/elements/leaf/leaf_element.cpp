#include "core/elements/leaf/leaf_element.hpp"

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/elements/leaf/leaf_series.hpp"

namespace flexopt {

Answer<LeafLinear> LeafElement::linearise() {
  return {nullptr, "the model \"" + report().model + "\" has no linearised interior"};
}

std::string LeafElement::interior_gap(InteriorUse /*use*/) { return linearise().reason; }

std::vector<Vector3d> LeafElement::material_points(
    const std::vector<std::array<double, 2>>& places) {
  std::vector<Vector3d> points;
  points.reserve(places.size());
  for (const auto& [along, across] : places) points.push_back(material_point(along, across));
  return points;
}

Answer<LeafGradient<double>> LeafLinear::gradient(LeafRates&, const LeafRows&) const {
  return {nullptr, "its model has no exact derivatives"};
}

Answer<LeafSeries> LeafLinear::series() const {
  return {nullptr, "its model has no series along the stroke; full accuracy has"};
}

}  // namespace flexopt
