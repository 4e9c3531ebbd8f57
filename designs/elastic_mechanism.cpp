// Elastic bodies of a flat design with their meshes.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <list>
#include <mutex>
#include <type_traits>
#include <utility>

#include "core/math/dual.hpp"
#include "core/mechanism/each_number.hpp"
#include "designs/elastic_item.hpp"
#include "designs/flat_design.hpp"
#include "designs/solids/solid_faces.hpp"

namespace flexopt {
namespace {

constexpr double coarse_sizes = 1.6;  ///< of the coarse twin's elements over those of the mesh

template <class S>
std::vector<PatchT<S>> patches_of(const FlatElastic<S>& body) {
  std::vector<PatchT<S>> patches;
  for (const FlatInterface<S>& interface : body.interfaces) patches.push_back(interface.patch);
  return patches;
}

/// All that a mesh follows from, in a fixed order.
class PlanKey {
 public:
  PlanKey(const SolidShapeT<double>& shape, const std::vector<PatchT<double>>& patches,
          const MeshDensity& density) {
    add(shape.index());
    std::visit([&](const auto& of) { add(of); }, shape);
    for (const PatchT<double>& patch : patches) {
      for (const Vector3d& v : {patch.center, patch.half_u, patch.half_v})
        numbers_.insert(numbers_.end(), v.begin(), v.end());
    }
    add(density.size, density.through, density.root, density.growth, density.coarsening);
  }
  bool operator==(const PlanKey&) const = default;

 private:
  template <class... Numbers>
  void add(Numbers... numbers) {
    (numbers_.push_back(static_cast<double>(numbers)), ...);
  }
  void add(const BoxShapeT<double>& box) { add(box.lengths[0], box.lengths[1], box.lengths[2]); }
  void add(const NotchShapeT<double>& n) {
    add(static_cast<int>(n.contour), n.half_length, n.depth, n.thickness, n.width, n.end_length,
        n.fillet, n.exponent, n.two_axes);
  }
  void add(const ContourT<double>& contour) {
    add(contour.size());
    for (const ContourCornerT<double>& c : contour) {
      add(c.at[0], c.at[1], c.fillet, c.through.has_value());
      if (c.through) add((*c.through)[0], (*c.through)[1]);
    }
  }
  void add(const PlateShapeT<double>& plate) {
    add(plate.outline);
    add(plate.windows.size());
    for (const ContourT<double>& window : plate.windows) add(window);
    for (const auto& hole : plate.holes) add(hole.center[0], hole.center[1], hole.radius);
    add(plate.thickness);
  }

