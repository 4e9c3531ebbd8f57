#pragma once
// A body that bends: a mesh of solid elements between rigid interface frames, or matrices of
// another program in its place. Plain data.
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

template <class Scalar>
struct MaterialT;

/// Shape of the cells of a solid mesh, all quadratic; nodes in the order of CalculiX and Abaqus:
/// C3D20, C3D15, C3D10.
enum class SolidCell { hexahedron, wedge, tetrahedron };
inline constexpr int nodes_of(SolidCell cell) {
  return cell == SolidCell::hexahedron ? 20 : cell == SolidCell::wedge ? 15 : 10;
}

/// Corners of the faces of a cell, counterclockwise seen from outside; of a triangle the last one
/// is the first. Three faces meet at each corner, so that F faces have 2F − 4.
inline std::span<const std::array<int, 4>> faces_of(SolidCell cell) {
  using Face = std::array<int, 4>;
  static constexpr std::array<Face, 6> hexahedron{
      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
  static constexpr std::array<Face, 5> wedge{
      {{0, 2, 1, 0}, {3, 4, 5, 3}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}};
  static constexpr std::array<Face, 4> tetrahedron{
      {{0, 2, 1, 0}, {0, 1, 3, 0}, {1, 2, 3, 1}, {2, 0, 3, 2}}};
  if (cell == SolidCell::hexahedron) return hexahedron;
  if (cell == SolidCell::wedge) return wedge;
  return tetrahedron;
}

/// Which nodes make which cell. The same for all designs of an optimisation: nodes move with the
/// parameters, cells do not change.
struct SolidCells {
  struct Block {
    SolidCell cell = SolidCell::hexahedron;
    std::vector<int> nodes;  ///< of one cell after the other
    int count() const { return static_cast<int>(nodes.size()) / nodes_of(cell); }
  };
  std::vector<Block> blocks;
  int nodes = 0;  ///< of the mesh
};

/// Stiffness and mass of a body that another program has reduced to its interfaces, six
/// coordinates each (displacement, rotation), own axes of the body, then fixed-interface modes.
struct ImportedMatrices {
  MatrixXd stiffness, mass;
  int modes = 0;
};

/// A rigid frame that holds nodes of an elastic body.
template <class Scalar>
struct ElasticInterfaceT {
  std::string name;
  int body = -1;            ///< the rigid body that it is a part of, or the ground
  Vector3<Scalar> origin;   ///< its point, own axes of the elastic body [m]
  std::vector<int> patch;   ///< nodes of the mesh that move with it; not of imported matrices
  double clamp_growth = 1;  ///< stress-free sizes over nominal ones of the rigid body
  /// The middle of the patch, own axes [m]: what the growth of a warm body and of its holder moves.
  Vector3<Scalar> face = Vector3<Scalar>::Zero();
};

/// The degree of an elastic body's energy in its deformation.
enum class ElasticDegree { linear = 2, quartic = 4 };

/// An elastic body in its undeflected place, between at least two interfaces. Places of nodes and
/// interfaces are in its own axes. `MaterialT` is that of mechanism.hpp.
template <class Scalar, class Material>
struct ElasticBodyOf {
  std::string name;
  Vector3<Scalar> place = Vector3<Scalar>::Zero();     ///< of its own origin, global [m]
  Matrix3<Scalar> axes = Matrix3<Scalar>::Identity();  ///< columns: own axes, global
  std::shared_ptr<const SolidCells> cells;             ///< null for imported matrices
  std::vector<Vector3<Scalar>> nodes;                  ///< own axes [m]
  Material material;
  std::vector<ElasticInterfaceT<Scalar>> interfaces;
  ElasticDegree degree = ElasticDegree::linear;
  std::shared_ptr<const ImportedMatrices> imported;
  /// The design that the mesh was made for, from whose fixed-interface modes those of all designs
  /// on this mesh follow; null where it is this one.
  std::shared_ptr<const ElasticBodyOf<double, MaterialT<double>>> nominal;
  /// The same body on a coarser mesh, for the error of the mesh; none where there is no such mesh.
  std::shared_ptr<const ElasticBodyOf<double, MaterialT<double>>> coarse;
  /// Stress-free sizes of a warm body over nominal ones.
  double growth = 1;

  /// Undeflected place of an interface's origin, global axes [m].
  Vector3<Scalar> interface_place(std::size_t a) const {
    return place + axes * interfaces[a].origin;
  }
};

}  // namespace flexopt
