// Meshes of CalculiX, Abaqus and Gmsh.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "designs/solids/import_mesh.hpp"
#include "support/refusals.hpp"
#include "support/temporary_folder.hpp"

using namespace flexopt;

namespace {

/// Two C3D20R of 20 x 3 x 4 mm with the sets LEFT and RIGHT of the faces across x.
const std::string deck_of_box = FLEXOPT_SOURCE_DIR "/tests/designs/data/box.inp";

using Edges = std::vector<std::array<int, 2>>;

/// Between which corners the mid-side nodes of a cell lie, in the order of CalculiX.
Edges edges_of(SolidCell cell) {
  switch (cell) {
    case SolidCell::hexahedron:
      return {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
              {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
    case SolidCell::wedge:
      return {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
    default:
      return {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  }
}

/// These corners in the order of Gmsh's manual, section "Node ordering".
Edges gmsh_edges_of(SolidCell cell) {
  switch (cell) {
    case SolidCell::hexahedron:
      return {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3},
              {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}};
    case SolidCell::wedge:
      return {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 4}, {2, 5}, {3, 4}, {3, 5}, {4, 5}};
    default:
      return {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {2, 3}, {1, 3}};
  }
}

std::vector<Vector3d> corners_of(SolidCell cell) {
  switch (cell) {
    case SolidCell::hexahedron:
      return {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 0},
              {0, 0, 3}, {1, 0, 3}, {1, 2, 3}, {0, 2, 3}};
    case SolidCell::wedge:
      return {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {1, 0, 3}, {0, 2, 3}};
    default:
      return {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  }
}

/// One element with numbers from 11, and the surface 0 1 2 of its corners in the group "base".
struct GmshText {
  std::string nodes, elements;
  int count = 0;
};
GmshText gmsh_element(SolidCell cell, int type, int extra, bool version_4) {
  std::vector<Vector3d> places = corners_of(cell);
  for (const auto& [a, b] : gmsh_edges_of(cell)) places.push_back((places[a] + places[b]) / 2);
  for (int i = 0; i < extra; ++i) places.push_back({0.3, 0.3, 0.1 * i});  // in faces, in the middle
  GmshText text;
  text.count = static_cast<int>(places.size());
  std::string labels, coordinates, element;
  for (int i = 0; i < text.count; ++i) {
    const std::string xyz = fmt::format("{} {} {}\n", places[i][0], places[i][1], places[i][2]);
    text.nodes += version_4 ? "" : fmt::format("{} {}", 11 + i, xyz);
    labels += fmt::format("{}\n", 11 + i);
    coordinates += xyz;
    element += fmt::format(" {}", 11 + i);
  }
  if (version_4)
    text.nodes =
        fmt::format("1 {} 11 99\n3 1 0 {}\n{}{}", text.count, text.count, labels, coordinates);
  text.elements = version_4
                      ? fmt::format("2 2 1 2\n2 5 2 1\n1 11 12 13\n3 1 {} 1\n2{}\n", type, element)
                      : fmt::format("2\n1 2 2 7 5 11 12 13\n2 {} 2 0 1{}\n", type, element);
  return text;
}

std::string gmsh_file(SolidCell cell, int type, int extra, bool version_4) {
  const GmshText text = gmsh_element(cell, type, extra, version_4);
  std::string file =
      fmt::format("$MeshFormat\n{} 0 8\n$EndMeshFormat\n", version_4 ? "4.1" : "2.2");
  file += "$PhysicalNames\n2\n2 7 \"base of it\"\n3 1 \"all\"\n$EndPhysicalNames\n";
  if (version_4)
    file +=
        "$Entities\n1 0 1 1\n3 0 0 0 0\n5 0 0 0 1 2 0 1 7 0\n1 0 0 0 1 2 3 1 1 1 5\n$EndEntities\n";
  file +=
      "$Nodes\n" + (version_4 ? "" : fmt::format("{}\n", text.count)) + text.nodes + "$EndNodes\n";
  return file + "$Elements\n" + text.elements + "$EndElements\n$NodeData\n1 2 3\n$EndNodeData\n";
}

std::string inp_of(const ImportedMesh& mesh) {
  std::string text = "*Node\n";
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    text += fmt::format("{}, {}, {}, {}\n", mesh.labels[i], mesh.nodes[i][0], mesh.nodes[i][1],
                        mesh.nodes[i][2]);
  int number = 0;
  for (const auto& block : mesh.cells.blocks)
    for (int e = 0; e < block.count(); ++e) {
      text += fmt::format("*ELEMENT, Type=C3D{}\n{}", nodes_of(block.cell), ++number);
      for (int i = 0; i < nodes_of(block.cell); ++i)
        text += fmt::format(",{}{}", i == 9 ? "\n" : "",
                            mesh.labels[block.nodes[e * nodes_of(block.cell) + i]]);
      text += "\n";
    }
  for (const auto& set : mesh.sets) {
    text += "*NSET, NSET=" + set.name + "\n";
    for (const int node : set.nodes) text += fmt::format("{},\n", mesh.labels[node]);
  }
  return text;
}

ImportedMesh read_text_mesh(const std::string& name, const std::string& text, double unit = 1) {
  const test::TemporaryFolder folder;
  test::put(folder / name, text);
  return read_mesh((folder / name).string(), unit);
}

}  // namespace

TEST_CASE("a deck of CalculiX gives nodes, cells and sets", "[imports]") {
  const ImportedMesh mesh = read_mesh(deck_of_box, 1e-3);
  CHECK(mesh.cells.nodes == 32);
  REQUIRE(mesh.cells.blocks.size() == 1);
  CHECK(mesh.cells.blocks[0].count() == 2);
  const std::vector<int>& right = nodes_of_set(mesh, "Right", JsonPointer());
  CHECK(right.size() == 13);
  for (const int node : right) CHECK(mesh.nodes[node][0] == Approx(0.01));
  CHECK(test::complaint_of([&] { nodes_of_set(mesh, "RIHGT", JsonPointer("/sets/0")); }) ==
        "/sets/0 = RIHGT; no set of nodes of the mesh; did you mean 'RIGHT'? known: LEFT, NALL, "
        "RIGHT");
}

TEST_CASE("a mesh that is written is read again", "[imports]") {
  const ImportedMesh first = read_mesh(deck_of_box, 1),
                     again = read_text_mesh("a.INP", inp_of(first));
  CHECK(again.nodes == first.nodes);
  CHECK(again.labels == first.labels);
  REQUIRE(again.cells.blocks.size() == 1);
  CHECK(again.cells.blocks[0].nodes == first.cells.blocks[0].nodes);
  REQUIRE(again.sets.size() == first.sets.size());
  for (std::size_t i = 0; i < first.sets.size(); ++i) {
    CHECK(again.sets[i].name == first.sets[i].name);
    CHECK(again.sets[i].nodes == first.sets[i].nodes);
  }
}

TEST_CASE("sets of a deck: generated, of sets, of surface elements", "[imports]") {
  std::string text =
      inp_of(read_text_mesh("a.msh", gmsh_file(SolidCell::tetrahedron, 11, 0, false)));
  text +=
      "** a reference point, and a surface of Gmsh\n*NODE, NSET=FAR\n99, 1e3, +2, 3\n"
      "*ELEMENT, TYPE=CPS6, ELSET=Surface1\n7, 11,12,13,15,16,17\n"
      "*ELSET, ELSET=Clamp\nSurface1\n"
      "*NSET, NSET=Odd, GENERATE\n11, 15, 2\n*NSET,\nNSET=Both\nodd, 14\n99\n*TIE\nA, B\n";
  const ImportedMesh mesh = read_text_mesh("a.inp", text);
  const auto labels = [&](const char* name) {
    std::vector<int> found;
    for (const int node : nodes_of_set(mesh, name, JsonPointer()))
      found.push_back(mesh.labels[node]);
    return found;
  };
  CHECK(labels("Odd") == std::vector<int>{11, 13, 15});
  CHECK(labels("Both") == std::vector<int>{11, 13, 14, 15});
  CHECK(labels("Clamp") == std::vector<int>{11, 12, 13, 15, 16, 17});
  CHECK(mesh.cells.nodes == 10);
  CHECK(mesh.skipped ==
        std::vector<std::string>{"*TIE joins nodes; it is not taken over",
                                 "elements CPS6 (1) are no solids; their sets are sets of nodes",
                                 "the set FAR has no node of a solid element"});
}

TEST_CASE("meshes of Gmsh have their nodes in the order of CalculiX", "[imports]") {
  const auto [cell, type, extra] =
      GENERATE(table<SolidCell, int, int>({{SolidCell::tetrahedron, 11, 0},
                                           {SolidCell::hexahedron, 17, 0},
                                           {SolidCell::hexahedron, 12, 7},
                                           {SolidCell::wedge, 18, 0},
                                           {SolidCell::wedge, 13, 3}}));
  const bool version_4 = GENERATE(false, true);
  const ImportedMesh mesh = read_text_mesh("a.msh", gmsh_file(cell, type, extra, version_4), 0.1);
  REQUIRE(mesh.cells.blocks.size() == 1);
  const std::vector<int>& nodes = mesh.cells.blocks[0].nodes;
  REQUIRE(static_cast<int>(nodes.size()) == nodes_of(cell));
  CHECK(mesh.cells.nodes == nodes_of(cell));
  const std::vector<Vector3d> corners = corners_of(cell);
  for (std::size_t i = 0; i < corners.size(); ++i)
    CHECK((mesh.nodes[nodes[i]] - 0.1 * corners[i]).norm() < 1e-15);
  const Edges edges = edges_of(cell);
  for (std::size_t i = 0; i < edges.size(); ++i)
    CHECK((mesh.nodes[nodes[corners.size() + i]] -
           0.05 * (corners[edges[i][0]] + corners[edges[i][1]]))
              .norm() < 1e-15);
  CHECK(nodes_of_set(mesh, "base of it", JsonPointer()) == std::vector<int>{0, 1, 2});
}

TEST_CASE("meshes that are none are refused with their line", "[imports]") {
  const std::string good = gmsh_file(SolidCell::tetrahedron, 11, 0, false);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string deck = inp_of(read_text_mesh("a.msh", good));
  const auto [name, text, line, rule] =
      GENERATE_COPY(table<std::string, std::string, int, std::string>({
          {"a.msh", changed("2.2 0", "2.2 1"), 2, "a binary file; write it as text"},
          {"a.msh", changed("2.2 0", "4.0 0"), 2, "write 4.1 or 2.2"},
          {"a.msh", changed("2 11 2", "2 4 2"), 25,
           "a linear element; mesh with quadratic elements: gmsh -order 2"},
          {"a.msh", changed("2 11 2", "2 29 2"), 25, "an element of type 29"},
          {"a.msh", changed(" 20\n", " 21\n"), 0, "an element has node 21, which has no place"},
          {"a.msh", changed(" 20\n", " 19\n"), 25, "an element has a node twice"},
          {"a.msh", changed(" 20\n", "\n"), 25, "an element of 9 nodes; expected 10"},
          {"a.msh", changed("$EndElements", "$End"), 0, "the file ends too early"},
          {"a.msh", changed("$Nodes\n10\n11", "$Nodes\n10\nx"), 11, "'x' is no number"},
          {"a.msh", changed("$Nodes", "$PartitionedEntities"), 9, "without partitions"},
          {"a.inp", deck + "*ELEMENT, TYPE=C3D8R\n", 19,
           "C3D8R is linear; mesh with quadratic elements"},
          {"a.inp", deck + "*ELEMENT, TYPE=B31\n", 19, "B31 is no solid element that is read"},
          {"a.inp", deck + "*INCLUDE, INPUT=b.inp\n", 19, "put the included file in its place"},
          {"a.inp", deck + "*PART, NAME=p\n", 19, "without parts and assemblies"},
          {"a.inp", deck + "*NODE\n12, 0, 0, 0\n", 20, "node 12 stands here a second time"},
          {"a.inp", deck + "*NODE, SYSTEM=C\n", 19, "*NODE with SYSTEM or ELSET is not read"},
          {"a.inp", deck + "*ELEMENT, TYPE=C3D10\n2, 11, 12\n*STEP\n", 21,
           "element 2 before it lacks nodes"},
          {"a.inp", deck + "*ELEMENT, TYPE=C3D10\n2,11,12,13,14,15,16,17,18,19,20\n", 20,
           "its stiffness would count twice"},
          {"a.inp", deck + "*NSET, NSET=A\nB\n", 20, "there is no set B above"},
          {"a.inp", deck + "*SOLID SECTION, MATERIAL=A\n*SOLID SECTION, MATERIAL=B\n", 20,
           "materials A and B"},
          {"a.inp", "*NODE\n1, 0, 0, 0\n", 0, "there are no solid elements in it"},
          {"a.stl", "solid\n", 0, "expected a mesh"},
      }));
  CAPTURE(rule, text);
  const SpecError error =
      test::refusal_of([&, &name = name, &text = text] { read_text_mesh(name, text); });
  CHECK(error.faults()[0].line == line);
  CHECK(error.faults()[0].source.ends_with(name));
  CHECK_THAT(error.rule(), Catch::Contains(rule));
}
