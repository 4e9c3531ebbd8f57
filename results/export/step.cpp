#include <cmath>

#include "core/spec/spec_error.hpp"
#include "results/export/exported.hpp"
#include "results/export/step_writer.hpp"
#include "results/files/program_part.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

step::Point point_mm(const Vector3d& p) { return {1e3 * p[0], 1e3 * p[1], 1e3 * p[2]}; }
step::Point direction(const Vector3d& v) {
  const Vector3d unit = v.normalized();
  return {unit[0], unit[1], unit[2]};
}

step::Sheet sheet(const LeafSurface& surface) {
  step::Sheet made{surface.along, surface.across, surface.places, surface.folds, {}, {}};
  for (std::size_t k = 0; k < surface.middle.size(); ++k) {
    made.top.push_back(point_mm(surface.middle[k] + surface.half[k]));
    made.bottom.push_back(point_mm(surface.middle[k] - surface.half[k]));
  }
  return made;
}

step::Pipe wire(const LeafSurface& surface) {
  step::Pipe pipe;
  for (std::size_t i = 0; i < surface.middle.size(); ++i) {
    const Vector3d &side = surface.side[i], along = side.cross(surface.half[i]);
    pipe.circles.push_back(
        {point_mm(surface.middle[i]), direction(along), direction(side), 1e3 * side.norm()});
  }
  return pipe;
}

bool is_plain(const LeafSpring& leaf) { return !leaf.curve && !leaf.fold && !leaf.has_profile(); }

/// The section of a flat leaf along it, extruded over its width; at clamped ends it widens by
/// quarter circles.
step::Prism prism(const LeafSpring& leaf, double radius) {
  const Vector3d corner = leaf.origin - 0.5 * leaf.width * leaf.axes.col(1);
  const double h = 0.5 * leaf.thickness, L = leaf.length;
  const auto at = [&](double x, double y) {
    return point_mm(corner + x * leaf.axes.col(0) + y * leaf.axes.col(2));
  };
  const double base = radius, tip = leaf.tip == free_edge ? 0 : radius;
  step::Prism made;
  made.over = point_mm(leaf.width * leaf.axes.col(1));
  const auto line = [&](const step::Point& p, const step::Point& q) {
    made.outline.push_back({p, q, std::nullopt});
  };
  const auto arc = [&](double x0, double y0, double x1, double y1, double x2, double y2) {
    made.outline.push_back({at(x0, y0), at(x2, y2), at(x1, y1)});
  };
  const double part = 1 - std::sqrt(0.5);  // share of the radius: the middle of a quarter circle
  line(at(base, -h), at(L - tip, -h));
  if (tip > 0) arc(L - tip, -h, L - part * tip, -h - part * tip, L, -h - tip);
  line(at(L, -h - tip), at(L, h + tip));
  if (tip > 0) arc(L, h + tip, L - part * tip, h + part * tip, L - tip, h);
  line(at(L - tip, h), at(base, h));
  if (base > 0) arc(base, h, part * base, h + part * base, 0, h + base);
  line(at(0, h + base), at(0, -h - base));
  if (base > 0) arc(0, -h - base, part * base, -h - part * base, base, -h);
  return made;
}

step::Solid leaf_solid(const Exported& exported, const PathPoint* point, std::size_t i,
                       std::vector<std::string>& without_fillets) {
  const LeafSpring& leaf = exported.mechanism.leaves[i];
  const bool round = leaf.section == Section::circular;
  double radius = exported.request.stress.fillet.value_or(0);
  const bool carries = !point && !round && is_plain(leaf) && 2 * radius < leaf.length;
  if (radius > 0 && !carries) {
    without_fillets.push_back(leaf.name);
    radius = 0;
  }
  if (!point && !round && is_plain(leaf)) return {leaf.name, prism(leaf, radius)};
  // every other point of what is fine enough for triangles
  const LeafSurface surface = drawn_surface(exported.mechanism, point, i, 2);
  if (!round) return {leaf.name, sheet(surface)};
  if (point || !is_plain(leaf)) return {leaf.name, wire(surface)};
  const Vector3d way = surface.middle.back() - surface.middle.front();
  return {leaf.name, step::Cylinder{point_mm(surface.middle.front()), direction(way),
                                    1e3 * surface.half.front().norm(), 1e3 * way.norm()}};
}

std::string written(const step::Document& document) {
  const PartFunction write = part_function("flexopt_step.so", "flexopt_write_step");
  if (!write.address)
    throw SpecError("--format", "step",
                    "this program was built without Open CASCADE (" + write.missing +
                        "): install the package libocct-data-exchange-dev and build it again");
  std::string text;
  reinterpret_cast<decltype(&flexopt_write_step)>(write.address)(document, text);
  return text;
}

}  // namespace

StepFile step_file(const Exported& exported, const PathPoint* point) {
  const Mechanism& mechanism = exported.mechanism;
  StepFile file;
  step::Document document{exported.name, "flexopt " + std::string(version()), {}};
  std::vector<std::string> without_fillets;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    document.solids.push_back(leaf_solid(exported, point, i, without_fillets));
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const TriangleMesh mesh = body_solid(mechanism, static_cast<int>(b));
    if (mesh.triangles.empty()) continue;
    const BodyPose pose = body_pose(mechanism, point, static_cast<int>(b));
    step::Polyhedron body{{}, mesh.triangles};
    for (const Vector3d& p : mesh.points) body.points.push_back(point_mm(pose(p)));
    document.solids.push_back({mesh.name, std::move(body)});
  }
  for (const std::string& name : without_fillets)
    file.notes.push_back("step: leaf " + name +
                         " has no fillets: only flat undeflected ones have them");
  file.content = written(document);
  return file;
}

}  // namespace flexopt
