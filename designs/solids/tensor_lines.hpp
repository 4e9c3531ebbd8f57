#pragma once
// Planes of nodes across the own axes of a box, a plate or a notch. A notch is a box whose planes
// follow its contour.
#include "core/math/dual.hpp"
#include "designs/solids/notch_mesh.hpp"
#include "designs/solids/solid_shape.hpp"

namespace flexopt {

/// Places of the planes of a shape across each axis, then of both sides of each patch: in the same
/// order for all designs [m].
template <class S>
struct PlanesT {
  std::array<std::vector<S>, 3> at;
  std::array<int, 3> of_shape;
};
template <class S>
PlanesT<S> planes_of(const SolidShapeT<S>& shape, const std::vector<PatchT<S>>& patches);

/// Lines across each axis; boundaries of elements and, between them, their middles. `extent`: of
/// the shape along its longest axis [m].
using MeshLines = std::array<std::vector<MeshLine>, 3>;
MeshLines plan_lines(const SolidShapeT<double>& shape, const PlanesT<double>& planes, double extent,
                     const MeshDensity& density);

/// Places of the lines, and heights and widths over those of the end of the notch, by line of x.
template <class S>
struct LinePlacesT {
  std::array<std::vector<S>, 3> at;
  std::vector<std::array<S, 2>> narrower;
};
template <class S>
LinePlacesT<S> places_of(const MeshLines& lines, const SolidShapeT<S>& shape,
                         const PlanesT<S>& planes);

/// Whether a place is in the material; of a notch, in the box that it is mapped from.
bool is_within(const SolidShapeT<double>& shape, const Vector3d& place);

}  // namespace flexopt
