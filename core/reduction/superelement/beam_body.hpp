#pragma once
// The linear part of a beam leaf's energy about its undeformed state, condensed to its two ends.
#include "core/mechanism/model_options.hpp"
#include "core/reduction/superelement/plate_body.hpp"

namespace flexopt {

/// A straight beam or wire between two nodes, the middles of its ends, which hold it as rigid edges
/// hold a leaf: beams.md, "Ends". `elements`: along, even; the frame sits in the middle. The
/// `recovery` has the order (line, component, function) of PlateLeaf::nodal.
CondensedPlate condense_beam(const LeafSpring& beam, int elements, Warping warping,
                             int vibration_modes, bool transverse_shear = true);

}  // namespace flexopt
