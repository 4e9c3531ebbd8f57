#include "designs/solids/import_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/spec/names.hpp"
#include "designs/solids/mesh_gatherer.hpp"

namespace flexopt {

void MeshGatherer::add_node(const NumberedLines& lines, int label, const Vector3d& place) {
  if (!place.allFinite()) lines.fail("a place is not finite");
  if (!places_.try_emplace(label, mesh_.nodes.size()).second)
    lines.fail(fmt::format("node {} stands here a second time", label));
  mesh_.nodes.push_back(unit_ * place);
  mesh_.labels.push_back(label);
}

void MeshGatherer::add_cell(const NumberedLines& lines, SolidCell cell,
                            const std::vector<int>& labels) {
  std::vector<int> sorted = labels;
  std::ranges::sort(sorted);
  if (std::ranges::adjacent_find(sorted) != sorted.end()) lines.fail("an element has a node twice");
  if (!known_.insert(std::move(sorted)).second)
    lines.fail("an element of the same nodes stands above; its stiffness would count twice");
  auto& blocks = mesh_.cells.blocks;
  auto block = std::ranges::find(blocks, cell, &SolidCells::Block::cell);
  if (block == blocks.end()) block = blocks.insert(blocks.end(), {.cell = cell, .nodes = {}});
  block->nodes.insert(block->nodes.end(), labels.begin(), labels.end());
}

void MeshGatherer::add_to_set(const std::string& name, const std::vector<int>& labels) {
  auto set = std::ranges::find(mesh_.sets, name, &ImportedMesh::Set::name);
  if (set == mesh_.sets.end()) set = mesh_.sets.insert(set, {.name = name, .nodes = {}});
  set->nodes.insert(set->nodes.end(), labels.begin(), labels.end());
}

ImportedMesh MeshGatherer::finish(const NumberedLines& lines) {
  if (mesh_.cells.blocks.empty()) lines.fail("there are no solid elements in it", true);
  std::vector<int> index(mesh_.nodes.size(), -1);
  for (const auto& block : mesh_.cells.blocks)
    for (const int label : block.nodes) {
      const auto place = places_.find(label);
      if (place == places_.end())
        lines.fail(fmt::format("an element has node {}, which has no place", label), true);
      index[place->second] = 0;
    }
  ImportedMesh mesh = std::move(mesh_);
  int count = 0;
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (index[i] < 0) continue;
    mesh.nodes[count] = mesh.nodes[i];
    mesh.labels[count] = mesh.labels[i];
    index[i] = count++;
  }
  mesh.nodes.resize(count);
  mesh.labels.resize(count);
  mesh.cells.nodes = count;
  const auto index_of = [&](int label) {
    const auto place = places_.find(label);
    return place == places_.end() ? -1 : index[place->second];
  };
  for (auto& block : mesh.cells.blocks)
    std::ranges::transform(block.nodes, block.nodes.begin(), index_of);
  for (auto& set : mesh.sets) {
    std::ranges::transform(set.nodes, set.nodes.begin(), index_of);
    std::erase(set.nodes, -1);
    std::ranges::sort(set.nodes);
    set.nodes.erase(std::unique(set.nodes.begin(), set.nodes.end()), set.nodes.end());
    if (set.nodes.empty())
      mesh.skipped.push_back(fmt::format("the set {} has no node of a solid element", set.name));
  }
  std::erase_if(mesh.sets, [](const ImportedMesh::Set& set) { return set.nodes.empty(); });
  return mesh;
}

ImportedMesh read_mesh(const std::string& file, double unit) {
  NumberedLines lines(file);
  const std::string kind = capitals(std::filesystem::path(file).extension().string());
  if (kind == ".INP") return read_inp(std::move(lines), unit);
  if (kind == ".MSH") return read_msh(std::move(lines), unit);
  lines.fail("expected a mesh: .inp of CalculiX or Abaqus, .msh of Gmsh", true);
}

const std::vector<int>& nodes_of_set(const ImportedMesh& mesh, const std::string& name,
                                     const JsonPointer& at) {
  auto set = std::ranges::find(mesh.sets, name, &ImportedMesh::Set::name);
  if (set == mesh.sets.end())
    set = std::ranges::find_if(mesh.sets, [&](const ImportedMesh::Set& other) {
      return capitals(other.name) == capitals(name);
    });
  if (set == mesh.sets.end())
    throw SpecError(at, name,
                    "no set of nodes of the mesh; " + known_names(name, names_in(mesh.sets)));
  return set->nodes;
}

}  // namespace flexopt
