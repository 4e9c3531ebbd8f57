#pragma once
// Meshes of other programs: .inp of CalculiX and Abaqus, .msh of Gmsh (2.2 and 4.1, text).
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.hpp"
#include "core/mechanism/elastic_body.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {

struct ImportedMesh {
  struct Set {
    std::string name;
    std::vector<int> nodes;  ///< ascending, each once
  };
  SolidCells cells;
  std::vector<Vector3d> nodes;  ///< those of cells alone [m]
  std::vector<int> labels;      ///< their numbers in the file
  /// Node sets and sets of surface elements (.inp), physical surfaces (.msh), as far as their nodes
  /// are those of cells. None of the same name.
  std::vector<Set> sets;
  /// What the file says of the material, if its forces are in N: E [Pa], ν, density [kg/m³].
  std::optional<double> youngs_modulus, poissons_ratio, density;
  /// What the file holds beside and the mesh does not need, a sentence each, for the report.
  std::vector<std::string> skipped;
};

/// Reads a mesh whose unit of length is `unit` [m]. Its cells are quadratic; of hexahedra of 27 and
/// prisms of 18 nodes those in faces and in the middle are dropped. Throws SpecError, with file and
/// line: what is no mesh, linear elements, elements that are no solids, parts and assemblies,
/// *INCLUDE, several materials, binary files.
ImportedMesh read_mesh(const std::string& file, double unit);

/// Nodes of a set; letters of either case, as in CalculiX, where no set has exactly this name.
/// Throws SpecError at `at`, with the names of all sets.
const std::vector<int>& nodes_of_set(const ImportedMesh& mesh, const std::string& name,
                                     const JsonPointer& at);

}  // namespace flexopt
