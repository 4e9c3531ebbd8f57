#pragma once
// Shapes of elastic bodies and their meshes of solid elements, whose nodes move with the parameters
// of a design while the cells stay as they were planned for the nominal design.
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/math/answer.hpp"
#include "core/math/types.hpp"
#include "core/mechanism/elastic_body.hpp"

namespace flexopt {

/// A corner of a closed contour, in the plane.
template <class S>
struct ContourCornerT {
  std::array<S, 2> at;                      ///< [m]
  S fillet = S(0.0);                        ///< radius of the rounded corner; 0: sharp [m]
  std::optional<std::array<S, 2>> through;  ///< the way to it from the corner before is an arc
};
template <class S>
using ContourT = std::vector<ContourCornerT<S>>;

/// A cuboid about the own origin.
template <class S>
struct BoxShapeT {
  std::array<S, 3> lengths;  ///< along the own axes [m]
};

/// A plate of constant thickness along z about z = 0.
template <class S>
struct PlateShapeT {
  struct Hole {
    std::array<S, 2> center;
    S radius;
  };
  ContourT<S> outline;
  std::vector<ContourT<S>> windows;
  std::vector<Hole> holes;
  S thickness;
};

enum class NotchContour { circular, elliptic, corner_filleted, v_shaped, power };

/// A notch hinge about the own origin, the middle of its thinnest section: x along it, y across the
/// thinnest thickness, z along the width. The thickness is t at x = 0 and grows to both sides to
/// `height` where the notch ends; behind follow ends of that height.
template <class S>
struct NotchShapeT {
  NotchContour contour = NotchContour::circular;
  S half_length;          ///< of the notch along x: its radius, or the semi-axis along x [m]
  S depth;                ///< of one side: (height − t)/2; radius of a circular notch [m]
  S thickness, width;     ///< thinnest thickness t, width of the ends [m]
  S end_length;           ///< of each end beyond the notch [m]
  S fillet = S(0.0);      ///< corner-filleted and V: radius of the fillets [m]
  double exponent = 2;    ///< of a power-function contour
  bool two_axes = false;  ///< the same notch along the width too: width − 2 depth is left of it
};

template <class S>
using SolidShapeT = std::variant<BoxShapeT<S>, PlateShapeT<S>, NotchShapeT<S>>;

/// A rectangle on a face of the shape whose nodes an interface holds, own axes.
template <class S>
struct PatchT {
  Vector3<S> center;
  Vector3<S> half_u, half_v;  ///< from the centre to the middles of two sides [m]
  std::string name;           ///< in messages
};

/// How fine a mesh is. Counts follow from the nominal design.
struct MeshDensity {
  double size = 0;        ///< of an element [m]; 0: from the shape
  int through = 0;        ///< elements through the thickness; 0: from the shape
  double root = 0;        ///< size at the edges of patches [m]; 0: from the patch
  double growth = 1.8;    ///< ratio of neighbours, above 1
  double coarsening = 1;  ///< all sizes times this: 1 for the mesh itself, 1.6 for its coarse twin
};

/// Cells of a shape with its patches, and how the nodes follow shape and patches.
struct SolidPlan {
  std::shared_ptr<const SolidCells> cells;
  std::vector<std::vector<int>> patches;  ///< nodes of each
  struct Placing;                         ///< of the mesher
  std::shared_ptr<const Placing> placing;
};

/// Plans the mesh of the nominal design. Tells why there is none: a patch that lies on no face, one
/// that another overlaps, a contour that crosses itself.
Answer<SolidPlan> plan_mesh(const SolidShapeT<double>& nominal,
                            const std::vector<PatchT<double>>& patches, const MeshDensity& density);

/// The nodes for a shape and patches of the plan's topology, own axes [m].
template <class S>
std::vector<Vector3<S>> place_nodes(const SolidPlan& plan, const SolidShapeT<S>& shape,
                                    const std::vector<PatchT<S>>& patches);

/// The cells of a mesh whose nodes have been mirrored in a plane (z → −z, say): the nodes of each
/// in the order of a cell that is not inverted.
SolidCells mirrored(const SolidCells& cells);

}  // namespace flexopt
