#include "core/elements/leaf/leaf_element.hpp"

#include <cmath>
#include <numbers>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/elements/leaf/leaf_series.hpp"

namespace flexopt {

void set_modes(LeafDynamics& dynamics, const VectorXd& omega2) {
  const Eigen::Index modes = omega2.size();
  dynamics.internal_stiffness = omega2.asDiagonal();
  dynamics.mode_frequencies.resize(modes);
  for (Eigen::Index k = 0; k < modes; ++k)
    dynamics.mode_frequencies[k] = std::sqrt(std::abs(omega2[k])) / (2 * std::numbers::pi);
  const bool stable = modes > 0 && omega2[modes - 1] > 0;
  dynamics.highest_mode = stable ? 0.5 * dynamics.mode_frequencies[modes - 1] : 0;
}

Answer<std::unique_ptr<LeafLinear>> LeafElement::linearise() {
  return Because("the model \"" + report().model + "\" has no linearised interior");
}

Check LeafElement::check_interior(InteriorUse /*use*/) {
  return linearise().map([](const auto&) {});
}

Answer<std::unique_ptr<LeafGradient<double>>> LeafLinear::gradient(LeafRates&,
                                                                   const LeafRows&) const {
  return Because("its model has no exact derivatives");
}

Answer<std::unique_ptr<LeafSeries>> LeafLinear::series() const {
  return Because("its model has no series along the stroke; full accuracy has");
}

}  // namespace flexopt
