#pragma once
// Surfaces of leaves, triangles, and the parts of a mechanism as other programs draw them.
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/elements/leaf/leaf_results.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/response/response.hpp"

namespace flexopt {

/// Names of the joints that move and of the springs: no solid, and no plate, is one piece with
/// them.
std::vector<std::string> joints_and_springs(const Mechanism& mechanism);

/// Names of the elastic bodies that are matrices of another program: no drawing has them.
std::vector<std::string> bodies_without_mesh(const Mechanism& mechanism);

// Leaves with their thickness as every drawing of them takes them: a grid on the middle surface and
// the way from it to the face.

struct LeafSurface {
  int along = 0, across = 0;     ///< points; of a wire one across, its centre line
  std::vector<double> places;    ///< places of the points along: part of the length
  std::vector<Vector3d> middle;  ///< points along first [m]
  /// Vectors from the middle to the face on the side of the normal [m]. At a fold they lean along
  /// the mitre.
  std::vector<Vector3d> half;
  std::vector<Vector3d> side;  ///< for a wire: from the centre line across, its radius long [m]
  /// Points along at which the surface has an edge: those of a fold.
  std::vector<int> folds;

  bool round() const { return !side.empty(); }
  std::size_t at(int i, int j) const { return static_cast<std::size_t>(j * along + i); }
  /// Outline in the middle of the width: along one face, and back along the other.
  std::vector<Vector3d> contour() const;
};

/// Points of a grid on the undeflected leaf: two along a straight piece without profile, else
/// enough that chords leave out less than 1e-4 of what they cut.
LeafSurface undeflected_surface(const LeafSpring& leaf);

/// Surface between the mesh points of a shape, by cubics along and across, with `finer` points for
/// each interval of the mesh along. `places`: the shape's undeflected or deflected points.
LeafSurface surface_of_shape(const LeafSpring& leaf, const LeafShape& shape,
                             const std::vector<Vector3d>& places, int finer = 4);

// The section of a flat leaf along it, with fillets.

/// A line, or an arc through the point `by` [m].
struct OutlineEdge {
  Eigen::Vector2d from, to;
  std::optional<Eigen::Vector2d> by;
};

/// A flat leaf seen along its width, x along it and y along its normal [m]; of a reinforced one the
/// part between `from` and `to` has another thickness.
struct LeafSection {
  double length = 0, half = 0;  ///< half: of the thickness
  double radius = 0;            ///< of the fillets at held edges and at steps; 0: none
  bool free_tip = false;
  double from = 0, to = 0, middle = 0;  ///< middle: half of the thickness there

  bool stepped() const { return to > from && middle > half; }
  double step_radius() const { return stepped() ? std::min(radius, middle - half) : 0; }
  double tip_radius() const { return free_tip ? 0 : radius; }
  /// Whether the fillets have room along the leaf.
  bool fits() const;
  /// Closed, counter-clockwise: by quarter circles at held edges and where the thickness steps.
  std::vector<OutlineEdge> outline() const;
  double area() const;  ///< [m²]
};

// Closed meshes of triangles: leaves with their thickness, boxes, hulls.

struct TriangleMesh {
  std::string name;
  std::vector<Vector3d> points;               ///< [m]
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside

  /// Volume that the triangles enclose [m³].
  double volume() const;
  /// Edges of triangles along which the surface turns by more than 26°.
  std::vector<std::array<int, 2>> ridges() const;
  /// Turns all triangles round where the volume is negative.
  void face_outwards();
};

/// Closed mesh of both faces and all rims of a leaf. A wire has `around` sides, and the area of the
/// circle. The number and the order of points and triangles follow from the size of the grid alone.
TriangleMesh closed_leaf(const LeafSurface& surface, int around = 32);

/// A box of twelve triangles.
TriangleMesh closed_box(const BodyBoxT<double>& box);

/// The smallest convex body around the points; nothing where they lie in a plane.
TriangleMesh convex_hull(const std::vector<Vector3d>& points);

// The parts of a mechanism as closed bodies: what STL, glTF and STEP hold.

/// Undeflected: the box of a body, or the hull of the edges, joints and springs that it holds, each
/// with a small ball around it, as the report draws it. Empty where it holds nothing, and of frames
/// of elastic bodies.
TriangleMesh body_solid(const Mechanism& mechanism, int body);

/// Whether a rigid body is a frame of an elastic body with a mesh, named by that, which is drawn in
/// its place.
bool is_elastic_frame(const Mechanism& mechanism, int body);

/// Surface of an elastic body between the nodes of its mesh, undeflected (null) or at a point: as
/// its frames stand there. Empty of imported matrices. Swelling by temperature is not drawn.
TriangleMesh elastic_solid(const Mechanism& mechanism, const PathPoint* point, std::size_t body);

/// Pose of a body at a point of a path.
struct BodyPose {
  Vector3d reference = Vector3d::Zero();  ///< undeflected [m]
  Vector3d displacement = Vector3d::Zero();
  Matrix3d rotation = Matrix3d::Identity();

