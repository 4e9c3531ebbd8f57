#include "core/reduction/superelement/beam_body.hpp"

#include <cassert>

namespace flexopt {

CondensedPlate condense_beam(const LeafSpring& beam, int elements, Warping warping,
                             int vibration_modes, bool transverse_shear) {
  assert(elements >= 2 && elements % 2 == 0);
  const ModelOptions options{.flexure = Flexure::beam,
                             .warping = warping,
                             .mesh = {elements, 1},
                             .transverse_shear = transverse_shear};
  const PlateBody body{beam, {elements, 1}};
  return condense(
      body,
      {.interface = Interface::rigid_edges, .mesh_nodes = {}, .vibration_modes = vibration_modes},
      std::make_shared<const PlateMesh>(leaf_shape(beam, options)));
}

}  // namespace flexopt
