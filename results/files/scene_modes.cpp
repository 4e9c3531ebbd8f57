#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/response/path/frequency_derivatives.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_parts.hpp"
#include "results/files/scene.hpp"

namespace flexopt {

namespace {

constexpr double full_scale = 32767;

constexpr int vtk_triangle = 5, vtk_quad = 9;  // VTK file formats, cell types

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
    if (drawn_points(path[i]) > 0)
      sets += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", path[i].stroke,
                          file_name(i));
  return "<?xml version=\"1.0\"?>\n"
         "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
         "<Collection>\n" +
         sets + "</Collection>\n</VTKFile>\n";
}

struct ModeShape {
  VectorXd points;  ///< motion of all points that are drawn, the largest of which is one
  VectorXd bodies;  ///< displacement and spin of each body
};
/// A mode with the motion of all so many mesh points; nothing where the model of a leaf does not
/// tell its own.
std::optional<ModeShape> mode_shape(const Mechanism& mechanism, const PathPoint& point,
                                    const Mode& mode, std::size_t points) {
  if (mode.body_motion.size() != static_cast<Eigen::Index>(6 * mechanism.bodies.size()))
    return std::nullopt;
  for (std::size_t k = 0; k < mode.leaf_motion.size(); ++k)
    if (mode.leaf_motion[k].size() == 0 && mechanism.leaves[k].tip == free_edge)
      return std::nullopt;
  ModeShape shape{VectorXd::Zero(static_cast<Eigen::Index>(3 * points)), mode.body_motion};
  Eigen::Index begin = 0;
  for (std::size_t k = 0; k < mode.leaf_motion.size(); ++k) {
    const VectorXd own = mode.leaf_motion[k].size() > 0
                             ? mode.leaf_motion[k]
                             : cubic_leaf_motion(mechanism, k, point, mode.body_motion);
    if (begin + own.size() > shape.points.size()) break;
    shape.points.segment(begin, own.size()) = own;
    begin += own.size();
  }
  for (const VectorXd& own : mode.elastic_motion) {
    shape.points.segment(begin, own.size()) = own;
    begin += own.size();
  }
  double largest = 0;
  for (Eigen::Index i = 0; i + 2 < shape.points.size(); i += 3)
    largest = std::max(largest, shape.points.segment<3>(i).norm());
  if (largest > 0) {
    shape.points /= largest;
    shape.bodies /= largest;
  }
  return shape;
}

}  // namespace

std::size_t drawn_points(const PathPoint& point) {
  std::size_t points = 0;
  for_each_shape(point, [&](const auto& shape) { points += shape.undeflected.size(); });
  return points;
}

std::vector<double> places_along(const LeafShape& shape) {
  std::vector<double> places{0};
  for (int i = 1; i < shape.points_along; ++i)
    places.push_back(places.back() + (shape.undeflected[i] - shape.undeflected[i - 1]).norm());
  for (double& s : places) s /= std::max(places.back(), 1e-300);
  return places;
}

VectorXd cubic_leaf_motion(const Mechanism& mechanism, std::size_t leaf, const PathPoint& point,
                           const VectorXd& body_motion) {
  const LeafShape& shape = point.shapes[leaf];
  const LeafSpring& of = mechanism.leaves[leaf];
  const int along = shape.points_along, across = shape.points_across;
  const auto at = [&](int i, int j) -> const Vector3d& { return shape.deflected[j * along + i]; };
  struct Edge {
    Vector3d shift = Vector3d::Zero(), spin = Vector3d::Zero(), reference = Vector3d::Zero();
  };
  const auto edge = [&](int body) {
    if (body < 0) return Edge{};
    return Edge{body_motion.segment<3>(6 * body), body_motion.segment<3>(6 * body + 3),
                mechanism.bodies[body].reference + point.bodies[body].displacement};
  };
  const Edge base = edge(of.base), tip = edge(of.tip == free_edge ? of.base : of.tip);
  VectorXd motion(3 * along * across);
  const std::vector<double> places = places_along(shape);
  for (int j = 0; j < across; ++j) {
    const Vector3d &first = at(0, j), &last = at(along - 1, j);
    const Vector3d u0 = base.shift + base.spin.cross(first - base.reference),
                   u1 = tip.shift + tip.spin.cross(last - tip.reference),
                   w0 = base.spin.cross(Vector3d(last - first)),
                   w1 = tip.spin.cross(Vector3d(last - first));
    for (int i = 0; i < along; ++i) {
      const double s = places[i], r = 1 - s;
      motion.segment<3>(3 * (j * along + i)) =
          (1 + 2 * s) * r * r * u0 + s * s * (3 - 2 * s) * u1 + s * r * r * w0 - s * s * r * w1;
    }
  }
  return motion;
}