  Vector3d operator()(const Vector3d& place) const {
    return reference + displacement + rotation * (place - reference);
  }
};
BodyPose body_pose(const Mechanism& mechanism, const PathPoint* point, int body);

/// All leaves, then all bodies that have a shape, then elastic bodies, undeflected (null) or at a
/// point with shapes.
std::vector<TriangleMesh> drawn_parts(const Mechanism& mechanism, const PathPoint* point);

/// The surface of a leaf at a point of the path; `finer` as of surface_of_shape.
LeafSurface drawn_surface(const Mechanism& mechanism, const PathPoint* point, std::size_t leaf,
                          int finer = 4);

/// Diagonal of the box around the undeflected mechanism [m]: what the parts that have no size of
/// their own are drawn by.
double drawn_size(const Mechanism& mechanism);

// Bodies as parts to be made, which leave the free length of every leaf free: what STEP and the
// contour of DXF hold.

/// A body, undeflected, as a union of convex meshes: blocks ∪ (ribs − rooms).
struct BodyForm {
  int body = ground;
  std::string name;
  std::vector<TriangleMesh> blocks;  ///< behind each edge that the body holds; joints and springs
  std::vector<TriangleMesh> ribs;    ///< the box of the body, and what joins all
  std::vector<TriangleMesh> rooms;   ///< of the leaves that it holds
  int parts = 0;                     ///< that do not hang together
  std::vector<std::string> bare;     ///< leaves without a block: they meet others of the body there
  std::vector<std::string> faults;   ///< why it cannot be made as it is, a sentence each
};

/// The forms of all bodies, then that of the ground. A block is as wide as its leaf. Ribs are the
/// shortest that meet no other body and no leaf of others. `room` [m]: a fillet, or the width of a
/// cut, that has room beside each leaf.
std::vector<BodyForm> body_forms(const Mechanism& mechanism, double room);

// Quadratic bricks of an undeflected leaf, for programs that take solid elements.

struct SolidMeshSize {
  int along = 20, across = 10, through = 1;  ///< elements of a leaf, of a folded one of each leg
  /// x = ξ − g sin(2πξ)/(2π): finer at clamps and folds (along), at free edges (across). Beside a
  /// mitre elements stay longer than it leans.
  double grading = 0.95, grading_across = 0.7;
};

/// How much stiffer a mechanism of these leaves is at most than in a mesh that is finer along them
/// [-]: 0.85 (h − t/2)/(L n) for the first element, h long, of a leg L with n elements through.
/// That element shares the thickness that a clamp or a fold holds, which by itself fades within
/// t/2. Fitted to what CalculiX finds of folded leaves of 0.1 and 0.5 mm: docs/export.md.
double solid_excess(const Mechanism& mechanism, const SolidMeshSize& size);

struct SolidMesh {
  std::vector<Vector3d> nodes;  ///< [m]
  /// Eight corners, then the mid-sides in the order of CalculiX and Abaqus (C3D20).
  std::vector<std::array<int, 20>> elements;
  std::array<std::vector<int>, 2> edges;  ///< nodes of the faces at base and tip
};

/// A sheet, straight, curved or with a mitred fold, of any profile; a wire has twelve elements in
/// its section whatever `across` and `through`.
SolidMesh solid_mesh(const LeafSpring& leaf, const SolidMeshSize& size);

}  // namespace flexopt
