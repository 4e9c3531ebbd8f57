#include "core/elements/leaf/leaf_element.hpp"

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/elements/leaf/leaf_series.hpp"

namespace flexopt {

Answer<std::unique_ptr<LeafLinear>> LeafElement::linearise() {
  return Because("the model \"" + report().model + "\" has no linearised interior");
}

Check LeafElement::check_interior(InteriorUse /*use*/) {
  return linearise().map([](const auto&) {});
}

std::vector<Vector3d> LeafElement::material_points(
    const std::vector<std::array<double, 2>>& places) {
  std::vector<Vector3d> points;
  points.reserve(places.size());
  for (const auto& [along, across] : places) points.push_back(material_point(along, across));
  return points;
}

Answer<std::unique_ptr<LeafGradient<double>>> LeafLinear::gradient(LeafRates&,
                                                                   const LeafRows&) const {
  return Because("its model has no exact derivatives");
}

Answer<std::unique_ptr<LeafSeries>> LeafLinear::series() const {
  return Because("its model has no series along the stroke; full accuracy has");
}

}  // namespace flexopt
