#include "core/reduction/leaf_models.hpp"

#include <map>

#include "core/elements/full_leaf.hpp"

namespace flexopt {

std::vector<std::unique_ptr<LeafElement>> make_full_leaves(const Mechanism& mechanism,
                                                           const ModelOptions& model) {
  std::map<PlateShape, std::shared_ptr<const PlateMesh>> meshes;  // equal leaves share theirs
  std::vector<std::unique_ptr<LeafElement>> leaves;
  for (int i = 0; i < static_cast<int>(mechanism.leaves.size()); ++i) {
    const LeafSpring& leaf = mechanism.leaves[i];
    const PlateShape shape = plate_shape(leaf, model.mesh, model.free_edge_torsion);
    auto& mesh = meshes[shape];
    if (!mesh) mesh = std::make_shared<PlateMesh>(shape);
    leaves.push_back(std::make_unique<FullLeaf>(leaf, mesh, i));
  }
  return leaves;
}

}  // namespace flexopt
