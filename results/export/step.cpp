#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
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

/// A leaf, or the parts of a reinforced one in their order along it with the rigid box between them
/// (`box`: its body, −1 for none).
struct WholeLeaf {
  std::string name;
  std::vector<std::size_t> parts;
  int box = -1;
};

/// The leaves of a mechanism as one would make them; parts are known by the names and the bodies
/// that the reader of design files gives them.
std::vector<WholeLeaf> whole_leaves(const Mechanism& mechanism) {
  const std::vector<LeafSpring>& leaves = mechanism.leaves;
  const auto named = [&](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(leaves, name, &LeafSpring::name) -
                                    leaves.begin());
  };
  std::vector<WholeLeaf> whole;
  std::vector<bool> used(leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    if (used[i]) continue;
    WholeLeaf one{leaves[i].name, {i}};
    if (one.name.ends_with("/base") && leaves[i].tip >= 0) {
      const std::string name = one.name.substr(0, one.name.size() - 5);
      const std::size_t middle = named(name + "/reinforcement"), tip = named(name + "/tip");
      const bool plate = middle < leaves.size();
      const int step =
          plate && leaves[middle].base == leaves[i].tip ? leaves[middle].tip : leaves[i].tip;
      const RigidBody& body = mechanism.bodies[step];
      if (tip < leaves.size() && leaves[tip].base == step &&
          (plate || (body.name == name + "/reinforcement" && body.box))) {
        one = {name, {i}, plate ? -1 : step};
        if (plate) one.parts.push_back(middle);
        one.parts.push_back(tip);
      }
    }
    for (const std::size_t part : one.parts) used[part] = true;
    whole.push_back(std::move(one));
  }
  return whole;
}

/// Half of the thickness along a flat leaf; of a reinforced one with its steps.
LeafSection section_of(const Exported& exported, const WholeLeaf& leaf) {
  const std::vector<LeafSpring>& leaves = exported.mechanism.leaves;
  const LeafSpring &first = leaves[leaf.parts.front()], &last = leaves[leaf.parts.back()];
  LeafSection section{.length = (last.tip_middle() - first.origin).norm(),
                      .half = 0.5 * first.thickness,
                      .radius = exported.request.stress.fillet.value_or(0),
                      .free_tip = last.tip == free_edge};
  if (leaf.parts.size() > 1) {
    section.from = first.length;
    section.to = section.length - last.length;
    section.middle = leaf.box >= 0
                         ? exported.mechanism.bodies[leaf.box].box->half_edges.col(2).norm()
                         : 0.5 * leaves[leaf.parts[1]].thickness;
  }
  return section;
}

step::Prism prism(const LeafSpring& leaf, const LeafSection& section) {
  const Vector3d corner = leaf.origin - 0.5 * leaf.width * leaf.axes.col(1);
  const auto at = [&](const Eigen::Vector2d& p) {
    return point_mm(corner + p[0] * leaf.axes.col(0) + p[1] * leaf.axes.col(2));
  };
  step::Prism made;
  made.over = point_mm(leaf.width * leaf.axes.col(1));
  for (const OutlineEdge& e : section.outline())
    made.outline.push_back({at(e.from), at(e.to), e.by ? std::optional(at(*e.by)) : std::nullopt});
  return made;
}

step::Shape bent_or_curved(const Exported& exported, const PathPoint* point, std::size_t i) {
  const LeafSpring& leaf = exported.mechanism.leaves[i];
  // every other point of what is fine enough for triangles
  const LeafSurface surface = drawn_surface(exported.mechanism, point, i, 2);
  if (!surface.round()) return sheet(surface);
  if (point || !is_plain(leaf)) return wire(surface);
  const Vector3d way = surface.middle.back() - surface.middle.front();
  return step::Cylinder{point_mm(surface.middle.front()), direction(way),
                        1e3 * surface.half.front().norm(), 1e3 * way.norm()};
}

step::Polyhedron polyhedron(const TriangleMesh& mesh, const BodyPose& pose) {
  step::Polyhedron made{{}, mesh.triangles};
  for (const Vector3d& p : mesh.points) made.points.push_back(point_mm(pose(p)));
  return made;
}

constexpr std::array<double, 3> steel{0.62, 0.68, 0.74}, blue_body{0.20, 0.35, 0.60},
    grey{0.45, 0.45, 0.45};

step::Product leaf_product(const Exported& exported, const PathPoint* point, const WholeLeaf& leaf,
                           std::vector<std::string>& notes) {
  const Mechanism& mechanism = exported.mechanism;
  const LeafSpring& first = mechanism.leaves[leaf.parts.front()];
  step::Product made{.name = leaf.name, .colour = steel};
  const LeafSection section = section_of(exported, leaf);
  const bool flat = !point && first.section != Section::circular && is_plain(first);
  if (flat && section.fits()) {
    made.shapes.push_back(prism(first, section));
    made.volume = 1e9 * section.area() * first.width;
    return made;
  }
  if (section.radius > 0)
    notes.push_back("step: leaf " + leaf.name +
                    " has no fillets: only flat undeflected ones have them");
  double volume = 0;
  for (const std::size_t i : leaf.parts) {
    made.shapes.push_back(bent_or_curved(exported, point, i));
    volume += closed_leaf(drawn_surface(mechanism, point, i)).volume();
  }
  if (leaf.box >= 0) {
    const TriangleMesh box = closed_box(*mechanism.bodies[leaf.box].box);
    made.shapes.push_back(polyhedron(box, body_pose(mechanism, point, leaf.box)));
    volume += box.volume();
  }
  made.volume = 1e9 * volume;
  return made;
}

