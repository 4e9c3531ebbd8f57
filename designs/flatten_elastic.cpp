// Rigid frames that hold the elastic bodies of a design file.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/math/dual.hpp"
#include "core/mechanism/profile.hpp"
#include "designs/flattener.hpp"
#include "designs/solids/solid_faces.hpp"

namespace flexopt {
namespace {

constexpr double near_share = 1e-6;  ///< of a body: what lies nearer to a face lies on it

/// Whether two unit vectors are one.
template <class S>
bool same(const Vector3<S>& a, const Vector3<S>& b) {
  return value_of(a.dot(b)) > 1 - 1e-9;
}

/// The face along a normal that a place lies on, or the only one. Nothing else where there is none.
template <class S>
const FlatFaceT<S>* face_along(const std::vector<FlatFaceT<S>>& faces, const Vector3<S>& normal,
                               const std::optional<Vector3<S>>& place, double above = 0) {
  const double near = near_share * extent(faces);
  const FlatFaceT<S>* found = nullptr;
  for (const FlatFaceT<S>& face : faces) {
    if (!same(face.normal, normal)) continue;
    if (place) {
      const double height = value_of(face.height(*place));
      if (!(height >= -near && height <= above + near) || !face.holds(*place, near)) continue;
    } else if (found) {
      return nullptr;
    }
    found = &face;
  }
  return found;
}

/// A vector in own axes of the elastic body.
template <class S>
Vector3<S> own(const FlatElastic<S>& elastic, const Vector3<S>& global) {
  return elastic.axes.transpose().lazyProduct(global);
}

/// Puts the patch on a face; `along`: global, not along the normal.
template <class S>
void put(FlatInterface<S>& interface, const FlatElastic<S>& elastic, const FlatFaceT<S>& face,
         const Vector3<S>& at, const Vector3<S>& along, const std::array<S, 2>& sides) {
  interface.at = at;
  interface.normal = elastic.axes.lazyProduct(face.normal);
  const auto [u, v] = in_plane(interface.normal, std::optional(along));
  interface.along = u;
  interface.sides = sides;
  interface.patch = {own(elastic, Vector3<S>(at - elastic.place)),
                     Vector3<S>(own(elastic, u)) * (sides[0] * 0.5),
                     own(elastic, v) * (sides[1] * 0.5), ""};
}

/// The patch is the whole face.
template <class S>
void put(FlatInterface<S>& interface, const FlatElastic<S>& elastic, const FlatFaceT<S>& face) {
  const S half = face.half_u.norm();
  put<S>(interface, elastic, face, elastic.place + elastic.axes.lazyProduct(face.center),
         elastic.axes.lazyProduct(Vector3<S>(face.half_u / half)),
         {half * 2.0, face.half_v.norm() * 2.0});
}

/// A body of a file has `at`, global, as the point of a node set, or where the design has the
/// interface.
template <class S>
void put_as_filed(FlatInterface<S>& interface, const FlatElastic<S>& elastic,
                  const std::optional<Vector3<S>>& at, const std::string& pointer) {
  const auto& file = std::get<ElasticItem::Imported>(elastic.file->shape);
  const double side = elastic.mirrored ? -1 : 1;
  Vector3d place = Vector3d::Zero();
  if (file.mesh) {
    interface.nodes = nodes_of_set(*file.mesh, interface.name, JsonPointer(pointer));
    for (const int node : interface.nodes)
      place += file.mesh->nodes[static_cast<std::size_t>(node)] /
               static_cast<double>(interface.nodes.size());
  } else {
    place =
        std::ranges::find(file.body->interfaces, interface.name, &ImportedInterface::name)->place;
  }
  place[2] *= side;
  Vector3<S>& center = interface.patch.center = place.cast<S>();
  interface.patch.half_u = interface.patch.half_v = Vector3<S>::Zero();
  if (at) {
    const Vector3<S> there = own(elastic, Vector3<S>(*at - elastic.place));
    if (file.mesh) {
      center = there;
    } else {
      Vector3d filed = there.unaryExpr([](const S& x) { return value_of(x); });
      filed[2] *= side;
      if (const Check kept = check_interface_place(*file.body, interface.name, filed); !kept)
        throw SpecError(pointer + "/at", interface.name, kept.error());
    }
  }
  interface.at = at ? *at : Vector3<S>(elastic.place + elastic.axes.lazyProduct(center));
}

/// Refuses a body of a file, which has no faces.
template <class S>
void expect_faces(const FlatElastic<S>& elastic, const std::string& pointer) {
  if (elastic.file)
    throw SpecError(pointer, "\"" + elastic.name + "\"",
                    "a body of a file has the interfaces of the file alone: name one of them, \"" +
                        elastic.name + ".…\"");
}

/// The end of a leaf.
template <class S>
struct LeafEnd {
  Vector3<S> at, along, across;  ///< unit; along the leaf there, from base to tip
  S width, thickness;
};

template <class S>
S size_at(const FlatSize<S>& size, int end) {
  if (size.values.size() == 1) return size.values.front();
  const ProfileWeights weights = profile_weights(size.values.size(), end);
  S value(0);
  for (int i = 0; i < weights.count; ++i)
    value += size.values[static_cast<std::size_t>(weights.first + i)] * weights.weight[i];
  return value;
}

template <class S>
LeafEnd<S> end_of(const FlatLeaf<S>& leaf, int end) {
  using std::cos, std::sin;
  LeafEnd<S> result;
  result.at = end == 0 ? leaf.base_at : leaf.tip_at;
  const Vector3<S> from = end == 1 && leaf.fold ? *leaf.fold : leaf.base_at,
                   to = end == 0 && leaf.fold ? *leaf.fold : leaf.tip_at;
  const Vector3<S> line = to - from;
  result.along = line / S(line.norm());
  result.across = leaf.across - result.along * result.along.dot(leaf.across);
  result.across /= S(result.across.norm());
  if (leaf.curve) {  // it bulges to across × (base → tip)
    const Vector3<S> bulge = result.across.cross(result.along);
    const S half = *leaf.curve * (end == 0 ? 0.5 : -0.5);
    result.along = result.along * cos(half) + bulge * sin(half);
  }
  result.width = size_at(leaf.width, end);
  result.thickness = size_at(leaf.thickness, end);
  if (leaf.wire) {  // a square of its area
    result.width *= std::sqrt(std::numbers::pi) / 2;
    result.thickness *= std::sqrt(std::numbers::pi) / 2;
  }
  return result;
}

/// What is wrong with a place that is on no face.
template <class S>
std::string off_the_faces(const std::vector<FlatFaceT<S>>& faces, const Vector3<S>& place) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const FlatFaceT<S>& face : faces)
    if (face.holds(place, near_share * extent(faces)))
      nearest = std::min(nearest, std::abs(value_of(face.height(place))));
  return std::isfinite(nearest) ? fmt::format("{:.3g} m from the nearest face", nearest)
                                : "beside the body";
}

