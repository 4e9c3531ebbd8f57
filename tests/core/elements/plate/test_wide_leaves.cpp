// Wide leaves in their plane: (E16) and (E17) of core/elements/README.md.
#include "tip_stiffness.hpp"

using namespace flexopt;

namespace {

/// Stiffness over the thickness of a leaf that is moved along one direction, all others held.
double per_thickness(double width, double thickness, Direction along, std::array<int, 2> mesh) {
  const LeafSpring leaf = models::leaf({0, 0, 0}, {1, 0, 0}, 0.06, width, thickness);
  const ModelOptions model{.accuracy = Accuracy::full, .mesh = mesh};
  return tip_stiffness(leaf, 0.06, along, Others::held, model) / thickness;
}

}  // namespace

TEST_CASE("in its plane a guided leaf is as stiff as it is thick") {
  const double aspect = GENERATE(1.0, 1.5, 2.0, 3.0, 5.0), w = 0.06 / aspect;
  const Direction along = GENERATE(Direction::uz, Direction::ux);
  for (const std::array<int, 2>& mesh : {default_mesh, std::array{20, 8}}) {
    const double thin = per_thickness(w, w / 400, along, mesh);
    for (const double ratio : {50.0, 25.0, 12.0}) {
      CAPTURE(aspect, ratio, along, mesh[0]);
      CHECK(per_thickness(w, w / ratio, along, mesh) == Approx(thin).epsilon(1e-3));
    }
  }
}
