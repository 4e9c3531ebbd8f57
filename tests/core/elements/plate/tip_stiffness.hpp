#pragma once
// The stiffness of single leaves, undeflected.
#include "support/strokes.hpp"

namespace flexopt {

enum class Others { free, held };

/// Stiffness along one direction of a body at a place along x on the leaf, which its tip moves; the
/// body's other directions are free or held.
inline double tip_stiffness(const LeafSpring& leaf, double x, Direction along, Others others,
                            const ModelOptions& model) {
  Mechanism mechanism;
  mechanism.drives = {make_drive(along)};
  mechanism.bodies = {models::body({x, 0, 0}, 1, 1e-4)};
  mechanism.leaves = {leaf};
  for (int d = 0; d < 6; ++d)
    mechanism.bodies[0].held[static_cast<std::size_t>(d)] =
        others == Others::held && d != index(along);
  const StrokeResponse response = test::evaluated(
      mechanism, model, {.points = {0}, .outputs = {Output::equilibrium, Output::stiffness}});
  return 1 / response.path[0].compliance_free(index(along), index(along));
}

}  // namespace flexopt
