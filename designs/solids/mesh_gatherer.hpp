#pragma once
// What the readers of mesh files gather: nodes, cells and sets by the numbers of the file.
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "designs/solids/import_mesh.hpp"
#include "designs/solids/numbered_lines.hpp"

namespace flexopt {

class MeshGatherer {
 public:
  explicit MeshGatherer(double unit) : unit_(unit) {}

  void add_node(const NumberedLines& lines, int label, const Vector3d& place);
  /// Labels in the order of SolidCell.
  void add_cell(const NumberedLines& lines, SolidCell cell, const std::vector<int>& labels);
  void add_to_set(const std::string& name, const std::vector<int>& labels);
  /// Sets constants of the material, given in units of the file.
  void set_elastic(double modulus, double ratio) {
    mesh_.youngs_modulus = modulus / (unit_ * unit_);
    mesh_.poissons_ratio = ratio;
  }
  void set_density(double density) { mesh_.density = density / (unit_ * unit_ * unit_ * unit_); }
  void skip(std::string what) { mesh_.skipped.push_back(std::move(what)); }

  /// The mesh, with nodes of cells alone.
  ImportedMesh finish(const NumberedLines& lines);

 private:
  double unit_;
  ImportedMesh mesh_;  ///< its cells and sets have labels in the place of indices
  std::unordered_map<int, std::size_t> places_;  ///< of a label among all nodes
  std::set<std::vector<int>> known_;             ///< sorted labels of cells
};

/// Readers by the form of the file.
ImportedMesh read_inp(NumberedLines lines, double unit);
ImportedMesh read_msh(NumberedLines lines, double unit);

}  // namespace flexopt