/// The patch of a leaf's base (0) or tip (1).
template <class S>
FlatInterface<S> edge_of(const FlatLeaf<S>& leaf, int end, const FlatElastic<S>& elastic) {
  FlatInterface<S> result;
  result.name = leaf.name + (end == 0 ? ".base" : ".tip");
  result.source = leaf.source;
  result.source.pointer += end == 0 ? "/base" : "/tip";
  const std::string& pointer = result.source.pointer;
  expect_faces(elastic, pointer + "/body");
  result.implied = true;
  const LeafEnd<S> edge = end_of(leaf, end);
  const auto faces = flat_faces(elastic.shape);
  const Vector3<S> at = own(elastic, Vector3<S>(edge.at - elastic.place)),
                   along = own(elastic, edge.along), across = own(elastic, edge.across);
  const double near = near_share * extent(faces);
  if (const auto& clamp = leaf.clamps[static_cast<std::size_t>(end)]) {
    const Vector3<S> middle = at + along * (clamp->length * (end == 0 ? -0.5 : 0.5));
    const FlatFaceT<S>* face = face_along(faces, own(elastic, clamp->normal), std::optional(middle),
                                          0.5 * value_of(edge.thickness));
    if (face == nullptr || std::abs(value_of(face->normal.dot(along))) > near_share)
      throw SpecError(pointer + "/clamp/side", off_the_faces(faces, middle),
                      "the clamped part of the leaf lies on this face: its middle plane is half "
                      "its thickness above it at most, and parallel to it");
    const Vector3<S> foot = middle - face->normal * face->height(middle);
    put<S>(result, elastic, *face, elastic.place + elastic.axes.lazyProduct(foot), edge.across,
           {edge.width, clamp->length});
    return result;
  }
  const FlatFaceT<S>* face = nullptr;
  const auto slope = [&](const FlatFaceT<S>& of) {
    return std::abs(value_of(of.normal.dot(along)));
  };
  for (const FlatFaceT<S>& one : faces)
    if (std::abs(value_of(one.height(at))) <= near && one.holds(at, near) &&
        std::abs(value_of(one.normal.dot(across))) <= near_share && slope(one) > 0.1 &&
        (face == nullptr || slope(one) > slope(*face)))
      face = &one;
  if (face == nullptr)
    throw SpecError(pointer + "/at", off_the_faces(faces, at),
                    fmt::format("the edge of a leaf lies on a flat face of the elastic body {}, "
                                "within 1e-6 of its size, and the leaf leaves it at 6 deg at "
                                "least; one that lies on the face has a clamp",
                                elastic.name));
  S cosine = face->normal.dot(along);
  if (value_of(cosine) < 0) cosine = -cosine;
  put<S>(result, elastic, *face, edge.at, edge.across, {edge.width, edge.thickness / cosine});
  return result;
}

}  // namespace

