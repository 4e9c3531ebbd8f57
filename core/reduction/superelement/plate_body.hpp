#pragma once
// Linear finite element models of flat plates (the quadratic part of the plate leaf's energy about
// its undeformed state) and their Craig–Bampton condensation to interface nodes.
#include <array>
#include <memory>
#include <vector>

#include "core/elements/plate/full_leaf.hpp"
#include "core/elements/plate/plate_mesh.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/reduction/superelement/superelement.hpp"

namespace flexopt {

/// How interface nodes hold a body.
enum class Interface {
  /// Two nodes: the middles of the edges x = 0 and x = L, each edge rigid as in a leaf (E3).
  rigid_edges,
  /// Four nodes: the corners (0, −), (0, +), (L, −), (L, +). The sides between them are
  /// interpolated, so that constant strains, curvatures and twist pass exactly (R12), (R13).
  corners
};

/// A flat plate on a tensor mesh of Bogner–Fox–Schmit elements, x along, y across from −w/2.
struct PlateBody {
  LeafSpring plate;  ///< length, width, thickness [m] and material are used
  std::array<int, 2> mesh{4, 4};
  Interface interface = Interface::corners;
  /// Sides y = ∓w/2 with the torsion layer of a free edge, (E2) of core/elements.
  std::array<bool, 2> free_edges{false, false};
  bool transverse_shear = true;  ///< of a leaf between rigid edges, (E10) of core/elements
  int vibration_modes = 0;       ///< fixed-interface modes kept
};

/// A condensed body: the superelement and the fields it stands for.
struct CondensedPlate {
  std::shared_ptr<const PlateMesh> mesh;
  LeafScale scale;       ///< of the plate: length L, energy D
  Vector3d frame_point;  ///< of the frame: the middle of the plate, in its axes [m]
  /// Nodes, K_CB, M_CB, Φ_CB. `recovery`: nodal dofs over L for the boundary modes, in the order
  /// (line, component, node, function) of PlateLeaf::nodal.
  SuperelementModel superelement;
};

/// Static condensation to the interface nodes, and the lowest fixed-interface modes. The mesh is,
/// between rigid edges, that of a leaf, whose sides are both free or neither; else that of a linear
/// plate, without free-edge term, which depends on the sides. The frame sits in the middle.
CondensedPlate condense(const PlateBody& body);
/// On a mesh of one's own, of a beam too.
CondensedPlate condense(const PlateBody& body, std::shared_ptr<const PlateMesh> mesh);

/// A straight beam or wire between two nodes, the middles of its ends, which hold it as rigid edges
/// hold a leaf: beams.md, "Ends". `elements`: along, even; the frame sits in the middle. The
/// `recovery` has the order (line, component, function) of PlateLeaf::nodal.
CondensedPlate condense_beam(const LeafSpring& beam, int elements, Warping warping,
                             int vibration_modes, bool transverse_shear = true);

}  // namespace flexopt
