#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <map>

#include "designs/solids/mesh_gatherer.hpp"

namespace flexopt {
namespace {

/// What an element of Gmsh is.
struct GmshType {
  enum class Use { none, surface, solid } use = Use::none;
  int nodes = 0;
  SolidCell cell = SolidCell::hexahedron;
  std::vector<int> order = {};  ///< for each node of the cell its place in the file
};

GmshType gmsh_type(const NumberedLines& lines, int number) {
  using enum GmshType::Use;
  static const std::vector<int> tetrahedron{0, 1, 2, 3, 4, 5, 6, 7, 9, 8},
      wedge{0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11},
      hexahedron{0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15};
  static const std::map<int, GmshType> types{{15, {none, 1}},
                                             {1, {none, 2}},
                                             {8, {none, 3}},
                                             {2, {surface, 3}},
                                             {3, {surface, 4}},
                                             {9, {surface, 6}},
                                             {16, {surface, 8}},
                                             {10, {surface, 9}},
                                             {11, {solid, 10, SolidCell::tetrahedron, tetrahedron}},
                                             {18, {solid, 15, SolidCell::wedge, wedge}},
                                             {13, {solid, 18, SolidCell::wedge, wedge}},
                                             {17, {solid, 20, SolidCell::hexahedron, hexahedron}},
                                             {12, {solid, 27, SolidCell::hexahedron, hexahedron}}};
  if (const auto type = types.find(number); type != types.end()) return type->second;
  if (number >= 4 && number <= 7)
    lines.fail("a linear element; mesh with quadratic elements: gmsh -order 2");
  lines.fail(
      fmt::format("an element of type {}; read are tetrahedra of 10, hexahedra of 20 or 27 "
                  "and prisms of 15 or 18 nodes",
                  number));
}

class MshReader {
 public:
  MshReader(NumberedLines lines, double unit) : lines_(std::move(lines)), mesh_(unit) {}

  ImportedMesh read() {
    while (lines_.next()) {
      const std::string section(lines_.text());
      if (section.empty()) continue;
      if (!section.starts_with('$')) lines_.fail("expected a section that begins with $");
      if (section != "$MeshFormat" && version_ == 0) lines_.fail("expected $MeshFormat first");
      if (section == "$MeshFormat")
        read_format();
      else if (section == "$PhysicalNames")
        read_names();
      else if (section == "$PartitionedEntities")
        lines_.fail("write the mesh without partitions");
      else if (section == "$Entities")
        read_entities();
      else if (section == "$Nodes")
        version_ == 2.2 ? read_nodes_2() : read_nodes_4();
      else if (section == "$Elements")
        version_ == 2.2 ? read_elements_2() : read_elements_4();
      const std::string end = "$End" + section.substr(1);
      while (lines_.text() != end) lines_.need();
    }
    return mesh_.finish(lines_);
  }

 private:
  /// The next line, which begins with so many whole numbers.
  std::vector<int> wholes(std::size_t least) {
    lines_.need();
    std::vector<int> read;
    for (const double number : lines_.numbers(least)) read.push_back(lines_.whole(number));
    return read;
  }

  void read_format() {
    lines_.need();
    const std::vector<double>& format = lines_.numbers(2);
    version_ = format[0];
    if (version_ != 2.2 && version_ != 4.1)
      lines_.fail(fmt::format("format {:g}; write 4.1 or 2.2: gmsh -format msh41", version_));
    if (format[1] != 0) lines_.fail("a binary file; write it as text: gmsh without -bin");
  }

  void read_names() {
    for (int left = wholes(1)[0]; left > 0; --left) {
      lines_.need();
      const std::string line(lines_.text());
      char* end = nullptr;
      const long dimension = std::strtol(line.c_str(), &end, 10), tag = std::strtol(end, &end, 10);
      const std::size_t open = line.find('"'), close = line.rfind('"');
      if (open == close) lines_.fail("expected dimension, number and \"name\" of a physical group");
      if (dimension == 2) names_[static_cast<int>(tag)] = line.substr(open + 1, close - open - 1);
    }
  }

  /// Version 4 tells here which surfaces belong to which physical groups.
  void read_entities() {
    const std::vector<int> counts = wholes(4);
    for (int i = 0; i < counts[0] + counts[1]; ++i) lines_.need();
    for (int i = 0; i < counts[2]; ++i) {
      lines_.need();
      std::size_t at = 8;  // behind number, box and number of groups
      const std::vector<double>& entity = lines_.numbers(at);
      std::vector<int>& groups = groups_[lines_.whole(entity[0])];
      for (int left = lines_.whole(entity[7]); left > 0; --left) {
        if (at == entity.size()) lines_.fail("a surface without its groups");
        groups.push_back(std::abs(lines_.whole(entity[at++])));
      }
    }
  }

  void read_nodes_2() {
    for (int left = wholes(1)[0]; left > 0; --left) {
      lines_.need();
      const std::vector<double>& node = lines_.numbers(4);
      mesh_.add_node(lines_, lines_.whole(node[0]), {node[1], node[2], node[3]});
    }
  }

  void read_nodes_4() {
    for (int blocks = wholes(4)[0]; blocks > 0; --blocks) {
      std::vector<int> labels;
      for (int left = wholes(4)[3]; left > 0; --left) labels.push_back(wholes(1)[0]);
      for (const int label : labels) {
        lines_.need();
        const std::vector<double>& place = lines_.numbers(3);
        mesh_.add_node(lines_, label, {place[0], place[1], place[2]});
      }
    }
  }

  void read_elements_2() {
    for (int left = wholes(1)[0]; left > 0; --left) {
      const std::vector<int> element = wholes(3);  // number, type, tags
      const int first = 3 + element[2];
      if (element[2] < 0 || first > static_cast<int>(element.size()))
        lines_.fail("an element without its tags");
      add({element.begin() + first, element.end()}, gmsh_type(lines_, element[1]),
          element[2] > 0 && element[3] != 0 ? std::vector<int>{element[3]} : std::vector<int>());
    }
  }

  void read_elements_4() {
    for (int blocks = wholes(4)[0]; blocks > 0; --blocks) {
      const std::vector<int> block = wholes(4);  // dimension, entity, type, elements
      const GmshType type = gmsh_type(lines_, block[2]);
      const std::vector<int> groups = block[0] == 2 ? groups_[block[1]] : std::vector<int>();
      for (int left = block[3]; left > 0; --left) {
        const std::vector<int> element = wholes(1);
        add({element.begin() + 1, element.end()}, type, groups);
      }
    }
  }

  void add(const std::vector<int>& nodes, const GmshType& type, const std::vector<int>& groups) {
    if (static_cast<int>(nodes.size()) != type.nodes)
      lines_.fail(fmt::format("an element of {} nodes; expected {}", nodes.size(), type.nodes));
    if (type.use == GmshType::Use::solid) {
      std::vector<int> ordered;
      for (const int place : type.order) ordered.push_back(nodes[place]);
      mesh_.add_cell(lines_, type.cell, ordered);
    } else if (type.use == GmshType::Use::surface) {
      for (const int group : groups)
        mesh_.add_to_set(names_.contains(group) ? names_[group] : std::to_string(group), nodes);
    }
  }

  NumberedLines lines_;
  MeshGatherer mesh_;
  double version_ = 0;
  std::map<int, std::string> names_;        ///< of physical surfaces
  std::map<int, std::vector<int>> groups_;  ///< of the surfaces of the geometry
};

}  // namespace

ImportedMesh read_msh(NumberedLines lines, double unit) {
  return MshReader(std::move(lines), unit).read();
}

}  // namespace flexopt