template <class S>
FlatInterface<S> Flattener<S>::interface_of(const BodyItem& item,
                                            const ElasticItem::Interface& interface,
                                            const Placement<S>& at,
                                            const FlatElastic<S>& elastic) const {
  FlatInterface<S> result;
  result.name = instance_name(item, interface.name);
  result.source = source_of(item);
  result.source.pointer += "/elastic" + interface.key;
  const std::string& pointer = result.source.pointer;
  if (elastic.file) {
    std::optional<Vector3<S>> global;
    if (interface.at) global = at.place(vector(*interface.at));
    put_as_filed(result, elastic, global, pointer);
    return result;
  }
  const auto faces = flat_faces(elastic.shape);
  if (item.elastic->is_notch()) {
    put(result, elastic, faces[interface.name == "base" ? 1 : 0]);
    return result;
  }
  const Vector3<S> normal = unit(vector(*interface.normal), pointer + "/normal");
  Vector3<S> global = elastic.place;
  if (interface.at) global = at.place(vector(*interface.at));
  std::optional<Vector3<S>> place;
  if (interface.at) place = own(elastic, Vector3<S>(global - elastic.place));
  const FlatFaceT<S>* face = face_along(faces, own(elastic, at.direction(normal)), place);
  if (face == nullptr)
    throw SpecError(
        pointer + (place ? "/at" : ""), place ? off_the_faces(faces, *place) : "the face",
        place ? "it lies on a flat face of the body of this direction, within 1e-6 of its size"
              : "there is no flat face of this direction, or there are several: at tells which");
  if (!interface.size && !face->whole)
    throw SpecError(pointer + "/size", "nothing",
                    "this face is no rectangle: give the size of the patch");
  if (!interface.size) {
    put(result, elastic, *face);
    return result;
  }
  const Vector3<S> along =
      interface.along ? unit(vector(*interface.along), pointer + "/along") : in_plane(normal)[0];
  if (std::abs(value_of(along.dot(normal))) > 1 - 1e-9)
    throw SpecError(pointer + "/along", "the normal", "a side of the patch lies in the face");
  put<S>(result, elastic, *face, global, at.direction(along),
         {positive((*interface.size)[0], pointer + "/size/0", "a side"),
          positive((*interface.size)[1], pointer + "/size/1", "a side")});
  return result;
}

template <class S>
int Flattener<S>::hold(int elastic, const std::string& local, FlatInterface<S> interface,
                       std::optional<int> carrier) {
  FlatElastic<S>& of = out_.elastic_bodies[static_cast<std::size_t>(elastic)];
  const std::string name = of.name + "." + interface.name;
  if (std::ranges::find(of.interfaces, interface.name, &FlatInterface<S>::name) !=
      of.interfaces.end())
    throw SpecError(interface.source.pointer, "\"" + name + "\"",
                    "another interface has this name");
  interface.patch.name = name;
  const auto tied = [&](const FlatJoint<S>& joint) {
    return joint.type == JointType::rigid && joint.body == of.frame && joint.other == *carrier;
  };
  if (of.rigid && carrier && *carrier != of.frame && std::ranges::none_of(out_.joints, tied)) {
    FlatJoint<S> joint;
    joint.name = name;
    joint.source = interface.source;
    joint.type = JointType::rigid;
    joint.body = of.frame;
    joint.other = *carrier;
    joint.place = of.place + of.axes.lazyProduct(interface.patch.center);
    out_.joints.push_back(std::move(joint));
  }
  const bool names = std::ranges::none_of(
      of.interfaces, [&](const FlatInterface<S>& other) { return other.body == of.frame; });
  if (of.rigid || (!carrier && names && of.frame != no_body)) {
    interface.body = of.frame;
  } else if (carrier) {
    interface.body = *carrier;
  } else {
    interface.body = static_cast<int>(out_.bodies.size());
    FlatBody<S> body;
    body.name = name;
    body.source = interface.source;
    body.of_interface = true;
    body.at = of.place + of.axes.lazyProduct(interface.patch.center);
    out_.bodies.push_back(std::move(body));
  }
  const int body = interface.body;
  if (!bodies_.try_emplace(local + "." + interface.name, NamedBody{body, -1}).second)
    throw SpecError(interface.source.pointer, "\"" + name + "\"", "another body has this name");
  of.interfaces.push_back(std::move(interface));
  return body;
}