  std::vector<double> numbers_;
};

/// plan_mesh() of what it was asked for lately is kept.
Answer<SolidPlan> kept_plan(const FlatElastic<double>& body, const MeshDensity& density) {
  static std::mutex mutex;
  static std::list<std::pair<PlanKey, SolidPlan>> kept;  // the last one asked for is the first
  constexpr std::size_t most = 64;
  const std::vector<PatchT<double>> patches = patches_of(body);
  PlanKey key(body.shape, patches, density);
  {
    const std::lock_guard lock(mutex);
    const auto found = std::ranges::find(kept, key, &std::pair<PlanKey, SolidPlan>::first);
    if (found != kept.end()) {
      kept.splice(kept.begin(), kept, found);
      return found->second;
    }
  }
  Answer<SolidPlan> plan = plan_mesh(body.shape, patches, density);
  if (!plan) return plan;
  const std::lock_guard lock(mutex);
  kept.emplace_front(std::move(key), *plan);
  if (kept.size() > most) kept.pop_back();
  return plan;
}

/// The interface that a message names, else the elastic body.
const ItemSource& told_source(const FlatElastic<double>& body, const std::string& message) {
  const ItemSource* source = &body.source;
  std::size_t longest = 0;
  for (const FlatInterface<double>& interface : body.interfaces)
    if (const std::string& name = interface.patch.name;
        name.size() > longest && message.find(name) != std::string::npos) {
      source = &interface.source;
      longest = name.size();
    }
  return *source;
}

void check_interfaces(const FlatElastic<double>& body) {
  const std::size_t count = body.interfaces.size();
  const std::string value = fmt::format("{} interface{}", count, count == 1 ? "" : "s");
  if (count < 2)
    throw SpecError(body.source.pointer + "/interfaces", value,
                    "an elastic body has two or more: of its own, or leaves and other elastic "
                    "bodies that name it");
  if (count > 3 && body.degree() == ElasticDegree::quartic)
    throw SpecError(body.source.pointer + "/degree", value, "of degree 4 with three at most");
}

ElasticPlan plan_of(const FlatElastic<double>& body) {
  check_interfaces(body);
  if (body.file) return {};
  if (const double longest = extent(flat_faces(body.shape)); body.density.size > longest)
    throw SpecError(body.source.pointer + "/elements/size",
                    fmt::format("{:g} m", body.density.size),
                    fmt::format("the largest elements are no larger than the faces of the body, "
                                "{:g} m; smaller ones at patches and corners are so by root and "
                                "growth",
                                longest));
  Answer<SolidPlan> mesh = kept_plan(body, body.density);
  if (!mesh) {
    const ItemSource& source = told_source(body, mesh.error());
    throw located(source, SpecError(source.pointer, body.name, mesh.error()));
  }
  MeshDensity coarse = body.density;
  coarse.coarsening = coarse_sizes;
  ElasticPlan plan{std::move(*mesh), {}, {}};
  if (Answer<SolidPlan> twin = kept_plan(body, coarse)) plan.coarse = std::move(*twin);
  return plan;
}

/// The point of an interface: of a notch its middle, of another body of degree 4 the middle of all
/// interfaces, of a linear one that of the patch.
template <class S>
Vector3<S> origin_of(const FlatElastic<S>& body, const FlatInterface<S>& interface) {
  if (body.degree() == ElasticDegree::linear && !std::holds_alternative<NotchShapeT<S>>(body.shape))
    return interface.patch.center;
  Vector3<S> middle = Vector3<S>::Zero();
  for (const FlatInterface<S>& one : body.interfaces)
    if (!std::holds_alternative<NotchShapeT<S>>(body.shape)) middle += one.patch.center;
  return middle / S(static_cast<double>(body.interfaces.size()));
}

/// The matrices of the body mirrored across its z.
std::shared_ptr<const ImportedMatrices> mirrored(const ImportedMatrices& matrices) {
  VectorXd sign = VectorXd::Ones(matrices.stiffness.rows());
  for (Eigen::Index a = 0; a + 6 <= sign.size() - matrices.modes; a += 6)
    sign.segment<3>(a + 2).setConstant(-1);  // uz, rx, ry
  auto result = std::make_shared<ImportedMatrices>(matrices);
  result->stiffness = sign.asDiagonal() * matrices.stiffness * sign.asDiagonal();
  result->mass = sign.asDiagonal() * matrices.mass * sign.asDiagonal();
  return result;
}

/// The elastic body on one of its meshes.
template <class S>
ElasticBodyT<S> meshed(const FlatElastic<S>& from, const SolidPlan& plan,
                       const MaterialT<S>& material) {
  ElasticBodyT<S> body;
  body.name = from.name;
  body.place = from.place;
  body.axes = from.axes;
  body.degree = from.degree();
  const auto add = [&](const FlatInterface<S>& of, std::vector<int> patch) {
    body.interfaces.push_back({.name = of.name,
                               .body = of.body,
                               .origin = origin_of(from, of),
                               .patch = std::move(patch),
                               .face = of.patch.center});
  };
  if (from.file) {
    const auto& file = std::get<ElasticItem::Imported>(from.file->shape);
    if (file.body) {
      body.imported = from.mirrored ? mirrored(*file.body->matrices) : file.body->matrices;
      for (const ImportedInterface& one : file.body->interfaces)  // in the order of the matrices
        add(*std::ranges::find(from.interfaces, one.name, &FlatInterface<S>::name), {});
      return body;
    }
    body.cells = std::make_shared<const SolidCells>(from.mirrored ? mirrored(file.mesh->cells)
                                                                  : file.mesh->cells);
    for (const Vector3d& node : file.mesh->nodes)
      body.nodes.push_back(
          Vector3d(node[0], node[1], from.mirrored ? -node[2] : node[2]).template cast<S>());
    for (const FlatInterface<S>& one : from.interfaces) {
      add(one, one.nodes);
      ElasticInterfaceT<S>& interface = body.interfaces.back();
      interface.face.setZero();  // the middle of the nodes: the point of a set may be elsewhere
      for (const int node : one.nodes)
        interface.face += body.nodes[static_cast<std::size_t>(node)] *
                          S(1.0 / static_cast<double>(one.nodes.size()));
    }
  } else {
    body.cells = plan.cells;
    body.nodes = place_nodes(plan, from.shape, patches_of(from));
    for (std::size_t a = 0; a < from.interfaces.size(); ++a)
      add(from.interfaces[a], plan.patches[a]);
  }
  body.material =
      from.material ? with_numbers<S>(*from.material, [](double x) { return S(x); }) : material;
  return body;
}

/// The cuboid around the nodes, along the own axes.
template <class S>
BodyBoxT<S> box_around(const ElasticBodyT<S>& body) {
  Vector3<S> low = body.nodes.front(), high = low;
  for (const Vector3<S>& node : body.nodes)
    for (int k = 0; k < 3; ++k) {
      if (value_of(node[k]) < value_of(low[k])) low[k] = node[k];
      if (value_of(node[k]) > value_of(high[k])) high[k] = node[k];
    }
  BodyBoxT<S> box;
  const Vector3<S> middle = (low + high) * S(0.5);
  box.center = body.place + body.axes.lazyProduct(middle);
  for (int k = 0; k < 3; ++k)
    box.half_edges.col(k) = body.axes.col(k) * S((high[k] - low[k]) * 0.5);
  return box;
}

}  // namespace

std::vector<ElasticPlan> plans_of(const FlatDesign<double>& nominal, const Material& material) {
  std::vector<ElasticPlan> plans(nominal.elastic_bodies.size());
  FaultList faults;
  for (std::size_t i = 0; i < plans.size(); ++i)
    faults.attempt([&] {
      const FlatElastic<double>& body = nominal.elastic_bodies[i];
      try {
        plans[i] = plan_of(body);
        if (!body.file)
          plans[i].nominal =
              std::make_shared<const ElasticBody>(meshed(body, plans[i].mesh, material));
      } catch (const SpecError& error) {
        throw located(body.source, error);
      }
    });
  faults.raise();
  return plans;
}

template <class S>
void add_elastic_bodies(const FlatDesign<S>& design, const MaterialT<S>& material,
                        const std::vector<ElasticPlan>& plans, MechanismT<S>& mechanism) {
  for (std::size_t i = 0; i < design.elastic_bodies.size(); ++i) {
    const FlatElastic<S>& from = design.elastic_bodies[i];
    ElasticBodyT<S>& body =
        mechanism.elastic_bodies.emplace_back(meshed(from, plans[i].mesh, material));
    body.nominal = plans[i].nominal;
    if constexpr (std::is_same_v<S, double>)
      if (plans[i].coarse)
        body.coarse = std::make_shared<const ElasticBody>(meshed(from, *plans[i].coarse, material));
    if (from.frame < 0) continue;
    RigidBodyT<S>& carrier = mechanism.bodies[static_cast<std::size_t>(from.frame)];
    if (!carrier.box && !body.nodes.empty()) carrier.box = box_around(body);
  }
}

template void add_elastic_bodies(const FlatDesign<double>&, const Material&,
                                 const std::vector<ElasticPlan>&, Mechanism&);
template void add_elastic_bodies(const FlatDesign<Dual1>&, const MaterialT<Dual1>&,
                                 const std::vector<ElasticPlan>&, MechanismT<Dual1>&);

}  // namespace flexopt