step::Product body_product(const Mechanism& mechanism, const PathPoint* point,
                           const BodyForm& form) {
  const bool moves = form.body != ground;
  const BodyPose pose = moves ? body_pose(mechanism, point, form.body) : BodyPose{};
  step::Product made{.name = form.name, .colour = moves ? blue_body : grey};
  for (const TriangleMesh& mesh : form.blocks) made.shapes.push_back(polyhedron(mesh, pose));
  for (const TriangleMesh& mesh : form.ribs) made.cut.push_back(polyhedron(mesh, pose));
  for (const TriangleMesh& mesh : form.rooms) made.rooms.push_back(polyhedron(mesh, pose));
  made.solids = moves && form.parts == 1 ? 1 : 0;
  return made;
}

step::Product elastic_product(const Mechanism& mechanism, const PathPoint* point, std::size_t k) {
  const TriangleMesh mesh = elastic_solid(mechanism, point, k);
  step::Product made{.name = mesh.name, .colour = blue_body};
  made.shapes.push_back(polyhedron(mesh, {}));
  made.volume = 1e9 * mesh.volume();
  return made;
}

/// Elastic bodies that hang on bodies of forms, which end before their faces.
void note_bare_faces(const Mechanism& mechanism, std::vector<std::string>& notes) {
  for (const ElasticBody& body : mechanism.elastic_bodies)
    for (const ElasticInterface& face : body.interfaces)
      if (body.cells && (face.body == ground || !is_elastic_frame(mechanism, face.body)))
        notes.push_back(fmt::format(
            "step: nothing is drawn between face {} of elastic body {} and {}, which holds it",
            face.name, body.name,
            face.body == ground ? "the ground" : "body " + mechanism.bodies[face.body].name));
}

std::string written(const step::Document& document) {
  const PartFunction write = part_function("flexopt_step.so", "flexopt_write_step");
  if (!write.address)
    throw SpecError("--format", "step",
                    "this program was built without Open CASCADE (" + write.missing +
                        "): install the package libocct-data-exchange-dev and build it again");
  std::string text;
  try {
    reinterpret_cast<decltype(&flexopt_write_step)>(write.address)(document, text);
  } catch (const std::runtime_error& error) {
    throw NotExported(std::string("step: ") + error.what());
  }
  return text;
}

}  // namespace

StepFile step_file(const Exported& exported, const PathPoint* point, bool monolithic) {
  const Mechanism& mechanism = exported.mechanism;
  if (const auto names = joints_and_springs(mechanism); monolithic && !names.empty())
    throw SpecError("--monolithic", fmt::format("{}", fmt::join(names, ", ")),
                    "one solid has no joints and no springs");
  if (monolithic && !mechanism.elastic_bodies.empty())
    throw SpecError("--monolithic", mechanism.elastic_bodies.front().name,
                    "one solid is made of leaves and rigid bodies, not of elastic bodies");
  StepFile file;
  step::Document document{.name = exported.name,
                          .origin = "flexopt " + std::string(version()),
                          .products = {},
                          .monolithic = monolithic};
  std::vector<std::string> of_leaves;  // bodies that are parts of reinforced leaves
  for (const WholeLeaf& leaf : whole_leaves(mechanism)) {
    document.products.push_back(leaf_product(exported, point, leaf, file.notes));
    if (leaf.parts.size() > 1)
      for (const int body :
           {mechanism.leaves[leaf.parts.front()].tip, mechanism.leaves[leaf.parts.back()].base})
        of_leaves.push_back(mechanism.bodies[body].name);
  }
  const double fillet = exported.request.stress.fillet.value_or(0);
  for (const BodyForm& form : body_forms(mechanism, fillet)) {
    if (form.body != ground && (is_elastic_frame(mechanism, form.body) ||
                                std::ranges::find(of_leaves, form.name) != of_leaves.end()))
      continue;
    if (monolithic && !form.faults.empty())
      throw NotExported("step: no single solid: " + form.faults.front());
    for (const std::string& fault : form.faults) file.notes.push_back("step: " + fault);
    if (!form.blocks.empty() || !form.ribs.empty())
      document.products.push_back(body_product(mechanism, point, form));
    else if (!form.bare.empty())
      file.notes.push_back("step: body " + form.name +
                           " has no solid: it is the line in which its leaves meet");
  }
  for (std::size_t k = 0; k < mechanism.elastic_bodies.size(); ++k)
    if (mechanism.elastic_bodies[k].cells)
      document.products.push_back(elastic_product(mechanism, point, k));
  note_bare_faces(mechanism, file.notes);
  file.content = written(document);
  return file;
}

}  // namespace flexopt