template <class S>
void Flattener<S>::tie_interfaces(const BodyItem& item) {
  const std::string local = instance_name(item, item.name);
  const auto entry = bodies_.find(local);
  if (!item.elastic || entry == bodies_.end() || entry->second.elastic < 0 ||
      scope_.joined.contains(local))
    return;
  const int index = entry->second.elastic;
  const Placement<S> at = frame(item.frame, item);
  for (const ElasticItem::Interface& from : item.elastic->interfaces) {
    if (from.body.empty()) continue;
    const std::string key = "/elastic" + from.key + (item.elastic->is_notch() ? "" : "/body");
    const NamedBody target = named(item, from.body, key);
    const FlatElastic<S> elastic = out_.elastic_bodies[static_cast<std::size_t>(index)];
    FlatInterface<S> interface = interface_of(item, from, at, elastic);
    if (target.elastic < 0) {
      interface.carrier = target.body == ground
                              ? "ground"
                              : out_.bodies[static_cast<std::size_t>(target.body)].name;
      hold(index, local, std::move(interface), target.body);
      continue;
    }
    const FlatElastic<S>& other = out_.elastic_bodies[static_cast<std::size_t>(target.elastic)];
    if (target.elastic == index)
      throw SpecError(item.pointer + key, "\"" + other.name + "\"",
                      "an interface is a part of another body");
    expect_faces(other, item.pointer + key);
    const auto faces = flat_faces(other.shape);
    const std::optional<Vector3<S>> place = own(other, Vector3<S>(interface.at - other.place));
    const FlatFaceT<S>* face = face_along(faces, own(other, Vector3<S>(-interface.normal)), place);
    if (face == nullptr)
      throw SpecError(item.pointer + key, off_the_faces(faces, *place),
                      fmt::format("the interface lies face to face on {}, within 1e-6 of its size",
                                  other.name));
    FlatInterface<S> mate;
    interface.carrier = other.name;
    mate.name = elastic.name + "." + interface.name;
    mate.source = interface.source;
    mate.implied = true;
    put(mate, other, *face, interface.at, interface.along, interface.sides);
    const int carrier = hold(target.elastic, instance_name(item, from.body), std::move(mate));
    hold(index, local, std::move(interface), carrier);
  }
}

template <class S>
void Flattener<S>::hold_edges(const LeafItem& item, FlatLeaf<S>& leaf) {
  for (const std::size_t end : {0u, 1u}) {
    const HeldPlace& held = end == 0 ? item.base : item.tip;
    const std::string key = end == 0 ? "/base" : "/tip";
    const int elastic = held.body.empty() ? -1 : named(item, held.body, key + "/body").elastic;
    if (elastic < 0 && held.clamp)
      throw SpecError(item.pointer + key + "/clamp", "a clamp",
                      "of a leaf on an elastic body alone, by the name of that body");
    if (elastic < 0) continue;
    const FlatElastic<S>& of = out_.elastic_bodies[static_cast<std::size_t>(elastic)];
    leaf.held_by[end] = of.name;
    if (held.clamp)
      leaf.clamps[end] = FlatClamp<S>{
          positive(held.clamp->length, item.pointer + key + "/clamp/length", "a length"),
          frame(item.frame, item).direction(vector(held.clamp->normal))};
    FlatInterface<S> edge = edge_of(leaf, static_cast<int>(end), of);
    (end == 0 ? leaf.base : leaf.tip) =
        hold(elastic, instance_name(item, held.body), std::move(edge));
  }
}

template FlatInterface<double> Flattener<double>::interface_of(const BodyItem&,
                                                               const ElasticItem::Interface&,
                                                               const Placement<double>&,
                                                               const FlatElastic<double>&) const;
template FlatInterface<Dual1> Flattener<Dual1>::interface_of(const BodyItem&,
                                                             const ElasticItem::Interface&,
                                                             const Placement<Dual1>&,
                                                             const FlatElastic<Dual1>&) const;
template int Flattener<double>::hold(int, const std::string&, FlatInterface<double>,
                                     std::optional<int>);
template int Flattener<Dual1>::hold(int, const std::string&, FlatInterface<Dual1>,
                                    std::optional<int>);
template void Flattener<double>::tie_interfaces(const BodyItem&);
template void Flattener<Dual1>::tie_interfaces(const BodyItem&);
template void Flattener<double>::hold_edges(const LeafItem&, FlatLeaf<double>&);
template void Flattener<Dual1>::hold_edges(const LeafItem&, FlatLeaf<Dual1>&);

}  // namespace flexopt
