#include "results/files/result_parts.hpp"

#include <fmt/format.h>

#include <cassert>
#include <iterator>

#include "results/files/folder.hpp"
#include "results/files/scene.hpp"

namespace flexopt {

namespace {

constexpr int vtk_quad = 9;  // VTK file formats, cell types

std::string file_name(std::size_t i) { return fmt::format("shape_{:03}.vtu", i); }

void add_vector(std::string& out, const Vector3d& v) {
  fmt::format_to(std::back_inserter(out), "{} {} {}\n", v[0], v[1], v[2]);
}

std::string data_array(const std::string& type, const std::string& name, int components,
                       const std::string& content) {
  return fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n"
      "{}</DataArray>\n",
      type, name, components, content);
}

/// The collection; "time" is the stroke. Points without shapes are not in it.
std::string shapes_pvd(const std::vector<PathPoint>& path) {
  std::string sets;
  for (std::size_t i = 0; i < path.size(); ++i)
    if (!path[i].shapes.empty())
      sets += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", path[i].stroke,
                          file_name(i));
  return "<?xml version=\"1.0\"?>\n"
         "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
         "<Collection>\n" +
         sets + "</Collection>\n</VTKFile>\n";
}

}  // namespace

std::string shape_vtu(const std::vector<LeafShape>& leaves, const std::vector<VtkField>& fields) {
  std::string points, displacement, von_mises, connectivity, offsets, types, leaf_index;
  int count = 0, cells = 0;
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    const LeafShape& leaf = leaves[k];
    const int along = leaf.points_along, across = leaf.points_across;
    assert(leaf.undeflected.size() == static_cast<std::size_t>(along * across));
    assert(leaf.deflected.size() == leaf.undeflected.size());
    assert(leaf.von_mises.size() == leaf.undeflected.size());
    for (std::size_t i = 0; i < leaf.undeflected.size(); ++i) {
      add_vector(points, leaf.undeflected[i]);
      add_vector(displacement, leaf.deflected[i] - leaf.undeflected[i]);
      von_mises += fmt::format("{}\n", leaf.von_mises[i]);
    }
    for (int j = 0; j + 1 < across; ++j)
      for (int i = 0; i + 1 < along; ++i) {
        const int a = count + j * along + i;
        connectivity += fmt::format("{} {} {} {}\n", a, a + 1, a + 1 + along, a + along);
        offsets += fmt::format("{}\n", 4 * ++cells);
        types += fmt::format("{}\n", vtk_quad);
        leaf_index += fmt::format("{}\n", k);
      }
    count += along * across;
  }
  std::string further;
  for (const VtkField& field : fields) {
    assert(field.values.size() == static_cast<std::size_t>(count));
    std::string values;
    for (const Vector3d& v : field.values) add_vector(values, v);
    further += data_array("Float64", field.name, 3, values);
  }
  return fmt::format(
             "<?xml version=\"1.0\"?>\n"
             "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
             "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
             count, cells) +
         "<PointData Vectors=\"displacement\" Scalars=\"von_mises\">\n" +
         data_array("Float64", "displacement", 3, displacement) +
         data_array("Float64", "von_mises", 1, von_mises) + further + "</PointData>\n" +
         "<CellData Scalars=\"leaf\">\n" + data_array("Int32", "leaf", 1, leaf_index) +
         "</CellData>\n<Points>\n" + data_array("Float64", "Points", 3, points) +
         "</Points>\n<Cells>\n" + data_array("Int32", "connectivity", 1, connectivity) +
         data_array("Int32", "offsets", 1, offsets) + data_array("UInt8", "types", 1, types) +
         "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

std::string point_vtu(const Mechanism& mechanism, const PathPoint& point) {
  std::size_t points = 0;
  for (const LeafShape& leaf : point.shapes) points += leaf.undeflected.size();
  std::vector<VtkField> fields;
  const auto add = [&](const std::vector<Mode>& modes, const char* drive) {
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const auto shape = mode_shape(mechanism, point, modes[k], points);
      if (!shape) continue;
      VtkField& field = fields.emplace_back();
      field.name = fmt::format("mode {}, drive {}, {:.6g} Hz", k + 1, drive, modes[k].frequency);
      for (Eigen::Index i = 0; i < shape->points.size(); i += 3)
        field.values.emplace_back(shape->points.segment<3>(i));
    }
  };
  add(point.modes_locked, "locked");
  add(point.modes_free, "free");
  return shape_vtu(point.shapes, fields);
}

void write_shapes(const std::filesystem::path& folder, const std::vector<PathPoint>& path) {
  namespace fs = std::filesystem;
  bool any = false;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const bool drawn = !path[i].shapes.empty();
    write_or_remove(folder / file_name(i), drawn ? shape_vtu(path[i].shapes) : "");
    any = any || drawn;
  }
  for (std::size_t i = path.size(); fs::remove(folder / file_name(i)); ++i) {
  }
  write_or_remove(folder / "shapes.pvd", any ? shapes_pvd(path) : "");
}

}  // namespace flexopt