OrderedJson modes_json(const Mechanism& mechanism, const std::vector<PathPoint>& path,
                       const std::vector<std::size_t>& frames, std::size_t points) {
  std::size_t locked = 0, free = 0;
  for (const std::size_t f : frames) {
    locked = std::max(locked, path[f].modes_locked.size());
    free = std::max(free, path[f].modes_free.size());
  }
  const std::size_t bodies = mechanism.bodies.size(), modes = locked + free;
  std::vector<std::int16_t> leaf_values;
  std::vector<float> body_values;
  std::vector<VectorXd> before(modes);
  bool any = false;
  for (const std::size_t f : frames)
    for (std::size_t m = 0; m < modes; ++m) {
      const std::vector<Mode>& list = m < locked ? path[f].modes_locked : path[f].modes_free;
      const std::size_t k = m < locked ? m : m - locked;
      ModeShape shape{VectorXd::Zero(static_cast<Eigen::Index>(3 * points)),
                      VectorXd::Zero(static_cast<Eigen::Index>(6 * bodies))};
      if (k < list.size())
        if (auto own = mode_shape(mechanism, path[f], list[k], points)) {
          shape = std::move(*own);
          any = true;
        }
      if (before[m].size() > 0 && before[m].dot(shape.points) < 0) {
        shape.points *= -1;
        shape.bodies *= -1;
      }
      for (const double x : shape.points)
        leaf_values.push_back(static_cast<std::int16_t>(std::lround(full_scale * x)));
      for (const double x : shape.bodies) body_values.push_back(static_cast<float>(x));
      before[m] = std::move(shape.points);
    }
  if (!any) return nullptr;
  return {{"frames", frames},
          {"locked", locked},
          {"free", free},
          {"leaves", packed_rows(leaf_values, {frames.size(), modes, points, 3})},
          {"bodies", packed_floats(body_values, {frames.size(), modes, bodies, 6})}};
}

std::vector<std::vector<int>> mode_branches(const std::vector<PathPoint>& path, DriveState drive) {
  std::vector<std::vector<int>> branches(path.size());
  std::vector<const VectorXd*> before;  // motions of the nearest earlier point with modes
  std::vector<int> known;               // and their branches
  int count = 0;
  for (std::size_t p = 0; p < path.size(); ++p) {
    const std::vector<Mode>& now =
        drive == DriveState::locked ? path[p].modes_locked : path[p].modes_free;
    if (now.empty()) continue;
    std::vector<int>& own = branches[p];
    own.assign(now.size(), -1);
    const std::vector<int> found = match_modes(before, now);
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i] >= 0) own[found[i]] = known[i];
    for (int& branch : own)
      if (branch < 0) branch = count++;
    before.clear();
    for (const Mode& mode : now) before.push_back(&mode.motion);
    known = own;
  }
  return branches;
}

std::string shape_vtu(const PathPoint& point, const std::vector<VtkField>& fields) {
  std::string points, displacement, von_mises, connectivity, offsets, types, part;
  int count = 0, end = 0, cells = 0, k = 0;
  const auto add_cell = [&](const auto& corners, int type) {
    for (const int corner : corners)
      fmt::format_to(std::back_inserter(connectivity), "{} ", count + corner);
    connectivity += '\n';
    offsets += fmt::format("{}\n", end += static_cast<int>(std::size(corners)));
    types += fmt::format("{}\n", type);
    part += fmt::format("{}\n", k);
    ++cells;
  };
  const auto add_points = [&](const auto& shape) {
    assert(shape.deflected.size() == shape.undeflected.size());
    assert(shape.von_mises.size() == shape.undeflected.size());
    for (std::size_t i = 0; i < shape.undeflected.size(); ++i) {
      add_vector(points, shape.undeflected[i]);
      add_vector(displacement, shape.deflected[i] - shape.undeflected[i]);
      von_mises += fmt::format("{}\n", shape.von_mises[i]);
    }
    count += static_cast<int>(shape.undeflected.size());
    ++k;
  };
  for (const LeafShape& leaf : point.shapes) {
    const int along = leaf.points_along, across = leaf.points_across;
    assert(leaf.undeflected.size() == static_cast<std::size_t>(along * across));
    for (int j = 0; j + 1 < across; ++j)
      for (int i = 0; i + 1 < along; ++i) {
        const int a = j * along + i;
        add_cell(std::array{a, a + 1, a + 1 + along, a + along}, vtk_quad);
      }
    add_points(leaf);
  }
  for (const ElasticShape& body : point.elastic_shapes) {
    for (const auto& triangle : body.triangles) add_cell(triangle, vtk_triangle);
    add_points(body);
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
         "<CellData Scalars=\"leaf\">\n" + data_array("Int32", "leaf", 1, part) +
         "</CellData>\n<Points>\n" + data_array("Float64", "Points", 3, points) +
         "</Points>\n<Cells>\n" + data_array("Int32", "connectivity", 1, connectivity) +
         data_array("Int32", "offsets", 1, offsets) + data_array("UInt8", "types", 1, types) +
         "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

std::string point_vtu(const Mechanism& mechanism, const PathPoint& point) {
  const std::size_t points = drawn_points(point);
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
  return shape_vtu(point, fields);
}

void write_shapes(const std::filesystem::path& folder, const std::vector<PathPoint>& path) {
  namespace fs = std::filesystem;
  bool any = false;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const bool drawn = drawn_points(path[i]) > 0;
    write_or_remove(folder / file_name(i), drawn ? shape_vtu(path[i]) : "");
    any = any || drawn;
  }
  for (std::size_t i = path.size(); fs::remove(folder / file_name(i)); ++i) {
  }
  write_or_remove(folder / "shapes.pvd", any ? shapes_pvd(path) : "");
}

}  // namespace flexopt
