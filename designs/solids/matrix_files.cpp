#include "designs/solids/import_matrices.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCore>
#include <cmath>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "core/math/rotation.hpp"
#include "core/math/sparse_definite.hpp"
#include "designs/solids/import_mesh.hpp"
#include "designs/solids/numbered_lines.hpp"

namespace flexopt {
namespace {

using SparseRows = Eigen::SparseMatrix<double>;

int index_of(const NumberedLines& lines, double number, int n) {
  const int index = lines.whole(number);
  if (index < 1 || index > n) lines.fail(fmt::format("row or column {} of {}", index, n));
  return index - 1;
}

/// Coordinate 3 node + direction of each row of CalculiX's matrices, which its lines name as
/// node.direction: all three of every node of the mesh.
std::vector<int> read_coordinates(const std::string& file, const ImportedMesh& mesh) {
  std::unordered_map<int, int> node_of;
  for (int i = 0; i < mesh.cells.nodes; ++i) node_of[mesh.labels[i]] = i;
  std::vector<int> coordinates;
  std::vector<bool> met(3 * mesh.nodes.size());
  NumberedLines lines(file);
  while (lines.next()) {
    if (lines.text().empty()) continue;
    const double number = lines.numbers(1)[0], label = std::floor(number);
    const int direction = static_cast<int>(std::lround(10 * (number - label))) - 1;
    const auto node = node_of.find(lines.whole(label));
    if (node == node_of.end() || direction < 0 || direction > 2)
      lines.fail("no displacement of a node of the mesh's solid elements");
    coordinates.push_back(3 * node->second + direction);
    if (met[coordinates.back()]) lines.fail("this displacement stands above, too");
    met[coordinates.back()] = true;
  }
  for (std::size_t i = 0; i < met.size(); ++i)
    if (!met[i])
      lines.fail(fmt::format("{}.{} is missing: the deck holds this node or ties it to others",
                             mesh.labels[i / 3], i % 3 + 1),
                 true);
  return coordinates;
}

/// A symmetric matrix of which one triangle is written, a line "row column value" an entry, times
/// `factor`; all of it.
SparseRows read_triangle(const std::string& file, const std::vector<int>& coordinates,
                         double factor) {
  const int n = static_cast<int>(coordinates.size());
  std::vector<Eigen::Triplet<double>> entries;
  NumberedLines lines(file);
  bool lower = false, upper = false;
  while (lines.next()) {
    if (lines.text().empty()) continue;
    const std::vector<double>& entry = lines.numbers(3);
    const int i = index_of(lines, entry[0], n), j = index_of(lines, entry[1], n);
    if (!std::isfinite(entry[2])) lines.fail("an entry is not finite");
    (i < j ? upper : lower) |= i != j;
    if (lower && upper) lines.fail("entries of both triangles; expected those of one");
    entries.emplace_back(coordinates[i], coordinates[j], factor * entry[2]);
    if (i != j) entries.emplace_back(coordinates[j], coordinates[i], factor * entry[2]);
  }
  SparseRows matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Completes motions of the patches by those of the free coordinates without forces there.
void relax(const SparseRows& stiffness, const std::vector<int>& free, const std::string& file,
           MatrixXd& fields) {
  std::vector<int> place(stiffness.rows(), -1);
  for (std::size_t i = 0; i < free.size(); ++i) place[free[i]] = static_cast<int>(i);
  SparseMatrix inner(static_cast<int>(free.size()));
  for (const int column : free)
    for (SparseRows::InnerIterator entry(stiffness, column); entry; ++entry)
      if (const int row = place[entry.row()]; row >= place[column])
        inner.add(row, place[column], entry.value());
  const auto factor = DefiniteFactor::of(inner);
  if (!factor)
    NumberedLines(file).fail("check 3: a part of the body hangs on nothing; " + factor.error(),
                             true);
  const MatrixXd forces = stiffness * fields;
  MatrixXd answers = -forces(free, Eigen::all);
  (*factor)->solve(answers);
  fields(free, Eigen::all) = answers;
}

}  // namespace

MatrixXd read_matrix_market(const std::string& file, int n) {
  NumberedLines lines(file);
  lines.need();
  const std::string head = capitals(lines.text());
  const bool symmetric = head.ends_with(" SYMMETRIC"), array = head.find(" ARRAY ") != head.npos;
  if (!head.starts_with("%%MATRIXMARKET MATRIX ") || (!symmetric && !head.ends_with(" GENERAL")) ||
      head.find(" REAL ") == head.npos)
    lines.fail("expected %%MatrixMarket matrix coordinate|array real general|symmetric");
  do lines.need();
  while (lines.text().empty() || lines.text().starts_with('%'));
  const std::vector<double> size = lines.numbers(array ? 2 : 3);
  if (size[0] != n || size[1] != n)
    lines.fail(fmt::format("{:g} x {:g} entries; the interfaces and modes have {} coordinates",
                           size[0], size[1], n));
  MatrixXd matrix = MatrixXd::Zero(n, n);
  const auto put = [&](int i, int j, double value) {
    matrix(i, j) = value;
    if (symmetric) matrix(j, i) = value;
  };
  if (array) {
    for (int j = 0; j < n; ++j)
      for (int i = symmetric ? j : 0; i < n; ++i) {
        lines.need();
        put(i, j, lines.numbers(1)[0]);
      }
  } else {
    for (double left = size[2]; left > 0; --left) {
      lines.need();
      const std::vector<double>& entry = lines.numbers(3);
      put(index_of(lines, entry[0], n), index_of(lines, entry[1], n), entry[2]);
    }
  }
  return matrix;
}

ImportedMatrices condensed_matrix_storage(const std::string& stem, const std::string& mesh_file,
                                          const ImportUnits& units,
                                          const std::vector<ImportedInterface>& interfaces,
                                          const std::vector<std::string>& sets) {
  const ImportedMesh mesh = read_mesh(mesh_file, units.length);
  const std::vector<int> coordinates = read_coordinates(stem + ".dof", mesh);
  const SparseRows stiffness =
                       read_triangle(stem + ".sti", coordinates, units.force / units.length),
                   mass = read_triangle(stem + ".mas", coordinates, units.mass);
  MatrixXd fields = MatrixXd::Zero(coordinates.size(), 6 * interfaces.size());
  std::vector<int> holder(mesh.nodes.size(), -1);
  for (std::size_t a = 0; a < interfaces.size(); ++a) {
    const JsonPointer at = JsonPointer("/interfaces") / a / "nodes";
    for (const int node : nodes_of_set(mesh, sets[a], at)) {
      if (holder[node] >= 0)
        throw SpecError(at, sets[a],
                        fmt::format("node {} is held by {} too; patches share none",
                                    mesh.labels[node], interfaces[holder[node]].name));
      holder[node] = static_cast<int>(a);
      fields.block<3, 3>(3 * node, 6 * a).setIdentity();
      fields.block<3, 3>(3 * node, 6 * a + 3) = -hat(mesh.nodes[node] - interfaces[a].place);
    }
  }
  std::vector<int> free;
  for (int i = 0; i < fields.rows(); ++i)
    if (holder[i / 3] < 0) free.push_back(i);
  if (!free.empty()) relax(stiffness, free, stem + ".sti", fields);
  const auto over_interfaces = [&](const SparseRows& A) -> MatrixXd {
    const MatrixXd reduced = fields.transpose() * (A * fields);
    return 0.5 * (reduced + reduced.transpose());
  };
  return {.stiffness = over_interfaces(stiffness), .mass = over_interfaces(mass)};
}

}  // namespace flexopt
